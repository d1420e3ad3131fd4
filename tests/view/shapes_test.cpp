// Shapes of pictures: edges of boxes.
#include "palpa/view/shapes.h"

#include <gtest/gtest.h>
#include <vtkActor.h>
#include <vtkActorCollection.h>
#include <vtkCellArray.h>
#include <vtkMapper.h>
#include <vtkNew.h>
#include <vtkPolyData.h>
#include <vtkRenderer.h>

#include "palpa/solver/similarity.h"

namespace palpa::detail {
namespace shapes_test {

TEST(Shapes, ABoxHasItsTwelveEdges) {
  const Similarity pose{rotation_about({1, 2, 3}, 40.0), 0.5, {0.1, 0.2, -0.3}};
  std::array<Vec3, 8> corners;
  for (std::size_t n = 0; n < 8; ++n)
    corners[n] = pose.to_world({n & 1 ? 0.04 : 0.01, n & 2 ? 0.05 : 0.02, n & 4 ? 0.09 : 0.03});
  vtkNew<vtkRenderer> renderer;
  constexpr double radius_m = 1e-4;
  draw_box(renderer, corners, {1, 0, 0}, radius_m);
  vtkActorCollection& actors = *renderer->GetActors();  // collected anew by each call
  ASSERT_EQ(actors.GetNumberOfItems(), 1);
  actors.InitTraversal();
  vtkMapper& mapper = *actors.GetNextActor()->GetMapper();
  mapper.Update();
  auto& tubes = *vtkPolyData::SafeDownCast(mapper.GetInput());
  ASSERT_GT(tubes.GetNumberOfPoints(), 0);
  // Each point lies on an edge, up to the radius, and each edge has points at its middle or ends.
  std::array<int, 12> points{};
  for (vtkIdType i = 0; i < tubes.GetNumberOfPoints(); ++i) {
    double p[3];
    tubes.GetPoint(i, p);
    const Vec3 at{p[0], p[1], p[2]};
    std::size_t edge = 0;
    bool is_on_any = false;
    for (std::size_t corner = 0; corner < 8; ++corner) {
      for (const std::size_t axis : {1U, 2U, 4U}) {
        if (corner & axis) continue;
        const Vec3 from = corners[corner], along = corners[corner | axis] - from;
        const double share = dot(at - from, along) / norm_squared(along);
        const bool is_on = share > -0.02 && share < 1.02 && norm(at - from - share * along) < 1.5 * radius_m;
        points[edge++] += is_on;
        is_on_any = is_on_any || is_on;
      }
    }
    EXPECT_TRUE(is_on_any);
  }
  for (const int count : points) EXPECT_GT(count, 0);
}

}  // namespace shapes_test
}  // namespace palpa::detail
