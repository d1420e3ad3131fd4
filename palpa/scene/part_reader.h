// Parts of a scene, filled in from their tables.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "palpa/mode/parameters.h"
#include "palpa/scene/parts.h"
#include "palpa/scene/toml_section.h"

namespace palpa::detail::scene_file {

using detail::Key;
using detail::Keys;

/// A name of something; throws SceneError where it is no plain word.
std::string check_plain(const std::string& kind, const toml::key& word);
/// `table` as a function of a field: {of, points, outside}.
std::pair<FieldRef, TransferFunction> function_in(const toml::table& table, const std::string& where, const Range& range);

/// Fills in the parameters of a part or a mode from its table, which has been checked against their keys.
class PartReader final : public ParameterVisitor {
 public:
  /// \param volumes  those that fields and volumes must be of; nullptr: of any
  PartReader(const Section& section, const Keys& keys, const std::vector<std::string>* volumes)
      : section_(section), keys_(keys), volumes_(volumes) {}

  void number(const ParameterInfo& info, double& value) override { value = section_.number(info.name).value_or(value); }
  void optional_number(const ParameterInfo& info, std::optional<double>& value) override;
  void whole_number(const ParameterInfo& info, std::optional<std::int64_t>& value) override;
  void flag(const ParameterInfo& info, bool& value) override;
  void text(const ParameterInfo& info, std::string& value) override;
  void texts(const ParameterInfo& info, std::vector<std::string>& value) override;
  void vectors(const ParameterInfo& info, std::vector<Vec3>& value) override;
  void choice(const ParameterInfo& info, int& value) override;
  void numbers(const ParameterInfo& info, std::vector<double>& value) override;
  void field(const ParameterInfo& info, FieldRef& ref) override;
  void strength(const ParameterInfo& info, Strength& strength) override;
  void list(const ParameterInfo& info, ParameterList& list) override;

  /// A field's name whose volume is there: found out before any volume is opened.
  FieldRef field_in(const toml::node& node) const;

 private:
  void read(const toml::table& table, const Keys& keys, const std::string& where, ParameterList& list, std::size_t i) const;
  /// Each under its name, which is a plain word: "field 'a' of …" of `fields`.
  void named_tables(const toml::table& table, const Key& key, ParameterList& list) const;

  const Section& section_;
  const Keys& keys_;
  const std::vector<std::string>* volumes_;
};

/// Fills in a part from its table; gives back the table, checked.
template <class Part>
Section read(const toml::table& table, std::string where, Part& part, const std::vector<std::string>* volumes = nullptr) {
  const Keys& keys = detail::keys_of<Part>();
  Section section(table, keys, std::move(where));
  PartReader reader(section, keys, volumes);
  detail::visit_parameters(part, reader);
  return section;
}

}  // namespace palpa::detail::scene_file
