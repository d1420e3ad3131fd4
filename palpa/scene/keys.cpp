#include "palpa/scene/keys.h"

#include <algorithm>
#include <array>
#include <limits>

#include "palpa/base/wording.h"

namespace palpa::detail {

namespace {

constexpr double unbounded = std::numeric_limits<double>::infinity();

std::string unit_of(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 7> suffixes{{{"_nms_per_rad", "N·m·s/rad"},
                                                                                   {"_ns_per_m", "N·s/m"},
                                                                                   {"_n_per_m", "N/m"},
                                                                                   {"_per_m", "unit/m"},
                                                                                   {"_nm", "N·m"},
                                                                                   {"_n", "N"},
                                                                                   {"_m", "m"}}};
  for (const auto& [suffix, unit] : suffixes) {
    if (name.ends_with(suffix)) return " [" + std::string(unit) + "]";
  }
  return {};
}

/// Format and TOML type of values by kind. In the words, N stands for the count of numbers.
struct KindWords {
  ParameterKind kind;
  std::string_view form;  ///< in tables; of numbers without unit and range
  std::string_view expected;
  unsigned values;
};
constexpr unsigned any_number = whole | floating;
constexpr std::array<KindWords, 21> kind_words{{
    {ParameterKind::number, "number", "a number", any_number},
    {ParameterKind::optional_number, "number", "a number", any_number},
    {ParameterKind::level, "number", "a number", any_number},
    {ParameterKind::whole_number, "whole number", "a whole number", whole},
    {ParameterKind::flag, "true or false", "true or false", boolean},
    {ParameterKind::text, "text", "a text in quotes", text_value},
    {ParameterKind::choice, "text", "a text in quotes", text_value},
    {ParameterKind::volume, "volume", "a volume's name in quotes", text_value},
    {ParameterKind::scalar_field, "FIELD", "a text in quotes", text_value},
    {ParameterKind::vector_field, "FIELD", "a text in quotes", text_value},
    {ParameterKind::optional_field, "FIELD", "a text in quotes", text_value},
    {ParameterKind::texts, "list of texts", "a list of texts", array},
    {ParameterKind::strength, "STRENGTH", "a number or a function {of = FIELD, points = [[value, newtons], …]}",
     any_number | table},
    {ParameterKind::vector, "[x, y, z]", "a list of N numbers", array},
    {ParameterKind::vectors, "[[x, y, z], …]", "a list of [x, y, z]", array},
    {ParameterKind::numbers, "list of N numbers", "a list of N numbers", array},
    {ParameterKind::whole_numbers, "list of N whole numbers", "a list of N whole numbers", array},
    {ParameterKind::list, "tables", "a list of tables", array},
    {ParameterKind::table, "table", "a table", table},
    {ParameterKind::named_tables, "table", "a table", table},
    {ParameterKind::rows, "list", "a list", array},
}};

const KindWords& kind_words_of(ParameterKind kind) noexcept { return *std::ranges::find(kind_words, kind, &KindWords::kind); }

std::string with_count(std::string_view words, std::size_t count) {
  std::string out(words);
  if (const std::size_t at = out.find(" N "); at != std::string::npos) out.replace(at + 1, 1, std::to_string(count));
  return out;
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
  if (!key.choices.empty()) {
    std::string words;
    for (const std::string& choice : key.choices) words += (words.empty() ? "" : " or ") + toml_string(choice);
    return words;
  }
  const std::string form = with_count(kind_words_of(key.kind).form, key.count), range = sentence_of(key.range);
  if ((kind_words_of(key.kind).values & any_number) == 0) return form;
  return form + unit_of(key.name) + (range.empty() ? "" : ", " + range);
}

std::string expected(const Key& key) {
  std::string out = with_count(kind_words_of(key.kind).expected, key.count);
  if (key.kind == ParameterKind::optional_number && !key.choices.empty()) out = in_quotes(key.choices.front()) + " or " + out;
  if (key.kind == ParameterKind::whole_numbers) out += ", each " + sentence_of(key.range);
  if (key.or_kind) out += " or " + with_count(kind_words_of(*key.or_kind).expected, key.count);
  return out;
}

unsigned values_of(const Key& key) noexcept {
  unsigned values = kind_words_of(key.kind).values;
  if (key.or_kind) values |= kind_words_of(*key.or_kind).values;
  if (key.kind == ParameterKind::optional_number && !key.choices.empty()) values |= text_value;
  return values;
}

// ---- KeyCollector

Key& KeyCollector::add(const ParameterInfo& info, std::string value) {
  const auto earlier = std::ranges::find(keys_, info.name, &Key::name);
  if (earlier != keys_.end()) {
    earlier->or_kind = info.kind;
    earlier->count = info.count;
    return *earlier;
  }
  keys_.push_back({.name = std::string(info.name),
                   .kind = info.kind,
                   .form = std::string(info.form),
                   .fallback = info.required() ? "required"
                               : info.fallback ? std::string(*info.fallback)
                                               : std::move(value),
                   .sentence = std::string(info.sentence),
                   .range = info.range,
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
void KeyCollector::vectors(const ParameterInfo& info, std::vector<Vec3>&) { add(info, ""); }
void KeyCollector::other(const ParameterInfo& info) { add(info, ""); }

Keys parameter_keys(const Mode& mode) {
  Keys keys;
  KeyCollector collector(keys);
  look_through(mode, collector);
  return keys;
}

}  // namespace palpa::detail
