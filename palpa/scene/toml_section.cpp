#include "palpa/scene/toml_section.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "palpa/base/limits.h"
#include "palpa/base/toml_problem.h"
#include "palpa/base/wording.h"
#include "palpa/data/length_unit.h"
#include "palpa/scene/scene.h"

namespace palpa::detail::scene_file {

using detail::in_quotes;
using detail::Key;
using detail::Keys;
using detail::sentence_of;
using detail::suggestion;
using detail::toml_number;

namespace {

unsigned value_of(const toml::node& node) noexcept {
  switch (node.type()) {
    case toml::node_type::string: return detail::text_value;
    case toml::node_type::integer: return detail::whole;
    case toml::node_type::floating_point: return detail::floating;
    case toml::node_type::boolean: return detail::boolean;
    case toml::node_type::array: return detail::array;
    case toml::node_type::table: return detail::table;
    default: return 0;
  }
}

/// Limit on the elements of a list or a table of this name.
const Limit& limit_of(std::string_view key) noexcept {
  static constexpr std::pair<std::string_view, Limit> limits[] = {
      {"mode", limit::modes},    {"volume", limit::volumes},     {"poses", limit::poses},      {"hand", limit::hands},
      {"points", limit::points}, {"points_m", limit::tool_feet}, {"file", limit::volume_files}};
  const auto* found = std::ranges::find(limits, key, &std::pair<std::string_view, Limit>::first);
  return found != std::end(limits) ? found->second : limit::entries;
}

/// Whether a key with choices may be this text: one of them, or another spelling of a unit of length.
bool is_choice(const Key& key, const std::string& text) {
  return std::ranges::find(key.choices, text) != key.choices.end() || (key.name == "length_unit" && detail::length_unit(text));
}

}  // namespace

void fail(const std::string& place, const std::string& text) { throw SceneError(detail::one_line(place + ": " + text)); }

std::string place_of(const toml::source_region& region) {
  if (!region.path) return "scene";
  if (region.path->starts_with(set_mark)) return *region.path;
  return *region.path + ":" + std::to_string(region.begin.line) + ":" + std::to_string(region.begin.column);
}

toml::table parse_toml(const std::string& text, const std::string& name) {
  if (text.size() > limit::scene_bytes.count())
    fail(name, "longer than " + quantity(limit::scene_bytes) + "; " + std::string(limit::scene_bytes.remedy));
  if (const auto problem = detail::problem_with_toml(text))
    fail(name + ":" + std::to_string(problem->line) + ":" + std::to_string(problem->column), problem->sentence);
  try {
    return toml::parse(std::string_view(text), std::string_view(name));
  } catch (const toml::parse_error& error) {
    fail(place_of(error.source()),
         "no valid TOML: " + std::string(error.description()) + "; a line is KEY = VALUE, [TABLE] or [[LIST]]");
  }
}

std::string kind_of(const toml::node& node) {
  switch (value_of(node)) {
    case detail::text_value: return "a text";
    case detail::whole:
    case detail::floating: return "a number";
    case detail::boolean: return "true or false";
    case detail::array: return "a list";
    case detail::table: return "a table";
    default: return "a date or time";
  }
}

std::optional<double> number_in(const toml::node& node) {
  if (const auto* integer = node.as_integer()) return static_cast<double>(integer->get());
  if (const auto* floating = node.as_floating_point()) return floating->get();
  return std::nullopt;
}

std::optional<std::vector<double>> numbers_in(const toml::node& node, std::size_t count) {
  const toml::array* array = node.as_array();
  if (!array || array->size() != count) return std::nullopt;
  std::vector<double> numbers;
  for (const toml::node& element : *array) {
    const std::optional<double> number = number_in(element);
    if (!number || !std::isfinite(*number)) return std::nullopt;
    numbers.push_back(*number);
  }
  return numbers;
}

std::vector<const toml::table*> tables_in(const toml::node* node) {
  std::vector<const toml::table*> tables;
  if (node) {
    for (const toml::node& element : *node->as_array()) tables.push_back(element.as_table());
  }
  return tables;
}

Section::Section(const toml::table& table, const Keys& keys, std::string where) : table_(table), where_(std::move(where)) {
  const toml::key* unknown = nullptr;
  for (const auto& [key, node] : table) {
    if (!detail::find(keys, key.str()) && (!unknown || key.source().begin < unknown->source().begin)) unknown = &key;
  }
  if (unknown)
    fail(place_of(unknown->source()), "unknown key " + in_quotes(unknown->str()) + " in " + where_ + "; " +
                                          suggestion(unknown->str(), detail::names_of(keys)));
  for (const Key& key : keys) {
    if (const toml::node* node = table.get(key.name)) {
      check(key, *node);
    } else if (key.required) {
      fail(place_of(table), "no key " + in_quotes(key.name) + " in " + where_ + "; it is needed: " + key.sentence);
    }
  }
}

void Section::check(const Key& key, const toml::node& node) const {
  const auto refuse = [&](const toml::node& at, const std::string& problem) { fail_at(at, key.name, problem); };
  const auto must_be = [&](const toml::node& at, const std::string& problem) {
    refuse(at, problem + "; it must be " + expected(key));
  };
  if ((values_of(key) & value_of(node)) == 0) must_be(node, "is " + kind_of(node));
  if (const std::optional<double> number = number_in(node)) {
    if (!std::isfinite(*number)) must_be(node, "is not finite");
    if (!key.range.contains(*number)) refuse(node, "is " + toml_number(*number) + "; it must be " + sentence_of(key.range));
  }
  if (const auto* text = node.as_string(); text && !key.choices.empty()) {
    if (!is_choice(key, text->get())) {
      refuse(node, "cannot be " + in_quotes(text->get()) + "; " + suggestion(text->get(), key.choices));
    }
  }
  const toml::array* array = node.as_array();
  const std::size_t elements = array ? array->size() : node.is_table() ? node.as_table()->size() : 0;
  if (const Limit& limit = limit_of(key.name); elements > limit.count()) refuse(node, "has " + more_than(limit));
  if (!array || key.may_be(ParameterKind::rows)) return;
  if (key.count > 0) {
    const auto numbers = numbers_in(node, key.count);
    if (!numbers) refuse(node, "is a list of another kind; it must be " + expected(key) + ", all finite");
    const auto fits = [&](double n) { return key.range.contains(n) && n == std::floor(n); };
    if (key.kind == ParameterKind::whole_numbers && !std::ranges::all_of(*numbers, fits)) {
      refuse(node, "holds other numbers; it must be " + expected(key));
    }
    return;
  }
  if (key.kind == ParameterKind::vectors) {
    if (array->empty()) must_be(node, "is empty");
    for (const toml::node& element : *array) {
      if (!numbers_in(element, 3))
        refuse(element, "holds " + kind_of(element) + " that is no position; it must be [x, y, z], all finite");
    }
    return;
  }
  for (const toml::node& element : *array) {
    const bool fits = key.kind == ParameterKind::list ? element.is_table() : element.is_string();
    if (!fits) must_be(element, "holds " + kind_of(element));
  }
}

std::string text_of(const toml::node& node) {
  if (const auto* text = node.as_string()) return detail::toml_string(text->get());
  if (const auto* integer = node.as_integer()) return std::to_string(integer->get());
  if (const auto number = number_in(node)) return toml_number(*number);
  if (const auto* flag = node.as_boolean()) return flag->get() ? "true" : "false";
  std::string out;
  if (const toml::array* array = node.as_array()) {
    for (const toml::node& element : *array) out += (out.empty() ? "" : ", ") + text_of(element);
    return "[" + out + "]";
  }
  if (const toml::table* table = node.as_table()) {
    for (const auto& [key, value] : *table) {
      const bool bare = detail::is_plain_word(key.str());
      out +=
          (out.empty() ? "" : ", ") + (bare ? std::string(key.str()) : detail::toml_string(key.str())) + " = " + text_of(value);
    }
    return "{" + out + "}";
  }
  return {};
}

}  // namespace palpa::detail::scene_file
