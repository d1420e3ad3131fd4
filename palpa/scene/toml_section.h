// Tables of a scene file, checked against the lists of their keys.
#pragma once

#include <toml++/toml.h>

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "palpa/base/wording.h"
#include "palpa/scene/keys.h"

namespace palpa::detail::scene_file {

inline constexpr std::string_view set_mark = "--set ";  // stands for the file's name in values from --set

/// Throws SceneError "PLACE: TEXT".
[[noreturn]] void fail(const std::string& place, const std::string& text);
/// "FILE:LINE:COLUMN", or the mark of --set with its path.
std::string place_of(const toml::source_region& region);
inline std::string place_of(const toml::node& node) { return place_of(node.source()); }

/// Parses a text; `name` stands for the file in errors. Throws SceneError.
toml::table parse_toml(const std::string& text, const std::string& name);

/// Kind of a value, in words: "a number".
std::string kind_of(const toml::node& node);
/// A number; none where it is of another kind.
std::optional<double> number_in(const toml::node& node);
/// `count` finite numbers of a list; none where it is something else.
std::optional<std::vector<double>> numbers_in(const toml::node& node, std::size_t count);
/// Elements of a list of tables that was checked to be one; none of a null pointer.
std::vector<const toml::table*> tables_in(const toml::node* node);
/// The canonical text of a value, on one line.
std::string text_of(const toml::node& node);

/// A table whose keys have all been checked against their list: known, of the right kind, in range,
/// among the choices, and the required ones there. What is asked for afterwards needs no check.
class Section {
 public:
  /// `where` completes "… in ": "[coupling]", "mode 'skin'".
  Section(const toml::table& table, const detail::Keys& keys, std::string where);

  const std::string& where() const noexcept { return where_; }
  const toml::node* node(std::string_view key) const { return table_.get(key); }
  const toml::table* subtable(std::string_view key) const { return node(key) ? node(key)->as_table() : nullptr; }
  std::optional<double> number(std::string_view key) const { return node(key) ? number_in(*node(key)) : std::nullopt; }
  std::optional<std::string> text(std::string_view key) const { return table_[key].value<std::string>(); }
  /// Fails at the key: "'KEY' in WHERE …", what is wrong; what would be right.
  [[noreturn]] void refuse(std::string_view key, const std::string& problem) const { fail_at(*node(key), key, problem); }

 private:
  [[noreturn]] void fail_at(const toml::node& at, std::string_view key, const std::string& problem) const {
    fail(place_of(at), detail::in_quotes(key) + " in " + where_ + " " + problem);
  }
  void check(const detail::Key& key, const toml::node& node) const;

  const toml::table& table_;
  std::string where_;
};

}  // namespace palpa::detail::scene_file
