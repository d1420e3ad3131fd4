// Keys of scene files, collected from the lists of the parts and modes, for checks and documentation.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "palpa/mode/mode.h"
#include "palpa/scene/parts.h"

namespace palpa::detail {

/// "above 0 and at most 100"; empty for an unbounded range.
std::string sentence_of(const Range& range);

struct Key {
  std::string name;
  ParameterKind kind = ParameterKind::text;
  std::optional<ParameterKind> or_kind = {};  ///< alternative kind
  std::string form;                           ///< format of its value, for people; empty: by the kind
  std::string fallback;                       ///< value if left out, for people
  std::string sentence;
  Range range;  ///< of its numbers
  std::vector<std::string> choices;
  std::size_t count = 0;        ///< [1] length of a list of numbers
  std::vector<Key> items = {};  ///< keys of tables with parameters of their own
  bool required = false;
  bool may_be(ParameterKind other) const noexcept { return kind == other || or_kind == other; }
};
using Keys = std::vector<Key>;

const Key* find(const Keys& keys, std::string_view name) noexcept;
std::vector<std::string> names_of(const Keys& keys);
/// Format of a value of this key: "number [N], between 0 and 100".
std::string form_of(const Key& key);
/// Expected type: "a number".
std::string expected(const Key& key);

/// TOML type of a value, as bits.
enum TomlValue : unsigned { boolean = 1, whole = 2, floating = 4, text_value = 8, array = 16, table = 32 };
/// Types that a key accepts.
unsigned values_of(const Key& key) noexcept;

/// Makes keys of the visited parameters. A parameter that is listed twice may be of either kind.
class KeyCollector final : public ParameterVisitor {
 public:
  explicit KeyCollector(Keys& keys) : keys_(keys) {}
  void number(const ParameterInfo& info, double& value) override;
  void optional_number(const ParameterInfo& info, std::optional<double>& value) override;
  void flag(const ParameterInfo& info, bool& value) override;
  void text(const ParameterInfo& info, std::string& value) override;
  void choice(const ParameterInfo& info, int& value) override;
  void field(const ParameterInfo& info, FieldRef& ref) override;
  void strength(const ParameterInfo& info, Strength& value) override;
  void list(const ParameterInfo& info, ParameterList& list) override;
  void whole_number(const ParameterInfo& info, std::optional<std::int64_t>& value) override;
  void numbers(const ParameterInfo& info, std::vector<double>& value) override;
  void texts(const ParameterInfo& info, std::vector<std::string>& value) override;
  void vectors(const ParameterInfo& info, std::vector<Vec3>& value) override;
  void other(const ParameterInfo& info) override;

 private:
  /// \param value  default; empty: none
  Key& add(const ParameterInfo& info, std::string value);
  Keys& keys_;
};

/// Keys of a part, for example `CouplingOptions`. Any thread.
template <class Part>
const Keys& keys_of() {
  static const Keys keys = [] {
    Keys all;
    KeyCollector collector(all);
    Part part;
    visit_parameters(part, collector);
    return all;
  }();
  return keys;
}

Keys parameter_keys(const Mode& mode);

}  // namespace palpa::detail
