// Off-screen rendering with VTK, without X; VTK's messages become exceptions.
#pragma once

#include <memory>
#include <string>

#include "palpa/view/picture.h"

class vtkRenderer;
class vtkRenderWindow;

namespace palpa::detail {

/// During its lifetime VTK writes nothing to stderr: errors are kept, warnings dropped. VTK's messages and rendering are
/// global: objects exist in one thread at a time (others block), which may nest them. All code that creates VTK objects needs
/// an instance.
class QuietVtk {
 public:
  QuietVtk();
  ~QuietVtk();
  QuietVtk(const QuietVtk&) = delete;
  QuietVtk& operator=(const QuietVtk&) = delete;

  /// Throws LoadError `pictures: VTK: …` with the first error since the start or the last call.
  void raise_error();
  void forget_errors();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Throws LoadError for a picture smaller than this, or larger than the maximum.
void check_size(int width_px, int height_px, int least_width_px, int least_height_px);

/// Render window without X and GPU: EGL without a surface. Created, used and destroyed by one thread.
class OffscreenWindow {
 public:
  /// Throws LoadError without OpenGL 3.2, with the missing part and its package.
  OffscreenWindow(int width_px, int height_px);
  ~OffscreenWindow();
  OffscreenWindow(const OffscreenWindow&) = delete;
  OffscreenWindow& operator=(const OffscreenWindow&) = delete;

  /// For adding renderers (to a vtkContextView by SetRenderWindow). Owned by this.
  vtkRenderWindow* vtk() const noexcept;
  /// Adds a white renderer, owned by this.
  vtkRenderer* white();
  /// Renders and reads back. Throws LoadError with VTK's first error.
  Picture draw();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpa::detail
