// palpa-explorer: see and feel one volume in one window. Exit codes as for palpa.
#include <QVTKOpenGLNativeWidget.h>
#include <signal.h>
#include <vtkObject.h>

#include <CLI/CLI.hpp>
#include <QApplication>
#include <QOffscreenSurface>
#include <QOpenGLContext>
#include <cstdio>
#include <cstdlib>

#include "explorer/main_window.h"
#include "palpa/base/sanitized.h"
#include "palpa/version.h"

namespace {

bool has_display() {
  for (const char* name : {"DISPLAY", "WAYLAND_DISPLAY", "QT_QPA_PLATFORM"})
    if (const char* value = std::getenv(name); value && *value) return true;
  return false;
}

bool has_opengl() {
  QOpenGLContext context;
  if (!context.create()) return false;
  QOffscreenSurface surface;
  surface.setFormat(context.format());
  surface.create();
  return context.makeCurrent(&surface) && context.format().version() >= qMakePair(3, 2);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App line("See and feel one volume in one window", "palpa explore");
  std::vector<std::string> files;
  palpa::explorer::WindowOptions options;
  std::vector<std::string> data;
  line.add_option("FILE", files, "Scene, data file, or trace; two traces: one beside the other; none: the start page");
  line.add_option("--data", data, "Folder with the files of a scene")->allow_extra_args(false);
  line.add_option("--device", options.device, "Haptic device, as of palpa run; without it the mouse is the hand");
  line.set_version_flag("--version", palpa::version);
  try {
    line.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return line.exit(error) == 0 ? 0 : 2;
  }
  options.data_folders.assign(data.begin(), data.end());
  const auto is_trace = [](const std::string& file) {
    return std::filesystem::exists(std::filesystem::path(file) / "trace.toml");
  };
  if (files.size() > 2 || (files.size() == 2 && !(is_trace(files[0]) && is_trace(files[1])))) {
    std::fprintf(stderr, "palpa-explorer: %s: one file at a time, or two traces; a scene names several data files\n",
                 palpa::detail::sanitized(files[1]).c_str());
    return 2;
  }
  if (!has_display()) {
    std::fputs(
        "palpa-explorer: display: there is no display to open a window on (DISPLAY is not set); on a machine without one palpa "
        "run "
        "feels and palpa report shows, over the network ssh -X brings it\n",
        stderr);
    return 2;
  }
  // A file at its size limit becomes a write error, like a full disk.
  ::signal(SIGXFSZ, SIG_IGN);
  QSurfaceFormat::setDefaultFormat(QVTKOpenGLNativeWidget::defaultFormat());
  vtkObject::GlobalWarningDisplayOff();
  QCoreApplication::setAttribute(Qt::AA_EnableHighDpiScaling);
  QCoreApplication::setAttribute(Qt::AA_UseHighDpiPixmaps);
  QApplication application(argc, argv);
  QApplication::setApplicationName("palpa");
  QApplication::setOrganizationName("palpa");
  QApplication::setApplicationDisplayName("Palpa");
  QApplication::setDesktopFileName("palpa-explorer");
  options.has_opengl = has_opengl();
  if (!options.has_opengl)
    std::fputs("palpa-explorer: no OpenGL 3.2: slices only. On Debian the package libgl1-mesa-dri brings it.\n", stderr);
  palpa::explorer::MainWindow window(options);
  window.show();
  if (!files.empty()) window.open(files.front(), files.size() == 2 ? files[1] : std::string());
  return QApplication::exec();
}
