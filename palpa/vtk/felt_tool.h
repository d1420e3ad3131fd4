// Actors of a tool, for any renderer: its feet at the proxy, red by force, and paler at the device. Header-only, for any VTK of
// the user.
#pragma once

#include <vtkActor.h>
#include <vtkDoubleArray.h>
#include <vtkGlyph3DMapper.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkSphereSource.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "palpa/device/latest.h"
#include "palpa/loop/loop.h"
#include "palpa/session/foot_forces.h"
#include "palpa/session/session.h"
#include "palpa/solver/similarity.h"
#include "palpa/solver/tool.h"
#include "palpa/vtk/felt_actors.h"

namespace palpa {

namespace detail {

/// Colour of a foot by its share [1] of red (`redness`).
inline FeltColor foot_color(double share) {
  constexpr FeltColor red{0.84, 0.10, 0.11};
  FeltColor color;
  for (std::size_t n = 0; n < color.size(); ++n) color[n] = (1.0 - share) * proxy_color[n] + share * red[n];
  return color;
}

}  // namespace detail

/// Feet of a tool as balls: at the proxy, red and larger by the force on each, and a paler copy at the device. Of a point
/// nothing is drawn. `FeltActors` draws the rest of the moment.
///
/// Two threads, as of `FeltActors`: the loop of a live session publishes its latest state (`observer`: no lock, no allocation),
/// and the window's thread reads it for drawing. Neither blocks.
class FeltTool {
 public:
  /// \param renderer       draws the feet from the first `show` on
  /// \param tool           of the scene: `Tool(scene.tool(), scene.coupling())`
  /// \param view_half_height_hand_m  [hand m] unit of sizes: half the height of the picture; > 0
  /// \param hand_to_world  hand frame to the renderer's world: `scene.hand_to_world()` if that is the data's
  FeltTool(vtkRenderer* renderer, const Tool& tool, double view_half_height_hand_m, const Similarity& hand_to_world = {})
      : renderer_(renderer), tool_(tool), unit_m_(hand_to_world.scale * view_half_height_hand_m), map_(hand_to_world) {
    prepare(at_device_);
    prepare(at_proxy_);
    at_device_.actor->GetProperty()->SetOpacity(0.35);
  }
  FeltTool(const FeltTool&) = delete;
  FeltTool& operator=(const FeltTool&) = delete;

  // ---- called by the window's thread ----

  /// Removes the actors from the renderer; the destructor does not.
  void remove() {
    for (const Feet* feet : {&at_device_, &at_proxy_}) renderer_->RemoveActor(feet->actor);
    is_added_ = false;
  }
  /// Shows the loop's latest state. True: it was new, so render.
  bool update() {
    if (!latest_.is_fresh()) return false;
    const FeetNow& now = latest_.take();
    show(now.probe, now.proxy, {now.forces_n.data(), now.forces_n.size()});
    return true;
  }
  /// Shows the tool in two poses, hand frame. A pose that is not finite is ignored.
  /// \param forces_n  [N] by the number of the foot; missing ones are zero
  void show(const Pose& probe, const Pose& proxy, std::span<const Vec3> forces_n) {
    if (tool_.is_point() || !is_drawable(probe) || !is_drawable(proxy)) return;
    if (!std::exchange(is_added_, true)) {
      for (const Feet* feet : {&at_device_, &at_proxy_}) renderer_->AddActor(feet->actor);
    }
    double most_n = 0.0;
    for (const Vec3& force_n : forces_n) most_n = std::max(most_n, norm(force_n));
    for (std::size_t foot = 0; foot < tool_.feet(); ++foot) {
      const double force_n = foot < forces_n.size() ? norm(forces_n[foot]) : 0.0;
      const double red = redness(force_n, most_n);
      // Larger than the point that FeltActors draws there.
      place(at_device_, foot, tool_.foot_m(probe, foot), detail::probe_color, 0.012 * unit_m_);
      place(at_proxy_, foot, tool_.foot_m(proxy, foot), detail::foot_color(red), (0.018 + 0.018 * red) * unit_m_);
    }
    for (const Feet* feet : {&at_device_, &at_proxy_}) {
      feet->points->Modified();
      feet->colors->Modified();
      feet->radii_m->Modified();
    }
  }

  // ---- called by the loop's thread ----

  /// Callback for a LiveLoop after each tick; the actors outlive it.
  TickObserver observer() {
    return [this](const TickFrame& frame, const Session& session) { give(frame, session); };
  }
  /// Publishes a tick's state. Allocates nothing.
  void give(const TickFrame& frame, const Session& session) noexcept {
    constexpr unsigned one_in = 8;  // [ticks] suffices for screens at 60 Hz
    if (given_++ % one_in != 0) return;
    const Tick& tick = frame.result;
    FeetNow now{.probe = {tick.probe_m, tick.probe_turn}, .proxy = {tick.proxy_m, tick.proxy_turn}};
    if (!session.sub_steps().empty()) {
      const SubStep& last = session.sub_steps().back();
      add_foot_forces(session.primitives().subspan(last.first_primitive, last.primitives), now.forces_n);
    }
    latest_.give(now);
  }

 private:
  /// The feet in one pose.
  struct Feet {
    vtkNew<vtkPoints> points;
    vtkNew<vtkUnsignedCharArray> colors;
    vtkNew<vtkDoubleArray> radii_m;  // of the world
    vtkNew<vtkPolyData> data;
    vtkNew<vtkGlyph3DMapper> mapper;
    vtkNew<vtkActor> actor;
  };
  struct FeetNow {
    Pose probe, proxy;
    std::array<Vec3, most_feet> forces_n{};
  };

  static bool is_drawable(const Pose& pose) noexcept { return is_finite(pose.position_m) && is_unit(pose.turn, 1e-3); }

  void prepare(Feet& feet) {
    const auto count = static_cast<vtkIdType>(tool_.feet());
    feet.points->SetDataTypeToDouble();
    feet.points->SetNumberOfPoints(count);
    feet.colors->SetNumberOfComponents(3);
    feet.colors->SetNumberOfTuples(count);
    feet.radii_m->SetName("radius");
    feet.radii_m->SetNumberOfTuples(count);
    feet.data->SetPoints(feet.points);
    feet.data->GetPointData()->SetScalars(feet.colors);
    feet.data->GetPointData()->AddArray(feet.radii_m);
    vtkNew<vtkSphereSource> ball;
    ball->SetRadius(1.0);
    ball->SetThetaResolution(16);
    ball->SetPhiResolution(10);
    feet.mapper->SetInputData(feet.data);
    feet.mapper->SetSourceConnection(ball->GetOutputPort());
    feet.mapper->SetScaleArray("radius");
    feet.mapper->SetScaleModeToScaleByMagnitude();
    feet.mapper->SetColorModeToDirectScalars();
    feet.actor->SetMapper(feet.mapper);
    feet.actor->PickableOff();
    feet.actor->GetProperty()->SetAmbient(0.25);
    feet.actor->GetProperty()->SetDiffuse(0.75);
  }
  void place(Feet& feet, std::size_t foot, const Vec3& at_m, const detail::FeltColor& color, double radius_m) {
    const Vec3 world_m = map_.to_world(at_m);
    const auto number = static_cast<vtkIdType>(foot);
    feet.points->SetPoint(number, world_m.x, world_m.y, world_m.z);
    feet.radii_m->SetValue(number, radius_m);
    for (int n = 0; n < 3; ++n)
      feet.colors->SetTypedComponent(number, n,
                                     static_cast<unsigned char>(std::lround(255.0 * color[static_cast<std::size_t>(n)])));
  }

  const vtkSmartPointer<vtkRenderer> renderer_;
  const Tool tool_;
  const double unit_m_;  // of sizes, of the world
  const Similarity map_;
  Feet at_device_, at_proxy_;
  bool is_added_ = false;
  Latest<FeetNow> latest_;
  unsigned given_ = 0;  ///< by the loop [ticks]
};

}  // namespace palpa
