#include "palpa/scene/load_scene.h"

#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <set>

#include "palpa/base/input_file.h"
#include "palpa/base/limits.h"
#include "palpa/base/toml_problem.h"
#include "palpa/base/wording.h"
#include "palpa/data/analytic.h"
#include "palpa/data/grid.h"
#include "palpa/data/labels.h"
#include "palpa/data/length_unit.h"
#include "palpa/data/read_series.h"
#include "palpa/data/timed_field.h"
#include "palpa/data/volume.h"
#include "palpa/file/read_volume.h"
#include "palpa/scene/keys.h"
#include "palpa/scene/parts.h"
#include "palpa/scene/scene_checks.h"

namespace palpa {

namespace {

using detail::Finding;
using detail::in_quotes;
using detail::Key;
using detail::Keys;
using detail::sentence_of;
using detail::suggestion;
using detail::toml_number;

constexpr std::string_view set_mark = "--set ";  // replaces the file's name in places of values from --set

// ---- Places

[[noreturn]] void fail(const std::string& place, const std::string& text) {
  throw SceneError(detail::one_line(place + ": " + text));
}

std::string place_of(const toml::source_region& region) {
  if (!region.path) return "scene";
  if (region.path->starts_with(set_mark)) return *region.path;
  return *region.path + ":" + std::to_string(region.begin.line) + ":" + std::to_string(region.begin.column);
}
std::string place_of(const toml::node& node) { return place_of(node.source()); }

// ---- Text

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

// ---- Values

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

/// `count` finite numbers in a list; nullopt for anything else.
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

/// Largest number of elements in a list or a table of this name.
const Limit& limit_of(std::string_view key) noexcept {
  static constexpr std::pair<std::string_view, Limit> limits[] = {{"mode", limit::modes},
                                                                  {"volume", limit::volumes},
                                                                  {"poses", limit::poses},
                                                                  {"points", limit::points},
                                                                  {"file", limit::volume_files}};
  const auto* found = std::ranges::find(limits, key, &std::pair<std::string_view, Limit>::first);
  return found != std::end(limits) ? found->second : limit::entries;
}

/// Elements of a list of tables; empty without a list. The caller has checked the type.
std::vector<const toml::table*> tables_in(const toml::node* node) {
  std::vector<const toml::table*> tables;
  if (node) {
    for (const toml::node& element : *node->as_array()) tables.push_back(element.as_table());
  }
  return tables;
}

/// Whether a text is valid for a key with choices: a choice, or another spelling of a unit of length.
bool is_choice(const Key& key, const std::string& text) {
  return std::ranges::find(key.choices, text) != key.choices.end() || (key.name == "length_unit" && detail::length_unit(text));
}

/// A table whose keys have all been checked against their list: known, of the right kind, in range, among the choices, none
/// missing. Later access needs no check.
class Section {
 public:
  /// `where` completes "… in ": "[coupling]", "mode 'skin'".
  Section(const toml::table& table, const Keys& keys, std::string where) : table_(table), where_(std::move(where)) {
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

  const std::string& where() const noexcept { return where_; }
  const toml::node* node(std::string_view key) const { return table_.get(key); }
  const toml::table* subtable(std::string_view key) const { return node(key) ? node(key)->as_table() : nullptr; }
  std::optional<double> number(std::string_view key) const { return node(key) ? number_in(*node(key)) : std::nullopt; }
  std::optional<std::string> text(std::string_view key) const { return table_[key].value<std::string>(); }
  /// Fails at the key: "'KEY' in WHERE …", the fault and its remedy.
  [[noreturn]] void refuse(std::string_view key, const std::string& problem) const { fail_at(*node(key), key, problem); }

 private:
  [[noreturn]] void fail_at(const toml::node& at, std::string_view key, const std::string& problem) const {
    fail(place_of(at), in_quotes(key) + " in " + where_ + " " + problem);
  }
  void check(const Key& key, const toml::node& node) const {
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
    for (const toml::node& element : *array) {
      const bool fits = key.kind == ParameterKind::list ? element.is_table() : element.is_string();
      if (!fits) must_be(element, "holds " + kind_of(element));
    }
  }

  const toml::table& table_;
  std::string where_;
};

/// Canonical text of a value, on one line.
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

// ---- --set

/// Edits the tree before it is read, so that every check applies to the new values.
class Setter {
 public:
  explicit Setter(toml::table& root) : root_(root) {}

  void set(const std::string& path, const std::string& value) {
    const std::string place = std::string(set_mark) + path;
    const std::vector<std::string> parts = split(path);
    const std::size_t n = parts.size();
    constexpr std::array tables = {"coupling", "workspace", "time", "view"};
    if (n == 2 && (path == "law.method" || std::ranges::find(tables, parts[0]) != tables.end())) {
      if (!root_.contains(parts[0])) root_.insert(toml::key(parts[0], region(place)), toml::table{});
      return put(root_[parts[0]].as_table(), parts[1], value, place);
    }
    if (n == 3 && parts[0] == "volume") {
      toml::table* volumes = root_["volume"].as_table();
      std::vector<std::string> names;
      if (volumes) {
        for (const auto& [key, node] : *volumes) names.emplace_back(key.str());
      }
      if (!volumes || !volumes->contains(parts[1]))
        fail(place, "no volume " + in_quotes(parts[1]) + "; " + suggestion(parts[1], names));
      return put((*volumes)[parts[1]].as_table(), parts[2], value, place);
    }
    if ((n == 3 || n == 5) && parts[0] == "mode") {
      toml::table& mode = item(root_, "mode", parts[1], "mode", place);
      if (n == 3) return put(&mode, parts[2], value, place);
      return put(&item(mode, parts[2], parts[3], parts[2], place), parts[4], value, place);
    }
    fail(place,
         "no such path; there are: coupling.KEY, law.method, workspace.KEY, volume.NAME.KEY, mode.NAME.KEY, "
         "mode.NAME.level.NAME.KEY, time.KEY, view.KEY");
  }

  /// Value parsed as TOML; text if that fails, so that words need no quotes.
  static void put(toml::table* table, const std::string& key, const std::string& value, const std::string& place) {
    if (!table) return;  // not a table: reported by the checks
    const std::string line = "v = " + value;
    toml::table parsed;
    if (value.size() <= limit::scene_bytes.count() && !detail::problem_with_toml(line)) {
      try {
        parsed = toml::parse(std::string_view(line), std::string_view(place));
      } catch (const toml::parse_error&) {
        parsed.clear();
      }
    }
    toml::node* node = parsed.size() == 1 ? parsed.get("v") : nullptr;
    if (!node) {
      parsed = toml::parse(std::string_view("v = " + detail::toml_string(value)), std::string_view(place));
      node = parsed.get("v");
    }
    // The key's own place is --set as well, even if it replaces a key of the file.
    table->erase(key);
    table->insert_or_assign(toml::key(key, region(place)), std::move(*node));
  }

 private:
  static std::vector<std::string> split(const std::string& path) {
    std::vector<std::string> parts(1);
    for (const char c : path) c == '.' ? parts.emplace_back() : parts.back() += c;
    return parts;
  }

  static toml::source_region region(const std::string& place) {
    return {{1, 1}, {1, 1}, std::make_shared<const std::string>(place)};
  }

  /// Table of the list `list` with the name `name`.
  static toml::table& item(toml::table& owner, const std::string& list, const std::string& name, const std::string& kind,
                           const std::string& place) {
    std::vector<std::string> names;
    if (toml::array* items = owner[list].as_array()) {
      for (toml::node& element : *items) {
        toml::table* table = element.as_table();
        const std::optional<std::string> found = table ? (*table)["name"].value<std::string>() : std::nullopt;
        if (found == name) return *table;
        if (found) names.push_back(*found);
      }
    }
    fail(place, "no " + kind + " " + in_quotes(name) + "; " + suggestion(name, names));
  }

  toml::table& root_;
};

// ---- Reading

std::string check_plain(const std::string& kind, const toml::key& word) {
  const std::string problem = detail::problem_with_name(kind, word.str());
  if (!problem.empty()) fail(place_of(word.source()), problem);
  return std::string(word.str());
}

/// `table` as a function of a field: {of, points, outside}.
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

/// Fills in a part or a mode from its table, which has been checked against its keys.
class Reader final : public ParameterVisitor {
 public:
  /// \param volumes  allowed volumes of fields; nullptr: any
  Reader(const Section& section, const Keys& keys, const std::vector<std::string>* volumes)
      : section_(section), keys_(keys), volumes_(volumes) {}

  void number(const ParameterInfo& info, double& value) override { value = section_.number(info.name).value_or(value); }
  void optional_number(const ParameterInfo& info, std::optional<double>& value) override {
    if (section_.node(info.name)) value = section_.number(info.name);
  }
  void whole_number(const ParameterInfo& info, std::optional<std::int64_t>& value) override {
    if (const toml::node* node = section_.node(info.name)) value = node->value<std::int64_t>();
  }
  void flag(const ParameterInfo& info, bool& value) override {
    if (const toml::node* node = section_.node(info.name)) value = *node->value<bool>();
  }
  void text(const ParameterInfo& info, std::string& value) override {
    const auto given = section_.text(info.name);
    if (!given) return;
    value = *given;
    if (info.kind != ParameterKind::volume || !volumes_ || std::ranges::find(*volumes_, value) != volumes_->end()) return;
    fail(place_of(*section_.node(info.name)), "no volume " + in_quotes(value) + "; " + suggestion(value, *volumes_));
  }
  void texts(const ParameterInfo& info, std::vector<std::string>& value) override {
    const toml::node* node = section_.node(info.name);
    if (!node || !node->is_array()) return;
    value.clear();
    for (const toml::node& element : *node->as_array()) value.push_back(*element.value<std::string>());
  }
  void choice(const ParameterInfo& info, int& value) override {
    const auto word = section_.text(info.name);
    if (word) value = static_cast<int>(std::ranges::find(info.choices, *word) - info.choices.begin());
  }
  void numbers(const ParameterInfo& info, std::vector<double>& value) override {
    const toml::node* node = section_.node(info.name);
    if (node && node->is_array()) value = *numbers_in(*node, info.count);
  }
  void field(const ParameterInfo& info, FieldRef& ref) override {
    if (const toml::node* node = section_.node(info.name)) ref = field_in(*node);
  }
  void strength(const ParameterInfo& info, Strength& strength) override {
    const toml::node* node = section_.node(info.name);
    if (!node) return;
    if (const auto constant = number_in(*node)) {
      strength = Strength(*constant);
      return;
    }
    auto [of, curve] = function_in(*node->as_table(), in_quotes(info.name) + " of " + section_.where(), info.range);
    strength = Strength(field_in(*node->as_table()->get("of")), std::move(curve));
  }
  void list(const ParameterInfo& info, ParameterList& list) override {
    const toml::node* node = section_.node(info.name);
    if (!node) return;
    const Keys& keys = detail::find(keys_, info.name)->items;
    const std::string in_list = in_quotes(info.name) + " of " + section_.where();
    if (info.kind == ParameterKind::table) return read(*node->as_table(), keys, in_list, list, 0);
    if (info.kind == ParameterKind::named_tables) return named_tables(*node->as_table(), *detail::find(keys_, info.name), list);
    for (const toml::table* table : tables_in(node)) {
      const auto name = (*table)["name"].value<std::string>();
      const std::string item = std::string(info.name) + " " + (name ? in_quotes(*name) : std::to_string(list.size() + 1)) +
                               " of " + section_.where();
      list.append();
      read(*table, keys, detail::find(keys, "name") ? item : in_list, list, list.size() - 1);
    }
  }

  /// Name of a field with a known volume: checked before any volume is opened.
  FieldRef field_in(const toml::node& node) const {
    const std::string name = *node.value<std::string>();
    const std::string problem = volumes_ ? detail::problem_with_volume_of(name, *volumes_) : "";
    if (!problem.empty()) fail(place_of(node), problem);
    return {name};
  }

 private:
  void read(const toml::table& table, const Keys& keys, const std::string& where, ParameterList& list, std::size_t i) const {
    const Section section(table, keys, where);
    Reader reader(section, keys, volumes_);
    list.visit(i, reader);
  }
  /// Tables keyed by a plain word: "field 'a' of …" of `fields`.
  void named_tables(const toml::table& table, const Key& key, ParameterList& list) const {
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

  const Section& section_;
  const Keys& keys_;
  const std::vector<std::string>* volumes_;
};

/// Fills in a part from its table; returns the checked table.
template <class Part>
Section read(const toml::table& table, std::string where, Part& part, const std::vector<std::string>* volumes = nullptr) {
  const Keys& keys = detail::keys_of<Part>();
  Section section(table, keys, std::move(where));
  Reader reader(section, keys, volumes);
  detail::visit_parameters(part, reader);
  return section;
}

/// Checks combinations of keys of a request.
void check_request(const Section& section, const VolumeRequest& request) {
  for (const char* key : {"byte_order", "header_bytes"}) {
    if (request.layout.type.empty() && section.node(key)) {
      section.refuse(key, "is for a file of bare numbers; give 'type', too, or leave it out");
    }
  }
  for (const VolumeRequest::FieldRequest& field : request.fields) {
    const toml::node* arrays = (*section.subtable("fields"))[field.name]["arrays"].node();
    if (!arrays || (field.arrays.size() == 3 && field.array.empty())) continue;
    fail(place_of(*arrays), "'arrays' in field " + in_quotes(field.name) + " of " + section.where() +
                                (field.array.empty() ? " has " + std::to_string(field.arrays.size()) +
                                                           " names; it must be a list of 3, along x, y and z"
                                                     : " stands beside 'array'; give one of them"));
  }
}

class Loader {
 public:
  Loader(const std::string& text, std::string name, std::filesystem::path folder, const VolumeReader& read_volume,
         const ModeCatalog& catalog, const SceneOptions& options)
      : name_(std::move(name)),
        folder_(std::move(folder)),
        read_volume_(read_volume),
        catalog_(catalog),
        options_(options),
        root_(parse_toml(text, name_)) {}

  LoadedScene load() {
    for (const auto& [path, value] : options_.sets) Setter(root_).set(path, value);
    check_format();
    const Section scene = read_header();
    read_table(scene, "coupling", loaded_.scene.coupling);
    detail::LawPart law{loaded_.scene.law};
    read_table(scene, "law", law);
    loaded_.scene.law = law.method;
    const std::vector<VolumePlan> volumes = plan_volumes(scene);
    read_table(scene, "workspace", loaded_.scene.workspace);
    read_table(scene, "time", loaded_.scene.time);
    read_view(scene);
    std::vector<SceneMode> modes = read_modes(scene);

    for (const VolumePlan& plan : volumes) open(plan);
    for (std::size_t i = 0; i < modes.size(); ++i) {
      refuse_first(detail::field_findings(loaded_.scene, modes[i], i));
      loaded_.scene.add(std::move(modes[i].name), std::move(modes[i].mode), std::move(modes[i].masks), modes[i].enabled);
    }
    for (std::size_t i = 0; i < loaded_.scene.modes().size(); ++i) derive_fields(loaded_.scene.modes()[i], i);
    std::vector<Finding> warnings = refuse_first(detail::findings(loaded_.scene));
    std::ranges::move(detail::layer_findings(loaded_.scene, loaded_.scene.layers), std::back_inserter(warnings));
    if (options_.thin_parts) {
      std::vector<std::string> chose;
      for (const VolumePlan& plan : volumes) {
        if (plan.filter) chose.push_back(plan.name);
      }
      std::ranges::move(detail::thin_part_findings(loaded_.scene, chose), std::back_inserter(warnings));
    }
    for (const Finding& finding : warnings) {
      loaded_.warnings.push_back(detail::one_line(place_of(finding.part) + ": " + finding.text));
    }
    return std::move(loaded_);
  }

 private:
  /// A volume before it is opened.
  struct VolumePlan : detail::VolumePart {
    std::string name;
    const toml::table* table = nullptr;
    Similarity placed;                                   // `pose`
    PoseTrack track;                                     // `poses`
    std::vector<std::pair<std::string, double>> labels;  // names of fields, and their label numbers
    std::string source;
  };

  /// The format comes first: another format may have other keys.
  void check_format() const {
    const toml::node* format = root_.get("palpa");
    if (!format) fail(name_ + ":1:1", "no format; a scene begins with 'palpa = 1'");
    if (const auto* number = format->as_integer(); number && number->get() != 1)
      fail(place_of(*format),
           "scene format " + std::to_string(number->get()) + " is not known; this program reads 'palpa = 1'");
  }

  Section read_header() {
    detail::HeaderPart header;
    const Section scene = read(root_, "the scene", header);
    loaded_.scene.title = header.title;
    loaded_.scene.needs = header.needs;
    for (std::size_t i = 0; i < loaded_.scene.needs.size(); ++i) {
      const std::string& type = loaded_.scene.needs[i];
      if (!catalog_.find(type))
        fail(place_of(*scene.node("needs")->as_array()->get(i)),
             "needs the mode type " + in_quotes(type) + ", which is not there; " + suggestion(type, types()) +
                 ", and what plug-ins bring that are named with --plugin FILE");
    }
    return scene;
  }

  /// [KEY] of the scene.
  template <class Part>
  void read_table(const Section& scene, const std::string& key, Part& part) const {
    if (const toml::table* table = scene.subtable(key)) read(*table, "[" + key + "]", part, &volume_names_);
  }

  void read_view(const Section& scene) {
    const toml::table* table = scene.subtable("view");
    if (!table) return;
    ViewOptions& options = loaded_.scene.view;
    const Section view = read(*table, "[view]", options);
    if (options.from && norm(*options.from) == 0.0) {
      fail(place_of(*view.node("from")), "'from' is [0, 0, 0]; a direction of the world is no zero, such as [1, 0, 0]");
    }
    for (const toml::table* layer_table : tables_in(view.node("layer"))) {
      ViewLayer& layer_read = loaded_.scene.layers.emplace_back();
      const Section layer = read(*layer_table, "[[view.layer]]", layer_read);
      const toml::table* colors = layer.subtable("colors");
      if (!colors) continue;
      const Section section(*colors, detail::keys_of<detail::ColorsPart>(), "'colors' of [[view.layer]]");
      for (const toml::node& point : *section.node("points")->as_array()) {
        if (!is_color_point(point)) {
          fail(place_of(point),
               "a point of 'colors' is something else; points are [[value, \"#rrggbb\", opacity from 0 to 1], …]");
        }
        const toml::array& parts = *point.as_array();
        layer_read.colors.push_back(
            {*number_in(*parts.get(0)), *parts.get(1)->value<std::string>(), *number_in(*parts.get(2))});
      }
    }
  }

  static bool is_color_point(const toml::node& node) {
    const toml::array* point = node.as_array();
    if (!point || point->size() != 3) return false;
    const auto value = number_in(*point->get(0));
    const auto color = point->get(1)->value<std::string>();
    const auto opacity = number_in(*point->get(2));
    return value && std::isfinite(*value) && color && color->size() == 7 && color->front() == '#' &&
           color->find_first_not_of("0123456789abcdefABCDEF", 1) == std::string::npos && opacity && *opacity >= 0.0 &&
           *opacity <= 1.0;
  }

  // ---- Volumes

  std::vector<VolumePlan> plan_volumes(const Section& scene) {
    const toml::table* volumes = scene.subtable("volume");
    std::vector<std::pair<const toml::key*, const toml::node*>> in_order;
    if (volumes) {
      for (const auto& [key, node] : *volumes) in_order.emplace_back(&key, &node);
    }
    // A table loses the order of the file; the first volume is the default of a workspace's fit.
    std::ranges::stable_sort(in_order,
                             [](const auto& a, const auto& b) { return a.first->source().begin < b.first->source().begin; });

    std::vector<VolumePlan> plans;
    for (const auto& [key, node] : in_order) {
      const std::string name = check_plain("volume", *key);
      if (!node->is_table())
        fail(place_of(*node), "volume " + in_quotes(name) + " is " + kind_of(*node) + "; it must be a table");
      plans.push_back(plan_volume(name, *node->as_table()));
      volume_names_.push_back(name);
    }
    return plans;
  }

  VolumePlan plan_volume(const std::string& name, const toml::table& table) const {
    VolumePlan plan;
    plan.name = name;
    plan.table = &table;
    const Section section = read(table, "volume " + in_quotes(name), static_cast<detail::VolumePart&>(plan));
    check_request(section, plan.request);
    if (const toml::table* labels = section.subtable("labels")) {
      for (const auto& [key, node] : *labels) {
        const std::string label = check_plain("label", key);
        if (!node.is_integer()) {
          fail(place_of(node), "label " + in_quotes(label) + " is " + kind_of(node) + "; it must be a whole number of the map");
        }
        plan.labels.emplace_back(label, static_cast<double>(node.as_integer()->get()));
      }
    }
    place(section, plan);
    const int sources = !plan.analytic.empty() + (section.node("file") != nullptr) + (section.node("files") != nullptr);
    if (sources != 1) {
      fail(place_of(table), "volume " + in_quotes(name) + " has " + (sources == 0 ? "no data" : "two sources") +
                                "; give either 'file' or 'analytic'");
    }
    const bool formula = !plan.analytic.empty();
    for (const Key& key : detail::keys_of<VolumeRequest>()) {
      if (formula && section.node(key.name)) section.refuse(key.name, "speaks of a file; leave it out with 'analytic'");
    }
    if (plan.sampled && !formula) section.refuse("sampled", "is for embedded data; leave it out with 'file'");
    check_series(section, plan);
    for (const char* key : {"filter", "sign"}) {
      if (formula && !plan.sampled && section.node(key)) {
        section.refuse(key, "speaks of voxels, and a formula has none; give 'sampled', too, or leave it out");
      }
    }
    if (!formula) find_data(section, plan);
    for (const Key& key : detail::keys_of<detail::VolumePart>()) {
      if (const toml::node* node = section.node(key.name)) plan.source += key.name + " = " + text_of(*node) + "\n";
    }
    return plan;
  }

  static void check_series(const Section& section, const VolumePlan& plan) {
    const bool grids_of_formula =
        plan.sampled && std::ranges::find(beating_volumes(), plan.analytic, &AnalyticVolume::name) != beating_volumes().end();
    if (section.node("frames") && !grids_of_formula) {
      section.refuse("frames", "is for embedded data that change with time, with 'sampled'; leave it out");
    }
    if (section.node("files")) {
      if (!plan.frame_period_s) section.refuse("files", "is a time series; say the time from frame to frame, 'frame_period_s'");
      if (section.node("frame")) section.refuse("frame", "speaks of one file with several frames; leave it out with 'files'");
    } else if (section.node("file")) {
      if (section.node("frame") && plan.frame_period_s) {
        section.refuse("frame", "takes one frame, and 'frame_period_s' all of them; leave one out");
      }
    } else if (plan.frame_period_s && !grids_of_formula) {
      section.refuse("frame_period_s", "is for a time series, of files or sampled from embedded data; leave it out");
    }
    if (section.node("between_frames") && !plan.frame_period_s && !grids_of_formula) {
      section.refuse("between_frames", "is for a time series; give 'frame_period_s' too, or leave it out");
    }
  }

  void find_data(const Section& section, VolumePlan& plan) const {
    std::vector<std::filesystem::path>& files = plan.request.files;
    if (section.node("files")) {
      files = find_files(plan.series, section);
    } else if (section.text("file")) {
      files = {find_file(plan.file, section)};
    } else {
      for (const std::string& file : plan.files) files.push_back(find_file(file, section));
      if (files.empty()) section.refuse("file", "is an empty list; name a file");
    }
  }

  /// Beside the scene, then in each data folder, then in $PALPA_DATA.
  std::vector<std::filesystem::path> candidates_of(const std::filesystem::path& path) const {
    if (path.is_absolute()) return {path};
    std::vector<std::filesystem::path> candidates{folder_ / path};
    for (const std::filesystem::path& data : options_.data_folders) candidates.push_back(data / path);
    if (const char* data = std::getenv("PALPA_DATA"); data && *data) candidates.push_back(std::filesystem::path(data) / path);
    return candidates;
  }

  std::filesystem::path find_file(const std::string& file, const Section& section) const {
    if (file.empty() || file.find('\0') != std::string::npos) section.refuse("file", "is no path; give the path of a file");
    const std::filesystem::path path(file);
    std::vector<std::string> looked;
    for (const std::filesystem::path& candidate : candidates_of(path)) {
      std::error_code ignored;
      if (std::filesystem::exists(place_in_file(candidate).file, ignored)) return candidate;
      looked.push_back(candidate.string());
    }
    const std::string hint = path.is_absolute() ? "" : "; name the folder it is in with --data or $PALPA_DATA";
    fail(place_of(*section.node("file")),
         "no file " + in_quotes(file) + " for " + section.where() + "; looked for " + detail::joined(looked) + hint);
  }

  /// Files of a series, in the order of their frames: the matches in the first folder with any.
  std::vector<std::filesystem::path> find_files(const std::string& pattern, const Section& section) const {
    const toml::node& node = *section.node("files");
    const std::filesystem::path path(pattern);
    if (pattern.empty() || pattern.find('\0') != std::string::npos || !path.has_filename()) {
      section.refuse("files", "is no pattern of paths; give one like \"phase_*.vti\"");
    }
    std::vector<std::string> looked;
    for (const std::filesystem::path& candidate : candidates_of(path)) {
      const std::vector<std::filesystem::path> found = files_matching(candidate);
      if (found.size() == 1) {
        fail(place_of(node), "only " + in_quotes(found.front().string()) + " matches 'files' in " + section.where() +
                                 "; a series has several frames: give one file as 'file'");
      }
      if (found.size() > limit::series_files.count()) section.refuse("files", "matches " + more_than(limit::series_files));
      if (!found.empty()) return found;
      looked.push_back(candidate.string());
    }
    fail(place_of(node), "no files match " + in_quotes(pattern) + " for " + section.where() + "; looked for " +
                             detail::joined(looked) +
                             (path.is_absolute() ? "" : "; name the folder they are in with --data or $PALPA_DATA"));
  }

  static void place(const Section& volume, VolumePlan& plan) {
    if (const toml::table* pose = volume.subtable("pose")) plan.placed = similarity_of(plan.pose, *pose, volume);
    const toml::node* node = volume.node("poses");
    if (!node) return;
    if (volume.node("pose")) {
      fail(place_of(*node), "both 'pose' and 'poses' are given in " + volume.where() + "; use one of them");
    }
    const std::string poses = "'poses' of " + volume.where();
    const std::vector<const toml::table*> tables = tables_in(node);
    for (std::size_t i = 0; i < tables.size(); ++i) {
      plan.track.push_back({plan.poses[i].time_s, similarity_of(plan.poses[i].pose, *tables[i], volume)});
    }
    std::size_t wrong = 0;
    if (const char* problem = plan.track.empty() ? nullptr : problem_with(plan.track, &wrong))
      fail(place_of(*tables[wrong]), poses + ": " + problem);
    if (tables.size() < 2) {
      fail(place_of(*node), poses + " has " + (tables.empty() ? "none" : "one") + "; what moves has at least two: use 'pose'");
    }
  }

  static Similarity similarity_of(const detail::PosePart& pose, const toml::table& table, const Section& volume) {
    const auto& [x, y, z, degrees] = pose.rotate_axis_deg;
    const Vec3 axis{x, y, z};
    if (axis == Vec3{}) {
      fail(place_of(*table.get("rotate_axis_deg")),
           "the axis in 'rotate_axis_deg' of " + volume.where() + " is zero; give [x, y, z, degrees]");
    }
    return {rotation_about(axis, degrees), pose.scale, pose.translate_m};
  }

  static Volume make(const VolumePlan& plan) {
    Volume volume = analytic_volume(plan.analytic)->make();
    if (!plan.sampled) return volume;
    const int longest = *plan.sampled;
    if (!timed(*volume.fields.front().field)) return sampled(volume, longest);
    volume = sampled(volume, longest, plan.frames, plan.between_frames);
    if (!plan.frame_period_s) return volume;
    for (VolumeField& f : volume.fields) {
      f.field = time_series(series_of(*f.field)->frames, *plan.frame_period_s, plan.between_frames);
    }
    return volume;
  }

  /// Result of `act`; its SceneError is placed at `node` of the volume's table.
  template <class Act>
  static auto at(const toml::node& node, const VolumePlan& plan, Act act) {
    try {
      return act();
    } catch (const SceneError& error) {
      fail(place_of(node), error.what());
    } catch (const std::invalid_argument& error) {
      fail(place_of(node), "volume " + in_quotes(plan.name) + ": " + error.what());
    } catch (const std::bad_alloc&) {
      fail(place_of(node), "not enough memory for volume " + in_quotes(plan.name) + "; use smaller data");
    }
  }

  Volume data_of(const VolumePlan& plan) const {
    if (!plan.analytic.empty()) return make(plan);
    return plan.frame_period_s ? read_series(plan.request, *plan.frame_period_s, plan.between_frames, read_volume_)
                               : read_volume_(plan.request);
  }

  void open(const VolumePlan& plan) {
    Scene& scene = loaded_.scene;
    Volume volume = at(*plan.table, plan, [&] { return data_of(plan); });
    for (const auto& [label, value] : plan.labels) {
      const toml::node& node = *plan.table->get("labels");
      if (std::ranges::find(volume.fields, label, &VolumeField::name) != volume.fields.end()) {
        fail(place_of(node),
             "volume " + in_quotes(plan.name) + " has a field " + in_quotes(label) + " already; give the label another name");
      }
      volume.fields.push_back(
          {label, "", at(node, plan, [&, v = value] { return label_field(*volume.fields.front().field, v); })});
    }
    if (const toml::node* sign = plan.table->get("sign")) volume = at(*sign, plan, [&] { return signless(volume); });
    if (const toml::node* node = plan.table->get("filter")) {
      volume = at(*node, plan, [&] { return filtered(volume, plan.filter); });
    }
    warn_of_other_space(plan, volume);
    at(*plan.table, plan, [&] {
      return plan.track.empty() ? scene.add(plan.name, std::move(volume), plan.placed, plan.filter)
                                : scene.add_moving(plan.name, std::move(volume), plan.track, plan.filter);
    });
    SceneVolume& added = *scene.find_volume(plan.name);
    added.source = plan.source;
    added.smoothing_m = plan.smoothing_m.value_or(0.0);
    for (const std::string& warning : added.volume.warnings) warn_of(plan, warning);
  }

  void warn_of(const VolumePlan& plan, const std::string& warning) {
    loaded_.warnings.push_back(detail::one_line(place_of(*plan.table) + ": volume " + in_quotes(plan.name) + ": " + warning));
  }

  /// Scans of one patient on two days have similar positions with different meanings.
  void warn_of_other_space(const VolumePlan& plan, const Volume& volume) {
    if (plan.table->contains("pose") || plan.table->contains("poses")) return;  // registered by the user
    for (const SceneVolume& earlier : loaded_.scene.volumes()) {
      const std::string& space = earlier.volume.frame_of_reference;
      if (space.empty() || volume.frame_of_reference.empty() || space == volume.frame_of_reference) continue;
      return warn_of(plan, "is in another frame of reference than volume " + in_quotes(earlier.name) +
                               ": they lie together only by chance; register one to the other, or give it a pose");
    }
  }

  // ---- Modes

  std::vector<std::string> types() const {
    std::vector<std::string> types;
    for (const Mode& mode : catalog_.modes()) types.emplace_back(mode.type());
    return types;
  }

  std::vector<SceneMode> read_modes(const Section& scene) {
    mode_tables_ = tables_in(scene.node("mode"));
    if (mode_tables_.empty()) {
      fail(scene.node("mode") ? place_of(*scene.node("mode")) : name_ + ":1:1",
           "a scene without modes cannot be felt; add a [[mode]]");
    }
    std::vector<SceneMode> modes;
    std::set<std::string> names;
    for (std::size_t i = 0; i < mode_tables_.size(); ++i) {
      modes.push_back(read_mode(*mode_tables_[i], i));
      if (!names.insert(modes.back().name).second)
        fail(place_of(*mode_tables_[i]->get("name")), detail::name_is_taken("mode", modes.back().name));
      refuse_first(detail::parameter_findings(modes.back(), i));
    }
    return modes;
  }

  SceneMode read_mode(const toml::table& table, std::size_t number) const {
    const auto given_name = table["name"].value<std::string>();
    const std::string where = given_name ? "mode " + in_quotes(*given_name) : "mode " + std::to_string(number + 1);
    // The keys depend on the type, so that comes first.
    const toml::node* type = table.get("type");
    const Mode* example = type && type->is_string() ? catalog_.find(*type->value<std::string>()) : nullptr;
    if (type && type->is_string() && !example) {
      const std::string word = *type->value<std::string>();
      fail(place_of(*type), "unknown mode type " + in_quotes(word) + " in " + where + "; " + suggestion(word, types()));
    }
    Keys keys = detail::keys_of<detail::ModePart>();
    if (example) std::ranges::move(detail::parameter_keys(*example), std::back_inserter(keys));
    if (!type) fail(place_of(table), "no key 'type' in " + where + "; it is needed: one of " + detail::joined(types()));
    const Section section(table, keys, where);

    detail::ModePart part;
    Reader reader(section, keys, &volume_names_);
    detail::visit_parameters(part, reader);
    SceneMode mode{part.name, *example, part.enabled, {}};
    mode.mode.visit(reader);
    for (const toml::table* mask : tables_in(section.node("mask"))) {
      auto [of, curve] = function_in(*mask, "'mask' of " + where, {0, 1});
      mode.masks.push_back({reader.field_in(*mask->get("of")), std::move(curve)});
    }
    return mode;
  }

  /// Computes the derived fields of a mode, so that failures are reported here.
  void derive_fields(const SceneMode& mode, std::size_t number) const {
    struct Deriver final : ParameterVisitor {
      explicit Deriver(const Scene& of) : scene(of) {}
      void field(const ParameterInfo& info, FieldRef& ref) override {
        if (ref.name.empty()) return;
        info.felt ? scene.field(ref, *info.felt) : scene.field(ref).field;
      }
      void companion(FieldRef&, const FieldRef& of, Derivation felt) override { scene.field(of, felt); }
      void strength(const ParameterInfo&, Strength& strength) override {
        if (!strength.is_constant()) scene.field(strength.of);
      }
      void list(const ParameterInfo&, ParameterList& list) override {
        for (std::size_t i = 0; i < list.size(); ++i) list.visit(i, *this);
      }
      const Scene& scene;
    };
    const auto place = [&] { return place_of(detail::Part{.section = "mode", .mode = number, .list = {}, .key = {}}); };
    try {
      Deriver deriver(loaded_.scene);
      look_through(mode.mode, deriver);
      for (const Mask& mask : mode.masks) loaded_.scene.field(mask.of);
    } catch (const std::invalid_argument& error) {
      fail(place(), "what " + detail::called(mode) + " feels cannot be derived: " + error.what());
    } catch (const std::bad_alloc&) {
      fail(place(), "not enough memory for what " + detail::called(mode) + " derives from its fields; use smaller data");
    }
  }

  // ---- Findings

  /// Fails at the first error; returns the warnings.
  std::vector<Finding> refuse_first(std::vector<Finding> found) const {
    for (const Finding& finding : found) {
      if (!finding.warning) fail(place_of(finding.part), finding.text);
    }
    return found;
  }

  /// Place of the nearest node in the file.
  std::string place_of(const detail::Part& part) const {
    const toml::node* nearest = part.section == "mode" ? mode_tables_[part.mode] : root_.get(part.section);
    const auto step = [&](const toml::node* to) {
      if (to) nearest = to;
      return to != nullptr;
    };
    const toml::table* table = nearest ? nearest->as_table() : nullptr;
    if (table && !part.list.empty() && step(table->get(part.list))) {
      step(nearest->as_array()->get(part.item));
      table = nearest->as_table();
    }
    if (table) step(table->get(part.key));
    return nearest ? palpa::place_of(*nearest) : name_ + ":1:1";
  }
  static std::string place_of(const toml::node& node) { return palpa::place_of(node); }

  std::string name_;
  std::filesystem::path folder_;
  const VolumeReader& read_volume_;
  const ModeCatalog& catalog_;
  const SceneOptions& options_;
  toml::table root_;
  std::vector<std::string> volume_names_;
  std::vector<const toml::table*> mode_tables_;
  LoadedScene loaded_;
};

}  // namespace

LoadedScene parse_scene(std::string text, const std::string& name, const std::filesystem::path& folder,
                        const VolumeReader& read_volume, const ModeCatalog& modes, const SceneOptions& options) {
  LoadedScene loaded = Loader(text, name, folder, read_volume, modes, options).load();
  loaded.text = std::move(text);
  return loaded;
}

LoadedScene load_scene(const std::filesystem::path& path, const SceneOptions& options) {
  return load_scene(path, volume_reader(), standard_modes(), options);
}

LoadedScene load_scene(const std::filesystem::path& path, const VolumeReader& read_volume, const ModeCatalog& modes,
                       const SceneOptions& options) {
  const std::string name = path.string();
  const std::string of_data = "; for data, 'palpa info " + name + " --scene first.toml' writes a scene that can be run";
  const detail::InputFile file(path);
  if (file.why_not() == detail::NoInput::folder) fail(name, "a folder, no scene" + of_data);
  if (file.why_not() == detail::NoInput::missing) fail(name, "no such scene; name a scene file (.toml)");
  if (!file.is_open()) fail(name, file.problem() + "; name a scene file (.toml)");
  if (file.bytes() > limit::scene_bytes.count()) fail(name, "longer than " + quantity(limit::scene_bytes) + of_data);
  std::string text = detail::read_whole(file, limit::scene_bytes, "name a scene file (.toml)");
  if (path.extension() != ".toml") {
    try {
      parse_toml(text, name);
    } catch (const SceneError&) {
      fail(name, "no scene" + of_data);
    }
  }
  return parse_scene(std::move(text), name, path.parent_path(), read_volume, modes, options);
}

namespace {

void add_paths(const std::string& before, const Keys& keys, std::vector<std::string>& paths) {
  for (const Key& key : keys) {
    if (key.name == "name") continue;  // part of the path itself
    const std::string path = before + key.name;
    paths.push_back(path);
    for (const std::string& choice : key.choices) paths.push_back(path + "=" + choice);
    if (key.kind == ParameterKind::flag) paths.insert(paths.end(), {path + "=true", path + "=false"});
  }
}

std::vector<std::pair<std::string, const toml::table*>> named_in(const toml::table& owner, std::string_view list) {
  std::vector<std::pair<std::string, const toml::table*>> named;
  if (const toml::array* items = owner[list].as_array()) {
    for (const toml::node& item : *items) {
      const toml::table* table = item.as_table();
      const auto name = table ? (*table)["name"].value<std::string>() : std::nullopt;
      if (name && detail::is_plain_word(*name)) named.emplace_back(*name, table);
    }
  }
  return named;
}

}  // namespace

std::vector<std::string> set_paths(const std::string& text, const ModeCatalog& modes) {
  std::vector<std::string> paths;
  add_paths("coupling.", detail::keys_of<CouplingOptions>(), paths);
  add_paths("law.", detail::keys_of<detail::LawPart>(), paths);
  add_paths("workspace.", detail::keys_of<Workspace>(), paths);
  add_paths("time.", detail::keys_of<TimeOptions>(), paths);
  toml::table root;
  try {
    root = parse_toml(text, "scene");
  } catch (const SceneError&) {
    return paths;
  }
  if (const toml::table* volumes = root["volume"].as_table()) {
    for (const auto& [name, volume] : *volumes) {
      if (detail::is_plain_word(name.str()))
        add_paths("volume." + std::string(name.str()) + ".", detail::keys_of<detail::VolumePart>(), paths);
    }
  }
  for (const auto& [name, table] : named_in(root, "mode")) {
    const std::string before = "mode." + name + ".";
    add_paths(before, detail::keys_of<detail::ModePart>(), paths);
    const Mode* mode = modes.find((*table)["type"].value_or(std::string()));
    if (!mode) continue;
    for (const Key& key : detail::parameter_keys(*mode)) {
      if (key.items.empty()) {
        add_paths(before, {key}, paths);
      } else {
        for (const auto& [item, unused] : named_in(*table, key.name))
          add_paths(before + key.name + "." + item + ".", key.items, paths);
      }
    }
  }
  return paths;
}

std::vector<std::string> how_to_read_paths() {
  std::vector<std::string> paths;
  add_paths("", detail::keys_of<VolumeRequest>(), paths);
  return paths;
}

VolumeRequest how_to_read(const std::vector<std::pair<std::string, std::string>>& keys) {
  toml::table table;
  for (const auto& [key, value] : keys) Setter::put(&table, key, value, std::string(set_mark) + key);
  VolumeRequest request;
  check_request(read(table, "--set", request), request);
  return request;
}

}  // namespace palpa
