// What VTK's charts paint, as SVG. VTK's own device writes its numbers through streams, which obey the locale of the program;
// texts in points instead of pixels; and dots of wide pens 0 long.
#pragma once

#include <vtkContextDevice2D.h>
#include <vtkMatrix3x3.h>
#include <vtkNew.h>

#include <array>
#include <string>
#include <vector>

namespace palpa::detail {

/// Gathers elements in pixels from the upper left corner. Clips nothing; images and textures are left out.
class SvgDevice : public vtkContextDevice2D {
 public:
  static SvgDevice* New();
  vtkTypeMacro(SvgDevice, vtkContextDevice2D);

  void set_height(int height_px) { height_px_ = height_px; }
  const std::string& shapes() const { return shapes_; }
  /// They lie over all shapes.
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
  void DrawString(float* point, const vtkUnicodeString& string) override;
  void DrawMathTextString(float* point, const vtkStdString& string) override;
  void ComputeStringBounds(const vtkStdString& string, float bounds[4]) override;
  void ComputeStringBounds(const vtkUnicodeString& string, float bounds[4]) override;
  void ComputeJustifiedStringBounds(const char* string, float bounds[4]) override;
  void SetMatrix(vtkMatrix3x3* matrix) override { matrix_->DeepCopy(matrix); }
  void GetMatrix(vtkMatrix3x3* matrix) override { matrix->DeepCopy(matrix_); }
  void MultiplyMatrix(vtkMatrix3x3* matrix) override;
  void PushMatrix() override;
  void PopMatrix() override;

  // Nothing here depends on these: pen and brush are those of the base.
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

}  // namespace palpa::detail
