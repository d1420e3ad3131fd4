// palpa-explorer: see and feel one volume in one window. Exit codes as for palpa.
#include <QVTKOpenGLNativeWidget.h>
#include <signal.h>
#include <vtkObject.h>

#include <CLI/CLI.hpp>
#include <QApplication>
#include <QOffscreenSurface>
#include <QOpenGLContext>
#include <QTimer>
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <optional>

#include "explorer/main_window.h"
#include "explorer/opening.h"
#include "explorer/picture_file.h"
#include "palpa/base/load_error.h"
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

/// Saves the window as a picture once nothing is read or drawn, at the latest when asked.
class Screenshot {
 public:
  Screenshot(palpa::explorer::MainWindow& window, const std::string& file) : window_(window), file_(file) {
    timer_.setInterval(interval_ms);
    QObject::connect(&timer_, &QTimer::timeout, [this] {
      still_ = window_.is_busy() ? 0 : still_ + 1;
      if (still_ == enough) save();
    });
    timer_.start();
  }
  void save() {
    if (!timer_.isActive()) return;
    timer_.stop();
    try {
      palpa::explorer::save_picture(window_.grab().toImage(), QString::fromStdString(file_));
    } catch (const palpa::LoadError& error) {
      std::fprintf(stderr, "palpa-explorer: %s\n", palpa::detail::sanitized(error.what()).c_str());
      is_lost_ = true;
    }
  }
  bool is_lost() const { return is_lost_; }

 private:
  // Between jobs, as from reading to drawing, there are pauses. Fewer or shorter: a picture of one; more: later.
  static constexpr int interval_ms = 100, enough = 10;
  palpa::explorer::MainWindow& window_;
  std::string file_;
  QTimer timer_;
  int still_ = 0;
  bool is_lost_ = false;
};

/// The window until it is closed. Returns the exit code.
int run(const palpa::explorer::WindowOptions& options, const std::vector<std::string>& files,
        const std::string& screenshot_file, double quit_after_s) {
  palpa::explorer::MainWindow window(options);
  window.show();
  QStringList paths;
  for (const std::string& file : files) paths << QString::fromStdString(file);
  if (!paths.isEmpty()) window.open_chosen(paths);
  std::optional<Screenshot> screenshot;
  if (!screenshot_file.empty()) screenshot.emplace(window, screenshot_file);
  if (quit_after_s > 0.0) {
    QTimer::singleShot(static_cast<int>(1000.0 * quit_after_s), &window, [&] {
      if (screenshot) screenshot->save();
      window.close();
    });
  }
  const int code = QApplication::exec();
  return screenshot && screenshot->is_lost() ? 2 : code;
}

bool are_traces(const std::vector<std::string>& files) {
  return files.size() == 2 &&
         std::ranges::all_of(files, [](const std::string& file) { return palpa::explorer::is_trace(file); });
}

bool are_data(const std::vector<std::string>& files) {
  return std::ranges::all_of(files, [](const std::string& file) {
    std::error_code ignored;
    return std::filesystem::is_regular_file(file, ignored) && !file.ends_with(".toml");
  });
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App line("See and feel one volume in one window", "palpa explore");
  std::vector<std::string> files;
  palpa::explorer::WindowOptions options;
  std::vector<std::string> data;
  line.add_option(
      "FILE", files,
      "Scene, data file, or trace; two traces: one beside the other; several data files: parts of one grid; none: the "
      "start page");
  line.add_option("--data", data, "Folder with the files of a scene")->allow_extra_args(false);
  line.add_option("--device", options.device, "Haptic device, as of palpa run; without it the mouse is the hand");
  std::string screenshot_file;
  line.add_option("--screenshot", screenshot_file, "Save the window as a new PNG once it is drawn")
      ->check([](const std::string& file) {
        return file.ends_with(".png") ? std::string() : "'" + file + "' is no name of a PNG; end it with .png";
      });
  double quit_after_s = 0.0;
  line.add_option("--quit-after-s", quit_after_s, "Close the window after this time")->check(CLI::Range(0.1, 86400.0));
  line.set_version_flag("--version", palpa::version);
  try {
    line.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return line.exit(error) == 0 ? 0 : 2;
  }
  options.data_folders.assign(data.begin(), data.end());
  if (files.size() > 1 && !are_traces(files) && !are_data(files)) {
    std::fprintf(
        stderr,
        "palpa-explorer: %s: one file at a time, or two traces, or data files that are parts of one grid; a scene names "
        "other data files\n",
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
  return run(options, files, screenshot_file, quit_after_s);
}
