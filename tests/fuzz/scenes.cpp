#include "tests/fuzz/scenes.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <limits>
#include <numbers>

#include "palpa/data/analytic.h"
#include "palpa/mode/modes.h"

namespace palpa::fuzz {
namespace {

using Limits = std::numeric_limits<double>;

constexpr std::array hostile{0.0,
                             -0.0,
                             Limits::quiet_NaN(),
                             Limits::infinity(),
                             -Limits::infinity(),
                             1e300,
                             -1e300,
                             Limits::max(),
                             Limits::lowest(),
                             Limits::min(),
                             Limits::denorm_min(),
                             1e-300,
                             -1e-310,
                             1e30,
                             3.5e38,
                             -3.5e38,
                             1e-45,
                             65536.0};

Vec3 direction(Choices& choices) {
  const double height = choices.between(-1.0, 1.0), turn = choices.between(0.0, 2.0 * std::numbers::pi);
  const double radius = std::sqrt(1.0 - height * height);
  return {radius * std::cos(turn), radius * std::sin(turn), height};
}

Mat3 rotation(Choices& choices) { return rotation_about(direction(choices), choices.between(0.0, 178.0)); }

// ---- volumes ----

/// Distances between planes, from even to a thousandth of the mean, and to 0.
std::vector<double> uneven_planes(Choices& choices, std::int64_t count) {
  std::vector<double> planes{0.0};
  const double unevenness = choices.one_of(std::array{2.0, 10.0, 1e3, 1e6});
  for (std::int64_t n = 1; n < count; ++n) planes.push_back(planes.back() + choices.log_between(1.0, unevenness));
  for (double& plane : planes) plane *= static_cast<double>(count - 1) / planes.back();
  planes.back() = static_cast<double>(count - 1);
  return planes;
}

/// About 0.1 m large if ordinary.
GridGeometry geometry(Choices& choices) {
  GridGeometry made;
  for (std::int64_t& dim : made.dims) dim = choices.one_in(10) ? 1 : 2 + static_cast<std::int64_t>(choices.below(9));
  const double size_m = choices.one_in(4) ? choices.log_between(1e-10, 1e6) : choices.log_between(0.05, 0.3);
  Vec3 spacing;
  for (double* step : {&spacing.x, &spacing.y, &spacing.z})
    *step = size_m / 8 * choices.log_between(0.5, choices.one_in(8) ? 1e4 : 2.0);
  made.index_to_world_m = {{{spacing.x, 0, 0}, {0, spacing.y, 0}, {0, 0, choices.one_in(3) ? -spacing.z : spacing.z}}};
  if (choices.one_in(3)) made.index_to_world_m = rotation(choices) * made.index_to_world_m;
  if (choices.one_in(4)) {
    const double shear = choices.one_in(4) ? choices.log_between(1.0, 1e3) : choices.between(-0.8, 0.8);
    made.index_to_world_m = Mat3{{{1, shear, 0}, {0, 1, -0.5 * shear}, {0, 0, 1}}} * made.index_to_world_m;
  }
  if (choices.one_in(3)) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      if (made.dims[axis] > 2 && !choices.one_in(3)) made.planes[axis] = uneven_planes(choices, made.dims[axis]);
    }
  }
  const Vec3 middle{0.5 * static_cast<double>(made.dims[0] - 1), 0.5 * static_cast<double>(made.dims[1] - 1),
                    0.5 * static_cast<double>(made.dims[2] - 1)};
  made.origin_m = -1.0 * (made.index_to_world_m * middle);
  if (choices.one_in(8)) made.origin_m += choices.log_between(1e-3, 1e9) * direction(choices);
  return made;
}

/// One number of a grid by the kind of content: smooth waves, noise, or extreme numbers.
struct Content {
  explicit Content(Choices& choices)
      : wave(choices.between(0.1, 2.0)),
        size(choices.one_in(6) ? choices.log_between(1e-300, 1e300) : choices.one_of(std::array{1.0, 1000.0, 1e-3})),
        noise(choices.one_in(3) ? choices.between(0.0, 1.0) : 0.0),
        steps(choices.one_in(4)),
        constant(choices.one_in(12)),
        odd_in(choices.one_of(std::array{0u, 0u, 0u, 300u, 30u, 3u, 1u})) {}

  double at(Choices& choices, const Vec3& index, int component) const {
    if (odd_in > 0 && choices.below(odd_in) == 0) return choices.one_of(hostile);
    if (constant) return size;
    double value =
        std::sin(wave * index.x + component) + std::cos(0.8 * wave * index.y - component) + std::sin(0.6 * wave * index.z);
    if (noise > 0.0) value += noise * choices.between(-1.0, 1.0);
    if (steps) value = std::round(value);
    return size * value;
  }

  double wave, size, noise;
  bool steps, constant;
  std::uint64_t odd_in;
};

template <class T>
T as(double value) {
  if constexpr (std::is_floating_point_v<T>) {
    return static_cast<T>(value);
  } else {
    if (std::isnan(value)) return 0;
    return static_cast<T>(std::clamp(value, static_cast<double>(std::numeric_limits<T>::min()),
                                     static_cast<double>(std::numeric_limits<T>::max())));
  }
}

template <class T>
std::shared_ptr<const void> numbers(Choices& choices, const GridGeometry& at, int components, const Content& content) {
  auto made = std::make_shared<std::vector<T>>();
  made->reserve(static_cast<std::size_t>(at.voxels() * components));
  for (std::int64_t k = 0; k < at.dims[2]; ++k)
    for (std::int64_t j = 0; j < at.dims[1]; ++j)
      for (std::int64_t i = 0; i < at.dims[0]; ++i)
        for (int c = 0; c < components; ++c) {
          const Vec3 index{static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)};
          made->push_back(as<T>(content.at(choices, index, c)));
        }
  return {made, made->data()};
}

Voxels voxels(Choices& choices, const GridGeometry& at, int components, VoxelType type, const Content& content) {
  Voxels made{.type = type, .components = components, .data = nullptr};
  switch (type) {
    case VoxelType::uint8: made.data = numbers<std::uint8_t>(choices, at, components, content); break;
    case VoxelType::int16: made.data = numbers<std::int16_t>(choices, at, components, content); break;
    case VoxelType::uint16: made.data = numbers<std::uint16_t>(choices, at, components, content); break;
    case VoxelType::int32: made.data = numbers<std::int32_t>(choices, at, components, content); break;
    case VoxelType::float32: made.data = numbers<float>(choices, at, components, content); break;
    case VoxelType::float64: made.data = numbers<double>(choices, at, components, content); break;
  }
  return made;
}

FieldPtr grid(Choices& choices, int components) {
  constexpr std::array types{VoxelType::float32, VoxelType::float64, VoxelType::int16,
                             VoxelType::uint8,   VoxelType::uint16,  VoxelType::int32};
  const GridGeometry at = geometry(choices);
  const VoxelType type = choices.one_of(types);
  const double scale = choices.one_in(8) ? choices.log_between(1e-200, 1e200) : 1.0;
  const double offset = choices.one_in(4) ? scale * choices.between(-100.0, 100.0) : 0.0;
  const std::uint64_t frames = choices.one_in(5) ? 2 + choices.below(3) : 1;
  std::vector<FieldPtr> made;
  for (std::uint64_t n = 0; n < frames; ++n) {
    const Content content(choices);
    made.push_back(grid_field(at, voxels(choices, at, components, type, content), scale, offset));
  }
  FieldPtr field = made.front();
  if (frames > 1) {
    const auto between = choices.one_in(2) ? BetweenFrames::nearest : BetweenFrames::linear;
    field = time_series(std::move(made), choices.log_between(1e-3, 1.0), between);
  }
  if (components == 3 && choices.one_in(6)) field = signless(field);
  return field;
}

Volume volume(Choices& choices, int components) {
  if (choices.one_in(240)) {  // derived fields take several times as long as a scene's ticks
    const auto& of = choices.one_in(3) ? beating_volumes() : analytic_volumes();
    return choices.one_of(of).make();
  }
  Volume made;
  made.format = "grid";
  made.fields.push_back({.name = "value", .unit = "", .field = grid(choices, components)});
  return made;
}

std::optional<Filter> filter(Choices& choices) {
  constexpr std::array<std::optional<Filter>, 4> filters{std::nullopt, Filter::trilinear, Filter::smooth, Filter::cubic};
  return choices.one_of(filters);
}

Similarity pose(Choices& choices) {
  return {rotation(choices), choices.log_between(0.5, 2.0), choices.between(0.0, 0.1) * direction(choices)};
}

/// Adds its fields to the names of scalar and vector fields.
void add_volume(Choices& choices, Scene& scene, int components, std::vector<std::string> (&names)[2]) {
  const std::string name = "v" + std::to_string(scene.volumes().size());
  const Volume made = volume(choices, components);
  const std::optional<Filter> filters = filter(choices);
  const bool moves = choices.one_in(6), is_posed = choices.one_in(4);
  PoseTrack track{{0.0, moves || is_posed ? pose(choices) : Similarity{}}};
  if (moves) {
    for (std::uint64_t n = choices.below(4); n > 0; --n)
      track.push_back({track.back().time_s + choices.log_between(1e-3, 1.0), pose(choices)});
  }
  const auto add = [&](std::optional<Filter> through) {
    moves ? scene.add_moving(name, made, track, through) : scene.add(name, made, track.front().pose, through);
  };
  try {
    add(filters);
  } catch (const SceneError&) {  // a filter that these data cannot have
    add(std::nullopt);
  }
  for (const VolumeField& field : made.fields) names[field.field->components() == 3].push_back(name + "." + field.name);
}

// ---- modes ----

/// Sets every parameter of any mode, by the parameter's own description.
class AnyParameters : public ParameterVisitor {
 public:
  AnyParameters(Choices& choices, const Scene& scene, const std::vector<std::string> (&names)[2])
      : choices_(choices), scene_(scene), names_(names) {}

  void number(const ParameterInfo& info, double& value) override {
    if (info.kind == ParameterKind::level) {
      value = level();
    } else if (info.required() || choices_.one_in(3)) {
      value = within(info.range);
    }
  }
  void optional_number(const ParameterInfo& info, std::optional<double>& value) override {
    if (choices_.one_in(3)) value = within(info.range);
  }
  void flag(const ParameterInfo&, bool& value) override { value = choices_.one_in(2); }
  void choice(const ParameterInfo& info, int& value) override {
    if (choices_.one_in(2)) value = static_cast<int>(choices_.below(info.choices.size()));
  }
  void text(const ParameterInfo&, std::string& value) override { value = "l" + std::to_string(++texts_); }
  void field(const ParameterInfo& info, FieldRef& value) override {
    if (info.kind == ParameterKind::optional_field && !choices_.one_in(2)) return;
    const int components = info.felt ? components_taken(*info.felt) : info.kind == ParameterKind::vector_field ? 3 : 1;
    value = any_field(components);
    if (components == 1) last_scalar_ = value;
  }
  void strength(const ParameterInfo&, Strength& value) override {
    switch (choices_.below(4)) {
      case 0: value = choices_.log_between(0.1, 5.0); break;
      case 1: value = function(1.0); break;
      case 2: value = choices_.log_between(1e-9, 1000.0); break;
      default: break;
    }
  }
  void numbers(const ParameterInfo& info, std::vector<double>& value) override {
    if (!choices_.one_in(4)) return;
    value.resize(info.count);
    for (double& number : value) number = choices_.between(-1.0, 1.0);
  }
  void list(const ParameterInfo&, ParameterList& value) override {
    for (std::uint64_t n = choices_.below(6); n > 0; --n) value.append();
    for (std::size_t i = 0; i < value.size(); ++i) value.visit(i, *this);
  }

  /// A function of a scalar field with steps, slopes and holes, up to `most` [1].
  Strength function(double most) {
    const FieldRef of = any_field(1);
    last_scalar_ = of;
    std::vector<double> values;
    for (std::uint64_t n = 1 + choices_.below(8); n > 0; --n) values.push_back(level());
    std::sort(values.begin(), values.end());
    std::vector<TransferFunction::Point> points;
    for (const double value : values) {
      const bool third = points.size() > 1 && points[points.size() - 2].value == value;
      if (!third) points.push_back({value, choices_.between(0.0, most)});
    }
    return {of, TransferFunction(std::move(points), choices_.one_in(3) ? choices_.between(0.0, most) : 0.0)};
  }

 private:
  FieldRef any_field(int components) {
    constexpr std::array of_vectors{"magnitude", "divergence", "q", "lambda2", "coherence", "component_x", "component_z"};
    const auto& own = names_[components == 3];
    const auto& other = names_[components != 3];
    if (own.empty() || (!other.empty() && choices_.one_in(4))) {
      if (components == 3) return {"curl(" + choices_.one_of(own.empty() ? other : own) + ")"};
      if (other.empty()) return {"gradient_magnitude(" + choices_.one_of(own) + ")"};
      return {std::string(choices_.one_of(of_vectors)) + "(" + choices_.one_of(other) + ")"};
    }
    return {choices_.one_of(own)};
  }
  /// A value in the field's range, or about it.
  double level() {
    ValueRange range{-1.0, 1.0};
    if (!last_scalar_.name.empty()) range = scene_.field(last_scalar_).field->value_ranges().front();
    const double share = choices_.one_in(10) ? choices_.between(-0.5, 1.5) : choices_.between(0.0, 1.0);
    const double value = range.min * (1.0 - share) + range.max * share;
    return std::isfinite(value) ? std::clamp(value, -1e300, 1e300) : 0.0;
  }
  double within(const Range& range) {
    const double low = std::max(range.low, -1e6), high = std::min(range.high, 1e6);
    if (choices_.one_in(8)) return choices_.one_in(2) || range.above_low ? high : low;
    const double least = std::max(low, 1e-6 * high);
    return choices_.log_between(std::max(least, 1e-9), std::max(high, 1e-8));
  }

  Choices& choices_;
  const Scene& scene_;
  const std::vector<std::string> (&names_)[2];
  FieldRef last_scalar_;
  int texts_ = 0;
};

void add_mode(Choices& choices, Scene& scene, const std::vector<std::string> (&names)[2]) {
  Mode mode = choices.one_of(standard_modes().modes());
  AnyParameters fill(choices, scene, names);
  mode.visit(fill);
  std::vector<Mask> masks;
  if (choices.one_in(4)) {
    const Strength mask = fill.function(1.0);
    masks.push_back({mask.of, mask.curve});
  }
  scene.add("m" + std::to_string(scene.modes().size()), std::move(mode), std::move(masks));
}

CouplingOptions coupling(Choices& choices) {
  CouplingOptions made;
  made.stiffness_n_per_m = choices.one_in(6) ? choices.log_between(1e-3, 1e5) : choices.log_between(200.0, 3000.0);
  made.damping_ns_per_m = choices.one_in(3) ? choices.between(0.0, choices.one_in(4) ? 100.0 : 1.0) : 0.0;
  made.max_force_n = choices.log_between(0.1, 100.0);
  made.impact_ns_per_m = choices.one_in(4) ? choices.between(0.0, 100.0) : 0.0;
  return made;
}

}  // namespace

double odd_number(Choices& choices, double usual) {
  return choices.one_in(2) ? usual * choices.log_between(1.0, 1e12) : choices.one_of(hostile);
}

void set_random_tool(Choices& choices, Scene& scene) {
  using Shape = ToolOptions::Shape;
  ToolOptions tool{.shape = choices.one_of(std::array{Shape::points, Shape::rod, Shape::pad, Shape::ball})};
  const double size_m = choices.one_in(6) ? choices.log_between(1e-9, 0.5) : choices.log_between(2e-3, 0.1);
  const auto feet = static_cast<int>(choices.one_in(10) ? 1 + choices.below(most_feet) : 1 + choices.below(16));
  const auto near_m = [&] { return choices.one_in(8) ? 0.0 : choices.between(-size_m, size_m); };
  if (tool.shape == Shape::points) {
    for (int foot = 0; foot < feet; ++foot) {
      const double x_m = near_m(), y_m = near_m();
      tool.points_m.push_back({x_m, y_m, near_m()});
    }
  } else {
    tool.points = feet;
    if (tool.shape == Shape::rod) tool.length_m = size_m;
    if (tool.shape != Shape::rod || choices.one_in(2)) tool.radius_m = 0.5 * size_m;
  }
  if (choices.one_in(3)) tool.centre_m = {near_m(), 0.0, near_m()};
  if (choices.one_in(3)) tool.share = choices.log_between(1e-6, 1.0);
  if (choices.one_in(2)) tool.turning_radius_m = choices.one_in(4) ? choices.log_between(1e-6, 1.0) : size_m;
  scene.set(tool);
  scene.edit<CouplingOptions>([&](CouplingOptions& made) {
    made.max_torque_nm = choices.log_between(1e-3, 10.0);
    if (choices.one_in(3)) made.turn_damping_nms_per_rad = choices.between(0.0, choices.one_in(4) ? 1.0 : 1e-3);
  });
  for (std::size_t m = 0; m < scene.modes().size(); ++m) {
    if (!choices.one_in(4)) continue;
    const auto feet_of_mode = choices.one_in(2) ? SceneMode::Feet::all : SceneMode::Feet::first;
    scene.edit_mode(std::string(scene.modes()[m].name), [&](SceneMode& mode) { mode.feet = feet_of_mode; });
  }
}

Scene random_scene(Choices& choices) {
  Scene scene(coupling(choices));
  std::vector<std::string> names[2];
  const std::uint64_t volumes = 1 + choices.below(3);
  for (std::uint64_t n = 0; n < volumes; ++n) add_volume(choices, scene, choices.one_in(2) ? 3 : 1, names);
  if (choices.one_in(3)) {
    scene.edit<TimeOptions>([&](auto& time) {
      time.play = choices.one_in(2) ? TimeOptions::Play::once : TimeOptions::Play::loop;
      time.speed = choices.log_between(0.1, choices.one_in(8) ? 1e6 : 10.0);
    });
  }
  Workspace workspace{.fit = "v0"};
  if (choices.one_in(6)) workspace = {.scale = choices.log_between(1e-6, 1e6)};
  scene.set(workspace);
  const std::uint64_t modes = 1 + choices.below(5);
  // A mode with unfit parameters is refused, as a scene's file would be; the others run.
  for (std::uint64_t n = 0; n < modes; ++n) {
    try {
      add_mode(choices, scene, names);
    } catch (const SceneError&) {
    }
  }
  return scene;
}

}  // namespace palpa::fuzz
