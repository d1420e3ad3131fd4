#include <vtkActor.h>
#include <vtkActorCollection.h>
#include <vtkCamera.h>
#include <vtkMapper.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <iterator>
#include <set>

#include "palpa/view/canvas.h"
#include "palpa/view/layers.h"
#include "palpa/view/offscreen.h"
#include "palpa/view/picture.h"
#include "palpa/view/shapes.h"
#include "palpa/view/streamlines.h"
#include "palpa/view/volume_picture.h"
#include "palpa/vtk/felt_actors.h"
#include "palpa/vtk/felt_tool.h"

namespace palpa {
namespace {

using detail::Canvas;
using detail::Color;
using detail::ColorBar;
using detail::ColorMap;
using detail::Layout;
using detail::LegendEntry;
using detail::Side;
using detail::View;

// [1] Points of a drawn path. More: slower; fewer: fast motion has corners.
constexpr std::size_t most_path_points = 4000;
// Smallest extent assumed for a path. Less: the tremor of a resting hand fills the picture; more: small motions are hard to
// see.
constexpr double min_path_radius_m = 0.02;
constexpr Color probe_color{detail::probe_color[0], detail::probe_color[1], detail::probe_color[2]};
constexpr Color limited_color{0.25, 0.80, 1.0};

/// Extent along the picture's right, up and towards the viewer.
struct Seen {
  Vec3 low{1e300, 1e300, 1e300};
  Vec3 high{-1e300, -1e300, -1e300};

  void add(const View& view, const Vec3& p_m) {
    const Vec3 q{dot(p_m, view.right), dot(p_m, view.up), dot(p_m, view.towards)};
    low = {std::min(low.x, q.x), std::min(low.y, q.y), std::min(low.z, q.z)};
    high = {std::max(high.x, q.x), std::max(high.y, q.y), std::max(high.z, q.z)};
  }
  void add(const View& view, const Box& box) {
    for (int corner = 0; corner < 8; ++corner) {
      add(view, Vec3{corner & 1 ? box.high_m.x : box.low_m.x, corner & 2 ? box.high_m.y : box.low_m.y,
                     corner & 4 ? box.high_m.z : box.low_m.z});
    }
  }
  void add(const Seen& other) {
    low = {std::min(low.x, other.low.x), std::min(low.y, other.low.y), std::min(low.z, other.low.z)};
    high = {std::max(high.x, other.high.x), std::max(high.y, other.high.y), std::max(high.z, other.high.z)};
  }
  bool any() const { return low.x <= high.x; }
  /// Half the longer side in the picture.
  double radius_m() const { return any() ? 0.5 * std::max(high.x - low.x, high.y - low.y) : 0.0; }
  Vec3 centre() const { return 0.5 * (low + high); }
};

Seen shared(const Seen& a, const Seen& b) {
  return {{std::max(a.low.x, b.low.x), std::max(a.low.y, b.low.y), std::max(a.low.z, b.low.z)},
          {std::min(a.high.x, b.high.x), std::min(a.high.y, b.high.y), std::min(a.high.z, b.high.z)}};
}

/// Extent of the renderer's shapes, by their points.
Seen seen_in(vtkRenderer& renderer, const View& view) {
  Seen seen;
  vtkActorCollection& actors = *renderer.GetActors();
  actors.InitTraversal();
  while (vtkActor* actor = actors.GetNextActor()) {
    actor->GetMapper()->Update();
    auto* data = vtkPolyData::SafeDownCast(actor->GetMapper()->GetInput());
    if (!data) continue;
    for (vtkIdType cell = 0; cell < data->GetNumberOfCells(); ++cell) {
      vtkIdType size = 0;
      const vtkIdType* corners = nullptr;
      data->GetCellPoints(cell, size, corners);
      for (vtkIdType i = 0; i < size; ++i) {
        double p[3];
        data->GetPoint(corners[i], p);
        seen.add(view, Vec3{p[0], p[1], p[2]});
      }
    }
  }
  return seen;
}

View looking(const ScenePictureOptions& options) {
  View view;
  view.width_px = options.width_px;
  view.height_px = options.height_px;
  view.towards = normalized(options.from);
  view.right = normalized(cross(options.up, view.towards));
  if (norm(view.right) == 0.0) throw LoadError("pictures: 'from' and 'up' are parallel or zero; look from the side of 'up'");
  view.up = cross(view.towards, view.right);
  return view;
}

/// Adjusts the view so that `seen` fills the scene's part of the picture.
void frame(View& view, const Seen& seen, const ScenePictureOptions& options, const Layout& layout, double margin_px) {
  struct Free {
    double left, right, bottom, top;  // [1] of width and height
  };
  const Free free{margin_px / view.width_px, (layout.scene_right_px - margin_px) / view.width_px, margin_px / view.height_px,
                  (layout.scene_top_px - margin_px) / view.height_px};
  const double width_m = std::max(seen.high.x - seen.low.x, 1e-9);
  const double height_m = std::max(seen.high.y - seen.low.y, 1e-9);
  const double aspect = 1.0 * view.width_px / view.height_px;
  const double fitting_m = 0.5 * std::max(height_m / (free.top - free.bottom), width_m / ((free.right - free.left) * aspect));
  view.half_height_m = options.half_height_m > 0.0 ? options.half_height_m : fitting_m;
  if (options.centre_m) {
    view.centre_m = *options.centre_m;
    return;
  }
  Vec3 middle = seen.centre();
  middle.x -= ((free.left + free.right) / 2 - 0.5) * 2.0 * view.half_height_m * aspect;
  middle.y -= ((free.bottom + free.top) / 2 - 0.5) * 2.0 * view.half_height_m;
  view.centre_m = middle.x * view.right + middle.y * view.up + middle.z * view.towards;
}

void look(vtkRenderer& renderer, const View& view, double reach_m) {
  vtkCamera& camera = *renderer.GetActiveCamera();
  const Vec3 eye = view.centre_m + (2.0 * reach_m) * view.towards;
  camera.ParallelProjectionOn();
  camera.SetFocalPoint(view.centre_m.x, view.centre_m.y, view.centre_m.z);
  camera.SetPosition(eye.x, eye.y, eye.z);
  camera.SetViewUp(view.up.x, view.up.y, view.up.z);
  camera.SetParallelScale(view.half_height_m);
  camera.SetClippingRange(0.5 * reach_m, 3.5 * reach_m);
}

/// Points of a path without non-finite values.
std::vector<PathPoint> usable(std::span<const PathPoint> path) {
  std::vector<PathPoint> points;
  for (const PathPoint& point : path) {
    if (is_finite(point.probe_m) && is_finite(point.proxy_m) && is_finite(point.force_n) && is_finite(point.asked_n)) {
      points.push_back(point);
    }
  }
  return points;
}

/// Part of a path around a moment in which the proxy stays within `near_m` of its position then.
std::vector<PathPoint> stretch_about(const std::vector<PathPoint>& path, const Moment& moment, double near_m) {
  const auto away_m = [&](const PathPoint& point) {
    return distance(point.probe_m, moment.probe_m) + distance(point.proxy_m, moment.proxy_m);
  };
  const auto here =
      std::min_element(path.begin(), path.end(), [&](const PathPoint& a, const PathPoint& b) { return away_m(a) < away_m(b); });
  const auto is_far = [&](const PathPoint& point) { return distance(point.proxy_m, moment.proxy_m) > near_m; };
  const auto begin = std::find_if(std::make_reverse_iterator(here), path.rend(), is_far).base();
  return {begin, std::find_if(here, path.end(), is_far)};
}

/// Reduces the path to about `most_path_points` points, each at least `apart_m` from its predecessor, which takes over the
/// largest force of omitted points.
std::vector<PathPoint> thinned(std::span<const PathPoint> path, double apart_m, Vec3 PathPoint::*place) {
  const std::size_t stride = path.size() / most_path_points + 1;
  std::vector<PathPoint> thin;
  for (std::size_t i = 0; i < path.size(); ++i) {
    const bool far = thin.empty() || distance(thin.back().*place, path[i].*place) > apart_m;
    if (thin.empty() || (i % stride == 0 && far)) {
      thin.push_back(path[i]);
    } else if (norm(path[i].force_n) > norm(thin.back().force_n)) {
      thin.back().force_n = path[i].force_n;
      thin.back().asked_n = path[i].asked_n;
      thin.back().limited = path[i].limited;
    }
  }
  return thin;
}

void draw_path(vtkRenderer* renderer, std::span<const PathPoint> path, const ColorMap& colors, double unit_m) {
  std::vector<std::vector<detail::TubePoint>> proxy(1), probe(1), bands(1);
  const double radius_m = 0.0115 * unit_m;
  double gone_m = 0.0;
  for (const PathPoint& point : thinned(path, 0.004 * unit_m, &PathPoint::proxy_m)) {
    if (!proxy[0].empty()) gone_m += distance(proxy[0].back().position_m, point.proxy_m);
    proxy[0].push_back({point.proxy_m, colors.at(norm(point.force_n)).color});
    const bool in_band = point.limited && std::fmod(gone_m, 6.0 * radius_m) < 2.5 * radius_m;
    if (in_band) {
      bands.back().push_back({point.proxy_m, limited_color});
    } else if (!bands.back().empty()) {
      bands.emplace_back();
    }
  }
  for (const PathPoint& point : thinned(path, 0.004 * unit_m, &PathPoint::probe_m)) {
    probe[0].push_back({point.probe_m, probe_color});
  }
  detail::draw_tubes(renderer, probe, 0.0028 * unit_m);
  detail::draw_tubes(renderer, proxy, radius_m, 0.5);
  detail::draw_tubes(renderer, bands, 1.2 * radius_m, 0.5);
}

/// Draws the path, with legend and colour bar.
void show_path(vtkRenderer* renderer, std::span<const PathPoint> path, double unit_m, detail::LayerSigns& signs) {
  double most_n = 0.0;
  double cut_n = 0.0;    // largest force limited by the guard, after …
  double asked_n = 0.0;  // … and before
  for (const PathPoint& point : path) {
    most_n = std::max(most_n, norm(point.force_n));
    if (!point.limited) continue;
    cut_n = std::max(cut_n, norm(point.force_n));
    asked_n = std::max(asked_n, norm(point.asked_n));
  }
  const ColorMap colors = detail::force_colors(most_n > 1e-9 ? most_n : 1.0);
  draw_path(renderer, path, colors, unit_m);
  signs.bars.insert(signs.bars.begin(), ColorBar{"force on hand / N", colors});
  std::vector<Color> shades;
  for (const auto& point : colors.points()) shades.push_back(point.color);
  signs.legend.push_back({"proxy's path", shades, LegendEntry::Sign::line});
  signs.legend.push_back({"probe's path", {probe_color}, LegendEntry::Sign::line});
  if (asked_n > 0.0) {
    const Color top = colors.at(cut_n).color;
    signs.legend.push_back({"limited to " + detail::number_words(cut_n) + " N (asked " + detail::number_words(asked_n) + " N)",
                            {top, limited_color, top, limited_color, top},
                            LegendEntry::Sign::line});
  }
}

/// Writes "proxy" and "probe" beside their balls, on either side of the spring, so that the texts do not cover it.
void name_ends(Canvas& canvas, const View& view, const Moment& moment) {
  const double em = canvas.em_px();
  const double dx = view.x_px(moment.probe_m) - view.x_px(moment.proxy_m);
  const double dy = view.y_px(moment.probe_m) - view.y_px(moment.proxy_m);
  const double length = std::hypot(dx, dy);
  const double sign = dx < 0.0 ? -1.0 : 1.0;
  const double across_x = length > 1.0 ? -sign * dy / length : 0.0;
  const double across_y = length > 1.0 ? sign * dx / length : 1.0;  // never down
  const auto name = [&](const char* word, const Vec3& at_m, double to_side) {
    const detail::PixelPoint from{view.x_px(at_m), view.y_px(at_m)};
    const double x = to_side * across_x * 3.4 * em;
    const detail::PixelPoint to{from.x_px + x, from.y_px + to_side * across_y * 3.4 * em};
    canvas.line(from, to, 0.07 * em, {0.13, 0.13, 0.15});
    canvas.text(word, to.x_px + (x < 0.0 ? -0.3 : 0.3) * em, to.y_px, x < 0.0 ? Side::right : Side::left);
  };
  name("proxy", moment.proxy_m, 1.0);
  name("probe", moment.probe_m, -1.0);
}

void explain_modes(const Moment& moment, detail::LayerSigns& signs) {
  std::set<std::uint16_t> modes;
  for (const PlacedPrimitive& placed : moment.primitives) modes.insert(placed.primitive.id.mode);
  for (const std::uint16_t mode : modes) {
    const std::string name = mode < moment.mode_names.size() ? moment.mode_names[mode] : "mode " + std::to_string(mode);
    signs.legend.push_back({name, {detail::mode_color(mode)}});
  }
}

/// Draws the feet of the scene's tool, with their legend.
void show_tool(vtkRenderer* front, const Scene& scene, const Moment& moment, double unit_m, detail::LayerSigns& signs) {
  const Tool tool(scene.tool(), scene.coupling());
  if (tool.is_point()) return;
  std::vector<Vec3> forces_n(tool.feet());
  add_foot_forces(moment.primitives, forces_n);
  FeltTool(front, tool, unit_m).show({moment.probe_m, moment.probe_turn}, {moment.proxy_m, moment.proxy_turn}, forces_n);
  const detail::FeltColor red = detail::foot_color(1.0);
  signs.legend.push_back({"foot of the tool, red by force", {{red[0], red[1], red[2]}}});
  signs.legend.push_back({"tool at the device", {probe_color}});
}

/// Extents in the picture.
struct Extents {
  Seen felt, now, data;
};

Extents extents_of(const Scene& scene, const std::vector<ViewLayer>& layers, const std::vector<PathPoint>& path,
                   const std::optional<Moment>& moment, const View& view) {
  Extents extents;
  for (const PathPoint& point : path) {
    extents.felt.add(view, point.probe_m);
    extents.felt.add(view, point.proxy_m);
  }
  if (moment) {
    extents.now.add(view, moment->probe_m);
    extents.now.add(view, moment->proxy_m);
    if (const Tool tool(scene.tool(), scene.coupling()); !tool.is_point()) {
      for (std::size_t foot = 0; foot < tool.feet(); ++foot)
        extents.now.add(view, tool.foot_m({moment->proxy_m, moment->proxy_turn}, foot));
    }
    extents.felt.add(extents.now);
  }
  const Similarity map = scene.hand_to_world();
  for (const ViewLayer& layer : layers)
    extents.data.add(view, detail::in_hand_frame(scene.field(layer.field).field, map)->bounds_m());
  if (!extents.data.any() && !extents.felt.any()) extents.data.add(view, Box{{-0.1, -0.1, -0.1}, {0.1, 0.1, 0.1}});
  return extents;
}

/// All of the data if that leaves the path large enough, otherwise its surroundings. \param close  the moment alone
Seen shown_part(const Extents& extents, bool close) {
  const auto& [felt, now, data] = extents;
  if (close) return now;
  if (!felt.any()) return data;
  Seen shown = data;
  const double path_radius_m = std::max(felt.radius_m(), min_path_radius_m);
  if (data.radius_m() > 7.0 * path_radius_m) {
    const double radius_m = std::clamp(0.6 * data.radius_m(), 3.0 * path_radius_m, 5.0 * path_radius_m);
    const Vec3 centre = felt.centre();
    shown.low = {std::max(data.low.x, centre.x - radius_m), std::max(data.low.y, centre.y - radius_m), felt.low.z};
    shown.high = {std::min(data.high.x, centre.x + radius_m), std::min(data.high.y, centre.y + radius_m), felt.high.z};
  }
  shown.add(felt);
  return shown;
}

/// Shows the renderers from back to front, with edges smoothed at the end: several samples of each pixel would double the time
/// without a graphics card.
void stack(vtkRenderWindow& window, std::initializer_list<vtkRenderer*> renderers, const View& view, double depth_m) {
  window.SetNumberOfLayers(static_cast<int>(renderers.size()));
  int number = 0;
  for (vtkRenderer* renderer : renderers) {
    renderer->SetLayer(number++);
    detail::add_light(renderer);
    look(*renderer, view, depth_m);
    window.AddRenderer(renderer);
  }
  window.SetMultiSamples(0);
  (*std::prev(renderers.end()))->UseFXAAOn();
}

void draw_directions(Canvas& canvas, const Layout& layout, const View& view, const Scene& scene) {
  const Similarity map = scene.hand_to_world();
  const std::array<Vec3, 3> axes{map.direction_to_hand({1, 0, 0}), map.direction_to_hand({0, 1, 0}),
                                 map.direction_to_hand({0, 0, 1})};
  const bool medical = std::any_of(scene.volumes().begin(), scene.volumes().end(),
                                   [](const SceneVolume& volume) { return volume.volume.medical_frame; });
  medical ? detail::draw_orientation(canvas, layout, view, axes) : detail::draw_axes(canvas, view, axes);
}

}  // namespace

Picture scene_picture(const Scene& scene, std::span<const PathPoint> path, const std::optional<Moment>& moment,
                      const ScenePictureOptions& options) {
  detail::check_size(options.width_px, options.height_px, 200, 150);
  View view = looking(options);
  const std::vector<ViewLayer> layers = detail::layers_of(scene);

  std::vector<PathPoint> felt_path = usable(path);
  const Extents extents = extents_of(scene, layers, felt_path, moment, view);
  const bool close = moment && options.half_height_m > 0.0, is_felt = extents.felt.any();
  const Seen shown = shown_part(extents, close);

  detail::OffscreenWindow window(options.width_px, options.height_px);
  vtkNew<vtkRenderer> front;
  Canvas canvas(front, options.width_px, options.height_px);
  const Layout layout(canvas, !scene.title.empty());
  const double margin_px = 2.2 * canvas.em_px();
  frame(view, shown, options, layout, margin_px);

  const double reach_m = 2.0 * view.half_height_m * std::max(1.0, 1.0 * view.width_px / view.height_px);
  const Vec3 reach{reach_m, reach_m, reach_m};
  vtkNew<vtkRenderer> solid;
  vtkNew<vtkRenderer> shells;
  detail::LayerSigns signs = detail::draw_layers(solid, shells, scene, layers,
                                                 {{view.centre_m - reach, view.centre_m + reach},
                                                  is_felt,
                                                  scene.time().at(moment ? moment->time_s : 0.0),
                                                  view.half_height_m,
                                                  view.towards});
  if (!close) {
    Seen drawn = seen_in(*solid, view);
    drawn.add(seen_in(*shells, view));
    drawn = shared(shown, drawn);  // drawn shapes may be smaller than the fields' boxes
    if (is_felt) drawn.add(extents.felt);
    if (drawn.any()) frame(view, drawn, options, layout, margin_px);
  }
  const double unit_m = view.half_height_m;
  if (close) felt_path = stretch_about(felt_path, *moment, 1.6 * unit_m);
  if (!felt_path.empty()) show_path(solid, felt_path, unit_m, signs);

  // From back to front: opaque layers, translucent layers, moment and annotations.
  solid->SetBackground(detail::ground_color.red, detail::ground_color.green, detail::ground_color.blue);
  shells->PreserveDepthBufferOn();
  stack(*window.vtk(), {solid, shells, front}, view, 4.0 * reach_m);

  detail::draw_margins(canvas, layout, scene.title);
  if (moment) {
    FeltActors(front, unit_m).show(moment->probe_m, moment->proxy_m, moment->primitives);
    show_tool(front, scene, *moment, unit_m, signs);
    explain_modes(*moment, signs);
    name_ends(canvas, view, *moment);
  }
  draw_directions(canvas, layout, view, scene);
  detail::draw_scale_bar(canvas, layout, view, scene.hand_to_world().scale, file_unit_m(scene));
  detail::draw_explanations(canvas, layout, signs.legend, signs.bars);
  Picture picture = window.draw();
  // The lowest bit is rounding noise of the lighting: invisible, but a quarter of the file.
  for (std::uint8_t& value : picture.rgb) value |= 1U;
  return picture;
}

}  // namespace palpa
