#include "palpa/scene/to_toml.h"

#include <algorithm>

#include "palpa/base/web_address.h"
#include "palpa/base/wording.h"
#include "palpa/data/filter.h"
#include "palpa/data/volume.h"
#include "palpa/scene/parts.h"
#include "palpa/scene/scene.h"

namespace palpa {

namespace {

using detail::Said;
using detail::toml_number;
using detail::toml_numbers;
using detail::toml_string;

std::string line(std::string_view key, const std::string& value) { return std::string(key) + " = " + value + "\n"; }

std::string lines(const std::vector<Said>& said) {
  std::string out;
  for (const Said& one : said) out += line(one.key, one.value);
  return out;
}

std::string in_braces(const std::vector<Said>& said) {
  std::string out;
  for (const Said& one : said) out += (out.empty() ? "" : ", ") + one.key + " = " + one.value;
  return "{" + out + "}";
}

std::string function(const FieldRef& of, const TransferFunction& curve) {
  std::string points;
  for (const TransferFunction::Point& point : curve.points()) {
    points += (points.empty() ? "" : ", ") + toml_numbers({point.value, point.result});
  }
  return in_braces({{"of", toml_string(of.name)}, {"points", "[" + points + "]"}, {"outside", toml_number(curve.outside())}});
}

/// Writes parameters; left-out values stay left out. Lists become tables of `section`, behind all keys, as TOML requires;
/// without a section, values.
class Writer final : public ParameterVisitor {
 public:
  explicit Writer(std::string section = {}) : section_(std::move(section)) {}

  void number(const ParameterInfo& info, double& value) override { say(info, toml_number(value)); }
  void optional_number(const ParameterInfo& info, std::optional<double>& value) override {
    if (value) say(info, toml_number(*value));
  }
  void flag(const ParameterInfo& info, bool& value) override { say(info, value ? "true" : "false"); }
  void text(const ParameterInfo& info, std::string& value) override {
    if (info.name == "name") name_ = value;
    if (!value.empty()) say(info, toml_string(value));
  }
  void choice(const ParameterInfo& info, int& value) override {
    if (value >= 0) say(info, toml_string(info.choices[static_cast<std::size_t>(value)]));
  }
  void field(const ParameterInfo& info, FieldRef& ref) override {
    if (!ref.name.empty()) say(info, toml_string(ref.name));
  }
  void strength(const ParameterInfo& info, Strength& value) override {
    say(info, value.is_constant() ? toml_number(value.constant_n) : function(value.of, value.curve));
  }
  void whole_number(const ParameterInfo& info, std::optional<std::int64_t>& value) override {
    if (value) say(info, std::to_string(*value));
  }
  void numbers(const ParameterInfo& info, std::vector<double>& value) override {
    if (!value.empty()) say(info, toml_numbers(value));
  }
  void texts(const ParameterInfo& info, std::vector<std::string>& value) override {
    std::string all;
    for (const std::string& text : value) all += (all.empty() ? "" : ", ") + toml_string(text);
    if (!all.empty()) say(info, "[" + all + "]");
  }
  void vectors(const ParameterInfo& info, std::vector<Vec3>& value) override {
    std::string all;
    for (const Vec3& v : value) all += (all.empty() ? "" : ", ") + toml_numbers({v.x, v.y, v.z});
    if (!all.empty()) say(info, "[" + all + "]");
  }
  void list(const ParameterInfo& info, ParameterList& items) override {
    std::string all;
    for (std::size_t i = 0; i < items.size(); ++i) {
      Writer item;
      items.visit(i, item);
      if (info.kind == ParameterKind::table) return say(info, in_braces(item.said));
      if (!section_.empty()) {
        tables += "[[" + section_ + "." + std::string(info.name) + "]]\n" + lines(item.said);
        continue;
      }
      all += all.empty() ? "" : ", ";
      if (info.kind == ParameterKind::named_tables) {
        all += item.name_ + " = ";
        std::erase_if(item.said, [](const Said& one) { return one.key == "name"; });
      }
      all += in_braces(item.said);
    }
    if (!all.empty()) say(info, info.kind == ParameterKind::named_tables ? "{" + all + "}" : "[" + all + "]");
  }

  std::vector<Said> said;
  std::vector<std::string> needed;  ///< required keys
  std::string tables;

 private:
  void say(const ParameterInfo& info, std::string value) {
    if (info.required()) needed.emplace_back(info.name);
    said.push_back({std::string(info.name), std::move(value)});
  }
  std::string section_;
  std::string name_;  // of an item of a table of named tables
};

template <class Part>
Writer written(Part part) {
  Writer writer;
  detail::visit_parameters(part, writer);
  return writer;
}

/// Values of a part that differ from their defaults.
template <class Part>
std::vector<Said> said_of(const Part& part) {
  Writer writer = written(part);
  const std::vector<Said> defaults = written(Part{}).said;
  std::erase_if(writer.said, [&](const Said& one) {
    return std::ranges::find(writer.needed, one.key) == writer.needed.end() &&
           std::ranges::find(defaults, one) != defaults.end();
  });
  return writer.said;
}

/// All values, but of a tool's limit only one that was changed: most scenes have no tool.
std::vector<Said> said_of_coupling(const CouplingOptions& coupling) {
  std::vector<Said> said = written(coupling).said;
  if (coupling.max_torque_nm == CouplingOptions{}.max_torque_nm)
    std::erase_if(said, [](const Said& one) { return one.key == "max_torque_nm"; });
  return said;
}

detail::PosePart part_of(const Similarity& pose) {
  if (pose == Similarity{}) return {};
  const auto [axis, degrees] = axis_angle(pose.rotation);
  return {pose.translation_m, {axis.x, axis.y, axis.z, degrees}, pose.scale};
}

detail::VolumePart part_of(const VolumeRequest& request) {
  detail::VolumePart part{.request = request};
  std::vector<std::string> files;
  for (const std::filesystem::path& file : request.files) files.push_back(detail::absolute_place(file, true).string());
  if (files.size() == 1) {
    part.file = files.front();
  } else {
    part.files = files;
  }
  for (VolumeRequest::FieldRequest& field : part.request.fields) {
    if (field.array == field.name) field.array.clear();  // the default
  }
  return part;
}

std::string volume_body(const SceneVolume& volume) {
  if (!volume.source.empty()) return volume.source;
  if (volume.volume.files.empty()) return "# made by a program: not representable in a scene file\n";
  const Field& first = *volume.volume.fields.front().field;
  const MovingView* moved = moving_of(first);
  if (series_of(moved ? *moved->field : first)) return "# a time series made by a program: not representable in a scene file\n";
  VolumeRequest by_files;  // for a reader that does not store its request
  for (const SourceFile& file : volume.volume.files) by_files.files.emplace_back(file.path);
  detail::VolumePart part = part_of(volume.volume.request ? *volume.volume.request : by_files);
  part.pose = part_of(volume.pose);
  for (const TimedPose& pose : volume.poses) part.poses.push_back({pose.time_s, part_of(pose.pose)});
  for (const VolumeField& field : volume.volume.fields) {
    const GridView* grid = grid_below(*field.field);
    if (!grid) continue;
    if (grid->filter != default_filter(*grid).filter) part.filter = grid->filter;
    if (grid->signless) part.sign = "none";
  }
  if (volume.smoothing_m > 0.0) part.smoothing_m = volume.smoothing_m;
  return lines(said_of(part));
}

std::string mode_body(const SceneMode& mode) {
  std::string out = lines(said_of(detail::ModePart{mode.name, std::string(mode.mode.type()), mode.enabled, mode.feet})), masks;
  for (const Mask& mask : mode.masks) masks += (masks.empty() ? "" : ", ") + function(mask.of, mask.curve);
  if (!masks.empty()) out += line("mask", "[" + masks + "]");
  Writer writer("mode");
  look_through(mode.mode, writer);
  return out + lines(writer.said) + writer.tables;
}

std::string hand_tables(const SceneHand& hand) {
  const std::string tool = hand.tool == ToolOptions{} ? "" : "\n[hand.tool]\n" + lines(said_of(hand.tool));
  return "\n[[hand]]\n" + lines(said_of(hand)) + tool;
}

std::string layer_body(const ViewLayer& layer) {
  std::string points;
  for (const ViewLayer::ColorPoint& point : layer.colors) {
    points += (points.empty() ? "[" : ", [") + toml_number(point.value) + ", " + toml_string(point.color) + ", " +
              toml_number(point.opacity) + "]";
  }
  return lines(said_of(layer)) + (points.empty() ? "" : line("colors", "{points = [" + points + "]}"));
}

}  // namespace

namespace detail {

std::vector<Said> said(const VolumeRequest& request) { return said_of(part_of(request)); }

std::string value_of(const std::vector<Said>& said, std::string_view key) {
  const auto found = std::ranges::find(said, key, &Said::key);
  return found == said.end() ? "" : found->value;
}

}  // namespace detail

std::string to_toml(const Scene& scene) {
  std::string out = lines(written(detail::HeaderPart{1, scene.title, scene.needs}).said);
  out += "\n[coupling]\n" + lines(said_of_coupling(scene.coupling()));
  out += "\n[law]\n" + lines(written(detail::LawPart{scene.law()}).said);
  if (scene.workspace() != Workspace{}) out += "\n[workspace]\n" + lines(written(scene.workspace()).said);
  if (scene.time() != TimeOptions{}) out += "\n[time]\n" + lines(written(scene.time()).said);
  for (const SceneHand& hand : scene.hands()) out += hand_tables(hand);
  if (scene.hands().empty() && scene.tool() != ToolOptions{}) out += "\n[tool]\n" + lines(said_of(scene.tool()));
  for (const SceneVolume& volume : scene.volumes()) out += "\n[volume." + volume.name + "]\n" + volume_body(volume);
  for (const SceneMode& mode : scene.modes()) out += "\n[[mode]]\n" + mode_body(mode);
  if (scene.view != ViewOptions{}) out += "\n[view]\n" + lines(written(scene.view).said);
  for (const ViewLayer& layer : scene.layers) out += "\n[[view.layer]]\n" + layer_body(layer);
  return out;
}

}  // namespace palpa
