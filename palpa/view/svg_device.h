// SVG from VTK's charts. VTK's own device prints numbers in the program's locale, texts in points instead of pixels, and dots
// of wide pens with length 0.
#pragma once

#include <string>

class vtkContextScene;

namespace palpa::detail {

/// Elements in pixels from the upper left corner; texts lie over all shapes.
struct SvgElements {
  std::string shapes, texts;
};
/// Renders a chart's scene. No clipping; images and textures are left out.
SvgElements svg_elements(vtkContextScene& scene, int height_px);

}  // namespace palpa::detail
