#include <cmath>
#include <numbers>

#include "palpa/grid/filter.h"
#include "palpa/scene/keys.h"
#include "palpa/scene/request_toml.h"
#include "palpa/scene/scene.h"
#include "palpa/scene/wording.h"
#include "palpa/volume/volume.h"

namespace palpa {

namespace {

using detail::toml_number;
using detail::toml_string;

std::string line(std::string_view key, const std::string& value) { return std::string(key) + " = " + value + "\n"; }

std::string list(std::initializer_list<double> numbers) {
  std::string out;
  for (const double number : numbers) out += (out.empty() ? "" : ", ") + toml_number(number);
  return "[" + out + "]";
}

std::string function(const FieldRef& of, const TransferFunction& curve) {
  std::string points;
  for (const TransferFunction::Point& point : curve.points()) {
    points += (points.empty() ? "" : ", ") + list({point.value, point.result});
  }
  return "{of = " + toml_string(of.name) + ", points = [" + points + "], outside = " + toml_number(curve.outside()) + "}";
}

/// Axis and angle [degrees] of a rotation R = c + (1 − c) a aᵀ + s [a]×.
std::string axis_angle(const Mat3& r) {
  const Vec3 twice_sine{r.row[2].y - r.row[1].z, r.row[0].z - r.row[2].x, r.row[1].x - r.row[0].y};
  const double cosine = 0.5 * (r.row[0].x + r.row[1].y + r.row[2].z - 1.0);
  const double degrees = std::atan2(0.5 * norm(twice_sine), cosine) * 180.0 / std::numbers::pi;
  Vec3 axis = normalized(twice_sine);
  if (cosine < 0.0) {
    // Towards half a turn the sine vanishes; the longest row of (R + Rᵀ)/2 − c = (1 − c) a aᵀ lies along the axis.
    Vec3 longest;
    for (int i = 0; i < 3; ++i) {
      const Vec3 row = 0.5 * (r.row[i] + transposed(r).row[i]) - cosine * Mat3::identity().row[i];
      if (norm(row) > norm(longest)) longest = row;
    }
    axis = dot(longest, twice_sine) < 0.0 ? normalized(-longest) : normalized(longest);
  }
  if (axis == Vec3{}) axis = {0, 0, 1};
  return list({axis.x, axis.y, axis.z, degrees});
}

std::string pose_body(const Similarity& pose) {
  const Vec3& t = pose.translation_m;
  return "translate_m = " + list({t.x, t.y, t.z}) + ", rotate_axis_deg = " + axis_angle(pose.rotation) +
         ", scale = " + toml_number(pose.scale);
}

std::string volume_body(const SceneVolume& volume) {
  if (!volume.source.empty()) return volume.source;
  if (volume.volume.files.empty()) return "# made by a program: a scene file cannot say it\n";
  const Field& first = *volume.volume.fields.front().field;
  const MovingView* moved = moving_of(first);
  if (series_of(moved ? *moved->field : first)) return "# a time series made by a program: a scene file cannot say it\n";
  VolumeRequest by_files;  // of a reader that does not note what it was asked
  for (const SourceFile& file : volume.volume.files) by_files.files.emplace_back(file.path);
  std::string body = detail::reading_of(volume.volume.request ? *volume.volume.request : by_files);
  if (volume.pose != Similarity{}) body += line("pose", "{" + pose_body(volume.pose) + "}");
  std::string poses;
  for (const TimedPose& key : volume.poses) {
    poses += (poses.empty() ? "" : ", ") + ("{time_s = " + toml_number(key.time_s) + ", ") + pose_body(key.pose) + "}";
  }
  if (!poses.empty()) body += line("poses", "[" + poses + "]");
  std::string filter, sign;
  for (const VolumeField& field : volume.volume.fields) {
    const GridView* grid = grid_below(*field.field);
    if (!grid) continue;
    if (grid->filter != default_filter(*grid).filter) filter = line("filter", toml_string(name_of(grid->filter)));
    if (grid->signless) sign = line("sign", toml_string("none"));
  }
  body += filter + sign;
  if (volume.smoothing_m > 0.0) body += line("smoothing_m", toml_number(volume.smoothing_m));
  return body;
}

/// Prints parameters; what was left out stays left out. Lists come last, as TOML asks.
class Printer final : public ParameterVisitor {
 public:
  void number(const ParameterInfo& info, double& value) override { keys += line(info.name, toml_number(value)); }
  void optional_number(const ParameterInfo& info, std::optional<double>& value) override {
    if (value) keys += line(info.name, toml_number(*value));
  }
  void flag(const ParameterInfo& info, bool& value) override { keys += line(info.name, value ? "true" : "false"); }
  void text(const ParameterInfo& info, std::string& value) override {
    if (!value.empty()) keys += line(info.name, toml_string(value));
  }
  void choice(const ParameterInfo& info, int& value) override {
    keys += line(info.name, toml_string(info.choices[static_cast<std::size_t>(value)]));
  }
  void field(const ParameterInfo& info, FieldRef& ref) override {
    if (!ref.name.empty()) keys += line(info.name, toml_string(ref.name));
  }
  void vector(const ParameterInfo& info, Vec3& value) override {
    keys += line(info.name, palpa::list({value.x, value.y, value.z}));
  }
  void strength(const ParameterInfo& info, Strength& value) override {
    keys += line(info.name, value.is_constant() ? toml_number(value.constant_n) : function(value.of, value.curve));
  }
  void list(const ParameterInfo& info, ParameterList& items) override {
    for (std::size_t i = 0; i < items.size(); ++i) {
      Printer item;
      items.visit(i, item);
      lists += "[[mode." + std::string(info.name) + "]]\n" + item.keys;
    }
  }
  std::string keys;
  std::string lists;
};

std::string workspace_body(const Workspace& workspace) {
  std::string body;
  if (!workspace.fit.empty()) body += line("fit", toml_string(workspace.fit));
  if (workspace.scale) body += line("scale", toml_number(*workspace.scale));
  if (!workspace.center_volume.empty()) body += line("center", toml_string(workspace.center_volume));
  if (workspace.center_m) body += line("center", list({workspace.center_m->x, workspace.center_m->y, workspace.center_m->z}));
  if (!workspace.towards_user.empty()) body += line("towards_user", toml_string(workspace.towards_user));
  if (!workspace.up.empty()) body += line("up", toml_string(workspace.up));
  return body;
}

}  // namespace

std::string to_toml(const Scene& scene) {
  std::string out = line("palpa", "1");
  if (!scene.title.empty()) out += line("title", toml_string(scene.title));
  if (!scene.needs.empty()) {
    std::string needs;
    for (const std::string& type : scene.needs) needs += (needs.empty() ? "" : ", ") + toml_string(type);
    out += line("needs", "[" + needs + "]");
  }
  out += "\n[coupling]\n";
  for (const detail::Key& key : detail::coupling_keys()) {
    out += line(key.name, toml_number(scene.coupling.*detail::coupling_member(key.name)));
  }
  out += "\n[law]\n" + line("method", toml_string(scene.law));
  if (scene.workspace != Workspace{}) out += "\n[workspace]\n" + workspace_body(scene.workspace);
  if (const TimeOptions& time = scene.time; time != TimeOptions{}) {
    const auto& ways = detail::find(detail::time_keys(), "play")->choices;
    out += "\n[time]\n" + line("play", toml_string(ways[static_cast<std::size_t>(time.play)])) +
           line("speed", toml_number(time.speed)) + line("start_s", toml_number(time.start_s));
  }
  for (const SceneVolume& volume : scene.volumes()) out += "\n[volume." + volume.name + "]\n" + volume_body(volume);
  for (const SceneMode& mode : scene.modes()) {
    out += "\n[[mode]]\n" + line("name", toml_string(mode.name)) + line("type", toml_string(mode.mode.type()));
    if (!mode.enabled) out += line("enabled", "false");
    if (!mode.masks.empty()) {
      std::string masks;
      for (const Mask& mask : mode.masks) masks += (masks.empty() ? "" : ", ") + function(mask.of, mask.curve);
      out += line("mask", "[" + masks + "]");
    }
    Printer printer;
    Mode printed = mode.mode;
    printed.visit(printer);
    out += printer.keys + printer.lists;
  }
  if (scene.view_from) out += "\n[view]\n" + line("from", list({scene.view_from->x, scene.view_from->y, scene.view_from->z}));
  for (const ViewLayer& layer : scene.layers) {
    const auto& ways = detail::find(detail::view_layer_keys(), "show")->choices;
    out += "\n[[view.layer]]\n" + line("show", toml_string(ways[static_cast<std::size_t>(layer.show)])) +
           line("field", toml_string(layer.field.name));
    if (layer.level) out += line("level", toml_number(*layer.level));
    if (!layer.name.empty()) out += line("name", toml_string(layer.name));
    if (layer.all_parts) out += line("parts", toml_string("all"));
    std::string points;
    for (const ViewLayer::ColorPoint& point : layer.colors) {
      points += (points.empty() ? "[" : ", [") + toml_number(point.value) + ", " + toml_string(point.color) + ", " +
                toml_number(point.opacity) + "]";
    }
    if (!points.empty()) out += line("colors", "{points = [" + points + "]}");
  }
  return out;
}

}  // namespace palpa
