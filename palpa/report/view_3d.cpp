#include "palpa/report/view_3d.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <set>

#include "palpa/loop/loop.h"
#include "palpa/mode/modes.h"
#include "palpa/report/html.h"
#include "palpa/report/numbers.h"
#include "palpa/report/words.h"
#include "palpa/session/foot_forces.h"
#include "palpa/view/scene_shapes.h"
#include "palpa/view/volume_picture.h"

namespace palpa::detail {
namespace {

using Json = nlohmann::ordered_json;

Json mm(const Vec3& at_m) { return {millimetres(at_m.x), millimetres(at_m.y), millimetres(at_m.z)}; }
Json unit(const Vec3& q) { return {rounded(q.x, 4), rounded(q.y, 4), rounded(q.z, 4)}; }

std::string hex(const Color& color) {
  const auto byte = [](double share) { return static_cast<unsigned>(std::lround(255.0 * std::clamp(share, 0.0, 1.0))); };
  return text("#%02x%02x%02x", byte(color.red), byte(color.green), byte(color.blue));
}

template <class Number>
std::string packed(const std::vector<Number>& numbers) {
  return base64({reinterpret_cast<const char*>(numbers.data()), sizeof(Number) * numbers.size()});
}

/// Positions in 16 bits of the shape's box, directions and colours in 8 bits: finer than any screen.
Json json_of(const Shape& shape) {
  Vec3 low{1e300, 1e300, 1e300}, high{-1e300, -1e300, -1e300};
  for (const Vec3& p : shape.points_m) {
    low = {std::min(low.x, p.x), std::min(low.y, p.y), std::min(low.z, p.z)};
    high = {std::max(high.x, p.x), std::max(high.y, p.y), std::max(high.z, p.z)};
  }
  const double step_m = std::max(largest_component(high - low) / 65535.0, 1e-12);
  std::vector<std::uint16_t> points;
  for (const Vec3& p : shape.points_m) {
    for (const double along_m : {p.x - low.x, p.y - low.y, p.z - low.z})
      points.push_back(static_cast<std::uint16_t>(std::lround(std::clamp(along_m / step_m, 0.0, 65535.0))));
  }
  Json json{{"layer", shape.layer},
            {"words", shape.words},
            {"color", hex(shape.color)},
            {"opacity", rounded(shape.opacity, 3)},
            {"low", mm(low)},
            {"step", rounded(1e3 * step_m, 7)},
            {"points", packed(points)}};
  if (shape.bar) json["bar"] = *shape.bar;
  if (!shape.normals.empty()) {
    std::vector<std::int8_t> normals;
    for (const Vec3& n : shape.normals) {
      for (const double part : {n.x, n.y, n.z})
        normals.push_back(static_cast<std::int8_t>(std::lround(127.0 * std::clamp(part, -1.0, 1.0))));
    }
    json["normals"] = packed(normals);
  }
  if (!shape.colors.empty()) {
    std::vector<std::uint8_t> colors;
    for (const Color& c : shape.colors) {
      for (const double part : {c.red, c.green, c.blue})
        colors.push_back(static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(part, 0.0, 1.0))));
    }
    json["colors"] = packed(colors);
  }
  if (!shape.triangles.empty()) {
    std::vector<std::uint32_t> corners;
    for (const auto& triangle : shape.triangles) corners.insert(corners.end(), triangle.begin(), triangle.end());
    const bool wide = shape.points_m.size() > 65535;
    json["wide"] = wide;
    json["triangles"] = wide ? packed(corners) : packed(std::vector<std::uint16_t>(corners.begin(), corners.end()));
  }
  if (!shape.line_points.empty()) json["lines"] = shape.line_points;
  return json;
}

Json json_of(const ColorBar& bar) {
  Json points = Json::array();
  for (const ColorMap::Point& point : bar.map.points()) points.push_back({rounded(point.value, 5), hex(point.color)});
  return {{"title", bar.title}, {"points", points}};
}

bool usable(const TickFrame& frame) {
  return frame.result.probe_valid && is_finite(frame.result.probe_m) && is_finite(frame.result.proxy_m);
}

/// Both paths, in gapless pieces; omitted ticks contribute their largest force.
Json json_of_paths(const Recorded& recorded, std::size_t most_points) {
  const std::size_t stride = recorded.ticks.size() / most_points + 1;
  Json segments = Json::array(), segment = Json::array();
  double force_n = 0.0;
  const auto end_stretch = [&] {
    if (segment.size() > 1) segments.push_back(std::move(segment));
    segment = Json::array();
  };
  for (std::size_t i = 0; i < recorded.ticks.size(); ++i) {
    const TickFrame& frame = recorded.ticks[i];
    if (!usable(frame)) {
      end_stretch();
      continue;
    }
    if (is_finite(frame.command.force_n)) force_n = std::max(force_n, norm(frame.command.force_n));
    if (i % stride != 0 && i + 1 != recorded.ticks.size()) continue;
    segment.push_back({rounded(frame.t_s, 7), mm(frame.result.probe_m), mm(frame.result.proxy_m), rounded(force_n, 4)});
    force_n = 0.0;
  }
  end_stretch();
  return segments;
}

/// True for a primitive of a level that cannot be pressed through: recorded with a strength above any spring force.
bool holds(const PlacedPrimitive& placed, const Recorded& recorded, const Scene* scene) {
  const std::size_t mode = placed.primitive.id.mode;
  return scene && mode < scene->modes().size() && scene->modes()[mode].mode.as<SurfaceAndFriction>() &&
         (placed.primitive.kind == PrimitiveKind::plane || placed.primitive.kind == PrimitiveKind::corner) &&
         placed.primitive.strength_n > force_limit_n(*scene, recorded.header.device_max_force_n);
}

Json json_of(const Turn& turn) { return {rounded(turn.w, 6), rounded(turn.x, 6), rounded(turn.y, 6), rounded(turn.z, 6)}; }

/// Force on each foot that bears any: number of the foot, newtons.
Json forces_of_feet(const RecordedMoment& moment) {
  std::vector<Vec3> forces_n(most_feet);
  add_foot_forces(moment.primitives, forces_n);
  Json forces = Json::array();
  for (std::size_t foot = 0; foot < most_feet; ++foot)
    if (norm(forces_n[foot]) > 0.0) forces.push_back({foot, rounded(norm(forces_n[foot]), 4)});
  return forces;
}

/// Orientations, torques and forces of feet of a tool, at a moment.
void add_tool(Json& row, const Recorded& recorded, const RecordedMoment& moment) {
  const TickFrame& frame = recorded.ticks[moment.row];
  const bool has_turns = is_unit(frame.result.probe_turn, 1e-3) && is_unit(frame.result.proxy_turn, 1e-3);
  row["probe_turn"] = json_of(has_turns ? unit_turn(frame.result.probe_turn) : Turn{});
  row["proxy_turn"] = json_of(has_turns ? unit_turn(frame.result.proxy_turn) : Turn{});
  row["torque"] = rounded(1e3 * norm(frame.command.torque_nm), 4);
  row["coupling_torque"] = rounded(1e3 * norm(frame.result.torque_nm), 4);
  row["feet"] = forces_of_feet(moment);
}

Json json_of(const Recorded& recorded, const RecordedMoment& moment, const Scene* scene) {
  const TickFrame& frame = recorded.ticks[moment.row];
  Json modes = Json::array();
  for (const auto& pushes : recorded.pushes) modes.push_back(rounded(norm(pushes[moment.row].force_n), 4));
  Json primitives = Json::array();
  for (const PlacedPrimitive& placed : moment.primitives) {
    const Primitive& primitive = placed.primitive;
    const Vec3 foot_m = recorded.header.has_tool ? frame.result.proxy_m + placed.lever_m : frame.result.proxy_m;
    primitives.push_back({{"kind", name_of(primitive.kind)},
                          {"mode", primitive.id.mode},
                          {"at", mm(primitive.kind == PrimitiveKind::directed ? foot_m : primitive.position_m)},
                          {"along", unit(primitive.direction)},
                          {"strength", rounded(primitive.strength_n, 4)},
                          {"force", rounded(norm(placed.force_n), 4)}});
    if (holds(placed, recorded, scene)) primitives.back()["holds"] = true;
    if (primitive.drag_ns_per_m > 0.0) primitives.back()["drag"] = rounded(primitive.drag_ns_per_m, 4);
  }
  const auto newtons = [](const Vec3& f_n) -> Json { return {rounded(f_n.x, 4), rounded(f_n.y, 4), rounded(f_n.z, 4)}; };
  Json row = {{"t", rounded(frame.t_s, 8)},
              {"valid", usable(frame)},
              {"probe", mm(frame.result.probe_m)},
              {"proxy", mm(frame.result.proxy_m)},
              {"force", newtons(frame.command.force_n)},
              {"modes", modes},
              {"primitives", primitives}};
  if (frame.command.guard == GuardState::limited) row["asked"] = rounded(norm(frame.result.force_n), 4);
  if (recorded.header.has_tool) add_tool(row, recorded, moment);
  return row;
}

/// Feet of the scene's tool, in the handle's axes; empty without the scene or for a point.
Json json_of_feet(const Scene* scene) {
  Json feet = Json::array();
  if (!scene) return feet;
  const Tool tool(scene->tool(), scene->coupling());
  if (tool.is_point()) return feet;
  for (std::size_t foot = 0; foot < tool.feet(); ++foot) feet.push_back(mm(tool.lever_m({}, foot)));
  return feet;
}

/// Marks of onsets, break-throughs, limits and faults, at the proxy.
Json json_of_events(const Recorded& recorded, std::size_t most) {
  Json events = Json::array();
  const auto& ticks = recorded.ticks;
  for (const RecordedEvent& event : recorded.events) {
    const bool limited = event.kind == "guard" && event.subject == "limited";
    const bool level = event.kind == "onset" || event.kind == "break_through";
    if (!limited && !level && event.kind != "fault") continue;
    const auto found = std::lower_bound(ticks.begin(), ticks.end(), event.tick,
                                        [](const TickFrame& frame, std::int64_t wanted) { return frame.tick < wanted; });
    if (found == ticks.end() || !is_finite(found->result.proxy_m)) continue;
    events.push_back({{"t", rounded(found->t_s, 8)},
                      {"kind", limited ? "limited" : event.kind},
                      {"words", level ? level_of(recorded, event) : event.value},
                      {"at", mm(found->result.proxy_m)}});
    if (events.size() == most) break;
  }
  return events;
}

}  // namespace

std::string json_of_view(const Recorded& recorded, const Scene* scene, const std::vector<RecordedMoment>& moments,
                         const Vec3& from, const View3dOptions& options) {
  Json view;
  Json layers = Json::array(), bars = Json::array();
  bool medical = false;
  if (scene) {
    std::vector<Vec3> path_m;
    for (const TickFrame& frame : recorded.ticks) {
      if (usable(frame)) path_m.push_back(frame.result.proxy_m);
    }
    const SceneShapes shapes =
        scene_shapes(*scene, worth_showing(*scene, path_m), scene->time().at(0.0), options.most_triangles);
    for (const Shape& shape : shapes.shapes) layers.push_back(json_of(shape));
    for (const ColorBar& bar : shapes.bars) bars.push_back(json_of(bar));
    view["cloud"] = shapes.has_cloud;
    medical = std::any_of(scene->volumes().begin(), scene->volumes().end(),
                          [](const SceneVolume& volume) { return volume.volume.medical_frame; });
  }
  const Similarity& map = recorded.header.hand_to_world;
  double most_n = 0.0;
  for (const TickFrame& frame : recorded.ticks) {
    if (is_finite(frame.command.force_n)) most_n = std::max(most_n, norm(frame.command.force_n));
  }
  view["medical"] = medical;
  view["axes"] = {unit(map.direction_to_hand({1, 0, 0})), unit(map.direction_to_hand({0, 1, 0})),
                  unit(map.direction_to_hand({0, 0, 1}))};
  view["world_per_hand"] = map.scale;
  if (const double unit_m = scene ? file_unit_m(*scene) : 0.0; unit_m > 0.0) view["file_unit_m"] = unit_m;
  view["layers"] = std::move(layers);
  view["bars"] = std::move(bars);
  view["most_n"] = rounded(most_n, 4);
  Json force = Json::array();
  const ColorMap forces = force_colors(1.0);
  for (const ColorMap::Point& point : forces.points()) force.push_back(hex(point.color));
  view["force_colors"] = std::move(force);
  view["from"] = unit(from);
  Json modes = Json::array();
  for (std::size_t m = 0; m < recorded.modes.size(); ++m)
    modes.push_back({{"name", recorded.modes[m]}, {"color", hex(mode_color(m))}});
  view["modes"] = std::move(modes);
  view["path"] = json_of_paths(recorded, options.most_path_points);
  view["events"] = json_of_events(recorded, options.most_events);
  Json looked = Json::array();
  for (const RecordedMoment& moment : moments) looked.push_back(json_of(recorded, moment, scene));
  view["moments"] = std::move(looked);
  if (recorded.header.has_tool) view["feet"] = json_of_feet(scene);
  if (const auto busiest = busiest_row(recorded)) view["first_look_s"] = rounded(recorded.ticks[*busiest].t_s, 8);
  return view.dump(-1, ' ', false, Json::error_handler_t::replace);
}

}  // namespace palpa::detail
