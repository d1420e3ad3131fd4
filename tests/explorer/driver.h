// Driver of the window: mouse, keys, and the shown content.
#pragma once

#include <QApplication>
#include <QTest>
#include <QWheelEvent>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>

#include "explorer/main_window.h"

namespace palpa::explorer {

/// The application of this process, on a display of its own. Without Xvfb the test fails.
QApplication& application();

/// Output folder of tests, empty at first.
std::filesystem::path fresh_folder(const std::string& name);
std::filesystem::path embedded(const std::string& scene);
/// The embedded head with few samples, which opens at once: for tests of the window, not of the picture.
std::filesystem::path small_head();

class Driver {
 public:
  explicit Driver(WindowOptions options = {});
  ~Driver();

  MainWindow& window() { return *window_; }
  View3D& view() { return *window_->view(); }
  /// Opens it and waits until it is drawn and the loop runs; false after the limit.
  bool open(const std::filesystem::path& path);
  /// Runs the window until `holds`; false after the limit.
  static bool wait_for(const std::function<bool()>& holds, int at_most_ms = 20'000);
  static void live(int ms) { QTest::qWait(ms); }
  /// Waits until everything is read and drawn finely; false after the limit.
  bool is_done() {
    return wait_for([this] { return !window_->is_busy(); }, 120'000);
  }
  /// Waits until the session has run for so many ticks more; false after the limit.
  bool run_ticks(std::int64_t ticks);
  /// Waits until the guard lets the force out: no ramp, no fall; false after the limit.
  bool is_let_out();
  /// Waits until the hand has come to rest at its target, or at what resists; false after the limit.
  bool hand_rests();

  // ---- input ----
  void press(QWidget& on, const QPoint& at, Qt::MouseButton button = Qt::LeftButton);
  void move(QWidget& on, const QPoint& from, const QPoint& to, Qt::MouseButton button = Qt::LeftButton, int steps = 20);
  void release(QWidget& on, const QPoint& at, Qt::MouseButton button = Qt::LeftButton);
  void drag(QWidget& on, const QPoint& from, const QPoint& to, Qt::MouseButton button = Qt::LeftButton);
  void wheel(QWidget& on, const QPoint& at, int notches, Qt::MouseButton held = Qt::NoButton);
  void key(Qt::Key key, Qt::KeyboardModifiers modifiers = Qt::NoModifier);

  // ---- output ----
  // Keeps a picture of the whole window.
  QImage look(const std::string& name);
  QString message();
  double force_n();
  /// A point of the view on a surface, nearest to the view's middle; none without a surface.
  std::optional<QPoint> surface_px();

 private:
  std::unique_ptr<MainWindow> window_;
};

}  // namespace palpa::explorer
