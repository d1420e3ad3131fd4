// Random events: no crash, no force beyond its limit, no memory growth.
#include <gtest/gtest.h>
#include <unistd.h>

#include <QDialog>
#include <QDockWidget>
#include <QElapsedTimer>
#include <QPointer>
#include <QSlider>
#include <algorithm>
#include <cstdlib>
#include <deque>
#include <fstream>
#include <random>

#include "driver.h"

namespace palpa::explorer {
namespace monkey_test {

double resident_mib() {
  std::ifstream file("/proc/self/statm");
  double pages = 0.0;
  file >> pages >> pages;
  return pages * static_cast<double>(::sysconf(_SC_PAGESIZE)) / 1048576.0;
}

TEST(ExplorerMonkey, FindsNothingThatBreaks) {
  const char* asked = std::getenv("PALPA_MONKEY_S");
  const double duration_s = asked ? std::atof(asked) : 15.0;
  const char* seed = std::getenv("PALPA_MONKEY_SEED");
  std::mt19937 random(seed ? static_cast<unsigned>(std::atoi(seed)) : 1U);
  const auto below = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(std::max(1, n))); };
  Driver driver;
  ASSERT_TRUE(driver.open(embedded("head_phantom.toml")));
  QElapsedTimer timer;
  timer.start();
  double most_n = 0.0, early_mib = 0.0, last_print_s = 0.0;
  // The loop takes a changed scene when it is ready; until then the old limit holds as well.
  constexpr double change_s = 3.0;
  struct Limit {
    double since_s, most_n;
  };
  std::deque<Limit> limits;
  std::int64_t events = 0;
  static constexpr const char* scenes[] = {"head_phantom.toml", "flow_phantom.toml", "wing_phantom.toml"};
  const auto elapsed_s = [&] { return 1e-3 * static_cast<double>(timer.elapsed()); };
  // Keys that open a desktop dialogue or end the program are left out: they need a person.
  static constexpr Qt::Key keys[] = {
      Qt::Key_1,      Qt::Key_2,      Qt::Key_3,      Qt::Key_Home,   Qt::Key_M,  Qt::Key_S,    Qt::Key_Space, Qt::Key_P,
      Qt::Key_N,      Qt::Key_B,      Qt::Key_Left,   Qt::Key_Right,  Qt::Key_Up, Qt::Key_Plus, Qt::Key_Minus, Qt::Key_Tab,
      Qt::Key_Escape, Qt::Key_Return, Qt::Key_Delete, Qt::Key_PageUp, Qt::Key_F1, Qt::Key_I};
  while (elapsed_s() < duration_s) {
    ++events;
    std::vector<QWidget*> widgets;
    for (QWidget* widget : driver.window().findChildren<QWidget*>())
      if (widget->isVisible() && widget->isEnabled() && widget->width() > 2 && !widget->inherits("QMenu") &&
          !widget->inherits("QMenuBar"))
        widgets.push_back(widget);
    QWidget* widget = below(3) == 0 ? static_cast<QWidget*>(&driver.view())
                                    : widgets[static_cast<std::size_t>(below(static_cast<int>(widgets.size())))];
    const bool leaves_the_window =
        widget->objectName() == "open_file" ||
        (widget->inherits("QToolButton") && widget->parentWidget() && widget->parentWidget()->inherits("QToolBar")) ||
        widget->objectName() == "add_mode";
    const QPoint at(below(widget->width()), below(widget->height()));
    switch (below(9)) {
      case 0:
      case 1:
      case 2:
        if (leaves_the_window || !widget->isVisible()) break;
        {
          const Qt::MouseButton button =
              std::array{Qt::LeftButton, Qt::RightButton, Qt::MiddleButton}[static_cast<std::size_t>(below(3))];
          driver.press(*widget, at, button);
          QPointer<QWidget> alive(widget);
          for (int i = 0; i < below(6) && alive; ++i)
            driver.move(*widget, at, {below(widget->width()), below(widget->height())}, button, 2);
          if (alive) driver.release(*widget, at, button);
        }
        break;
      case 3:
        if (!leaves_the_window) QTest::mouseClick(widget, Qt::LeftButton, {}, at);
        break;
      case 4: driver.wheel(*widget, at, below(9) - 4); break;
      case 5: driver.key(keys[static_cast<std::size_t>(below(static_cast<int>(std::size(keys))))]); break;
      case 6: driver.key(below(2) == 0 ? Qt::Key_Z : Qt::Key_Y, Qt::ControlModifier); break;
      case 7: driver.key(static_cast<Qt::Key>(Qt::Key_1 + below(3)), Qt::ControlModifier); break;
      case 8:
        if (below(40) == 0) driver.window().open(embedded(scenes[below(3)]));
        if (below(40) == 0) driver.key(Qt::Key_T, Qt::ControlModifier);
        break;
      default: break;
    }
    for (QWidget* top : QApplication::topLevelWidgets())
      if (top->isVisible() && (qobject_cast<QDialog*>(top) || top->inherits("QMenu"))) top->close();
    Driver::live(below(30));
    const Moment& moment = driver.window().touch().moment();
    const double limit_n = driver.window().document().scene().coupling().max_force_n;
    if (limits.empty() || limits.back().most_n != limit_n) limits.push_back({elapsed_s(), limit_n});
    while (limits.size() > 1 && elapsed_s() - limits[1].since_s > change_s) limits.pop_front();
    const double allowed_n = std::max_element(limits.begin(), limits.end(), [](const Limit& a, const Limit& b) {
                               return a.most_n < b.most_n;
                             })->most_n;
    ASSERT_TRUE(is_finite(moment.command_n));
    ASSERT_LE(norm(moment.command_n), allowed_n + 1e-9) << "the limit is " << limit_n;
    most_n = std::max(most_n, norm(moment.command_n));
    if (early_mib == 0.0 && elapsed_s() > 0.3 * duration_s) early_mib = resident_mib();
    if (elapsed_s() > last_print_s + 30.0) {
      last_print_s = elapsed_s();
      std::printf("%.0f s: %lld events, %.0f MiB, largest force %.2f N\n", last_print_s, static_cast<long long>(events),
                  resident_mib(), most_n);
      std::fflush(stdout);
    }
  }
  std::printf("%lld events, %.0f MiB after a third, %.0f MiB in the end, largest force %.2f N\n",
              static_cast<long long>(events), early_mib, resident_mib(), most_n);
  EXPECT_LT(resident_mib(), 1.5 * early_mib + 150.0);
}

}  // namespace monkey_test
}  // namespace palpa::explorer
