#include "palpa/view/svg_device.h"

#include <vtkBrush.h>
#include <vtkContext2D.h>
#include <vtkContextDevice2D.h>
#include <vtkContextScene.h>
#include <vtkMarkerUtilities.h>
#include <vtkMatrix3x3.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkPen.h>
#include <vtkStdString.h>
#include <vtkTextProperty.h>
#include <vtkTextRenderer.h>
#include <vtkVersion.h>

#if VTK_VERSION_NUMBER < VTK_VERSION_CHECK(9, 3, 0)
#include <vtkUnicodeString.h>
#endif

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "palpa/base/escaped.h"
#include "palpa/base/printed.h"

namespace palpa::detail {

namespace {

/// Collects SVG elements in pixels from the upper left corner. No clipping; images and textures are left out.
class SvgDevice : public vtkContextDevice2D {
 public:
  static SvgDevice* New();
  vtkTypeMacro(SvgDevice, vtkContextDevice2D);

  void set_height(int height_px) { height_px_ = height_px; }
  const std::string& shapes() const { return shapes_; }
  /// Lie over all shapes.
  const std::string& texts() const { return texts_; }

  void DrawPoly(float* points, int n, unsigned char* colors, int components) override;
  void DrawLines(float* points, int n, unsigned char* colors, int components) override;
  void DrawPoints(float* points, int n, unsigned char* colors, int components) override;
  void DrawPointSprites(vtkImageData* sprite, float* points, int n, unsigned char* colors, int components) override;
  void DrawMarkers(int shape, bool highlight, float* points, int n, unsigned char* colors, int components) override;
  void DrawQuad(float* points, int n) override;
  void DrawPolygon(float* points, int n) override;
  void DrawEllipseWedge(float x, float y, float outer_x, float outer_y, float inner_x, float inner_y, float start_deg,
                        float stop_deg) override;
  void DrawEllipticArc(float x, float y, float radius_x, float radius_y, float start_deg, float stop_deg) override;
  void DrawString(float* point, const vtkStdString& string) override;
  void DrawMathTextString(float* point, const vtkStdString& string) override;
  void ComputeStringBounds(const vtkStdString& string, float bounds[4]) override;
  void ComputeJustifiedStringBounds(const char* string, float bounds[4]) override;
#if VTK_VERSION_NUMBER < VTK_VERSION_CHECK(9, 3, 0)  // pure virtual until then
  void DrawString(float* point, const vtkUnicodeString& string) override { DrawString(point, vtkStdString(string.utf8_str())); }
  void ComputeStringBounds(const vtkUnicodeString& string, float bounds[4]) override {
    ComputeStringBounds(vtkStdString(string.utf8_str()), bounds);
  }
#endif
  void SetMatrix(vtkMatrix3x3* matrix) override { matrix_->DeepCopy(matrix); }
  void GetMatrix(vtkMatrix3x3* matrix) override { matrix->DeepCopy(matrix_); }
  void MultiplyMatrix(vtkMatrix3x3* matrix) override;
  void PushMatrix() override;
  void PopMatrix() override;

  // Unused: pen and brush belong to the base.
  void DrawImage(float[2], float, vtkImageData*) override {}
  void DrawImage(const vtkRectf&, vtkImageData*) override {}
  void SetColor4(unsigned char[4]) override {}
  void SetTexture(vtkImageData*, int) override {}
  void SetPointSize(float) override {}
  void SetLineWidth(float) override {}
  void SetLineType(int) override {}
  void SetClipping(int*) override {}
  void EnableClipping(bool) override {}

 protected:
  SvgDevice() = default;
  ~SvgDevice() override = default;

 private:
  struct Place {
    double x_px, y_px;  ///< from the upper left corner
  };
  Place place(float x, float y) const;
  /// "x,y x,y …".
  std::string places(const float* points, int n) const;
  std::string fill() const;
  std::string stroke() const;
  bool has_pen() const;

  int height_px_ = 0;
  vtkNew<vtkMatrix3x3> matrix_;
  std::vector<std::array<double, 9>> matrices_;
  std::string shapes_, texts_;
};

vtkStandardNewMacro(SvgDevice);

std::string hex(const unsigned char color[4]) { return text("#%02x%02x%02x", color[0], color[1], color[2]); }

std::string opacity_of(const char* name, unsigned char share) {
  return share == 255 ? "" : text(" %s=\"%.3g\"", name, share / 255.0);
}

SvgDevice::Place SvgDevice::place(float x, float y) const {
  const double* m = matrix_->GetData();
  return {m[0] * x + m[1] * y + m[2], height_px_ - (m[3] * x + m[4] * y + m[5])};
}

std::string SvgDevice::places(const float* points, int n) const {
  std::string out;
  for (int i = 0; i < n; ++i) {
    const Place at = place(points[2 * i], points[2 * i + 1]);
    out += text(i == 0 ? "%.6g,%.6g" : " %.6g,%.6g", at.x_px, at.y_px);
  }
  return out;
}

bool SvgDevice::has_pen() const { return this->Pen->GetLineType() != vtkPen::NO_PEN && this->Pen->GetOpacity() > 0; }

std::string SvgDevice::fill() const {
  const unsigned char* color = this->Brush->GetColor();
  return color[3] == 0 ? " fill=\"none\"" : " fill=\"" + hex(color) + "\"" + opacity_of("fill-opacity", color[3]);
}

std::string SvgDevice::stroke() const {
  if (!has_pen()) return "";
  const unsigned char* color = this->Pen->GetColor();
  std::string out = " stroke=\"" + hex(color) + "\"" + opacity_of("stroke-opacity", color[3]) +
                    text(" stroke-width=\"%.6g\"", static_cast<double>(this->Pen->GetWidth()));
  switch (this->Pen->GetLineType()) {
    case vtkPen::DASH_LINE: return out + " stroke-dasharray=\"8\"";
    case vtkPen::DOT_LINE: return out + " stroke-dasharray=\"1,7\"";
    case vtkPen::DASH_DOT_LINE: return out + " stroke-dasharray=\"4,6,2,4\"";
    case vtkPen::DASH_DOT_DOT_LINE: return out + " stroke-dasharray=\"4,2,2,2,2,4\"";
    default: return out;
  }
}

void SvgDevice::DrawPoly(float* points, int n, unsigned char*, int) {
  if (has_pen() && n > 1) shapes_ += "<polyline" + stroke() + " points=\"" + places(points, n) + "\"/>\n";
}

void SvgDevice::DrawLines(float* points, int n, unsigned char*, int) {
  for (int i = 0; i + 1 < n; i += 2) DrawPoly(points + 2 * i, 2, nullptr, 0);
}

void SvgDevice::DrawPoints(float* points, int n, unsigned char*, int) {
  DrawMarkers(VTK_MARKER_CIRCLE, false, points, n, nullptr, 0);
}

void SvgDevice::DrawPointSprites(vtkImageData*, float* points, int n, unsigned char* colors, int components) {
  DrawPoints(points, n, colors, components);
}

void SvgDevice::DrawMarkers(int shape, bool, float* points, int n, unsigned char*, int) {
  const unsigned char* color = this->Pen->GetColor();
  const double half = 0.5 * this->Pen->GetWidth();
  const std::string filled = " fill=\"" + hex(color) + "\"" + opacity_of("fill-opacity", color[3]);
  for (int i = 0; i < n; ++i) {
    const auto [x, y] = place(points[2 * i], points[2 * i + 1]);
    const double left = x - half, right = x + half, top = y - half, bottom = y + half;
    switch (shape) {
      case VTK_MARKER_SQUARE:
        shapes_ +=
            text("<rect x=\"%.6g\" y=\"%.6g\" width=\"%.6g\" height=\"%.6g\"", left, top, 2 * half, 2 * half) + filled + "/>\n";
        break;
      case VTK_MARKER_DIAMOND:
        shapes_ += text("<path d=\"M%.6g,%.6gL%.6g,%.6gL%.6g,%.6gL%.6g,%.6gz\"", x, top, right, y, x, bottom, left, y) +
                   filled + "/>\n";
        break;
      case VTK_MARKER_CROSS:
        shapes_ += text("<path d=\"M%.6g,%.6gL%.6g,%.6gM%.6g,%.6gL%.6g,%.6g\" stroke=\"", left, top, right, bottom, left,
                        bottom, right, top) +
                   hex(color) + text("\" stroke-width=\"%.3g\"/>\n", 0.4 * half);
        break;
      case VTK_MARKER_PLUS:
        shapes_ +=
            text("<path d=\"M%.6g,%.6gL%.6g,%.6gM%.6g,%.6gL%.6g,%.6g\" stroke=\"", left, y, right, y, x, top, x, bottom) +
            hex(color) + text("\" stroke-width=\"%.3g\"/>\n", 0.4 * half);
        break;
      case VTK_MARKER_CIRCLE:
        shapes_ += text("<circle cx=\"%.6g\" cy=\"%.6g\" r=\"%.6g\"", x, y, half) + filled + "/>\n";
        break;
      default: break;
    }
  }
}

void SvgDevice::DrawQuad(float* points, int n) {
  for (int i = 0; i + 3 < n; i += 4) DrawPolygon(points + 2 * i, 4);
}

void SvgDevice::DrawPolygon(float* points, int n) {
  if (this->Brush->GetOpacity() > 0) shapes_ += "<polygon" + fill() + " points=\"" + places(points, n) + "\"/>\n";
}

void SvgDevice::DrawEllipseWedge(float x, float y, float outer_x, float outer_y, float, float, float start_deg,
                                 float stop_deg) {
  DrawEllipticArc(x, y, outer_x, outer_y, start_deg, stop_deg);
}

void SvgDevice::DrawEllipticArc(float x, float y, float radius_x, float radius_y, float start_deg, float stop_deg) {
  const auto [x_px, y_px] = place(x, y);
  const double* m = matrix_->GetData();
  const double wide = std::hypot(m[0], m[3]) * radius_x, high = std::hypot(m[1], m[4]) * radius_y;
  if (std::abs(stop_deg - start_deg) >= 360.0F) {
    shapes_ +=
        "<ellipse" + fill() + stroke() + text(" cx=\"%.6g\" cy=\"%.6g\" rx=\"%.6g\" ry=\"%.6g\"/>\n", x_px, y_px, wide, high);
    return;
  }
  constexpr double degree = 3.14159265358979323846 / 180.0;
  const double from = degree * start_deg, to = degree * stop_deg;
  shapes_ += "<path" + fill() + stroke() +
             text(" d=\"M%.6g,%.6gA%.6g,%.6g 0 %d %d %.6g,%.6g\"/>\n", x_px + wide * std::cos(from),
                  y_px - high * std::sin(from), wide, high, std::abs(to - from) > 180.0 * degree ? 1 : 0, to > from ? 0 : 1,
                  x_px + wide * std::cos(to), y_px - high * std::sin(to));
}

void SvgDevice::DrawString(float* point, const vtkStdString& string) {
  vtkTextProperty* look = this->TextProp;
  double color[3];
  look->GetColor(color);
  const int across = look->GetJustification();
  const int up = look->GetVerticalJustification();
  const auto [x, y] = place(point[0], point[1]);
  // Arial's capitals are 0.72 of its size high: half of that centres them on the point.
  texts_ +=
      text("<text transform=\"translate(%.1f,%.1f)%s\" dy=\"%s\" font-size=\"%d\"%s text-anchor=\"%s\" fill=\"#%02x%02x%02x\">",
           x, y, look->GetOrientation() != 0.0 ? " rotate(-90)" : "",
           up == VTK_TEXT_TOP        ? "0.72em"
           : up == VTK_TEXT_CENTERED ? "0.36em"
                                     : "0",
           look->GetFontSize(), look->GetBold() ? " font-weight=\"bold\"" : "",
           across == VTK_TEXT_LEFT    ? "start"
           : across == VTK_TEXT_RIGHT ? "end"
                                      : "middle",
           static_cast<unsigned>(std::lround(255 * color[0])), static_cast<unsigned>(std::lround(255 * color[1])),
           static_cast<unsigned>(std::lround(255 * color[2]))) +
      escaped(string) + "</text>\n";
}

void SvgDevice::DrawMathTextString(float* point, const vtkStdString& string) { DrawString(point, string); }

void SvgDevice::ComputeStringBounds(const vtkStdString& string, float bounds[4]) {
  vtkNew<vtkTextProperty> look;
  look->ShallowCopy(this->TextProp);
  look->SetOrientation(0.0);
  constexpr int dots_per_inch = 72;  // one typographic point is one pixel
  int box[4] = {0, 0, 0, 0};
  vtkTextRenderer::GetInstance()->GetBoundingBox(look, string, box, dots_per_inch);
  bounds[0] = static_cast<float>(box[0]);
  bounds[1] = static_cast<float>(box[2]);
  bounds[2] = static_cast<float>(box[1] - box[0] + 1);
  bounds[3] = static_cast<float>(box[3] - box[2] + 1);
}

void SvgDevice::ComputeJustifiedStringBounds(const char* string, float bounds[4]) {
  ComputeStringBounds(vtkStdString(string), bounds);
}

void SvgDevice::MultiplyMatrix(vtkMatrix3x3* matrix) { vtkMatrix3x3::Multiply3x3(matrix_, matrix, matrix_); }

void SvgDevice::PushMatrix() {
  auto& kept = matrices_.emplace_back();
  std::copy_n(matrix_->GetData(), kept.size(), kept.begin());
}

void SvgDevice::PopMatrix() {
  if (matrices_.empty()) return;
  std::copy_n(matrices_.back().begin(), matrices_.back().size(), matrix_->GetData());
  matrices_.pop_back();
}

}  // namespace

SvgElements svg_elements(vtkContextScene& scene, int height_px) {
  vtkNew<SvgDevice> device;
  device->set_height(height_px);
  vtkNew<vtkContext2D> painter;
  painter->Begin(device);
  scene.Paint(painter);
  painter->End();
  return {device->shapes(), device->texts()};
}

}  // namespace palpa::detail
