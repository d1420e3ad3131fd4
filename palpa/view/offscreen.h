// Drawing with VTK without a screen: a window that needs no X, its picture, and VTK's messages as exceptions.
#pragma once

#include <memory>
#include <string>

#include "palpa/view/picture.h"

class vtkRenderer;
class vtkRenderWindow;

namespace palpa::detail {

/// While an object of this class lives, nothing of VTK reaches stderr: its errors are kept, its warnings dropped. One thread at
/// a time has such objects (others wait), because VTK's messages and rendering belong to the process; a thread may nest
/// several. All code that makes VTK objects does it while it has one.
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

/// Throws LoadError for a picture that is smaller than this, or larger than any that is drawn.
void check_size(int width_px, int height_px, int least_width_px, int least_height_px);

/// A render window that needs no X and no GPU: EGL without a surface. The thread that makes it also uses and destroys it.
class OffscreenWindow {
 public:
  /// Throws LoadError where no OpenGL 3.2 can be had: what is missing and what to install.
  OffscreenWindow(int width_px, int height_px);
  ~OffscreenWindow();
  OffscreenWindow(const OffscreenWindow&) = delete;
  OffscreenWindow& operator=(const OffscreenWindow&) = delete;

  /// To add renderers to (a vtkContextView takes it with SetRenderWindow). Lives as long as this.
  vtkRenderWindow* vtk() const noexcept;
  /// Adds a white renderer. Lives as long as this.
  vtkRenderer* white();
  /// Draws and reads back. Throws LoadError with VTK's first error.
  Picture draw();

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace palpa::detail
