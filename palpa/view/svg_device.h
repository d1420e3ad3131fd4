// What VTK's charts paint, as SVG. VTK's own device writes its numbers through streams, which obey the locale of the program;
// texts in points instead of pixels; and dots of wide pens 0 long.
#pragma once

#include <string>

class vtkContextScene;

namespace palpa::detail {

/// Elements in pixels from the upper left corner; texts lie over all shapes.
struct SvgElements {
  std::string shapes, texts;
};
/// Paints a scene. Clips nothing; images and textures are left out.
SvgElements svg_elements(vtkContextScene& scene, int height_px);

}  // namespace palpa::detail
