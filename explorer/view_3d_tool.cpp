// The tool in the hand, turned in the view.
#include <cmath>

#include "explorer/view_3d.h"

namespace palpa::explorer {

// As if the near side of the tool went with the cursor.
void View3D::turn_tool(const QPointF& way_px) {
  constexpr double rad_per_px = degrees_per_px * M_PI / 180.0;
  Q_EMIT tool_turned(rad_per_px * (way_px.x() * view_.up + way_px.y() * view_.right));
}

void View3D::roll_tool(double notches) {
  constexpr double rad_per_notch = 0.1;
  Q_EMIT tool_turned(rad_per_notch * notches * view_.towards);
}

}  // namespace palpa::explorer
