#include "palpa/report/scene_differences.h"

#include <toml++/toml.h>

#include <map>

#include "palpa/base/sanitized.h"
#include "palpa/base/toml_problem.h"
#include "palpa/base/wording.h"

namespace palpa::detail {
namespace {

using Values = std::map<std::string, std::string>;

std::string value_of(const toml::node& node) {
  if (const auto* text = node.as_string()) return text->get();
  if (const auto* whole = node.as_integer()) return std::to_string(whole->get());
  if (const auto* number = node.as_floating_point()) return toml_number(number->get());
  if (const auto* flag = node.as_boolean()) return flag->get() ? "true" : "false";
  std::string all;
  if (const auto* array = node.as_array()) {
    for (const toml::node& item : *array) all += (all.empty() ? "" : ", ") + value_of(item);
    return "[" + all + "]";
  }
  return "?";
}

/// Values below a node by path; an item of a list of tables by its name, or its index.
void gather(const toml::node& node, const std::string& path, Values& values) {
  if (const toml::table* table = node.as_table()) {
    for (const auto& [key, value] : *table) {
      if (path.empty() && key.str() == "title") continue;
      gather(value, path.empty() ? std::string(key.str()) : path + "." + std::string(key.str()), values);
    }
    return;
  }
  const toml::array* array = node.as_array();
  if (!array || array->empty() || !array->is_array_of_tables()) {
    values[path] = value_of(node);
    return;
  }
  for (std::size_t i = 0; i < array->size(); ++i) {
    const toml::node_view<const toml::node> item{(*array)[i]};
    gather((*array)[i], path + "." + item["name"].value_or(std::to_string(i + 1)), values);
  }
}

Values values_of(std::string_view scene) {
  Values values;
  try {
    if (!problem_with_toml(std::string(scene))) gather(toml::parse(scene), "", values);
  } catch (const toml::parse_error&) {
    return {};
  }
  return values;
}

}  // namespace

std::vector<SceneDifference> scene_differences(std::string_view first, std::string_view second) {
  const Values a = values_of(first), b = values_of(second);
  Values all = a;
  all.insert(b.begin(), b.end());
  std::vector<SceneDifference> differences;
  const auto in = [](const Values& values, const std::string& key) {
    const auto found = values.find(key);
    return found == values.end() ? std::string() : found->second;
  };
  for (const auto& [key, value] : all) {
    SceneDifference one{key, in(a, key), in(b, key)};
    if (one.first != one.second) differences.push_back(std::move(one));
  }
  return differences;
}

std::string format_difference(const SceneDifference& difference) {
  const auto said = [](const std::string& value) { return value.empty() ? std::string("not set") : shortened(value, 60); };
  return difference.key + ": " + said(difference.first) + " / " + said(difference.second);
}

}  // namespace palpa::detail
