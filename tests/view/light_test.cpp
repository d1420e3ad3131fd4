// Computed light at a point against VTK's drawing.
#include <gtest/gtest.h>
#include <vtkActor.h>
#include <vtkCamera.h>
#include <vtkFloatArray.h>
#include <vtkNew.h>
#include <vtkPlaneSource.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "palpa/view/offscreen.h"
#include "palpa/view/shapes.h"

namespace palpa::detail {
namespace light_test {

/// Red, green and blue [0…255] of a patch with this normal as VTK draws it.
std::array<int, 3> drawn(const Vec3& normal, double shininess) {
  QuietVtk quiet;
  vtkNew<vtkPlaneSource> plane;
  plane->SetOrigin(-2, -2, 0);
  plane->SetPoint1(2, -2, 0);
  plane->SetPoint2(-2, 2, 0);
  plane->Update();
  vtkNew<vtkFloatArray> normals;
  normals->SetNumberOfComponents(3);
  for (vtkIdType i = 0; i < plane->GetOutput()->GetNumberOfPoints(); ++i)
    normals->InsertNextTuple3(normal.x, normal.y, normal.z);
  plane->GetOutput()->GetPointData()->SetNormals(normals);
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(plane->GetOutput());
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  actor->GetProperty()->SetColor(0.8, 0.5, 0.2);
  actor->GetProperty()->SetAmbient(0.25);
  actor->GetProperty()->SetDiffuse(0.5);
  actor->GetProperty()->SetSpecular(0.3);
  actor->GetProperty()->SetSpecularPower(shininess);
  vtkNew<vtkRenderer> renderer;
  add_light(renderer);
  renderer->AddActor(actor);
  OffscreenWindow window(8, 8);
  window.vtk()->AddRenderer(renderer);
  vtkCamera& camera = *renderer->GetActiveCamera();
  camera.SetParallelProjection(true);
  camera.SetPosition(0, 0, 100);  // VTK uses the eye's position for specular light, in a parallel projection too
  camera.SetFocalPoint(0, 0, 0);
  camera.SetParallelScale(1.0);
  camera.SetClippingRange(1, 200);
  const Picture picture = window.draw();
  const std::size_t middle = 3 * (4 * static_cast<std::size_t>(picture.width_px) + 4);
  return {picture.rgb[middle], picture.rgb[middle + 1], picture.rgb[middle + 2]};
}

TEST(LightOnAPoint, IsWhatVtkDrawsThere) {
  const double own[3] = {0.8, 0.5, 0.2};
  for (const double shininess : {5.0, 30.0}) {
    // From all sides, highlights included: between the viewer and a lamp.
    for (const Vec3& way : {Vec3{0, 0, 1}, Vec3{-0.2, 0.28, 1}, Vec3{-0.6, 0.7, 0.4}, Vec3{0.35, -0.13, 1}, Vec3{0.9, 0.3, 0.2},
                            Vec3{-0.1, -0.9, 0.3}, Vec3{1, 0, 0.05}}) {
      const Vec3 normal = normalized(way);
      const Light light = light_on(normal, shininess), behind = light_on(-normal, shininess);
      EXPECT_EQ(light.diffuse, behind.diffuse);
      EXPECT_EQ(light.specular, behind.specular);
      const std::array<int, 3> color = drawn(normal, shininess);
      for (std::size_t c = 0; c < 3; ++c) {
        const double expected = std::min(255.0, 255.0 * (0.25 + 0.5 * light.diffuse + 0.3 * light.specular) * own[c]);
        EXPECT_NEAR(color[c], expected, 1.5) << "normal " << normal.x << " " << normal.y << " " << normal.z << ", colour " << c;
      }
    }
  }
}

}  // namespace light_test
}  // namespace palpa::detail
