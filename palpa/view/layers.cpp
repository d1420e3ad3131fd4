#include "palpa/view/layers.h"

#include <vtkActor.h>
#include <vtkActorCollection.h>
#include <vtkCellArray.h>
#include <vtkColorTransferFunction.h>
#include <vtkGPUVolumeRayCastMapper.h>
#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPiecewiseFunction.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>
#include <vtkVolume.h>
#include <vtkVolumeProperty.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstring>
#include <limits>
#include <map>

#include "palpa/data/grid.h"
#include "palpa/data/octave_parts.h"
#include "palpa/data/parallel.h"
#include "palpa/data/sampled.h"
#include "palpa/data/volume.h"
#include "palpa/scene/scene_checks.h"
#include "palpa/view/layer_surface.h"
#include "palpa/view/shapes.h"
#include "palpa/view/streamlines.h"
#include "palpa/vtk/to_vtk.h"

namespace palpa::detail {
namespace {

// [1] Factor of a mode's masks below which a flow is not drawn. More: its edges are cut off; less: noise is drawn.
constexpr double least_drawn = 0.2;
constexpr int slice_cells = 240;  // [1] along each side of a slice. More: slower; fewer: blurred

/// Collects the fields and levels of a mode.
class FieldsRead : public ParameterVisitor {
 public:
  std::vector<std::pair<std::string, ParameterKind>> fields;
  std::vector<double> levels;
  std::vector<std::string> level_names;  ///< parallel to `levels`
  bool solid_is_low = false;

  void field(const ParameterInfo& info, FieldRef& ref) override {
    if (!ref.name.empty()) fields.emplace_back(ref.name, info.kind);
  }
  void number(const ParameterInfo& info, double& value) override {
    if (info.kind == ParameterKind::level) levels.push_back(value);
  }
  void text(const ParameterInfo& info, std::string& value) override {
    if (info.name == "name") name_ = value;
  }
  void choice(const ParameterInfo& info, int& index) override {
    if (info.name == "solid") solid_is_low = info.choices[static_cast<std::size_t>(index)] == "low";
  }
  void list(const ParameterInfo&, ParameterList& items) override {
    for (std::size_t i = 0; i < items.size(); ++i) {
      name_.clear();
      items.visit(i, *this);
      level_names.resize(levels.size());
      if (!levels.empty()) level_names.back() = name_;
    }
  }

 private:
  std::string name_;
};

/// Field restricted to a part of its box.
class Part : public Field {
 public:
  Part(FieldPtr field, const Box& box) : field_(std::move(field)), box_(box) {}
  int components() const noexcept override { return field_->components(); }
  ScalarSample scalar(const Vec3& x_m) const noexcept override { return field_->scalar(x_m); }
  double spacing_m() const noexcept override { return field_->spacing_m(); }
  Box bounds_m() const noexcept override { return box_; }
  double depth_m(const Vec3& x_m) const noexcept override { return field_->depth_m(x_m); }
  std::vector<ValueRange> value_ranges() const override { return field_->value_ranges(); }

 private:
  FieldPtr field_;
  Box box_;
};

/// Scalar field over a part of its box as VTK image; NaN without data.
vtkSmartPointer<vtkImageData> image_of(const FieldPtr& field, const Box& box, int most_samples) {
  const double side_m = largest_component(box.size_m());
  const double samples = std::ceil(side_m / field->spacing_m()) + 1.0;
  const FieldPtr grid = sampled(Part(field, box), static_cast<int>(std::clamp(samples, 2.0, 1.0 * most_samples)));
  return to_vtk(*grid);
}

/// Field with data only where masks let a mode act.
class Masked : public Field {
 public:
  Masked(FieldPtr field, std::vector<std::pair<FieldPtr, TransferFunction>> masks)
      : field_(std::move(field)), masks_(std::move(masks)) {}
  int components() const noexcept override { return field_->components(); }
  VectorSample vector(const Vec3& x_m) const noexcept override {
    VectorSample sample = field_->vector(x_m);
    double share = 1.0;
    for (const auto& [of, curve] : masks_) {
      const ScalarSample value = of->scalar(x_m);
      share *= value.inside ? curve.at(value.value) : 0.0;
    }
    sample.inside = sample.inside && share > least_drawn;
    return sample;
  }
  double spacing_m() const noexcept override { return field_->spacing_m(); }
  Box bounds_m() const noexcept override { return field_->bounds_m(); }
  double depth_m(const Vec3& x_m) const noexcept override { return field_->depth_m(x_m); }
  std::vector<ValueRange> value_ranges() const override { return field_->value_ranges(); }

 private:
  FieldPtr field_;
  std::vector<std::pair<FieldPtr, TransferFunction>> masks_;
};

/// Field of a layer as it is drawn, hand frame.
struct DrawnField {
  FieldPtr field;
  Box box;
  std::optional<int> octave{};  ///< of a field in octaves
};
DrawnField drawn_field(const Scene& scene, const ViewLayer& layer, const LayerOptions& options) {
  const FieldPtr world = scene.field(layer.field).field;
  const FieldPtr field = in_hand_frame(frozen(world, options.at), scene.hand_to_world());
  const Box box = shared_part(field->bounds_m(), options.near);
  const double side_m = largest_component(box.size_m());
  const double step_m = side_m / (layer.show == ViewLayer::Show::slices ? slice_cells : options.most_samples);
  if (!(step_m > 0.0)) return {field, box};
  const auto octave = drawn_octave(*in_hand_frame(world, scene.hand_to_world()), options.at, box, step_m);
  return octave ? DrawnField{octave->field, box, octave->octave} : DrawnField{field, box};
}

/// Words of a layer with the octave that it shows.
std::string with_octave(const std::string& words, const DrawnField& drawn) {
  return drawn.octave ? words + ", octave " + std::to_string(*drawn.octave) : words;
}

/// Cache of drawn and sampled fields: several layers of one field share them.
class Images {
 public:
  Images(const Scene& scene, const LayerOptions& options) : scene_(scene), options_(options) {}
  const DrawnField& field_of(const ViewLayer& layer) {
    std::optional<DrawnField>& field = fields_[{layer.field.name, layer.show == ViewLayer::Show::slices}];
    if (!field) field = drawn_field(scene_, layer, options_);
    return *field;
  }
  vtkImageData* of(const ViewLayer& layer) {
    const DrawnField& drawn = field_of(layer);
    vtkSmartPointer<vtkImageData>& image = images_[layer.field.name];
    return image ? image : image = image_of(drawn.field, drawn.box, options_.most_samples);
  }

 private:
  const Scene& scene_;
  const LayerOptions& options_;
  std::map<std::pair<std::string, bool>, std::optional<DrawnField>> fields_;
  std::map<std::string, vtkSmartPointer<vtkImageData>> images_;
};

/// Isosurfaces by layer, null for other layers; on all cores.
std::vector<vtkSmartPointer<vtkPolyData>> find_surfaces(const Scene& scene, const std::vector<ViewLayer>& layers,
                                                        const LayerOptions& options, Images& images) {
  struct Work {
    std::size_t layer;
    FieldPtr field;
    vtkSmartPointer<vtkImageData> image;
    double level;
  };
  std::vector<Work> all;
  for (std::size_t i = 0; i < layers.size(); ++i) {
    if (layers[i].show != ViewLayer::Show::surface) continue;
    const DrawnField& drawn = images.field_of(layers[i]);
    if (!(largest_component(drawn.box.size_m()) > 0.0)) continue;
    all.push_back({i, drawn.field, vtkSmartPointer<vtkImageData>::New(),  // a pipeline of its own for each thread
                   surface_style(scene, layers, i, options.see_through).level});
    all.back().image->ShallowCopy(images.of(layers[i]));
  }
  std::vector<vtkSmartPointer<vtkPolyData>> surfaces(layers.size());
  in_parts(static_cast<std::int64_t>(all.size()), 1, [&](std::int64_t first, std::int64_t last) {
    for (std::int64_t i = first; i < last; ++i) {
      const Work& work = all[static_cast<std::size_t>(i)];
      vtkSmartPointer<vtkPolyData>& surface = surfaces[work.layer];
      surface = surface_of(work.image, *work.field, work.level);
      if (!layers[work.layer].all_parts && surface->GetNumberOfCells() > 0) surface = large_parts(surface);
    }
  });
  return surfaces;
}

/// Display name of a field: the file's, unless that is generic and the scene's is not (suggested scenes name their volume
/// "data").
std::string name_of(const Scene& scene, const FieldRef& ref, const VolumeField& named) {
  if (scene.volumes().size() != 1) return ref.name;
  if (!is_generic_name(named.name)) return named.name;
  const bool in_scene = ref.name.find("data") == ref.name.npos && ref.name.find('.') == ref.name.npos;
  return in_scene ? ref.name : named.field->components() == 1 ? "value" : "speed";
}

/// Whether the data come from a file, which may say a unit.
bool is_of_file(const Scene& scene, const FieldRef& ref) {
  return std::ranges::any_of(scene.volumes(), [&](const SceneVolume& volume) {
    return volume.volume.request && ref.name.find(volume.name) != ref.name.npos;
  });
}

std::string title_of(const Scene& scene, const ViewLayer& layer, const VolumeField& named) {
  const std::string name = layer.name.empty() ? name_of(scene, layer.field, named) : layer.name;
  if (!named.unit.empty()) return name + " / " + named.unit;
  return is_of_file(scene, layer.field) ? name + ", no unit in the file" : name;
}

/// Display name of a surface: the layer's, else that of a mode's level at the value, else field and value.
std::string surface_words(const Scene& scene, const ViewLayer& layer, const VolumeField& named, double level) {
  if (!layer.name.empty()) return layer.name;
  for (const SceneMode& mode : scene.modes()) {
    FieldsRead read;
    Mode copy = mode.mode;
    copy.visit(read);
    if (read.fields.empty() || read.fields.front().first != layer.field.name) continue;
    for (std::size_t i = 0; i < read.level_names.size(); ++i) {
      if (read.levels[i] == level && !read.level_names[i].empty()) return read.level_names[i];
    }
  }
  std::string unit = named.unit.empty() ? "" : " " + named.unit;
  if (named.unit.starts_with("1/")) unit = named.unit.substr(1);  // "3/s", not "3 1/s"
  const std::string value = " = " + number_words(level) + unit;
  if (layer.field.name.starts_with("q(")) return "vortices (Q" + value + ")";
  return name_of(scene, layer.field, named) + value;
}

/// Value of a scalar field, magnitude of a vector field; false without data.
bool value_at(const Field& field, const Vec3& x_m, double& value) {
  if (field.components() == 1) {
    const ScalarSample sample = field.scalar(x_m);
    value = sample.value;
    return sample.inside;
  }
  const VectorSample sample = field.vector(x_m);
  value = norm(sample.value);
  return sample.inside;
}

/// Three planes through the middle of the box, in the field's colours, with holes without data.
void draw_slices(vtkRenderer* renderer, const Field& field, const Box& box, const ColorMap& map) {
  constexpr int n = slice_cells;
  const Vec3 middle = box.centre_m(), size = box.size_m();
  const std::array<Vec3, 3> sides{Vec3{size.x, 0, 0}, Vec3{0, size.y, 0}, Vec3{0, 0, size.z}};
  for (int plane = 0; plane < 3; ++plane) {
    const Vec3& a = sides[static_cast<std::size_t>((plane + 1) % 3)];
    const Vec3& b = sides[static_cast<std::size_t>((plane + 2) % 3)];
    if (!(norm(a) > 0.0) || !(norm(b) > 0.0)) continue;
    vtkNew<vtkPoints> points;
    vtkNew<vtkCellArray> cells;
    vtkNew<vtkUnsignedCharArray> colors;
    colors->SetNumberOfComponents(4);
    std::vector<char> inside;
    for (int j = 0; j <= n; ++j) {
      for (int i = 0; i <= n; ++i) {
        const Vec3 p = middle + (1.0 * i / n - 0.5) * a + (1.0 * j / n - 0.5) * b;
        double value = 0.0;
        inside.push_back(value_at(field, p, value));
        const ColorMap::Point color = map.at(value);
        points->InsertNextPoint(p.x, p.y, p.z);
        const double bytes[] = {255.0 * color.color.red, 255.0 * color.color.green, 255.0 * color.color.blue,
                                255.0 * color.opacity};
        colors->InsertNextTuple(bytes);
      }
    }
    for (int j = 0; j < n; ++j) {
      for (int i = 0; i < n; ++i) {
        const vtkIdType at = j * (n + 1) + i;
        const vtkIdType corners[] = {at, at + 1, at + n + 2, at + n + 1};
        if (std::all_of(corners, corners + 4, [&](vtkIdType c) { return inside[static_cast<std::size_t>(c)]; }))
          cells->InsertNextCell(4, corners);
      }
    }
    vtkNew<vtkPolyData> data;
    data->SetPoints(points);
    data->SetPolys(cells);
    data->GetPointData()->SetScalars(colors);
    vtkNew<vtkPolyDataMapper> mapper;
    mapper->SetInputData(data);
    vtkNew<vtkActor> actor;
    actor->SetMapper(mapper);
    actor->GetProperty()->LightingOff();
    renderer->AddActor(actor);
  }
}

/// Cloud whose opacity is that of the layer's colours, reached over a fortieth of the box's longest side.
void draw_volume(vtkRenderer* renderer, vtkImageData* sampled, double side_m, const ColorMap& map) {
  vtkNew<vtkImageData> image;
  image->DeepCopy(sampled);  // values without data are replaced below
  const auto clearest =
      std::min_element(map.points().begin(), map.points().end(),
                       [](const ColorMap::Point& a, const ColorMap::Point& b) { return a.opacity < b.opacity; });
  auto* values = static_cast<float*>(image->GetScalarPointer());
  for (vtkIdType i = 0; i < image->GetNumberOfPoints(); ++i) {
    if (!std::isfinite(values[i])) values[i] = static_cast<float>(clearest->value);
  }
  vtkNew<vtkColorTransferFunction> colors;
  vtkNew<vtkPiecewiseFunction> opacities;
  for (const ColorMap::Point& point : map.points()) {
    colors->AddRGBPoint(point.value, point.color.red, point.color.green, point.color.blue);
    opacities->AddPoint(point.value, point.opacity);
  }
  double spacing[3];
  image->GetSpacing(spacing);
  const double least_m = *std::min_element(spacing, spacing + 3);
  vtkNew<vtkVolume> volume;
  volume->GetProperty()->SetColor(colors);
  volume->GetProperty()->SetScalarOpacity(opacities);
  volume->GetProperty()->SetScalarOpacityUnitDistance(side_m / 40.0);
  volume->GetProperty()->SetInterpolationTypeToLinear();
  // Without a graphics card VTK's CPU ray caster would be faster, but it sometimes renders as if the picture were square.
  vtkNew<vtkGPUVolumeRayCastMapper> mapper;
  mapper->SetInputData(image);
  mapper->AutoAdjustSampleDistancesOff();
  mapper->SetSampleDistance(static_cast<float>(least_m));
  mapper->UseJitteringOff();
  volume->SetMapper(mapper);
  renderer->AddVolume(volume);
}

/// Colours for speeds in ascending order, without a twentieth at each end: from zero to the fastest, or from the slowest if
/// that is not near zero.
ColorMap speed_colors(const ViewLayer& layer, const std::vector<double>& speeds) {
  if (!layer.colors.empty()) return ColorMap(layer.colors);
  if (speeds.empty()) return magnitude_colors(0.0, 0.0);
  const double slow = speeds[speeds.size() / 20];
  const double fast = speeds[speeds.size() - 1 - speeds.size() / 20];
  return magnitude_colors(slow > 0.4 * fast ? slow : 0.0, fast);
}

/// Draws streamlines; returns their colours by speed.
ColorMap draw_streamlines(vtkRenderer* solid, const ViewLayer& layer, const Field& field, const Box& box,
                          const LayerOptions& options) {
  const std::vector<Streamline> lines = streamlines(field, box, static_cast<std::size_t>(options.most_lines));
  std::vector<double> speeds;
  for (const Streamline& line : lines) {
    for (const StreamPoint& point : line) speeds.push_back(point.speed);
  }
  std::sort(speeds.begin(), speeds.end());
  const ColorMap map = speed_colors(layer, speeds);
  std::vector<std::vector<TubePoint>> tubes;
  for (const Streamline& line : lines) {
    std::vector<TubePoint>& tube = tubes.emplace_back();
    for (const StreamPoint& point : line) tube.push_back({point.position_m, map.at(point.speed).color});
  }
  draw_tubes(solid, tubes, 0.0045 * options.unit_m);
  return map;
}

/// Draws arrows; returns their colours by speed.
ColorMap draw_glyphs(vtkRenderer* solid, const ViewLayer& layer, const Field& field, const Box& box) {
  struct Glyph {
    Vec3 position_m;
    Vec3 value;
  };
  constexpr int longest = 11;  // [1] arrows along the longest side. More: they hide each other; fewer: details are lost
  std::vector<Glyph> glyphs;
  double fastest = 0.0;
  for (const Vec3& position : grid_positions(box, longest)) {
    const VectorSample sample = field.vector(position);
    if (!sample.inside) continue;
    glyphs.push_back({position, sample.value});
    fastest = std::max(fastest, norm(sample.value));
  }
  const ColorMap map = speed_colors(layer, {0.0, fastest});
  std::vector<Arrow> arrows;
  for (const Glyph& glyph : glyphs) {
    const double share = fastest > 0.0 ? norm(glyph.value) / fastest : 0.0;
    if (share < 0.05) continue;
    const Vec3 half = (0.5 * largest_component(box.size_m()) / longest * std::max(share, 0.25)) * normalized(glyph.value);
    arrows.push_back({glyph.position_m - half, glyph.position_m + half, map.at(norm(glyph.value)).color});
  }
  draw_arrows(solid, arrows);
  return map;
}

void draw_layer(vtkRenderer* solid, vtkRenderer* shells, const Scene& scene, const std::vector<ViewLayer>& layers,
                std::size_t number, const LayerOptions& options, Images& images, vtkPolyData* surface, LayerSigns& signs) {
  const ViewLayer& layer = layers[number];
  const VolumeField& named = scene.field(layer.field);
  const bool flows = layer.show == ViewLayer::Show::streamlines || layer.show == ViewLayer::Show::glyphs;
  const DrawnField& drawn = images.field_of(layer);
  const Box& box = drawn.box;
  const FieldPtr field = flows ? drawn_flow(scene, layer.field, drawn.field, options.at) : drawn.field;
  const double side_m = largest_component(box.size_m());
  if (!(side_m > 0.0)) return;

  const std::string title = with_octave(title_of(scene, layer, named), drawn);
  const Field& ranged = drawn.octave ? *named.field : *field;  // values of coarser octaves are means
  switch (layer.show) {
    case ViewLayer::Show::surface: {
      const SurfaceStyle look = surface_style(scene, layers, number, options.see_through);
      LegendEntry entry{with_octave(surface_words(scene, layer, named, look.level), drawn),
                        {blended(look.color, look.opacity, ground_color)}};
      if (look.opacity < 1.0) {
        signs.shells.push_back({surface, look.color, look.opacity});
        draw_shell(shells, signs.shells.back(), options.towards);
        entry.rim = blended(look.color, rim_opacity, ground_color);
      } else {
        solid->AddActor(actor_of(surface, look.color));
      }
      signs.legend.insert(signs.legend.begin(), std::move(entry));
      break;
    }
    case ViewLayer::Show::slices: {
      const ColorMap map = colors_of(layer, ranged);
      draw_slices(solid, *field, box, map);
      signs.bars.push_back({title, map});
      break;
    }
    case ViewLayer::Show::volume: {
      const ColorMap map = colors_of(layer, ranged);
      draw_volume(solid, images.of(layer), side_m, map);
      signs.bars.push_back({title, map});
      break;
    }
    case ViewLayer::Show::streamlines:
      signs.bars.push_back({title, draw_streamlines(solid, layer, *field, box, options)});
      break;
    case ViewLayer::Show::glyphs: signs.bars.push_back({title, draw_glyphs(solid, layer, *field, box)}); break;
  }
}

/// Appends the actors of a renderer from index `known` on, with the layer's data in `drawn`.
void add_actors_after(int known, vtkRenderer& renderer, LayerActor drawn, std::vector<LayerActor>& actors) {
  vtkActorCollection& all = *renderer.GetActors();
  all.InitTraversal();
  for (int number = 0; (drawn.actor = all.GetNextActor()) != nullptr; ++number) {
    if (number >= known) actors.push_back(drawn);
  }
}

}  // namespace

std::vector<ViewLayer> layers_of(const Scene& scene) {
  if (!scene.layers.empty()) return scene.layers;
  std::vector<ViewLayer> surfaces, slices, streams;
  const auto add = [](std::vector<ViewLayer>& layers, ViewLayer::Show show, const std::string& name,
                      std::optional<double> level) {
    for (const ViewLayer& layer : layers) {
      if (layer.field.name == name && layer.level == level) return;
    }
    layers.push_back({.show = show, .field = {name}, .level = level});
  };
  for (const SceneMode& mode : scene.modes()) {
    if (!mode.enabled) continue;
    FieldsRead read;
    Mode copy = mode.mode;
    copy.visit(read);
    if (read.fields.empty()) continue;
    const std::string& first = read.fields.front().first;
    std::sort(read.levels.begin(), read.levels.end());
    if (read.solid_is_low) std::reverse(read.levels.begin(), read.levels.end());
    if (surfaces.empty()) {
      for (const double level : read.levels) add(surfaces, ViewLayer::Show::surface, first, level);
    }
    for (const auto& [name, kind] : read.fields) {
      if (scene.field({name}).field->components() == 3) {
        if (streams.empty()) add(streams, ViewLayer::Show::streamlines, name, {});
      } else if (read.levels.empty() && slices.empty()) {
        add(slices, ViewLayer::Show::slices, name, {});
      }
    }
  }
  std::vector<ViewLayer> layers = surfaces;
  layers.insert(layers.end(), streams.begin(), streams.end());
  if (!layers.empty()) return layers;
  if (!slices.empty()) return slices;
  for (const SceneVolume& volume : scene.volumes()) {  // no mode reads a field
    const VolumeField& field = volume.volume.fields.front();
    const bool vectors = field.field->components() == 3;
    const std::string name = volume.volume.fields.size() == 1 ? volume.name : volume.name + "." + field.name;
    return {{.show = vectors ? ViewLayer::Show::streamlines : ViewLayer::Show::slices, .field = {name}}};
  }
  return {};
}

ColorMap colors_of(const ViewLayer& layer, const Field& field) {
  if (!layer.colors.empty()) return ColorMap(layer.colors);
  const std::vector<ValueRange> value_ranges = field.value_ranges();
  if (layer.show == ViewLayer::Show::volume) {  // low values are transparent
    const double low = value_ranges[0].min, high = value_ranges[0].max;
    return ColorMap(std::vector<ViewLayer::ColorPoint>{
        {low, "#000000", 0.0}, {0.5 * (low + high), "#8a6a4f", 0.05}, {high, "#fff6e5", 0.8}});
  }
  if (field.components() == 1) return grey_colors(value_ranges[0].min, value_ranges[0].max);
  double squared = 0.0;
  for (const ValueRange& extent : value_ranges) squared += std::pow(std::max(std::abs(extent.min), std::abs(extent.max)), 2);
  return magnitude_colors(0.0, std::sqrt(squared));
}

FieldPtr in_hand_frame(const FieldPtr& field, const Similarity& map) {
  return posed(field, {transposed(map.rotation), 1.0 / map.scale, map.to_hand({})});
}

FieldPtr drawn_flow(const Scene& scene, const FieldRef& ref, const FieldPtr& field, DataTime at) {
  for (const SceneMode& mode : scene.modes()) {
    FieldsRead read;
    Mode copy = mode.mode;
    copy.visit(read);
    const auto reads = [&](const auto& one) { return one.first == ref.name; };
    if (mode.masks.empty() || std::none_of(read.fields.begin(), read.fields.end(), reads)) continue;
    std::vector<std::pair<FieldPtr, TransferFunction>> masks;
    for (const Mask& mask : mode.masks)
      masks.emplace_back(in_hand_frame(frozen(scene.field(mask.of).field, at), scene.hand_to_world()), mask.curve);
    return std::make_shared<Masked>(field, std::move(masks));
  }
  return field;
}

bool is_generic_name(std::string_view name) {
  std::string small(name.substr(0, name.find_last_not_of("_0123456789") + 1));
  std::ranges::transform(small, small.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (small.ends_with('s')) small.pop_back();
  return std::ranges::any_of(std::array{"value", "vector", "scalar", "imagescalar"},
                             [&](const char* word) { return small == word; });
}

std::string layer_words(const Scene& scene, const std::vector<ViewLayer>& layers, std::size_t number) {
  const ViewLayer& layer = layers[number];
  const VolumeField named = scene.field(layer.field);
  if (layer.show != ViewLayer::Show::surface) return title_of(scene, layer, named);
  return surface_words(scene, layer, named, surface_style(scene, layers, number, true).level);
}

SurfaceStyle surface_style(const Scene& scene, const std::vector<ViewLayer>& layers, std::size_t number, bool see_through) {
  const ViewLayer& layer = layers[number];
  std::size_t outer = 0;  // surfaces before this one
  std::size_t surfaces = 0;
  for (std::size_t i = 0; i < layers.size(); ++i) {
    if (layers[i].show != ViewLayer::Show::surface) continue;
    if (i < number) ++outer;
    ++surfaces;
  }
  SurfaceStyle look{.level = 0.0, .color = surface_color(outer), .opacity = 1.0};
  if (layer.level) {
    look.level = *layer.level;
  } else {
    const ValueRange extent = scene.field(layer.field).field->value_ranges()[0];
    look.level = 0.5 * (extent.min + extent.max);
  }
  if (!layer.colors.empty()) {
    const ColorMap::Point point = ColorMap(layer.colors).at(look.level);
    look.color = point.color;
    look.opacity = point.opacity;
  } else if (outer + 1 < surfaces) {
    look.opacity = 0.4;
  } else if (see_through && surfaces == 1) {
    look.opacity = 0.6;
  }
  return look;
}

LayerSigns draw_layers(vtkRenderer* solid, vtkRenderer* shells, const Scene& scene, const std::vector<ViewLayer>& layers,
                       const LayerOptions& options) {
  for (const Finding& finding : layer_findings(scene, layers)) throw LoadError("pictures: " + finding.text);
  Images images(scene, options);
  const std::vector<vtkSmartPointer<vtkPolyData>> surfaces = find_surfaces(scene, layers, options, images);
  LayerSigns signs;
  // From the innermost outward, the drawing order of translucent surfaces.
  for (std::size_t i = layers.size(); i-- > 0;) {
    const std::size_t entries = signs.legend.size(), bars = signs.bars.size();
    const int solids = solid->GetActors()->GetNumberOfItems(), translucent = shells->GetActors()->GetNumberOfItems();
    draw_layer(solid, shells, scene, layers, i, options, images, surfaces[i], signs);
    LayerActor drawn{.actor = nullptr, .layer = i, .style = {}, .words = {}, .bar = {}};
    if (signs.legend.size() > entries) {
      drawn.style = surface_style(scene, layers, i, options.see_through);
      drawn.words = signs.legend.front().words;
    }
    if (signs.bars.size() > bars) drawn.bar = bars;
    add_actors_after(solids, *solid, drawn, signs.actors);
    add_actors_after(translucent, *shells, drawn, signs.actors);
  }
  std::reverse(signs.bars.begin(), signs.bars.end());
  for (LayerActor& one : signs.actors) {
    if (one.bar) one.bar = signs.bars.size() - 1 - *one.bar;
  }
  return signs;
}

}  // namespace palpa::detail
