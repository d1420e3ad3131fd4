#include "palpa/view/shapes.h"

#include <vtkActor.h>
#include <vtkArrowSource.h>
#include <vtkCellArray.h>
#include <vtkDoubleArray.h>
#include <vtkGlyph3D.h>
#include <vtkLight.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <vtkTubeFilter.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <cmath>

namespace palpa::detail {
namespace {

unsigned char byte(double share) { return static_cast<unsigned char>(std::lround(255.0 * share)); }

struct Lamp {
  Vec3 from;
  double strength;
};
// Main lamp above the viewer's left, a weak one to the right for relief. The strengths add up to 1: a patch that faces the
// viewer has its own colour.
constexpr Lamp lamps[] = {{{-0.5, 0.7, 1.0}, 0.7}, {{0.8, -0.3, 0.7}, 0.3}};

}  // namespace

void add_light(vtkRenderer* renderer) {
  renderer->AutomaticLightCreationOff();
  for (const Lamp& lamp : lamps) {
    vtkNew<vtkLight> source;
    source->SetLightTypeToCameraLight();
    source->SetPosition(lamp.from.x, lamp.from.y, lamp.from.z);
    source->SetFocalPoint(0, 0, 0);
    source->SetIntensity(lamp.strength / normalized(lamp.from).z);
    renderer->AddLight(source);
  }
}

Light light_on(const Vec3& normal, double shininess) noexcept {
  const Vec3 seen = normal.z < 0.0 ? -normal : normal;
  Light light;
  for (const Lamp& lamp : lamps) {
    const Vec3 from = normalized(lamp.from);
    const double facing = dot(seen, from);
    if (facing <= 0.0) continue;
    const double strength = lamp.strength / from.z;
    light.diffuse += strength * facing;
    light.specular += strength * std::pow(std::max(0.0, 2.0 * facing * seen.z - from.z), shininess);
  }
  return light;
}

void draw_tubes(vtkRenderer* renderer, std::span<const std::vector<TubePoint>> lines, double radius_m, double shine) {
  vtkNew<vtkPoints> points;
  points->SetDataTypeToDouble();
  vtkNew<vtkCellArray> cells;
  vtkNew<vtkUnsignedCharArray> colors;
  colors->SetNumberOfComponents(3);
  colors->SetName("color");
  for (const std::vector<TubePoint>& line : lines) {
    if (line.size() < 2) continue;
    cells->InsertNextCell(static_cast<int>(line.size()));
    for (const TubePoint& point : line) {
      cells->InsertCellPoint(points->InsertNextPoint(point.position_m.x, point.position_m.y, point.position_m.z));
      colors->InsertNextTuple3(byte(point.color.red), byte(point.color.green), byte(point.color.blue));
    }
  }
  if (points->GetNumberOfPoints() == 0) return;
  vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  data->SetLines(cells);
  data->GetPointData()->SetScalars(colors);
  vtkNew<vtkTubeFilter> tubes;
  tubes->SetInputData(data);
  tubes->SetRadius(radius_m);
  tubes->SetNumberOfSides(10);
  tubes->CappingOn();
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputConnection(tubes->GetOutputPort());
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  actor->GetProperty()->SetAmbient(shine);
  actor->GetProperty()->SetDiffuse(1.0 - shine);
  renderer->AddActor(actor);
}

void draw_arrows(vtkRenderer* renderer, std::span<const Arrow> arrows) {
  vtkNew<vtkPoints> points;
  vtkNew<vtkDoubleArray> vectors;
  vectors->SetNumberOfComponents(3);
  vtkNew<vtkUnsignedCharArray> colors;
  colors->SetNumberOfComponents(3);
  for (const Arrow& arrow : arrows) {
    const Vec3 along = arrow.to_m - arrow.from_m;
    points->InsertNextPoint(arrow.from_m.x, arrow.from_m.y, arrow.from_m.z);
    vectors->InsertNextTuple3(along.x, along.y, along.z);
    colors->InsertNextTuple3(byte(arrow.color.red), byte(arrow.color.green), byte(arrow.color.blue));
  }
  vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  data->GetPointData()->SetScalars(colors);
  data->GetPointData()->SetVectors(vectors);
  vtkNew<vtkArrowSource> shape;
  shape->SetShaftResolution(8);
  shape->SetTipResolution(12);
  vtkNew<vtkGlyph3D> glyphs;
  glyphs->SetInputData(data);
  glyphs->SetSourceConnection(shape->GetOutputPort());
  glyphs->SetScaleModeToScaleByVector();
  glyphs->SetColorModeToColorByScalar();
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputConnection(glyphs->GetOutputPort());
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  actor->GetProperty()->SetAmbient(0.4);
  actor->GetProperty()->SetDiffuse(0.6);
  renderer->AddActor(actor);
}

}  // namespace palpa::detail
