// The view cut open at a slice.
#include <vtkAbstractMapper.h>
#include <vtkActor.h>
#include <vtkMapper.h>
#include <vtkPlane.h>
#include <vtkVolume.h>
#include <vtkVolumeMapper.h>

#include <algorithm>
#include <cmath>

#include "explorer/view_3d.h"

namespace palpa::explorer {
namespace {

vtkAbstractMapper* mapper_of(vtkProp* prop) {
  if (auto* actor = vtkActor::SafeDownCast(prop)) return actor->GetMapper();
  if (auto* cloud = vtkVolume::SafeDownCast(prop)) return cloud->GetMapper();
  return nullptr;
}

}  // namespace

void View3D::set_cut(bool on) {
  is_cut_ = on;
  const Vec3& axis = *std::ranges::max_element(axes_, {}, [&](const Vec3& one) { return std::abs(dot(one, view_.towards)); });
  cut_away_ = dot(axis, view_.towards) > 0.0 ? -axis : axis;
  cut_->SetNormal(cut_away_.x, cut_away_.y, cut_away_.z);
  move_cut(cross_m_);
  cut_parts();
  redraw();
}

void View3D::move_cut(const Vec3& at_m) {
  cut_m_ = at_m;
  cut_->SetOrigin(at_m.x, at_m.y, at_m.z);
  if (!is_cut_) return;
  move_begins();
  redraw();
}

void View3D::cut_parts() {
  for (const auto* parts : {&drawing_.solid, &drawing_.shells}) {
    for (const Drawing::Part& part : *parts) {
      for (vtkProp* prop : {part.fine.Get(), part.coarse.Get()}) {
        vtkAbstractMapper* const mapper = mapper_of(prop);
        if (!mapper) continue;
        mapper->RemoveAllClippingPlanes();
        if (is_cut_) mapper->AddClippingPlane(cut_);
      }
    }
  }
}

Vec3 View3D::start_behind_cut(const Vec3& from_m) const {
  const double approach = -dot(view_.towards, cut_away_);  // [1] per metre of the ray
  if (!is_cut_ || !(approach > 0.0)) return from_m;
  return from_m - std::max(0.0, dot(cut_m_ - from_m, cut_away_) / approach) * view_.towards;
}

}  // namespace palpa::explorer
