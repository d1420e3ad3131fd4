// Mouse over any renderer as a hand. Header-only, for any VTK of the user.
#pragma once

#include <vtkCallbackCommand.h>
#include <vtkCamera.h>
#include <vtkInteractorStyle.h>
#include <vtkMath.h>
#include <vtkNew.h>
#include <vtkRenderWindowInteractor.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "palpa/device/mouse_hand.h"
#include "palpa/solver/similarity.h"

namespace palpa {

/// Moves a `MouseHand` with the mouse over the picture, by the distance at the camera's focal point, and by 2 mm per notch of
/// the wheel away from the eye, or back. While a button is pressed, the interactor's style rotates the view, and the hand
/// rests; the wheel always moves the hand. Window's thread; allocates at construction only.
class MousePointer {
 public:
  /// [hand m] motion per notch of the wheel. More: a skull takes a few jumps; less: many notches.
  static constexpr double notch_m = 0.002;

  /// \param interactor     with its style set
  /// \param renderer       with the camera
  /// \param pointer        outlives this
  /// \param hand_to_world  hand frame to the renderer's world: `scene.hand_to_world()` if that is the data's
  MousePointer(vtkRenderWindowInteractor* interactor, vtkRenderer* renderer, MouseHand& pointer,
               const Similarity& hand_to_world)
      : interactor_(interactor), renderer_(renderer), pointer_(pointer), map_(hand_to_world) {
    command_->SetClientData(this);
    command_->SetCallback(
        [](vtkObject*, unsigned long event, void* self, void*) { static_cast<MousePointer*>(self)->follow(event); });
    for (const auto event : {vtkCommand::MouseMoveEvent, vtkCommand::LeaveEvent}) interactor->AddObserver(event, command_);
    // Replaces the style's use of the wheel.
    for (const auto event : {vtkCommand::MouseWheelForwardEvent, vtkCommand::MouseWheelBackwardEvent})
      interactor->GetInteractorStyle()->AddObserver(event, command_);
    style_ = vtkInteractorStyle::SafeDownCast(interactor->GetInteractorStyle());
  }
  ~MousePointer() {
    interactor_->RemoveObserver(command_);
    if (style_) style_->RemoveObserver(command_);
  }
  MousePointer(const MousePointer&) = delete;
  MousePointer& operator=(const MousePointer&) = delete;

 private:
  void follow(unsigned long event) {
    if (event == vtkCommand::LeaveEvent) return last_px_.reset();  // the mouse may return anywhere
    vtkCamera& camera = *renderer_->GetActiveCamera();
    std::array<double, 3> up{}, into{};
    camera.GetViewUp(up.data());
    camera.GetDirectionOfProjection(into.data());
    const Vec3 in{into[0], into[1], into[2]}, right = normalized(cross(in, {up[0], up[1], up[2]})), above = cross(right, in);
    Vec3 way_m;  // in the renderer's world
    if (event == vtkCommand::MouseMoveEvent) {
      const std::array<int, 2> at_px{interactor_->GetEventPosition()[0], interactor_->GetEventPosition()[1]};
      const std::array<int, 2> before_px = last_px_.value_or(at_px);
      last_px_ = at_px;
      if (style_ && style_->GetState() != VTKIS_NONE) return;
      const double half_m = camera.GetParallelProjection()
                                ? camera.GetParallelScale()
                                : camera.GetDistance() * std::tan(0.5 * vtkMath::RadiansFromDegrees(camera.GetViewAngle()));
      const double per_px_m = 2.0 * half_m / std::max(renderer_->GetSize()[1], 1);
      way_m = per_px_m * ((at_px[0] - before_px[0]) * right + (at_px[1] - before_px[1]) * above);
    } else {
      way_m = (event == vtkCommand::MouseWheelForwardEvent ? notch_m : -notch_m) * map_.scale * in;
    }
    pointer_.move(map_.direction_to_hand(way_m) / map_.scale);
  }

  vtkSmartPointer<vtkRenderWindowInteractor> interactor_;
  vtkSmartPointer<vtkInteractorStyle> style_;
  vtkSmartPointer<vtkRenderer> renderer_;
  MouseHand& pointer_;
  const Similarity map_;
  std::optional<std::array<int, 2>> last_px_;
  vtkNew<vtkCallbackCommand> command_;
};

}  // namespace palpa
