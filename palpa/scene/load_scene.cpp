#include "palpa/scene/load_scene.h"

#include <algorithm>
#include <cmath>

#include "palpa/base/input_file.h"
#include "palpa/base/limits.h"
#include "palpa/base/wording.h"
#include "palpa/file/read_volume.h"
#include "palpa/scene/keys.h"
#include "palpa/scene/load_volumes.h"
#include "palpa/scene/part_reader.h"
#include "palpa/scene/parts.h"
#include "palpa/scene/scene_checks.h"
#include "palpa/scene/set_path.h"

namespace palpa {

using namespace detail::scene_file;
using detail::Finding;
using detail::in_quotes;
using detail::suggestion;

namespace {

class Loader {
 public:
  Loader(const std::string& text, std::string name, std::filesystem::path folder, const VolumeReader& read_volume,
         const ModeCatalog& catalog, const SceneOptions& options)
      : name_(std::move(name)),
        folder_(std::move(folder)),
        volumes_(folder_, read_volume, options),
        catalog_(catalog),
        options_(options),
        root_(parse_toml(text, name_)) {}

  /// The scene refuses what is not valid; its findings get the place in the file here.
  LoadedScene load() try {
    for (const auto& [path, value] : options_.sets) SetPath(root_).set(path, value);
    check_format();
    const Section scene = read_header();
    read_options<CouplingOptions>(scene, "coupling");
    detail::LawPart law{loaded_.scene.law()};
    read_table(scene, "law", law);
    loaded_.scene.set_law(law.method);
    volumes_.plan(scene);
    read_options<Workspace>(scene, "workspace");
    read_options<TimeOptions>(scene, "time");
    read_hands(scene);
    read_options<ToolOptions>(scene, "tool");
    read_view(scene);
    std::vector<detail::CheckedMode> modes = read_modes(scene);

    volumes_.open(loaded_.scene, loaded_.warnings);
    loaded_.scene.hand_to_world();
    for (detail::CheckedMode& mode : modes) loaded_.scene.add(std::move(mode));
    for (std::size_t i = 0; i < loaded_.scene.modes().size(); ++i) derive_fields(loaded_.scene.modes()[i], i);
    std::vector<Finding> warnings = detail::warnings(loaded_.scene);
    std::ranges::move(detail::layer_findings(loaded_.scene, loaded_.scene.layers), std::back_inserter(warnings));
    if (options_.thin_parts) {
      detail::ThinPartFindings thin = detail::thin_part_findings(loaded_.scene, volumes_.with_filter());
      std::ranges::move(thin.by_default, std::back_inserter(warnings));
      for (const Finding& finding : thin.by_choice) loaded_.notes.push_back(detail::one_line(finding.text) + ".");
    }
    for (const Finding& finding : warnings) {
      loaded_.warnings.push_back(detail::one_line(place_of(finding.part) + ": " + finding.text));
    }
    return std::move(loaded_);
  } catch (const detail::SceneProblem& problem) {
    fail(place_of(problem.finding.part), problem.finding.text);
  }

 private:
  /// The format comes first: another one may have other keys.
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
             "needs the mode type " + in_quotes(type) + ", which is not available; " + suggestion(type, types()) +
                 ", and what plug-ins bring that are named with --plugin FILE");
    }
    return scene;
  }

  /// [KEY] of the scene.
  template <class Part>
  void read_table(const Section& scene, const std::string& key, Part& part) const {
    if (const toml::table* table = scene.subtable(key)) read(*table, "[" + key + "]", part, &volumes_.names());
  }

  template <class Options>
  void read_options(const Section& scene, const std::string& key) {
    loaded_.scene.edit<Options>([&](Options& options) { read_table(scene, key, options); });
  }

  void read_hands(const Section& scene) {
    hand_tables_ = tables_in(scene.node("hand"));
    if (const toml::node* tool = scene.node("tool"); tool && !hand_tables_.empty()) {
      fail(place_of(*tool), "'tool' stands beside [[hand]] in the scene; give each hand its own, [hand.tool]");
    }
    for (std::size_t i = 0; i < hand_tables_.size(); ++i) {
      const auto name = (*hand_tables_[i])["name"].value<std::string>();
      const std::string where = "hand " + (name ? in_quotes(*name) : std::to_string(i + 1));
      SceneHand hand;
      const Section section = read(*hand_tables_[i], where, hand);
      if (const toml::table* tool = section.subtable("tool")) read(*tool, "'tool' of " + where, hand.tool);
      loaded_.scene.add_hand(std::move(hand));
    }
    if (const auto only = scene.text("only_hand")) leave_only(*only, *scene.node("only_hand"));
  }

  void leave_only(const std::string& name, const toml::node& node) {
    const std::vector<SceneHand>& hands = loaded_.scene.hands();
    const auto found = std::ranges::find(hands, name, &SceneHand::name);
    if (hands.empty()) fail(place_of(node), "'only_hand' in the scene has no [[hand]] to choose from; leave it out");
    if (found == hands.end())
      fail(place_of(node), "no hand " + in_quotes(name) + "; " + suggestion(name, detail::names_of(hands)));
    const auto number = static_cast<std::size_t>(found - hands.begin());
    hand_tables_ = {hand_tables_[number]};
    loaded_.scene = loaded_.scene.of_hand(number);
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

  // ---- Modes

  std::vector<std::string> types() const {
    std::vector<std::string> types;
    for (const Mode& mode : catalog_.modes()) types.emplace_back(mode.type());
    return types;
  }

  std::vector<detail::CheckedMode> read_modes(const Section& scene) {
    mode_tables_ = tables_in(scene.node("mode"));
    if (mode_tables_.empty()) {
      fail(scene.node("mode") ? place_of(*scene.node("mode")) : name_ + ":1:1",
           "a scene without modes cannot be felt; add a [[mode]]");
    }
    std::vector<detail::CheckedMode> modes;
    for (std::size_t i = 0; i < mode_tables_.size(); ++i) modes.emplace_back(read_mode(*mode_tables_[i], i), i);
    return modes;
  }

  SceneMode read_mode(const toml::table& table, std::size_t number) const {
    const auto given_name = table["name"].value<std::string>();
    const std::string where = given_name ? "mode " + in_quotes(*given_name) : "mode " + std::to_string(number + 1);
    // Which keys there are depends on the type, so that comes first.
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
    PartReader reader(section, keys, &volumes_.names());
    detail::visit_parameters(part, reader);
    SceneMode mode{part.name, *example, part.enabled, {}, part.feet};
    mode.mode.visit(reader);
    for (const toml::table* mask : tables_in(section.node("mask"))) {
      auto [of, curve] = function_in(*mask, "'mask' of " + where, {0, 1});
      mode.masks.push_back({reader.field_in(*mask->get("of")), std::move(curve)});
    }
    return mode;
  }

  /// Computes what a mode feels of its fields, so that what cannot be computed is found here.
  void derive_fields(const SceneMode& mode, std::size_t number) const {
    struct Deriver final : ParameterVisitor {
      explicit Deriver(const Scene& of) : scene(of) {}
      void field(const ParameterInfo& info, FieldRef& ref) override {
        if (ref.name.empty()) return;
        info.felt ? scene.field(ref, *info.felt) : scene.field(ref).field;
      }
      void companion(FieldRef& of, Derivation felt) override { scene.field(of, felt); }
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

  /// The place of the nearest thing that is written down.
  std::string place_of(const detail::Part& part) const {
    const toml::node* nearest = part.section == "mode"   ? mode_tables_[part.mode]
                                : part.section == "hand" ? hand_tables_[part.mode]
                                                         : root_.get(part.section);
    const auto step = [&](const toml::node* to) {
      if (to) nearest = to;
      return to != nullptr;
    };
    const toml::table* table = nearest ? nearest->as_table() : nullptr;
    if (table && !part.list.empty() && step(table->get(part.list))) {
      if (const toml::array* items = nearest->as_array()) step(items->get(part.item));
      table = nearest->as_table();
    }
    if (table) step(table->get(part.key));
    return nearest ? detail::scene_file::place_of(*nearest) : name_ + ":1:1";
  }
  static std::string place_of(const toml::node& node) { return detail::scene_file::place_of(node); }

  std::string name_;
  std::filesystem::path folder_;
  VolumeLoader volumes_;
  const ModeCatalog& catalog_;
  const SceneOptions& options_;
  toml::table root_;
  std::vector<const toml::table*> mode_tables_, hand_tables_;
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

std::string read_scene_text(const std::filesystem::path& path) {
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
  return text;
}

LoadedScene load_scene(const std::filesystem::path& path, const VolumeReader& read_volume, const ModeCatalog& modes,
                       const SceneOptions& options) {
  return parse_scene(read_scene_text(path), path.string(), path.parent_path(), read_volume, modes, options);
}

}  // namespace palpa
