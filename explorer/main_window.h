// Main window: one scene, shown and felt.
#pragma once

#include <QMainWindow>
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
#include "explorer/opening.h"
#include "explorer/panel.h"
#include "explorer/player.h"
#include "explorer/replay.h"
#include "explorer/scene_views.h"
#include "explorer/settings.h"
#include "explorer/start_page.h"
#include "explorer/time_bar.h"
#include "explorer/touch.h"

class QComboBox;
class QDockWidget;
class QLabel;
class QMenu;
class QStackedWidget;

namespace palpa::explorer {

/// Options of the command line.
struct WindowOptions {
  std::vector<std::filesystem::path> data_folders;
  std::string device;         ///< for `device_description`; empty: the mouse
  bool has_opengl = true;     ///< false: slices only
  std::string settings_file;  ///< empty: the user's
};

class MainWindow : public QMainWindow {
  Q_OBJECT
 public:
  explicit MainWindow(const WindowOptions& options);
  ~MainWindow() override;

  /// \param second_trace  shown beside the opened trace; empty: none
  void open(const std::filesystem::path& path, const std::filesystem::path& second_trace = {});
  void open(const Wanted& wanted);
  /// Opens files of the user: several data files as parts of one volume, two traces beside each other, else the first.
  void open_chosen(const QStringList& files);
  /// Shows a second trace beside the first.
  void compare_with(const std::filesystem::path& trace);
  /// True while a job reads or draws.
  bool is_busy() const { return !jobs_.words().isEmpty() || views_->is_drawing(); }
  /// For tests.
  View3D* view() { return views_->view(); }
  Touch& touch() { return touch_; }
  Document& document() { return document_; }
  Instruments& instruments() { return *instruments_; }
  SceneViews& views() { return *views_; }

 protected:
  void dragEnterEvent(QDragEnterEvent* event) override;
  void dropEvent(QDropEvent* event) override;
  void closeEvent(QCloseEvent* event) override;
  void changeEvent(QEvent* event) override;
  bool eventFilter(QObject* watched, QEvent* event) override;

 private:
  void make_pages();
  void make_actions();
  void make_file_actions();
  void make_edit_actions();
  void make_view_actions();
  void make_layout_actions(QMenu* look);
  void make_feel_actions();
  void make_trace_actions(QMenu* feel);
  void make_mode_actions(QMenu* feel);
  void make_help_actions();
  void make_tool_bar();
  void name_modes();
  void make_recent(QMenu* menu);
  bool may_close();
  void keep_unsaved();
  void set_dark(bool dark);
  void present(bool on);
  void place_message(bool presents);
  void picture_of_size();
  void show_recording();
  void touch_began(const Vec3& at_m, const Vec3& away);
  bool is_anything_on() const;
  /// True if the focus is on a name, and no force could be turned off.
  bool types_space() const;
  void make_docks();
  void lead_hand_by_mouse();
  void make_hand_box();
  void list_hands(const Scene& scene);
  /// Lets the mouse lead another hand of the scene. \param number  of the hand, after the last again the first
  void lead_hand(int number);
  /// Where a hand lies after a press [m], hand frame.
  Vec3 before_surface_m();
  /// True if the led hand has a tool.
  bool has_tool() const;
  void start_curves();
  /// From the hand to the foot, or the middle of the feet, of its tool that meets a surface first. \param away  [1] the way
  Vec3 foremost_lever_m(const Vec3& away);
  QAction* action(const QString& words, const QKeySequence& keys, const QString& tip, const std::function<void()>& what);
  void opened(const Opened& opened);
  void scene_changed();
  void begin_touch(const std::filesystem::path& out = {});
  void feel_with(std::unique_ptr<Device> device, const std::filesystem::path& out);
  void tick();
  void say(const QString& words, bool is_problem = false, const QList<MessageBar::Offer>& offers = {});
  QList<QAction*> make_opening_actions();
  void say_of(const Opened& opened);
  void ask_file();
  void ask_folder();
  void ask_data();
  void ask_trace(const QString& title, const std::function<void(const std::filesystem::path&)>& then);
  void ask_parts();
  void choose(const FileContents& contents, const Wanted& wanted, const std::function<void(const Wanted&)>& then);
  void add(Wanted wanted);
  bool save(bool under_another_name);
  void record(bool on);
  QImage picture();
  void screenshot();
  void play(const PlayedHand& hand, const std::filesystem::path& second_trace = {});
  /// Plays the open trace, or those of several hands.
  void play_recorded(const Opened& opened);
  void stop_playing();
  void follow_data();
  void remember(const std::filesystem::path& path);
  QString format_fault();
  QString format_hint() const;

  WindowOptions options_;
  Settings settings_;
  Document document_;
  Touch touch_;
  Jobs jobs_;

  QStackedWidget* pages_;
  StartPage* start_page_;
  SceneViews* views_;
  FeelPanel* feel_;
  SeePanel* see_;
  Instruments* instruments_;
  Player* player_;
  QDockWidget* player_dock_;
  QList<QDockWidget*> scene_docks_;  ///< visible while a scene is open
  Replay* replay_;
  TimeBar* time_bar_;
  FunctionDesk* desk_;
  Film* film_;
  MessageBar* message_;
  QWidget* message_place_ = nullptr;  ///< in the tool bar
  QLabel* pointed_;                   ///< position and values under the cursor
  QList<QAction*> mode_actions_, tools_;
  QList<QWidget*> hidden_for_presenting_;
  std::filesystem::path last_trace_;
  bool hint_followed_ = false;      ///< in this scene
  Vec3 put_at_m_;                   ///< hand frame
  std::int64_t put_from_tick_ = 0;  ///< moments before are of a hand elsewhere
  QAction* record_ = nullptr;
  QAction* hold_ = nullptr;
  QComboBox* hand_box_ = nullptr;
  QAction *hand_box_action_ = nullptr, *next_hand_ = nullptr;  ///< shown for a scene of several hands
  QTimer timer_;
  bool mouse_leads_ = false;
  Vec3 led_away_;  ///< [1] away from the surface where the mouse last led the hand
  int ticks_ = 0, frames_ = 0;
  std::int64_t unrecorded_ = 0;
  std::size_t notes_said_ = 0;  // of windows of volumes larger than memory
};

}  // namespace palpa::explorer
