#include "explorer/main_window.h"

#include <QAbstractSpinBox>
#include <QAction>
#include <QApplication>
#include <QCloseEvent>
#include <QDir>
#include <QDockWidget>
#include <QFileDialog>
#include <QFileInfo>
#include <QFrame>
#include <QGridLayout>
#include <QGuiApplication>
#include <QKeyEvent>
#include <QLabel>
#include <QLineEdit>
#include <QMessageBox>
#include <QScreen>
#include <QScrollArea>
#include <QStackedWidget>
#include <QStandardPaths>
#include <QStatusBar>
#include <QTabWidget>
#include <utility>

#include "explorer/job_bar.h"
#include "explorer/picture_file.h"
#include "explorer/presets.h"
#include "palpa/base/new_file.h"
#include "palpa/base/sanitized.h"
#include "palpa/device/open_device.h"
#include "palpa/study/check.h"

namespace palpa::explorer {
namespace {

namespace fs = std::filesystem;

constexpr int frame_ms = 33;       // between updates of the views. Shorter: more processor time; longer: stutter
constexpr int title_bar_px = 40;   // of a window manager, above the window. Less: the status bar is below the screen
constexpr int time_key = 900'020;  // of undo steps: a drag over the data's time is one
constexpr int data_frames = 3;     // from picture to picture of moving data. More: they jerk; fewer: they slow the window

std::vector<std::string> names_of_modes(const Scene& scene) {
  std::vector<std::string> names;
  for (const SceneMode& mode : scene.modes()) names.push_back(mode.name);
  return names;
}

}  // namespace

MainWindow::MainWindow(const WindowOptions& options) : options_(options), settings_(options.settings_file) {
  setWindowTitle(tr("Palpa"));
  const QRect screen = QGuiApplication::primaryScreen()->availableGeometry();
  if (!restoreGeometry(settings_.window())) resize(QSize(1600, 1000).boundedTo(screen.size() - QSize(0, title_bar_px)));
  setAcceptDrops(true);

  make_pages();
  make_docks();
  make_actions();
  lead_hand_by_mouse();

  connect(start_page_, &StartPage::chosen, this, [this](const QString& file) { open(file.toStdString()); });
  connect(start_page_, &StartPage::open_asked, this, &MainWindow::ask_file);
  connect(start_page_, &StartPage::folder_asked, this, &MainWindow::ask_folder);
  connect(&document_, &Document::opened_another, this, [this] { opened(document_.opened()); });
  connect(&document_, &Document::changed, this, &MainWindow::scene_changed);
  connect(&document_.undo(), &QUndoStack::cleanChanged, this, [this](bool clean) { setWindowModified(!clean); });
  connect(&document_, &Document::refused, this, [this](const QString& why) { say(why, true); });
  connect(views_, &SceneViews::said, this, [this](const QString& words, bool problem) { say(words, problem); });
  connect(views_, &SceneViews::pointed, pointed_, &QLabel::setText);
  connect(views_, &SceneViews::value_asked, desk_, [this](double value) { desk_->give_value_to_level(value); });
  connect(desk_, &QDockWidget::visibilityChanged, views_, &SceneViews::pick_values);
  connect(see_, &SeePanel::hidden_changed, this, [this](const std::set<std::size_t>& hidden) {
    if (View3D* view = views_->view()) view->hide_layers(hidden);
  });
  connect(see_, &SeePanel::preset_chosen, this, [this](int number) {
    const Preset& preset = presets()[static_cast<std::size_t>(number)];
    try {
      const Preseted made = apply(preset, document_.scene());
      document_.edit(QString::fromUtf8(preset.name), -1, [&](Scene& scene) { scene.layers = made.layers; });
      views_->show_values(document_.scene(), made.window_low, made.window_high);
    } catch (const std::exception& error) {
      say(QString::fromUtf8(error.what()), true);
    }
  });

  start_page_->show_recent(settings_.recent());
  if (const auto dark = settings_.dark()) set_dark(*dark);
  timer_.setInterval(frame_ms);
  timer_.setTimerType(Qt::PreciseTimer);
  connect(&timer_, &QTimer::timeout, this, &MainWindow::tick);
  timer_.start();
  qApp->installEventFilter(this);
}

MainWindow::~MainWindow() { touch_.end(); }

void MainWindow::make_pages() {
  pages_ = new QStackedWidget;
  pages_->setObjectName("pages");
  start_page_ = new StartPage;
  auto* start = new QScrollArea;  // scrolls in a small window
  start->setWidget(start_page_);
  start->setWidgetResizable(true);
  start->setFrameShape(QFrame::NoFrame);
  pages_->addWidget(start);
  views_ = new SceneViews(jobs_, options_.has_opengl);
  pages_->addWidget(views_);
  pages_->addWidget(new QWidget);  // while the first file is read

  message_ = new MessageBar;
  auto* central = new QWidget;
  auto* over = new QGridLayout(central);  // progress lies over the pages, which do not move
  over->setContentsMargins(0, 0, 0, 0);
  over->addWidget(pages_, 0, 0);
  time_bar_ = new TimeBar([this] { return player_->has_trace() ? player_->at_s() : std::max(0.0, touch_.moment().t_s); });
  over->addWidget(time_bar_, 1, 0);
  connect(time_bar_, &TimeBar::asked, this, [this](const TimeOptions& time) {
    document_.edit(tr("time of the data"), time_key, [&](Scene& scene) { scene.set(time); });
  });
  setCentralWidget(central);
  pointed_ = new QLabel;
  pointed_->setObjectName("pointed");
  pointed_->setAccessibleName(tr("Position and values under the cursor"));
  pointed_->setSizePolicy(QSizePolicy::Ignored, QSizePolicy::Preferred);  // long words make no wide window
  statusBar()->addWidget(pointed_, 1);
  for (const JobBar::Shown shown : {JobBar::Shown::other_jobs, JobBar::Shown::reading}) {
    auto* job_bar = new JobBar(jobs_, shown);
    if (shown == JobBar::Shown::other_jobs)
      statusBar()->addPermanentWidget(job_bar);
    else
      over->addWidget(job_bar, 0, 0, Qt::AlignCenter);
    connect(job_bar, &JobBar::cancelled, this, [this] {
      if (!document_.is_open()) pages_->setCurrentIndex(0);
      // Cancelling the device or the replay falls back to the mouse.
      if (document_.is_open() && !touch_.is_felt() && !player_->has_trace()) feel_with(nullptr, {});
    });
  }
}

void MainWindow::make_docks() {
  feel_ = new FeelPanel(document_);
  see_ = new SeePanel(document_);
  auto* tabs = new QTabWidget;
  tabs->addTab(feel_, tr("Feel"));
  tabs->addTab(see_, tr("See"));
  auto* panel = new QDockWidget(tr("Scene"));
  panel->setObjectName("panel");
  panel->setWidget(tabs);
  addDockWidget(Qt::RightDockWidgetArea, panel);
  instruments_ = new Instruments;
  auto* below = new QDockWidget(tr("Instruments"));
  below->setObjectName("instruments");
  below->setWidget(instruments_);
  addDockWidget(Qt::BottomDockWidgetArea, below);
  desk_ = new FunctionDesk(document_, jobs_, options_.has_opengl);
  addDockWidget(Qt::BottomDockWidgetArea, desk_);
  desk_->hide();
  connect(desk_, &FunctionDesk::said, this, [this](const QString& words, bool problem) { say(words, problem); });
  connect(feel_, &FeelPanel::function_asked, desk_, &FunctionDesk::edit_strength);
  connect(feel_, &FeelPanel::mask_asked, desk_, &FunctionDesk::edit_mask);
  connect(see_, &SeePanel::colors_asked, desk_, &FunctionDesk::edit_colors);
  player_ = new Player;
  player_dock_ = new QDockWidget(tr("Trace"));
  player_dock_->setObjectName("player");
  player_dock_->setWidget(player_);
  addDockWidget(Qt::BottomDockWidgetArea, player_dock_);
  tabifyDockWidget(below, desk_);
  tabifyDockWidget(below, player_dock_);
  player_dock_->hide();
  connect(player_, &Player::moved, this, [this] {
    if (player_->has_trace()) views_->show_played(*player_, document_.scene().coupling().max_force_n);
  });
  replay_ = new Replay(*player_, jobs_, document_, options_.data_folders, this);
  connect(player_, &Player::said, this, [this](const QString& words, bool problem) { say(words, problem); });
  connect(replay_, &Replay::said, this, [this](const QString& words, bool problem) { say(words, problem); });
  connect(replay_, &Replay::shown, this, [this] {
    player_dock_->show();
    player_dock_->raise();
  });
  connect(replay_, &Replay::failed, this, [this] { begin_touch(); });
  film_ = new Film(*player_, jobs_, this);
  connect(film_, &Film::said, this, [this](const QString& words, bool problem) { say(words, problem); });
  connect(player_dock_->toggleViewAction(), &QAction::toggled, this, [this](bool shown) {
    if (!shown && player_->has_trace() && !player_dock_->isVisible()) stop_playing();
  });
  setCorner(Qt::BottomRightCorner, Qt::RightDockWidgetArea);
  scene_docks_ = {panel, below};
  for (QDockWidget* dock : scene_docks_) dock->hide();  // until a scene is open
}

void MainWindow::opened(const Opened& opened) {
  const Scene& scene = opened.loaded.scene;
  setWindowTitle(tr("%1[*] – Palpa").arg(opened.title));
  if (pages_->currentIndex() != 1) {
    pages_->setCurrentIndex(1);
    for (QDockWidget* dock : scene_docks_) dock->show();
    if (!restoreState(settings_.panels())) {
      resizeDocks({scene_docks_[0]}, {360}, Qt::Horizontal);
      resizeDocks({scene_docks_[1]}, {210}, Qt::Vertical);
    }
    desk_->hide();
  }
  record_->setChecked(false);
  hint_followed_ = false;
  views_->start(scene);
  const double reach_m = Tool(scene.tool(), scene.coupling()).reach_m();
  touch_.start(scene, 0.5 * views_->bounds_m().size_m().z + 0.01 + reach_m);  // in front of the data's middle
  list_hands(scene);
  say_of(opened);
  scene_changed();
  replay_->end();
  player_dock_->hide();
  if (!opened.trace.empty()) return play_recorded(opened);
  begin_touch();
}

void MainWindow::begin_touch(const fs::path& out) {
  if (options_.device.empty()) return feel_with(nullptr, out);
  touch_.end();
  using Checked = std::pair<std::unique_ptr<Device>, std::string>;  // and the findings of a quick check of the scene on it
  jobs_.begin<Checked>(
      Jobs::Purpose::device, tr("opening the device %1").arg(QString::fromStdString(options_.device)),
      [name = options_.device, scene = document_.scene()](std::stop_token) {
        std::unique_ptr<Device> device = open_device(device_description(name));
        const std::optional<DevicePlant> plant = plant_like(name);
        return Checked{std::move(device), plant ? check_quickly(scene, *plant).verdict : std::string()};
      },
      [this, out](Checked opened) {
        if (!opened.second.empty()) say(QString::fromStdString("check: " + opened.second));
        feel_with(std::move(opened.first), out);
      },
      [this, out](const QString& why) {
        say(tr("%1\nThe mouse takes its place.").arg(why), true);
        options_.device.clear();
        feel_with(nullptr, out);
      });
}

void MainWindow::start_curves() {
  instruments_->start(names_of_modes(document_.scene()), touch_.led());
  instruments_->show_torque(has_tool());
}

void MainWindow::feel_with(std::unique_ptr<Device> device, const fs::path& out) {
  start_curves();
  hold_->setChecked(false);
  put_from_tick_ = 0;
  try {
    touch_.begin(document_.loaded(), std::move(device), out);
    if (!out.empty()) say(tr("Recording into %1; press R to end it.").arg(QString::fromStdString(out.string())));
  } catch (const std::exception& error) {
    say(QString::fromUtf8(error.what()), true);
    if (!out.empty()) begin_touch();  // continue without a recording
  }
  record_->setChecked(touch_.is_recorded());
  show_recording();
}

void MainWindow::scene_changed() {
  const Scene& scene = document_.scene();
  feel_->refresh();
  see_->refresh();
  if (touch_.is_felt()) {
    if (touch_.is_recorded()) say(tr("The scene changed while it was recorded: the trace can be replayed up to here."));
    touch_.change(scene);
    if (names_of_modes(scene) != instruments_->modes()) start_curves();
    instruments_->show_torque(has_tool());
  }
  if (player_->has_trace()) replay_->feel_changed_scene();
  if (desk_->isVisible()) desk_->refresh();
  time_bar_->show_scene(scene);
  views_->draw_layers(scene);
  name_modes();
}

void MainWindow::play(const PlayedHand& hand, const fs::path& second_trace) {
  touch_.end();
  replay_->play(hand, second_trace);
}

void MainWindow::play_recorded(const Opened& opened) {
  if (opened.hand_traces.empty()) return play({.trace = opened.trace, .description = {}}, opened.second_trace);
  touch_.end();
  std::vector<PlayedHand> hands;
  for (const fs::path& trace : opened.hand_traces) hands.push_back({.trace = trace, .description = {}, .number = hands.size()});
  replay_->play(hands, opened.second_trace);
}

void MainWindow::compare_with(const fs::path& trace) { replay_->compare_with(trace); }

void MainWindow::stop_playing() {
  replay_->end();
  views_->forget_trail();
  begin_touch();
}

void MainWindow::tick() {
  touch_.beat(1e-3 * frame_ms);
  if (film_->is_under_way()) return film_->next();
  if (player_->has_trace()) player_->pass(1e-3 * frame_ms);
  follow_data();
  if (!touch_.is_felt() || pages_->currentIndex() != 1) return;
  const Moment& moment = touch_.moment();
  if (moment.tick >= 0) {
    std::vector<Moment> hands;
    for (std::size_t hand = 0; hand < touch_.hands(); ++hand) hands.push_back(touch_.moment(hand));
    views_->show_felt(hands, document_.scene().coupling().max_force_n, mouse_leads_);
  }
  instruments_->update_from(touch_.samples());
  if (ticks_++ % 8 == 0) {
    show_recording();
    LiveLoop& loop = *touch_.loop();
    const LiveView& seen = loop.latest(touch_.led());
    const LoopStatistics statistics = loop.statistics(touch_.led());
    instruments_->show_statistics(statistics, seen.frame, moment.has_tool, seen.device_fault);
    if (touch_.is_recorded() && statistics.unrecorded > unrecorded_)
      say(tr("%1 ticks could not be recorded: the disk is full or too slow. What was written before stays in %2; press R to "
             "end the "
             "recording.")
              .arg(statistics.unrecorded)
              .arg(QString::fromStdString(touch_.trace().string())),
          true);
    unrecorded_ = statistics.unrecorded;
    const std::vector<std::string>& notes = statistics.windows.notes;
    notes_said_ = std::min(notes_said_, notes.size());  // another scene has none yet
    for (; notes_said_ < notes.size(); ++notes_said_) say(QString::fromStdString(notes[notes_said_]), true);
  }
  if (const std::string problem = touch_.take_problem(); !problem.empty()) say(QString::fromStdString(problem), true);
  if (View3D* view = views_->view()) view->show_words(format_fault(), format_hint());
}

/// Draws moving data as they are felt now.
void MainWindow::follow_data() {
  if (!document_.is_open()) return;
  time_bar_->follow();
  if (!time_bar_->plays() || pages_->currentIndex() != 1 || ++frames_ % data_frames != 0) return;
  Scene now = document_.scene();
  now.set(TimeOptions{.start_s = time_bar_->at_s()});
  views_->draw_layers(now, true);
}

QString MainWindow::format_hint() const {
  if (views_->awaits_surfaces()) return tr("The surfaces are being drawn; the slices can be touched.");
  if (hint_followed_) return {};
  return views_->touches_surfaces()
             ? tr("Press on the surface and drag to feel it; the wheel presses deeper. Drag beside it to turn.")
             : tr("Press and drag to feel the flow, at the depth of the nearest line; the right button turns.");
}

bool MainWindow::is_anything_on() const {
  const std::vector<SceneMode>& modes = document_.scene().modes();
  return std::any_of(modes.begin(), modes.end(), [](const SceneMode& mode) { return mode.enabled; });
}

QString MainWindow::format_fault() {
  if (touch_.is_held()) return tr("Force off: press Space to turn it on");
  if (!is_anything_on()) return tr("Nothing is on: turn a mode on under Feel (Ctrl+1)");
  LiveLoop* loop = touch_.loop();
  if (!loop) return {};
  const LiveView& seen = loop->latest(touch_.led());
  if (seen.device_fault) return QString(seen.device_fault);
  if (touch_.is_by_mouse() && seen.frame.command.cause == GuardCause::no_position) return {};
  switch (seen.frame.command.cause) {
    case GuardCause::not_finite: return tr("The force is not finite: the scene has a fault. Undo the last change.");
    case GuardCause::no_position: return tr("The device has no valid position: move it to its start position.");
    case GuardCause::link_lost: return tr("The device does not answer: check its cable and power.");
    case GuardCause::speed: return tr("The hand was too fast: hold still for a moment.");
    default: return {};
  }
}

void MainWindow::record(bool on) {
  if (!document_.is_open()) {
    say(tr("A recording needs a scene: open one."));
    return record_->setChecked(false);
  }
  if (!on) {
    const QString folder = QString::fromStdString(touch_.trace().string());
    const fs::path trace = touch_.trace(), before = std::exchange(last_trace_, touch_.trace());
    const std::string lost = touch_.end();
    remember(trace);
    QList<MessageBar::Offer> offers{{tr("Open"), [this, trace] { open(trace); }}};
    if (!before.empty()) offers.append({tr("Compare with the one before"), [this, trace, before] { open(before, trace); }});
    lost.empty() ? say(tr("Recorded in %1").arg(folder), false, offers) : say(QString::fromStdString(lost), true, offers);
    return begin_touch();
  }
  begin_touch(settings_.new_trace(QFileInfo(document_.opened().title).completeBaseName()));
}

bool MainWindow::save(bool under_another_name) {
  if (!document_.is_open()) {
    say(tr("There is no scene to save: open one."));
    return false;
  }
  fs::path file = document_.opened().scene_file;
  if (file.empty() || under_another_name) {
    const QString suggested = file.empty()
                                  ? QDir::home().filePath(QFileInfo(document_.opened().title).completeBaseName() + ".toml")
                                  : QString::fromStdString(file.string());
    const QString chosen = QFileDialog::getSaveFileName(this, tr("Save the scene"), suggested, tr("Scenes (*.toml)"));
    if (chosen.isEmpty()) return false;
    file = chosen.toStdString();
    if (file.extension() != ".toml") file += ".toml";
  }
  try {
    document_.save(file);
    remember(file);
    setWindowTitle(tr("%1[*] – Palpa").arg(QString::fromStdString(file.filename().string())));
    say(tr("Saved as %1").arg(QString::fromStdString(file.string())));
    return true;
  } catch (const std::exception& error) {
    say(QString::fromUtf8(error.what()), true);
    return false;
  }
}

QImage MainWindow::picture() {
  View3D* view = views_->view();
  return view ? view->picture() : pages_->grab().toImage();
}

void MainWindow::screenshot() {
  if (!document_.is_open()) return say(tr("A picture needs a scene: open one."));
  const QString file = settings_.new_picture();
  QDir().mkpath(QFileInfo(file).path());
  try {
    save_picture(picture(), file);
    say(tr("Saved %1").arg(file));
  } catch (const LoadError& error) {
    say(QString::fromUtf8(error.what()), true);
  }
}

void MainWindow::remember(const fs::path& path) {
  settings_.remember(path);
  start_page_->show_recent(settings_.recent());
}

void MainWindow::say(const QString& words, bool is_problem, const QList<MessageBar::Offer>& offers) {
  message_->say(words, is_problem, offers);
}

bool MainWindow::types_space() const {
  const auto* field = qobject_cast<QLineEdit*>(QApplication::focusWidget());
  const bool is_name = field && !field->isReadOnly() && !qobject_cast<QAbstractSpinBox*>(field->parent());
  return is_name && (!touch_.is_felt() || touch_.is_held());
}

// Fields with text claim these keys: a number has an undo of its own, and a space is a letter. The force must go off with any
// focus; without a force a space is a letter.
bool MainWindow::eventFilter(QObject* watched, QEvent* event) {
  if (event->type() == QEvent::ShortcutOverride && isActiveWindow()) {
    const auto* key = static_cast<QKeyEvent*>(event);
    const bool is_space = key->key() == Qt::Key_Space && key->modifiers() == Qt::NoModifier && !types_space();
    if (is_space || key->matches(QKeySequence::Undo) || key->matches(QKeySequence::Redo)) {
      event->ignore();
      return true;
    }
  }
  return QMainWindow::eventFilter(watched, event);
}

// The button's release is sent to the window that becomes active during a drag.
void MainWindow::changeEvent(QEvent* event) {
  QMainWindow::changeEvent(event);
  if (event->type() != QEvent::ActivationChange) return;
  if (!isActiveWindow() && std::exchange(mouse_leads_, false)) touch_.put_hand(before_surface_m());
  touch_.have_mouse(isActiveWindow());
}

bool MainWindow::may_close() {
  if (!document_.is_open() || document_.undo().isClean()) return true;
  QMessageBox question(QMessageBox::Question, tr("Palpa"),
                       tr("The scene %1 has unsaved changes.").arg(document_.opened().title),
                       QMessageBox::Save | QMessageBox::Discard | QMessageBox::Cancel, this);
  question.setDefaultButton(QMessageBox::Save);
  switch (question.exec()) {
    case QMessageBox::Save: return save(false);
    case QMessageBox::Discard: document_.undo().setClean(); return true;
    default: return false;
  }
}

// Of a window that a program closes, and of a scene that another replaces.
void MainWindow::keep_unsaved() {
  if (!document_.is_open() || document_.undo().isClean()) return;
  const QString folder = QStandardPaths::writableLocation(QStandardPaths::AppDataLocation);
  QDir().mkpath(folder);
  QString name = QFileInfo(document_.opened().title).completeBaseName();
  if (name.startsWith(Settings::unsaved)) name.remove(0, QString(Settings::unsaved).size());
  const QString file = folder + "/" + Settings::unsaved + name + ".toml";
  try {
    detail::write_whole(file.toStdString(), document_.text(), detail::Existing::replaced);
    std::fprintf(stderr, "The scene was not saved; it is kept in %s\n", detail::sanitized(file.toStdString()).c_str());
    remember(file.toStdString());
  } catch (const LoadError& error) {
    std::fprintf(stderr, "palpa-explorer: %s\n", detail::sanitized(error.what()).c_str());
  }
}

void MainWindow::closeEvent(QCloseEvent* event) {
  if (event->spontaneous() && !may_close()) return event->ignore();  // a person closes it
  // Stop the motors first.
  const std::string lost = touch_.end();
  if (!lost.empty()) std::fprintf(stderr, "palpa-explorer: %s\n", detail::sanitized(lost).c_str());
  timer_.stop();
  present(false);
  settings_.set_window(saveGeometry());
  if (pages_->currentIndex() == 1) settings_.set_panels(saveState());
  keep_unsaved();
  event->accept();
}

}  // namespace palpa::explorer
