#include "palpa/scene/keys.h"

#include <algorithm>
#include <array>
#include <limits>

#include "palpa/scene/wording.h"

namespace palpa::detail {

namespace {

constexpr double unbounded = std::numeric_limits<double>::infinity();

std::string unit_of(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 5> suffixes{
      {{"_ns_per_m", "N·s/m"}, {"_n_per_m", "N/m"}, {"_per_m", "unit/m"}, {"_n", "N"}, {"_m", "m"}}};
  for (const auto& [suffix, unit] : suffixes) {
    if (name.ends_with(suffix)) return " [" + std::string(unit) + "]";
  }
  return {};
}

std::string words_of(const Key& key) {
  if (key.choices.empty()) return "text";
  std::string words;
  for (const std::string& choice : key.choices) words += (words.empty() ? "" : " or ") + toml_string(choice);
  return words;
}

std::string expected_of(const Key& key, ParameterKind kind) {
  const std::string count = std::to_string(key.count);
  switch (kind) {
    case ParameterKind::number:
    case ParameterKind::level: return "a number";
    case ParameterKind::optional_number:
      return key.choices.empty() ? "a number" : in_quotes(key.choices.front()) + " or a number";
    case ParameterKind::whole_number: return "a whole number";
    case ParameterKind::flag: return "true or false";
    case ParameterKind::text:
    case ParameterKind::choice:
    case ParameterKind::scalar_field:
    case ParameterKind::vector_field:
    case ParameterKind::optional_field: return "a text in quotes";
    case ParameterKind::volume: return "a volume's name in quotes";
    case ParameterKind::texts: return "a list of texts";
    case ParameterKind::vector:
    case ParameterKind::numbers: return "a list of " + count + " numbers";
    case ParameterKind::whole_numbers: return "a list of " + count + " whole numbers, each " + sentence_of(key.range);
    case ParameterKind::strength: return "a number or a function {of = FIELD, points = [[value, newtons], …]}";
    case ParameterKind::list: return "a list of tables";
    case ParameterKind::table:
    case ParameterKind::named_tables: return "a table";
    case ParameterKind::rows: return "a list";
  }
  return {};
}

}  // namespace

std::string sentence_of(const Range& range) {
  if (range.low == -unbounded && range.high == unbounded) return {};
  const std::string low = (range.above_low ? "above " : "at least ") + toml_number(range.low);
  if (range.high == unbounded) return low;
  if (range.low == range.high) return toml_number(range.low);
  if (range.above_low) return low + " and at most " + toml_number(range.high);
  return "between " + toml_number(range.low) + " and " + toml_number(range.high);
}

const Key* find(const Keys& keys, std::string_view name) noexcept {
  const auto found = std::ranges::find(keys, name, &Key::name);
  return found == keys.end() ? nullptr : &*found;
}

std::vector<std::string> names_of(const Keys& keys) {
  std::vector<std::string> names;
  for (const Key& key : keys) names.push_back(key.name);
  return names;
}

std::string form_of(const Key& key) {
  if (key.kind == ParameterKind::named_tables) return "{NAME = " + key.form + "}";
  if (!key.form.empty()) return key.form;
  const std::string sentence = sentence_of(key.range), range = sentence.empty() ? "" : ", " + sentence;
  switch (key.kind) {
    case ParameterKind::number:
    case ParameterKind::optional_number:
    case ParameterKind::level: return "number" + unit_of(key.name) + range;
    case ParameterKind::whole_number: return "whole number" + range;
    case ParameterKind::flag: return "true or false";
    case ParameterKind::text:
    case ParameterKind::choice: return words_of(key);
    case ParameterKind::texts: return "list of texts";
    case ParameterKind::volume: return "volume";
    case ParameterKind::scalar_field:
    case ParameterKind::vector_field:
    case ParameterKind::optional_field: return "FIELD";
    case ParameterKind::strength: return "STRENGTH" + unit_of(key.name) + range;
    case ParameterKind::vector:
    case ParameterKind::numbers:
    case ParameterKind::whole_numbers: return "list of " + std::to_string(key.count) + " numbers";
    case ParameterKind::list: return "tables";
    case ParameterKind::table:
    case ParameterKind::named_tables: return "table";
    case ParameterKind::rows: return "list";
  }
  return {};
}

std::string expected(const Key& key) {
  return expected_of(key, key.kind) + (key.or_kind ? " or " + expected_of(key, *key.or_kind) : "");
}

// ---- KeyCollector

Key& KeyCollector::add(const ParameterInfo& info, std::string value) {
  const auto earlier = std::ranges::find(keys_, info.name, &Key::name);
  if (earlier != keys_.end()) {
    earlier->or_kind = info.kind;
    earlier->count = info.count;
    return *earlier;
  }
  const bool ranged = info.kind == ParameterKind::number || info.kind == ParameterKind::optional_number ||
                      info.kind == ParameterKind::whole_number || info.kind == ParameterKind::whole_numbers ||
                      info.kind == ParameterKind::strength;
  keys_.push_back({.name = std::string(info.name),
                   .kind = info.kind,
                   .form = std::string(info.form),
                   .fallback = info.required() ? "required"
                               : info.fallback ? std::string(*info.fallback)
                                               : std::move(value),
                   .sentence = std::string(info.sentence),
                   .range = ranged ? info.range : Range{-unbounded, unbounded},
                   .choices = {info.choices.begin(), info.choices.end()},
                   .count = info.count,
                   .required = info.required()});
  return keys_.back();
}

void KeyCollector::number(const ParameterInfo& info, double& value) { add(info, toml_number(value)); }
void KeyCollector::optional_number(const ParameterInfo& info, std::optional<double>& value) {
  add(info, value ? toml_number(*value) : "");
}
void KeyCollector::flag(const ParameterInfo& info, bool& value) { add(info, value ? "true" : "false"); }
void KeyCollector::text(const ParameterInfo& info, std::string& value) { add(info, value.empty() ? "" : toml_string(value)); }
void KeyCollector::choice(const ParameterInfo& info, int& value) {
  add(info, value < 0 ? "" : toml_string(info.choices[static_cast<std::size_t>(value)]));
}
void KeyCollector::field(const ParameterInfo& info, FieldRef&) { add(info, ""); }
void KeyCollector::strength(const ParameterInfo& info, Strength& value) {
  add(info, value.is_constant() ? toml_number(value.constant_n) : "a function");
}
void KeyCollector::list(const ParameterInfo& info, ParameterList& list) {
  Key& key = add(info, "");
  KeyCollector items(key.items);
  list.visit_default(items);
  if (key.kind == ParameterKind::named_tables) std::erase_if(key.items, [](const Key& item) { return item.name == "name"; });
}
void KeyCollector::whole_number(const ParameterInfo& info, std::optional<std::int64_t>& value) {
  add(info, value ? std::to_string(*value) : "");
}
void KeyCollector::numbers(const ParameterInfo& info, std::vector<double>& value) {
  add(info, value.empty() ? "" : toml_numbers(value));
}
void KeyCollector::texts(const ParameterInfo& info, std::vector<std::string>&) { add(info, ""); }
void KeyCollector::other(const ParameterInfo& info) { add(info, ""); }

Keys parameter_keys(const Mode& mode) {
  Keys keys;
  KeyCollector collector(keys);
  Mode example = mode;
  example.visit(collector);
  return keys;
}

}  // namespace palpa::detail
