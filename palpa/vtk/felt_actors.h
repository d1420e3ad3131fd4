// Actors of a moment, for any renderer: proxy, probe, spring, primitives. Header-only, for any VTK of the user.
#pragma once

#include <vtkActor.h>
#include <vtkCallbackCommand.h>
#include <vtkConeSource.h>
#include <vtkCylinderSource.h>
#include <vtkMatrix4x4.h>
#include <vtkNew.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkSphereSource.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "palpa/device/latest.h"
#include "palpa/loop/loop.h"
#include "palpa/session/session.h"
#include "palpa/solver/similarity.h"

namespace palpa {

namespace detail {

/// Red, green, blue [1].
using FeltColor = std::array<double, 3>;
inline constexpr FeltColor probe_color{0.45, 0.45, 0.48}, proxy_color{0.08, 0.08, 0.10}, spring_color{0.35, 0.35, 0.38};
/// Color of mode index `mode`: Okabe and Ito's colour-blind-safe set.
inline FeltColor felt_color(std::size_t mode) {
  constexpr unsigned bytes[] = {0x0072b2, 0xd55e00, 0x009e73, 0xcc79a7, 0xe69f00, 0x56b4e9};
  const unsigned color = bytes[mode % std::size(bytes)];
  return {(color >> 16) / 255.0, (color >> 8 & 255U) / 255.0, (color & 255U) / 255.0};
}

}  // namespace detail

/// Actors of a moment: a plane as a disc with its normal, a line as a rod, a point as a ball, a directed force as an arrow, in
/// the colour of its mode; proxy, probe, and the spring between them.
///
/// Two threads: the loop of a live session publishes its latest state (`observer`: no lock, no allocation), and the window's
/// thread reads it for drawing. Neither blocks.
class FeltActors {
 public:
  /// [1] Primitives drawn. More: they hide each other.
  static constexpr std::size_t most_primitives = 24;

  /// \param renderer       draws the actors from the first `show` on
  /// \param view_half_height_hand_m         [hand m] unit of sizes: half the height of the picture
  /// \param hand_to_world  hand frame to the renderer's world: `scene.hand_to_world()` if that is the data's
  FeltActors(vtkRenderer* renderer, double view_half_height_hand_m, const Similarity& hand_to_world = {})
      : renderer_(renderer), view_half_height_hand_m_(view_half_height_hand_m), map_(hand_to_world) {
    // Unit shapes along y, from the origin: actors scale and rotate them.
    vtkNew<vtkSphereSource> ball;
    ball->SetRadius(1.0);
    ball->SetThetaResolution(sides);
    ball->SetPhiResolution(sides / 2);
    vtkNew<vtkCylinderSource> rod;
    rod->SetRadius(1.0);
    rod->SetHeight(1.0);
    rod->SetCenter(0.0, 0.5, 0.0);
    rod->SetResolution(2 * sides);
    vtkNew<vtkConeSource> tip;
    tip->SetDirection(0.0, 1.0, 0.0);
    tip->SetCenter(0.0, 0.5, 0.0);
    tip->SetHeight(1.0);
    tip->SetRadius(1.0);
    tip->SetResolution(sides);
    vtkAlgorithmOutput* const shapes[] = {ball->GetOutputPort(), rod->GetOutputPort(), tip->GetOutputPort()};
    for (std::size_t n = 0; n < 3; ++n) {
      pools_[n].mapper->SetInputConnection(shapes[n]);
      pools_[n].mapper->ScalarVisibilityOff();
    }
  }
  ~FeltActors() {
    if (followed_) followed_->RemoveObserver(command_);
  }
  FeltActors(const FeltActors&) = delete;
  FeltActors& operator=(const FeltActors&) = delete;

  // ---- called by the window's thread ----

  /// Removes the actors from the renderer; the destructor does not.
  void remove() {
    for (Pool& pool : pools_) {
      for (const auto& actor : pool.actors) renderer_->RemoveActor(actor);
      pool.actors.clear();
    }
  }
  /// Shows the loop's latest state. True: it was new, so render.
  bool update() {
    if (!latest_.is_fresh()) return false;
    const Snapshot& now = latest_.take();
    show(now.probe_m, now.proxy_m, {now.primitives.data(), now.count});
    return true;
  }
  /// Shows the loop's latest state in the interactor's window from now on, about 60 times a second; slow rendering takes at
  /// most half of the time, so that the mouse stays responsive.
  /// \param interactor  initialised
  void follow(vtkRenderWindowInteractor* interactor) {
    constexpr unsigned long period_ms = 16;
    command_->SetClientData(this);
    command_->SetCallback([](vtkObject*, unsigned long, void* self, void*) { static_cast<FeltActors*>(self)->draw_if_due(); });
    followed_ = interactor;
    interactor->AddObserver(vtkCommand::TimerEvent, command_);
    interactor->CreateRepeatingTimer(period_ms);
  }
  /// Shows a moment, hand frame.
  void show(const Vec3& probe_m, const Vec3& proxy_m, std::span<const PlacedPrimitive> primitives) {
    for (Pool& pool : pools_) pool.used = 0;
    double most_n = least_n;
    for (const PlacedPrimitive& placed : primitives) most_n = std::max(most_n, norm(placed.force_n));
    for (const PlacedPrimitive& placed : primitives) draw(placed, proxy_m, norm(placed.force_n) / most_n);
    rod(proxy_m, probe_m, 0.007 * view_half_height_hand_m_, detail::spring_color);
    ball(proxy_m, 0.02 * view_half_height_hand_m_, detail::proxy_color);
    ball(probe_m, 0.02 * view_half_height_hand_m_, detail::probe_color);
    for (Pool& pool : pools_) {
      for (std::size_t n = pool.used; n < pool.actors.size(); ++n) pool.actors[n]->VisibilityOff();
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
    Snapshot now{.probe_m = frame.result.probe_m, .proxy_m = frame.result.proxy_m};
    if (!session.sub_steps().empty()) {
      const SubStep& last = session.sub_steps().back();
      now.count = std::min<std::size_t>(static_cast<std::size_t>(last.primitives), most_primitives);
      std::copy_n(session.primitives().begin() + last.first_primitive, now.count, now.primitives.begin());
    }
    latest_.give(now);
  }

 private:
  static constexpr int sides = 32;         // of round shapes. More: slower; fewer: visible corners
  static constexpr double least_n = 1e-3;  // below: drawn as without force

  /// Actors of a shape, as many as were ever shown at once.
  struct Pool {
    vtkNew<vtkPolyDataMapper> mapper;
    std::vector<vtkSmartPointer<vtkActor>> actors;
    std::size_t used = 0;
  };
  struct Snapshot {
    Vec3 probe_m, proxy_m;
    std::array<PlacedPrimitive, most_primitives> primitives{};
    std::size_t count = 0;
  };

  void draw_if_due() {
    const auto begin = std::chrono::steady_clock::now();
    if (begin < rests_until_ || !update()) return;
    followed_->Render();
    const auto end = std::chrono::steady_clock::now();
    rests_until_ = end + (end - begin);
  }
  void draw(const PlacedPrimitive& placed, const Vec3& proxy_m, double share) {
    const Primitive& primitive = placed.primitive;
    const detail::FeltColor color = detail::felt_color(primitive.id.mode);
    const Vec3 &at = primitive.position_m, &q = primitive.direction;
    switch (primitive.kind) {
      case PrimitiveKind::plane:
      case PrimitiveKind::corner:
        rod(at - 0.002 * view_half_height_hand_m_ * q, at + 0.002 * view_half_height_hand_m_ * q,
            0.2 * view_half_height_hand_m_, color, norm(placed.force_n) < least_n ? 0.2 : 0.45);
        arrow(at, at + (0.1 + 0.2 * share) * view_half_height_hand_m_ * q, 0.009 * view_half_height_hand_m_, color);
        break;
      case PrimitiveKind::line:
        rod(at - 0.3 * view_half_height_hand_m_ * q, at + 0.3 * view_half_height_hand_m_ * q, 0.008 * view_half_height_hand_m_,
            color);
        break;
      case PrimitiveKind::point: ball(at, 0.03 * view_half_height_hand_m_, color); break;
      case PrimitiveKind::directed:
        arrow(proxy_m + placed.lever_m,
              proxy_m + placed.lever_m + (0.1 + 0.25 * share) * view_half_height_hand_m_ * normalized(q),
              0.012 * view_half_height_hand_m_, color);
        break;
    }
  }
  void ball(const Vec3& at_m, double radius_m, const detail::FeltColor& color) {
    put(pools_[0], at_m, {0, radius_m, 0}, radius_m, color, 1.0);
  }
  void rod(const Vec3& from_m, const Vec3& to_m, double radius_m, const detail::FeltColor& color, double opacity = 1.0) {
    if (distance(from_m, to_m) > 0.0) put(pools_[1], from_m, to_m - from_m, radius_m, color, opacity);
  }
  void arrow(const Vec3& from_m, const Vec3& to_m, double radius_m, const detail::FeltColor& color) {
    const Vec3 along = normalized(to_m - from_m);
    const double head_m = std::min(5.0 * radius_m, 0.6 * distance(from_m, to_m));
    if (!(head_m > 0.0)) return;
    rod(from_m, to_m - 0.9 * head_m * along, radius_m, color);
    put(pools_[2], to_m - head_m * along, head_m * along, 2.2 * radius_m, color, 1.0);
  }

  /// Shows an actor of a shape: y axis along `way_m` with its length, thickness `radius_m`.
  void put(Pool& pool, const Vec3& from_m, const Vec3& way_m, double radius_m, const detail::FeltColor& color, double opacity) {
    if (pool.used == pool.actors.size()) {
      const auto made = vtkSmartPointer<vtkActor>::New();
      made->SetMapper(pool.mapper);
      made->PickableOff();
      made->SetUserMatrix(vtkNew<vtkMatrix4x4>());
      made->GetProperty()->SetAmbient(0.25);
      made->GetProperty()->SetDiffuse(0.75);
      renderer_->AddActor(made);
      pool.actors.push_back(made);
    }
    vtkActor& actor = *pool.actors[pool.used++];
    const Vec3 y = map_.scale * map_.turned_to_world(way_m), start = map_.to_world(from_m), along = normalized(y);
    const Vec3 other = std::abs(along.x) < 0.7 ? Vec3{1, 0, 0} : Vec3{0, 0, 1};
    const Vec3 x = map_.scale * radius_m * normalized(cross(along, other)), z = cross(x, along);
    vtkMatrix4x4& matrix = *actor.GetUserMatrix();
    const double rows[3][4] = {{x.x, y.x, z.x, start.x}, {x.y, y.y, z.y, start.y}, {x.z, y.z, z.z, start.z}};
    for (int r = 0; r < 3; ++r) {
      for (int c = 0; c < 4; ++c) matrix.SetElement(r, c, rows[r][c]);
    }
    actor.GetProperty()->SetColor(color[0], color[1], color[2]);
    actor.GetProperty()->SetOpacity(opacity);
    actor.VisibilityOn();
  }

  const vtkSmartPointer<vtkRenderer> renderer_;
  vtkNew<vtkCallbackCommand> command_;
  vtkSmartPointer<vtkRenderWindowInteractor> followed_;
  std::chrono::steady_clock::time_point rests_until_;
  const double view_half_height_hand_m_;
  const Similarity map_;
  std::array<Pool, 3> pools_;  ///< balls, rods, tips
  Latest<Snapshot> latest_;
  unsigned given_ = 0;  ///< by the loop [ticks]
};

}  // namespace palpa
