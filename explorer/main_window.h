// The window: one scene, seen and felt.
#pragma once

#include <QMainWindow>
#include <QSettings>
#include <QTimer>
#include <filesystem>
#include <memory>
#include <vector>

#include "explorer/document.h"
#include "explorer/film.h"
#include "explorer/function_desk.h"
#include "explorer/instruments.h"
#include "explorer/jobs.h"
#include "explorer/message_bar.h"
#include "explorer/panel.h"
#include "explorer/player.h"
#include "explorer/slice_view.h"
#include "explorer/start_page.h"
#include "explorer/touch.h"
#include "explorer/view_3d.h"

class QDockWidget;
class QLabel;
class QProgressBar;
class QStackedWidget;
class QTabWidget;
class QToolButton;

namespace palpa::explorer {

/// What the program was started with.
struct WindowOptions {
  std::vector<std::filesystem::path> data_folders;
  std::string device;         ///< as `device_description` reads it; empty: the mouse
  bool has_opengl = true;     ///< false: slices only
  std::string settings_file;  ///< empty: the user's
};

class MainWindow : public QMainWindow {
  Q_OBJECT
 public:
  explicit MainWindow(const WindowOptions& options);
  ~MainWindow() override;

  /// \param second_trace  shown beside the trace that is opened; empty: none
  void open(const std::filesystem::path& path, const std::filesystem::path& second_trace = {});
  /// Shows a second trace beside the one that is open.
  void compare_with(const std::filesystem::path& trace);
  /// For tests, which look on.
  View3D* view() { return view_; }
  Touch& touch() { return touch_; }
  Document& document() { return document_; }
  Instruments& instruments() { return *instruments_; }

 protected:
  void dragEnterEvent(QDragEnterEvent* event) override;
  void dropEvent(QDropEvent* event) override;
  void closeEvent(QCloseEvent* event) override;

 private:
  void make_actions();
  void make_docks();
  QAction* action(const QString& words, const QKeySequence& keys, const QString& tip, const std::function<void()>& what);
  void opened(const Opened& opened);
  void scene_changed();
  void redraw_layers();
  void begin_touch(const std::filesystem::path& out = {});
  void feel_with(std::unique_ptr<Device> device, const std::filesystem::path& out);
  void tick();
  void say(const QString& words, bool is_problem = false);
  void show_job();
  void ask_file();
  bool save(bool under_another_name);
  void record(bool on);
  QImage picture();
  /// Of a picture or a folder of them that is named by the time.
  QString picture_path(const QString& name, const QString& time) const;
  void screenshot();
  void play_hand(const PlayedHand& hand);
  void stop_playing();
  void feel_what_if();
  void show_beside(FeltTrace second);
  void show_played();
  void show_flow_near(const Vec3& proxy_m);
  void remember(const std::filesystem::path& path);
  QString words_of_fault();
  QString words_of_hint() const;

  WindowOptions options_;
  QSettings settings_;
  Document document_;
  Touch touch_;
  Jobs jobs_;

  QStackedWidget* pages_;
  StartPage* start_page_;
  View3D* view_ = nullptr;
  std::array<SliceView*, 3> slices_{};
  FeelPanel* feel_;
  SeePanel* see_;
  Instruments* instruments_;
  Player* player_;
  QDockWidget* player_dock_;
  QList<QDockWidget*> scene_docks_;  ///< shown while a scene is open
  FunctionDesk* desk_;
  Film* film_;
  PlayedHand played_;
  std::shared_ptr<const FeltTrace> played_first_;
  std::filesystem::path second_trace_;  ///< to be shown beside the first as soon as that is there
  MessageBar* message_;
  QLabel* job_words_;
  QProgressBar* job_bar_;
  QToolButton* job_cancel_;
  QAction* record_ = nullptr;
  QAction* hold_ = nullptr;
  SliceLook look_;
  FieldPtr flow_;  ///< vectors that are felt or seen, hand frame; null: there are none
  Vec3 flow_seen_at_m_;
  QTimer timer_;
  std::vector<TrailPoint> trail_;
  std::string drawn_;  ///< what the layers that are drawn depend on
  bool is_held_ = false, hint_seen_ = false;
  int ticks_ = 0;
  std::int64_t unrecorded_ = 0;
};

}  // namespace palpa::explorer
