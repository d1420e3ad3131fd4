#include "driver.h"

#include <QVTKOpenGLNativeWidget.h>

#include <QLabel>
#include <QWindow>
#include <cstdlib>
#include <fstream>

#include "display.h"
#include "explorer/surface_finder.h"
#include "tests/shared_data.h"

namespace palpa::explorer {

namespace fs = std::filesystem;

QApplication& application() {
  static int count = 1;
  static char name[] = "palpa-explorer-test";
  static char* names[] = {name, nullptr};
  // The program has its reader beside it, a test does not.
  if (const char* bin = std::getenv("PALPA_BIN")) ::setenv("PALPA_READER", (fs::path(bin) / "palpa-read").c_str(), 0);
  static const std::string problem = start_display();
  if (!problem.empty()) {
    std::fprintf(stderr, "%s\n", problem.c_str());
    std::abort();
  }
  static QApplication* made = [] {
    QSurfaceFormat::setDefaultFormat(QVTKOpenGLNativeWidget::defaultFormat());
    auto* one = new QApplication(count, names);
    QApplication::setOrganizationName("palpa");
    QApplication::setApplicationName("palpa");
    QApplication::setQuitOnLastWindowClosed(false);  // else no dialogue opens after the first test
    return one;
  }();
  return *made;
}

fs::path fresh_folder(const std::string& name) {
  const fs::path folder = fs::temp_directory_path() / ("palpa-" + name + "-" + std::to_string(::getpid()));
  fs::remove_all(folder);
  fs::create_directories(folder);
  return folder;
}

fs::path embedded(const std::string& scene) { return fs::path(PALPA_SCENES) / scene; }

fs::path small_head() {
  std::ifstream in(embedded("head_phantom.toml"));
  std::string text(std::istreambuf_iterator<char>(in), {});
  const std::string key = "sampled = 160";
  const std::size_t at = text.find(key);
  if (at != text.npos) text.replace(at, key.size(), "sampled = 56");
  const fs::path file = fresh_folder("small") / "small_head.toml";
  std::ofstream(file) << text;
  return file;
}

Driver::Driver(WindowOptions options) {
  application();
  if (options.settings_file.empty()) options.settings_file = (fresh_folder("settings") / "palpa.ini").string();
  if (options.data_folders.empty()) options.data_folders = {test::shared_data_folder()};
  window_ = std::make_unique<MainWindow>(options);
  window_->show();
  (void)QTest::qWaitForWindowExposed(window_.get());
  QApplication::setActiveWindow(window_.get());
}

Driver::~Driver() {
  window_->close();
  window_.reset();
}

bool Driver::open(const fs::path& path) {
  bool is_open = false;
  const auto told = QObject::connect(&window_->document(), &Document::opened_another, [&] { is_open = true; });
  window_->open(path);
  const bool opened = wait_for([&] { return is_open; }, 180'000);  // a busy machine takes a minute to sample a beating heart
  QObject::disconnect(told);
  if (!opened) return false;
  return wait_for([&] { return largest_component(view().drawing().bounds_m.size_m()) > 0.0; });
}

bool Driver::run_ticks(std::int64_t ticks) {
  const std::int64_t from = window_->touch().moment().tick;
  return wait_for([&] { return window_->touch().moment().tick >= from + ticks; });
}

bool Driver::is_let_out() {
  return wait_for([&] {
    LiveLoop* const loop = window_->touch().loop();
    if (!loop || window_->touch().moment().tick < 0) return false;
    const GuardState state = loop->latest().frame.command.guard;
    return state == GuardState::pass || state == GuardState::limited || state == GuardState::damped;
  });
}

bool Driver::hand_rests() {
  constexpr std::int64_t ticks = 80;
  Moment before = window_->touch().moment();
  return wait_for([&] {
    const Moment now = window_->touch().moment();
    if (now.tick < before.tick + ticks) return false;
    const bool rests = before.tick >= 0 && distance(now.probe_m, before.probe_m) < 5e-5;
    before = now;
    return rests;
  });
}

bool Driver::wait_for(const std::function<bool()>& holds, int at_most_ms) { return QTest::qWaitFor(holds, at_most_ms); }

void Driver::press(QWidget& on, const QPoint& at, Qt::MouseButton button) { QTest::mousePress(&on, button, {}, at); }

void Driver::move(QWidget& on, const QPoint& from, const QPoint& to, Qt::MouseButton button, int steps) {
  for (int i = 1; i <= steps; ++i) {
    const QPoint at = from + (to - from) * i / steps;
    // QTest's own move does not send the held buttons.
    QMouseEvent event(QEvent::MouseMove, at, on.mapTo(on.window(), at), on.mapToGlobal(at), Qt::NoButton, button, {});
    QApplication::sendEvent(&on, &event);
    QTest::qWait(4);
  }
}

void Driver::release(QWidget& on, const QPoint& at, Qt::MouseButton button) { QTest::mouseRelease(&on, button, {}, at); }

void Driver::drag(QWidget& on, const QPoint& from, const QPoint& to, Qt::MouseButton button) {
  press(on, from, button);
  move(on, from, to, button, 8);
  release(on, to, button);
}

void Driver::wheel(QWidget& on, const QPoint& at, int notches, Qt::MouseButton held) {
  for (int i = 0; i < std::abs(notches); ++i) {
    QWheelEvent event(at, on.mapToGlobal(at), {}, QPoint(0, notches > 0 ? 120 : -120), held, {}, Qt::NoScrollPhase, false);
    QApplication::sendEvent(&on, &event);
    QTest::qWait(2);
  }
}

void Driver::key(Qt::Key key, Qt::KeyboardModifiers modifiers) {
  // Without a window manager no window becomes active when a dialogue closes.
  if (!QApplication::activeWindow()) QApplication::setActiveWindow(window_.get());
  QTest::keyClick(window_.get(), key, modifiers);
}

QImage Driver::look(const std::string& name) {
  QTest::qWait(20);
  const QImage picture = window_->grab().toImage();
  fs::create_directories(PALPA_SCREENSHOTS);
  picture.save(QString::fromStdString(std::string(PALPA_SCREENSHOTS) + "/" + name + ".png"));
  return picture;
}

QString Driver::message() { return window_->findChild<MessageBar*>()->words(); }

double Driver::force_n() { return norm(window_->touch().moment().command_n); }

std::optional<QPoint> Driver::surface_px() {
  const SurfaceFinder finder(window_->document().scene());
  const detail::View& v = view().view();
  for (int ring = 0; ring < 12; ++ring) {
    for (int side = 0; side < std::max(1, 8 * ring); ++side) {
      const double angle = 2.0 * M_PI * side / std::max(1, 8 * ring);
      const QPoint at(static_cast<int>(0.5 * v.width_px + 18.0 * ring * std::cos(angle)),
                      static_cast<int>(0.5 * v.height_px + 18.0 * ring * std::sin(angle)));
      const Vec3 from = v.centre_m + ((at.x() - 0.5 * v.width_px) / v.px_per_m()) * v.right +
                        ((0.5 * v.height_px - at.y()) / v.px_per_m()) * v.up + 1.0 * v.towards;
      if (finder.first(from, -v.towards)) return at;
    }
  }
  return {};
}

}  // namespace palpa::explorer
