// Functions for C of a scene's picture.
#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "palpa/c.h"
#include "palpa/c/failure.h"
#include "palpa/c/grid_values.h"
#include "palpa/c/owned_text.h"
#include "palpa/c/scene_handle.h"
#include "palpa/c/sized.h"
#include "palpa/data/statistics.h"

namespace palpa::c {
namespace {

using Json = nlohmann::ordered_json;

// [1] More: longer texts; fewer: levels are placed less finely on a histogram.
constexpr std::size_t classes = 128;
// [1] Values that a histogram counts. More: slower; fewer: rare values are missing.
constexpr std::int64_t most_counted = std::int64_t{1} << 20;

Json json_of(const Vec3& v) { return {v.x, v.y, v.z}; }

Vec3 least(const Vec3& a, const Vec3& b) { return {std::min(a.x, b.x), std::min(a.y, b.y), std::min(a.z, b.z)}; }
Vec3 most(const Vec3& a, const Vec3& b) { return {std::max(a.x, b.x), std::max(a.y, b.y), std::max(a.z, b.z)}; }

/// Parameters of a mode, or of one of its levels, that a picture shows.
class Shown : public ParameterVisitor {
 public:
  explicit Shown(std::string path) : path_(std::move(path)) {}

  void number(const ParameterInfo& info, double& value) override {
    if (info.name == "value") json["value"] = value;
  }
  void text(const ParameterInfo& info, std::string& text) override {
    if (info.name == "name") json["name"] = text;
  }
  void field(const ParameterInfo&, FieldRef& ref) override {
    if (!json.contains("field")) json["field"] = ref.name;
  }
  void strength(const ParameterInfo& info, Strength& strength) override {
    if (info.name == "strength_n" && strength.is_constant()) json["strength_n"] = strength.constant_n;
  }
  void list(const ParameterInfo& info, ParameterList& list) override {
    if (info.name != "level") return;
    for (std::size_t i = 0; i < list.size(); ++i) {
      Shown level("");
      list.visit(i, level);
      if (!level.json.contains("name") || !level.json.contains("value")) continue;
      level.json["path"] = path_ + ".level." + level.json["name"].get<std::string>();
      levels.push_back(std::move(level.json));
    }
  }

  Json json = Json::object();
  Json levels = Json::array();

 private:
  std::string path_;
};

Json json_of(const SceneMode& mode) {
  Shown shown("mode." + mode.name);
  Mode copy = mode.mode;
  copy.visit(shown);
  Json json = {
      {"name", mode.name}, {"type", mode.mode.type()}, {"field", shown.json.value("field", "")}, {"enabled", mode.enabled}};
  // Levels have strengths of their own.
  const bool has_strength = shown.levels.empty() && shown.json.contains("strength_n");
  json["strength_n"] = has_strength ? shown.json["strength_n"] : Json(nullptr);
  for (Json& level : shown.levels)
    if (!level.contains("strength_n")) level["strength_n"] = nullptr;
  json["levels"] = std::move(shown.levels);
  return json;
}

Json json_of(const VolumeField& field, const std::string& name) {
  const Statistics values = statistics(*field.field, most_counted);
  return {{"name", name},
          {"unit", field.unit},
          {"components", field.field->components()},
          {"range", {values.min, values.max}},
          {"histogram", values.histogram.in_classes(std::min(classes, values.histogram.counts.size())).counts}};
}

Json json_of(const ViewLayer& layer) {
  const bool has_color = !layer.colors.empty();
  return {{"show", layer.show == ViewLayer::Show::surface ? "surface" : "streamlines"},
          {"field", layer.field.name},
          {"name", layer.name},
          {"level", layer.level ? Json(*layer.level) : Json(nullptr)},
          {"color", has_color ? layer.colors.front().color : ""},
          {"opacity", has_color ? layer.colors.front().opacity : 1.0}};
}

Json rows_of(const Similarity& map) {
  Json rows = Json::array();
  const double origin_m[] = {map.translation_m.x, map.translation_m.y, map.translation_m.z};
  for (int r = 0; r < 3; ++r) {
    const Vec3 row = map.scale * map.rotation.row[r];
    for (const double number : {row.x, row.y, row.z, origin_m[r]}) rows.push_back(number);
  }
  for (const double number : {0.0, 0.0, 0.0, 1.0}) rows.push_back(number);
  return rows;
}

Json facts_of(const Scene& scene) {
  Json fields = Json::array(), modes = Json::array(), layers = Json::array();
  constexpr double far = std::numeric_limits<double>::infinity();
  Box all{{far, far, far}, {-far, -far, -far}};
  for (const SceneVolume& volume : scene.volumes()) {
    const bool is_only_one = volume.volume.fields.size() == 1;
    for (const VolumeField& field : volume.volume.fields)
      fields.push_back(json_of(field, is_only_one ? volume.name : volume.name + "." + field.name));
    const Box box = volume.volume.bounds_m();
    all = {least(all.low_m, box.low_m), most(all.high_m, box.high_m)};
  }
  for (const SceneMode& mode : scene.modes()) modes.push_back(json_of(mode));
  for (const ViewLayer& layer : scene.layers)
    if (layer.show == ViewLayer::Show::surface || layer.show == ViewLayer::Show::streamlines) layers.push_back(json_of(layer));
  return {{"title", scene.title},
          {"fields", std::move(fields)},
          {"modes", std::move(modes)},
          {"layers", std::move(layers)},
          {"hand_to_world", rows_of(scene.hand_to_world())},
          {"bounds_m", {json_of(all.low_m), json_of(all.high_m)}},
          {"stiffness_n_per_m", scene.coupling().stiffness_n_per_m},
          {"max_force_n", scene.coupling().max_force_n}};
}

/// Values of the field at the points of the lattice, i fastest.
void sample(const Field& field, const GridGeometry& lattice, std::span<float> out) {
  constexpr float none = std::numeric_limits<float>::quiet_NaN();
  const bool is_scalar = field.components() == 1;
  auto to = out.begin();
  for (std::int64_t k = 0; k < lattice.dims[2]; ++k)
    for (std::int64_t j = 0; j < lattice.dims[1]; ++j)
      for (std::int64_t i = 0; i < lattice.dims[0]; ++i) {
        const Vec3 at_m = lattice.to_world({static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)});
        if (is_scalar) {
          const ScalarSample found = field.scalar(at_m);
          *to++ = found.inside ? static_cast<float>(found.value) : none;
        } else {
          const VectorSample found = field.vector(at_m);
          for (const double number : {found.value.x, found.value.y, found.value.z})
            *to++ = found.inside ? static_cast<float>(number) : none;
        }
      }
}

}  // namespace
}  // namespace palpa::c

using namespace palpa::c;

extern "C" {

char* palpa_scene_facts(const palpa_scene* scene) {
  return pointer_of("palpa_scene_facts", [&] {
    return owned_text(facts_of(given(scene, "scene").recipe.scene()).dump(-1, ' ', false, Json::error_handler_t::replace));
  });
}

palpa_result palpa_scene_sample(const palpa_scene* scene, const char* field, const palpa_grid* lattice, float* out,
                                size_t count) {
  return result_of("palpa_scene_sample", [&] {
    const palpa::Scene& of = given(scene, "scene").recipe.scene();
    given(field, "field");
    given(out, "out");
    if (!is_known_size<palpa_grid>(given(lattice, "lattice").size))
      throw WrongArgument("size of the lattice is wrong; set it to sizeof(palpa_grid)");
    const palpa::GridGeometry geometry = geometry_of(whole(lattice));
    std::int64_t points = 1;
    for (const std::int64_t n : geometry.dims)
      if (n < 1 || __builtin_mul_overflow(points, n, &points)) throw WrongArgument("dims cannot be; each is at least 1");
    const palpa::FieldPtr sampled = of.field(palpa::FieldRef(field)).field;
    if (__builtin_mul_overflow(points, sampled->components(), &points) || static_cast<std::uint64_t>(points) != count)
      throw WrongArgument("count is " + std::to_string(count) + "; the field has " + std::to_string(points) + " numbers there");
    sample(*sampled, geometry, {out, count});
  });
}
}
