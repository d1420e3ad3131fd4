#include "palpa/view/offscreen.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkLogger.h>
#include <vtkNew.h>
#include <vtkObjectFactory.h>
#include <vtkOpenGLState.h>
#include <vtkOutputWindow.h>
#include <vtkRenderer.h>
#include <vtkSmartPointer.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <sstream>
#include <string_view>
#include <utility>
#include <vector>

#include "palpa/base/load_error.h"

namespace palpa::detail {
namespace {

std::recursive_mutex vtk_in_use;

/// Extracts the sentence of `ERROR: In file.cxx, line 12\nvtkClass (0x55…): the sentence\n`, on one line.
std::string sentence_in(std::string text) {
  if (text.starts_with("ERROR: In ") && text.find('\n') != text.npos) text.erase(0, text.find('\n') + 1);
  if (const auto who = text.find(" (0x"), end = text.find("): "); who < end && end != text.npos) text.erase(0, end + 3);
  std::istringstream words(text);
  std::string sentence;
  for (std::string word; words >> word;) sentence += (sentence.empty() ? "" : " ") + word;
  if (sentence.size() > 200) sentence = sentence.substr(0, 200) + "…";
  return sentence.substr(0, sentence.find_last_not_of(".!") + 1);
}

class Messages : public vtkOutputWindow {
 public:
  static Messages* New();
  vtkTypeMacro(Messages, vtkOutputWindow);
  void DisplayText(const char*) override {}
  void DisplayDebugText(const char*) override {}
  void DisplayWarningText(const char*) override {}
  void DisplayGenericWarningText(const char*) override {}
  void DisplayErrorText(const char* text) override {
    const std::lock_guard alone(mutex_);  // surfaces are found on several threads
    if (first.empty()) first = sentence_in(text);
  }

  std::string first;

 private:
  std::mutex mutex_;
};
vtkStandardNewMacro(Messages);

bool has_extension(const char* extensions, std::string_view wanted) {
  std::istringstream words(extensions ? extensions : "");
  for (std::string word; words >> word;) {
    if (word == wanted) return true;
  }
  return false;
}

/// Displays without a screen, best first: Mesa's surfaceless display, then each graphics card.
std::vector<EGLDisplay> screenless_displays() {
  std::vector<EGLDisplay> displays;
  const char* extensions = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  const auto display_of =
      reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(eglGetProcAddress("eglGetPlatformDisplayEXT"));  // NOLINT
  if (!display_of) return displays;
  if (has_extension(extensions, "EGL_MESA_platform_surfaceless")) {
    displays.push_back(display_of(EGL_PLATFORM_SURFACELESS_MESA, reinterpret_cast<void*>(EGL_DEFAULT_DISPLAY), nullptr));
  }
  const auto devices_of = reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(eglGetProcAddress("eglQueryDevicesEXT"));  // NOLINT
  if (has_extension(extensions, "EGL_EXT_platform_device") && devices_of) {
    EGLDeviceEXT devices[16];
    EGLint count = 0;
    if (devices_of(std::size(devices), devices, &count)) {
      for (int i = 0; i < count; ++i) displays.push_back(display_of(EGL_PLATFORM_DEVICE_EXT, devices[i], nullptr));
    }
  }
  std::erase(displays, EGL_NO_DISPLAY);
  return displays;
}

/// OpenGL 3.2 context without a surface, current in this thread; empty on failure. The display stays initialised: EGL shares it
/// within the process.
struct Context {
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLContext context = EGL_NO_CONTEXT;

  Context() {
    // Keeps Mesa's loader from writing to stderr; the failure becomes an exception.
    setenv("EGL_LOG_LEVEL", "fatal", 0);
    constexpr EGLint core_3_2[] = {
        EGL_CONTEXT_MAJOR_VERSION,           3,       EGL_CONTEXT_MINOR_VERSION, 2, EGL_CONTEXT_OPENGL_PROFILE_MASK,
        EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
    for (const EGLDisplay candidate : screenless_displays()) {
      if (!eglInitialize(candidate, nullptr, nullptr) || !eglBindAPI(EGL_OPENGL_API)) continue;
      context = eglCreateContext(candidate, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, core_3_2);
      if (context == EGL_NO_CONTEXT) continue;
      display = candidate;
      if (make_current()) return;
      eglDestroyContext(display, context);
      context = EGL_NO_CONTEXT;
    }
  }
  ~Context() {
    if (context == EGL_NO_CONTEXT) return;
    if (is_current()) eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display, context);
  }
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;

  bool make_current() const { return eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context) == EGL_TRUE; }
  bool is_current() const { return eglGetCurrentContext() == context; }
};

/// Debian's VTK opens X windows only; this is its window for external contexts, with a `Context`.
class Window : public vtkGenericOpenGLRenderWindow {
 public:
  static Window* New();
  vtkTypeMacro(Window, vtkGenericOpenGLRenderWindow);

  const Context* context = nullptr;  ///< outlives this

  void MakeCurrent() override { context->make_current(); }
  bool IsCurrent() override { return context->is_current(); }
  vtkTypeBool IsDirect() override { return 1; }
  int SupportsOpenGL() override { return 1; }

  /// Debian's GLEW is built for X: without X, glewInit() loads every function and then reports an error, which is dropped here.
  /// `Context` has checked OpenGL 3.2.
  void OpenGLInitContext() override {
    QuietVtk quiet;
    vtkGenericOpenGLRenderWindow::OpenGLInitContext();
    quiet.forget_errors();
    Initialized = GlewInitValid = true;
    MaximumHardwareLineWidth = 1.0F;
  }

 protected:
  Window() {
    SetReadyForRendering(true);
    SetOwnContext(0);
    SetShowWindow(false);
    SetFrameBlitModeToNoBlit();
    SetMultiSamples(4);
  }
};
vtkStandardNewMacro(Window);

}  // namespace

struct QuietVtk::State {
  std::lock_guard<std::recursive_mutex> alone{vtk_in_use};
  vtkSmartPointer<vtkOutputWindow> outer = vtkOutputWindow::GetInstance();
  int outer_verbosity = vtkLogger::GetCurrentVerbosityCutoff();
  vtkNew<Messages> messages;
};

QuietVtk::QuietVtk() : state_(std::make_unique<State>()) {
  vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);
  vtkOutputWindow::SetInstance(state_->messages);
}

QuietVtk::~QuietVtk() {
  vtkOutputWindow::SetInstance(state_->outer);
  vtkLogger::SetStderrVerbosity(static_cast<vtkLogger::Verbosity>(state_->outer_verbosity));
}

void QuietVtk::raise_error() {
  if (state_->messages->first.empty()) return;
  const std::string first = std::exchange(state_->messages->first, {});
  throw LoadError("pictures: VTK: " + first + "; this is not expected, please report it with the scene");
}

void QuietVtk::forget_errors() { state_->messages->first.clear(); }

struct OffscreenWindow::Parts {
  QuietVtk quiet;
  Context context;
  vtkNew<Window> window;
};

void check_size(int width_px, int height_px, int least_width_px, int least_height_px) {
  constexpr int most_px = 8000;
  if (width_px >= least_width_px && height_px >= least_height_px && width_px <= most_px && height_px <= most_px) return;
  const auto size = [](int width, int height) { return std::to_string(width) + " x " + std::to_string(height); };
  throw LoadError("pictures: " + size(width_px, height_px) + " pixels cannot be drawn; " +
                  size(least_width_px, least_height_px) + " to " + size(most_px, most_px) + " can");
}

OffscreenWindow::OffscreenWindow(int width_px, int height_px) : parts_(std::make_unique<Parts>()) {
  if (parts_->context.context == EGL_NO_CONTEXT) {
    throw LoadError(
        "pictures: no OpenGL 3.2 without a screen (EGL); install libgl1-mesa-dri and libegl1, or a driver of the graphics card "
        "with EGL");
  }
  parts_->window->context = &parts_->context;
  parts_->window->SetSize(width_px, height_px);
}

OffscreenWindow::~OffscreenWindow() {
  // The window must free its OpenGL objects while the context exists.
  if (parts_->context.context != EGL_NO_CONTEXT) parts_->window->Finalize();
}

vtkRenderWindow* OffscreenWindow::vtk() const noexcept { return parts_->window; }

vtkRenderer* OffscreenWindow::white() {
  vtkNew<vtkRenderer> renderer;
  renderer->SetBackground(1.0, 1.0, 1.0);
  vtk()->AddRenderer(renderer);  // owns it
  return renderer;
}

Picture OffscreenWindow::draw() {
  Window& window = *parts_->window;
  window.OpenGLInit();
  // VTK assumes depth comparison by <=, which it sets only in its own contexts. OpenGL's default is <: of coplanar shapes the
  // first would win, and letters would vanish behind their background.
  constexpr unsigned less_or_equal = 0x0203;  // GL_LEQUAL
  window.GetState()->ResetGLDepthFuncState();
  window.GetState()->vtkglDepthFunc(less_or_equal);
  window.Render();
  const int width = window.GetSize()[0];
  const int height = window.GetSize()[1];
  vtkNew<vtkUnsignedCharArray> bottom_up;
  window.GetPixelData(0, 0, width - 1, height - 1, 0, bottom_up, 0);
  parts_->quiet.raise_error();

  Picture picture{width, height, std::vector<std::uint8_t>(3 * static_cast<std::size_t>(width) * height)};
  const std::size_t row_bytes = 3 * static_cast<std::size_t>(width);
  for (int row = 0; row < height; ++row) {
    std::memcpy(picture.rgb.data() + row * row_bytes,
                bottom_up->GetPointer(static_cast<vtkIdType>((height - 1 - row) * row_bytes)), row_bytes);
  }
  return picture;
}

}  // namespace palpa::detail
