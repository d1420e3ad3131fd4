#include "palpa/scene/part_reader.h"

#include <algorithm>
#include <stdexcept>

#include "palpa/base/wording.h"
#include "palpa/scene/scene_checks.h"

namespace palpa::detail::scene_file {

using detail::in_quotes;
using detail::sentence_of;
using detail::suggestion;
using detail::toml_number;

std::string check_plain(const std::string& kind, const toml::key& word) {
  const std::string problem = detail::problem_with_name(kind, word.str());
  if (!problem.empty()) fail(place_of(word.source()), problem);
  return std::string(word.str());
}

std::pair<FieldRef, TransferFunction> function_in(const toml::table& table, const std::string& where, const Range& range) {
  const Section section(table, detail::keys_of<detail::FunctionPart>(), where);
  const auto check = [&](const toml::node& node, double result) {
    if (range.contains(result)) return;
    fail(place_of(node), "a result in " + where + " is " + toml_number(result) + "; it must be " + sentence_of(range));
  };
  std::vector<TransferFunction::Point> points;
  for (const toml::node& element : *section.node("points")->as_array()) {
    const auto pair = numbers_in(element, 2);
    if (!pair)
      fail(place_of(element), "a point in " + where + " is no pair of numbers; points are [[value, result], …], all finite");
    check(*element.as_array()->get(1), (*pair)[1]);
    points.push_back({(*pair)[0], (*pair)[1]});
  }
  const double outside = section.number("outside").value_or(0.0);
  if (section.node("outside")) check(*section.node("outside"), outside);
  try {
    return {FieldRef{*section.text("of")}, TransferFunction(std::move(points), outside)};
  } catch (const std::invalid_argument& error) {
    fail(place_of(*section.node("points")), "the points in " + where + " make no function: " + error.what());
  }
}

void PartReader::optional_number(const ParameterInfo& info, std::optional<double>& value) {
  if (section_.node(info.name)) value = section_.number(info.name);
}

void PartReader::whole_number(const ParameterInfo& info, std::optional<std::int64_t>& value) {
  if (const toml::node* node = section_.node(info.name)) value = node->value<std::int64_t>();
}

void PartReader::flag(const ParameterInfo& info, bool& value) {
  if (const toml::node* node = section_.node(info.name)) value = *node->value<bool>();
}

void PartReader::text(const ParameterInfo& info, std::string& value) {
  const auto given = section_.text(info.name);
  if (!given) return;
  value = *given;
  if (info.kind != ParameterKind::volume || !volumes_ || std::ranges::find(*volumes_, value) != volumes_->end()) return;
  fail(place_of(*section_.node(info.name)), "no volume " + in_quotes(value) + "; " + suggestion(value, *volumes_));
}

void PartReader::texts(const ParameterInfo& info, std::vector<std::string>& value) {
  const toml::node* node = section_.node(info.name);
  if (!node || !node->is_array()) return;
  value.clear();
  for (const toml::node& element : *node->as_array()) value.push_back(*element.value<std::string>());
}

void PartReader::vectors(const ParameterInfo& info, std::vector<Vec3>& value) {
  const toml::node* node = section_.node(info.name);
  if (!node) return;
  value.clear();
  for (const toml::node& element : *node->as_array()) {
    const std::vector<double> xyz = *numbers_in(element, 3);
    value.push_back({xyz[0], xyz[1], xyz[2]});
  }
}

void PartReader::choice(const ParameterInfo& info, int& value) {
  const auto word = section_.text(info.name);
  if (word) value = static_cast<int>(std::ranges::find(info.choices, *word) - info.choices.begin());
}

void PartReader::numbers(const ParameterInfo& info, std::vector<double>& value) {
  const toml::node* node = section_.node(info.name);
  if (node && node->is_array()) value = *numbers_in(*node, info.count);
}

void PartReader::field(const ParameterInfo& info, FieldRef& ref) {
  if (const toml::node* node = section_.node(info.name)) ref = field_in(*node);
}

void PartReader::strength(const ParameterInfo& info, Strength& strength) {
  const toml::node* node = section_.node(info.name);
  if (!node) return;
  if (const auto constant = number_in(*node)) {
    strength = Strength(*constant);
    return;
  }
  auto [of, curve] = function_in(*node->as_table(), in_quotes(info.name) + " of " + section_.where(), info.range);
  strength = Strength(field_in(*node->as_table()->get("of")), std::move(curve));
}

void PartReader::list(const ParameterInfo& info, ParameterList& list) {
  const toml::node* node = section_.node(info.name);
  if (!node) return;
  const Keys& keys = detail::find(keys_, info.name)->items;
  const std::string in_list = in_quotes(info.name) + " of " + section_.where();
  if (info.kind == ParameterKind::table) return read(*node->as_table(), keys, in_list, list, 0);
  if (info.kind == ParameterKind::named_tables) return named_tables(*node->as_table(), *detail::find(keys_, info.name), list);
  for (const toml::table* table : tables_in(node)) {
    const auto name = (*table)["name"].value<std::string>();
    const std::string item =
        std::string(info.name) + " " + (name ? in_quotes(*name) : std::to_string(list.size() + 1)) + " of " + section_.where();
    list.append();
    read(*table, keys, detail::find(keys, "name") ? item : in_list, list, list.size() - 1);
  }
}

FieldRef PartReader::field_in(const toml::node& node) const {
  const std::string name = *node.value<std::string>();
  const std::string problem = volumes_ ? detail::problem_with_volume_of(name, *volumes_) : "";
  if (!problem.empty()) fail(place_of(node), problem);
  return {name};
}

void PartReader::read(const toml::table& table, const Keys& keys, const std::string& where, ParameterList& list,
                      std::size_t i) const {
  const Section section(table, keys, where);
  PartReader reader(section, keys, volumes_);
  list.visit(i, reader);
}

void PartReader::named_tables(const toml::table& table, const Key& key, ParameterList& list) const {
  struct Name final : ParameterVisitor {
    void text(const ParameterInfo& info, std::string& text) override {
      if (info.name == "name") text = value;
    }
    std::string value;
  } name;
  const std::string one = key.name.substr(0, key.name.size() - 1);
  for (const auto& [word, node] : table) {
    name.value = check_plain(one, word);
    const std::string where = one + " " + in_quotes(name.value) + " of " + section_.where();
    if (!node.is_table()) fail(place_of(node), where + " is " + kind_of(node) + "; it must be " + key.form);
    list.append();
    list.visit(list.size() - 1, name);
    read(*node.as_table(), key.items, where, list, list.size() - 1);
  }
}

}  // namespace palpa::detail::scene_file
