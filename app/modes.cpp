#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/commands.h"
#include "app/terminal.h"
#include "palpa/base/printed.h"
#include "palpa/base/wording.h"
#include "palpa/mode/plugin.h"
#include "palpa/scene/load_scene.h"

namespace palpa::app {
namespace {

using Json = nlohmann::ordered_json;

const char* name_of(ParameterKind kind) {
  switch (kind) {
    case ParameterKind::number:
    case ParameterKind::optional_number: return "number";
    case ParameterKind::flag: return "flag";
    case ParameterKind::text: return "text";
    case ParameterKind::choice: return "choice";
    case ParameterKind::scalar_field: return "scalar field";
    case ParameterKind::vector_field: return "vector field";
    case ParameterKind::optional_field: return "field";
    case ParameterKind::strength: return "strength";
    case ParameterKind::level: return "level";
    case ParameterKind::vector: return "vector";
    case ParameterKind::vectors: return "vectors";
    case ParameterKind::list: return "list";
    case ParameterKind::whole_number: return "whole number";
    case ParameterKind::texts: return "texts";
    case ParameterKind::volume: return "volume";
    case ParameterKind::numbers: return "numbers";
    case ParameterKind::whole_numbers: return "whole numbers";
    case ParameterKind::table: return "table";
    case ParameterKind::named_tables: return "tables";
    case ParameterKind::rows: return "rows";
  }
  return "";
}

/// Parameters of a mode as JSON: name, kind, sentence, and further properties.
class JsonOfParameters final : public ParameterVisitor {
 public:
  void number(const ParameterInfo& info, double& value) override {
    Json& entry = add(info);
    if (info.required()) return;
    entry["default"] = value;
    add_range(entry, info);
  }
  void optional_number(const ParameterInfo& info, std::optional<double>&) override { add_range(add(info), info); }
  void flag(const ParameterInfo& info, bool& value) override { add(info)["default"] = value; }
  void text(const ParameterInfo& info, std::string& value) override { add(info)["default"] = value; }
  void choice(const ParameterInfo& info, int& value) override {
    Json& entry = add(info);
    entry["default"] = info.choices[static_cast<std::size_t>(value)];
    entry["choices"] = Json(std::vector<std::string>(info.choices.begin(), info.choices.end()));
  }
  void field(const ParameterInfo& info, FieldRef&) override { add(info); }
  void whole_number(const ParameterInfo& info, std::optional<std::int64_t>& value) override {
    Json& entry = add(info);
    if (value) entry["default"] = *value;
    add_range(entry, info);
  }
  void numbers(const ParameterInfo& info, std::vector<double>& value) override { add(info)["default"] = value; }
  void texts(const ParameterInfo& info, std::vector<std::string>& value) override { add(info)["default"] = value; }
  void vectors(const ParameterInfo& info, std::vector<Vec3>&) override { add(info); }
  void strength(const ParameterInfo& info, Strength& value) override {
    Json& entry = add(info);
    entry["default"] = value.constant_n;
    add_range(entry, info);
  }
  void list(const ParameterInfo& info, ParameterList& list) override {
    JsonOfParameters items;
    list.visit_default(items);
    add(info)["parameters"] = items.json;
  }

  Json json = Json::array();

 private:
  Json& add(const ParameterInfo& info) {
    json.push_back(
        {{"name", info.name}, {"kind", name_of(info.kind)}, {"required", info.required()}, {"sentence", info.sentence}});
    return json.back();
  }
  static void add_range(Json& entry, const ParameterInfo& info) { entry["range"] = {info.range.low, info.range.high}; }
};

Json to_json(Mode mode) {
  JsonOfParameters parameters;
  mode.visit(parameters);
  return {{"type", mode.type()}, {"summary", mode.summary()}, {"parameters", parameters.json}};
}

}  // namespace

int run_modes(const ModesArguments& arguments) {
  const ModeCatalog catalog = modes_with(arguments.plugins);
  if (arguments.type.empty()) {
    std::size_t longest = 0;
    Json json = Json::array();
    for (const Mode& mode : catalog.modes()) {
      longest = std::max(longest, mode.type().size());
      json.push_back(to_json(mode));
    }
    if (arguments.json) {
      print(detail::text("%s\n", json.dump(2).c_str()));
      return 0;
    }
    for (const Mode& mode : catalog.modes()) {
      print(detail::text("  %-*s  %s\n", static_cast<int>(longest), std::string(mode.type()).c_str(),
                         std::string(mode.summary()).c_str()));
    }
    return 0;
  }

  const Mode* mode = catalog.find(arguments.type);
  if (!mode) {
    std::vector<std::string> types;
    for (const Mode& known : catalog.modes()) types.emplace_back(known.type());
    throw LoadError("modes: unknown type " + detail::in_quotes(arguments.type) + "; " +
                    detail::suggestion(arguments.type, types));
  }
  print(arguments.json ? to_json(*mode).dump(2) + "\n" : mode_reference_text(*mode));
  return 0;
}

}  // namespace palpa::app
