#include "explorer/main_window.h"

#include <QAction>
#include <QApplication>
#include <QCloseEvent>
#include <QDateTime>
#include <QDir>
#include <QDockWidget>
#include <QFileDialog>
#include <QFileInfo>
#include <QFrame>
#include <QHBoxLayout>
#include <QLabel>
#include <QMenuBar>
#include <QMimeData>
#include <QProcess>
#include <QProgressBar>
#include <QScrollArea>
#include <QSplitter>
#include <QStackedWidget>
#include <QStandardPaths>
#include <QStatusBar>
#include <QTabWidget>
#include <QToolBar>
#include <QToolButton>
#include <QVBoxLayout>
#include <algorithm>

#include "explorer/help_sheet.h"
#include "explorer/opening.h"
#include "explorer/presets.h"
#include "palpa/device/open_device.h"
#include "palpa/scene/parts.h"
#include "palpa/time/timed_field.h"
#include "palpa/view/layers.h"
#include "palpa/view/streamlines.h"

namespace palpa::explorer {
namespace {

namespace fs = std::filesystem;

constexpr int frame_ms = 33;  // between looks at what is felt. Shorter: the processor is busy; longer: it stutters
constexpr std::size_t trail_points = 400;
constexpr int most_recent = 8;
// Streamlines near the proxy: how far, how many, and how far it goes until they are drawn anew.
constexpr double flow_reach_m = 0.012, flow_step_m = 0.0015;
constexpr std::size_t flow_lines = 10;
constexpr double film_hz = 25.0;     // pictures a second of a film, as most players show
constexpr double in_front_m = 6e-3;  // of the surface, where a hand is put before it presses, and where it goes back to
constexpr double jump_m = 0.03;      // farther between two pictures than the mouse leads a hand: it was put there

bool is_dark(const QPalette& palette) { return palette.color(QPalette::Window).lightness() < 128; }

}  // namespace

MainWindow::MainWindow(const WindowOptions& options)
    : options_(options),
      settings_(options.settings_file.empty() ? QSettings().fileName() : QString::fromStdString(options.settings_file),
                QSettings::IniFormat) {
  setWindowTitle(tr("Palpa"));
  resize(1280, 840);
  setAcceptDrops(true);

  pages_ = new QStackedWidget;
  start_page_ = new StartPage;
  auto* start = new QScrollArea;  // a small window shows a part of it
  start->setWidget(start_page_);
  start->setWidgetResizable(true);
  start->setFrameShape(QFrame::NoFrame);
  pages_->addWidget(start);
  auto* work = new QSplitter(Qt::Horizontal);
  if (options.has_opengl) {
    view_ = new View3D;
    view_->set_dark(is_dark(palette()));
    work->addWidget(view_);
  }
  auto* column = new QSplitter(options.has_opengl ? Qt::Vertical : Qt::Horizontal);
  for (int axis = 2; axis >= 0; --axis) {
    slices_[static_cast<std::size_t>(axis)] = new SliceView(axis);
    column->addWidget(slices_[static_cast<std::size_t>(axis)]);
  }
  work->addWidget(column);
  work->setStretchFactor(0, 3);
  work->setStretchFactor(1, 1);
  if (options.has_opengl) work->setSizes({660, 240});
  pages_->addWidget(work);

  message_ = new QLabel;
  message_->setWordWrap(true);
  message_->setTextInteractionFlags(Qt::TextSelectableByMouse);
  message_->setAccessibleName(tr("Message"));
  message_->setObjectName("message");
  message_bar_ = new QFrame;
  message_bar_->setObjectName("message_bar");
  auto* message_row = new QHBoxLayout(message_bar_);
  message_row->setContentsMargins(10, 4, 6, 4);
  message_row->addWidget(message_, 1);
  auto* close = new QToolButton;
  close->setText("✕");
  close->setAccessibleName(tr("Close message"));
  close->setAutoRaise(true);
  connect(close, &QToolButton::clicked, message_bar_, &QWidget::hide);
  message_row->addWidget(close);
  message_bar_->hide();

  auto* central = new QWidget;
  auto* stack = new QVBoxLayout(central);
  stack->setContentsMargins(0, 0, 0, 0);
  stack->setSpacing(0);
  stack->addWidget(message_bar_);
  stack->addWidget(pages_, 1);
  setCentralWidget(central);

  job_words_ = new QLabel;
  job_bar_ = new QProgressBar;
  job_bar_->setRange(0, 0);
  job_bar_->setMaximumWidth(140);
  job_bar_->setMaximumHeight(14);
  job_cancel_ = new QToolButton;
  job_cancel_->setText(tr("Cancel"));
  for (QWidget* widget :
       {static_cast<QWidget*>(job_words_), static_cast<QWidget*>(job_bar_), static_cast<QWidget*>(job_cancel_)})
    statusBar()->addPermanentWidget(widget);
  connect(job_cancel_, &QToolButton::clicked, this, [this] {
    jobs_.cancel_all();
    // Whoever cancels the device, or the trace that was to be felt again, has the mouse.
    if (document_.is_open() && !touch_.is_felt() && !player_->has_trace()) feel_with(nullptr, {});
  });
  connect(&jobs_, &Jobs::changed, this, &MainWindow::show_job);

  make_docks();
  make_actions();
  show_job();

  connect(start_page_, &StartPage::chosen, this, [this](const QString& file) { open(file.toStdString()); });
  connect(start_page_, &StartPage::open_asked, this, &MainWindow::ask_file);
  connect(&document_, &Document::opened_another, this, [this] { opened(document_.opened()); });
  connect(&document_, &Document::changed, this, &MainWindow::scene_changed);
  connect(&document_, &Document::refused, this, [this](const QString& why) { say(why, true); });

  const auto began = [this](const Vec3& at_m, const Vec3& away) {
    if (player_->has_trace()) return say(tr("A trace is open: Escape leaves it, and the hand is yours again."));
    is_held_ = true;
    hint_seen_ = true;
    settings_.setValue("hint_seen", true);
    // Over there nothing is felt on the way; near by the hand slides.
    const Vec3 front_m = at_m - in_front_m * away;
    if (distance(touch_.led_to_m(), front_m) <= 2.0 * in_front_m) return;
    touch_.put_hand(front_m);
    trail_.clear();
  };
  const auto moved = [this](const Vec3& at_m, const Vec3& away, double depth_m) {
    if (is_held_) touch_.lead_hand(at_m + depth_m * away);
  };
  const auto ended = [this](const Vec3& away) {
    is_held_ = false;
    if (norm(away) > 0.0) touch_.lead_hand(touch_.moment().proxy_m - in_front_m * away);
  };
  if (view_) {
    connect(view_, &View3D::hold_began, this, began);
    connect(view_, &View3D::hold_moved, this, moved);
    connect(view_, &View3D::hold_ended, this, ended);
    connect(view_, &View3D::turned, this, [this] {
      if (LiveLoop* loop = touch_.loop(); loop && !touch_.is_by_mouse()) {
        const detail::View& view = view_->view();
        // Pushing right goes to the right of the screen.
        loop->turn(transposed(Mat3{{view.right, view.up, view.towards}}));
      }
    });
  }
  for (SliceView* slice : slices_) {
    connect(slice, &SliceView::hold_began, this, began);
    connect(slice, &SliceView::hold_moved, this, moved);
    connect(slice, &SliceView::hold_ended, this, ended);
    connect(slice, &SliceView::cross_moved, this, [this](const Vec3& at_m) {
      for (SliceView* other : slices_) other->set_cross(at_m);
    });
    connect(slice, &SliceView::window_dragged, this, [this](double low, double high) {
      look_.low = low;
      look_.high = high;
      for (SliceView* other : slices_) other->set_look(look_);
    });
    connect(slice, &SliceView::value_asked, this, [this](double value, const Vec3&) {
      if (editor_dock_->isVisible()) return give_value_to_level(value);
      say(tr("%1 here: %2 %3")
              .arg(QString::fromStdString(look_.name))
              .arg(value, 0, 'g', 5)
              .arg(QString::fromStdString(look_.unit)));
    });
  }
  connect(see_, &SeePanel::preset_chosen, this, [this](int number) {
    const Preset& preset = presets()[static_cast<std::size_t>(number)];
    try {
      const Preseted made = apply(preset, document_.scene());
      document_.edit(QString::fromUtf8(preset.name), -1, [&](Scene& scene) { scene.layers = made.layers; });
      look_ = slice_look_of(document_.scene());
      look_.low = made.window_low;
      look_.high = made.window_high;
      for (SliceView* slice : slices_) slice->set_look(look_);
    } catch (const std::exception& error) {
      say(QString::fromUtf8(error.what()), true);
    }
  });

  hint_seen_ = settings_.value("hint_seen").toBool();
  start_page_->show_recent(settings_.value("recent").toStringList());
  timer_.setInterval(frame_ms);
  timer_.setTimerType(Qt::PreciseTimer);
  connect(&timer_, &QTimer::timeout, this, &MainWindow::tick);
  timer_.start();
}

MainWindow::~MainWindow() { touch_.end(); }

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
  editor_ = new FunctionEditor(options_.has_opengl);
  editor_dock_ = new QDockWidget(tr("Function"));
  editor_dock_->setObjectName("function");
  editor_dock_->setWidget(editor_);
  addDockWidget(Qt::BottomDockWidgetArea, editor_dock_);
  editor_dock_->hide();
  connect(editor_, &FunctionEditor::strength_changed, this, [this](const TransferFunction& curve) {
    if (!edited_) return;
    if (edited_->what == Edited::What::mask) {
      document_.edit(tr("mask"), 900'002, [&](Scene& scene) {
        scene.find_mode(edited_->mode)->masks.at(edited_->number) = {{editor_->shown().field}, curve};
      });
      return;
    }
    document_.edit(tr("strength"), 900'000, [&](Scene& scene) {
      set_row([&](ParameterVisitor& v) { scene.find_mode(edited_->mode)->mode.visit(v); }, edited_->number,
              Strength(FieldRef{editor_->shown().field}, curve));
    });
  });
  connect(editor_, &FunctionEditor::colors_changed, this, [this](const std::vector<ViewLayer::ColorPoint>& colors) {
    if (!edited_ || !edited_->layer) return;
    document_.edit(tr("colours"), 900'001, [&](Scene& scene) {
      scene.layers = detail::layers_of(scene);
      if (*edited_->layer < scene.layers.size()) scene.layers[*edited_->layer].colors = colors;
    });
  });
  connect(editor_, &FunctionEditor::value_chosen, this, &MainWindow::give_value_to_level);
  connect(feel_, &FeelPanel::function_asked, this, &MainWindow::edit_strength);
  connect(feel_, &FeelPanel::mask_asked, this, &MainWindow::edit_mask);
  connect(see_, &SeePanel::colors_asked, this, &MainWindow::edit_colors);
  player_ = new Player;
  player_dock_ = new QDockWidget(tr("Trace"));
  player_dock_->setObjectName("player");
  player_dock_->setWidget(player_);
  addDockWidget(Qt::BottomDockWidgetArea, player_dock_);
  tabifyDockWidget(below, editor_dock_);
  tabifyDockWidget(below, player_dock_);
  player_dock_->hide();
  connect(player_, &Player::moved, this, &MainWindow::show_played);
  connect(player_dock_->toggleViewAction(), &QAction::toggled, this, [this](bool shown) {
    if (!shown && player_->has_trace() && !player_dock_->isVisible()) stop_playing();
  });
  setCorner(Qt::BottomRightCorner, Qt::RightDockWidgetArea);
  scene_docks_ = {panel, below};
  for (QDockWidget* dock : scene_docks_) dock->hide();  // until there is a scene
}

QAction* MainWindow::action(const QString& words, const QKeySequence& keys, const QString& tip,
                            const std::function<void()>& what) {
  auto* made = new QAction(words, this);
  made->setShortcut(keys);
  made->setToolTip(tip + (keys.isEmpty() ? QString() : " (" + keys.toString(QKeySequence::NativeText) + ")"));
  made->setStatusTip(tip);
  connect(made, &QAction::triggered, this, what);
  addAction(made);
  return made;
}

void MainWindow::make_actions() {
  QMenu* file = menuBar()->addMenu(tr("&File"));
  QMenu* edit = menuBar()->addMenu(tr("&Edit"));
  QMenu* look = menuBar()->addMenu(tr("&View"));
  QMenu* feel = menuBar()->addMenu(tr("F&eel"));
  QMenu* help = menuBar()->addMenu(tr("&Help"));

  QAction* open_file = action(tr("&Open …"), QKeySequence::Open, tr("Open a scene, data or a trace"), [this] { ask_file(); });
  QAction* save_scene = action(tr("&Save scene"), QKeySequence::Save, tr("Save the scene"), [this] { save(false); });
  file->addAction(open_file);
  file->addAction(save_scene);
  file->addAction(action(tr("Save scene &as …"), QKeySequence("Ctrl+Shift+S"), tr("Save the scene under another name"),
                         [this] { save(true); }));
  file->addAction(
      action(tr("Save a &picture"), QKeySequence("Ctrl+P"), tr("Save what the view shows as PNG"), [this] { screenshot(); }));
  file->addAction(action(tr("&Start page"), QKeySequence("Ctrl+Home"), tr("The scenes that come with Palpa"),
                         [this] { pages_->setCurrentIndex(0); }));
  file->addSeparator();
  file->addAction(action(tr("&Quit"), QKeySequence("Ctrl+Q"), tr("End Palpa"), [this] { this->close(); }));

  QAction* undo = document_.undo().createUndoAction(this, tr("Undo"));
  undo->setShortcut(QKeySequence::Undo);
  QAction* redo = document_.undo().createRedoAction(this, tr("Redo"));
  redo->setShortcut(QKeySequence::Redo);
  edit->addAction(undo);
  edit->addAction(redo);

  const auto from = [this](double x, double y, double z) {
    if (view_) view_->look_from({x, y, z}, std::abs(y) > 0.9 ? Vec3{0, 0, -y} : Vec3{0, 1, 0});
  };
  look->addAction(action(tr("Show &all"), QKeySequence("Home"), tr("Show all of the data"), [this] {
    if (view_) view_->show_all();
  }));
  look->addAction(
      action(tr("From the &front"), QKeySequence("1"), tr("Look from where the hand is"), [from] { from(0, 0, 1); }));
  look->addAction(
      action(tr("From the &right"), QKeySequence("2"), tr("Look from the hand's right"), [from] { from(1, 0, 0); }));
  look->addAction(action(tr("From &above"), QKeySequence("3"), tr("Look from above"), [from] { from(0, 1, 0); }));
  struct Key {
    const char* words;
    const char* keys;
    double right_deg, up_deg, zoom;
  };
  for (const Key& key : {Key{QT_TR_NOOP("Turn left"), "Left", -10, 0, 1}, Key{QT_TR_NOOP("Turn right"), "Right", 10, 0, 1},
                         Key{QT_TR_NOOP("Turn up"), "Up", 0, -10, 1}, Key{QT_TR_NOOP("Turn down"), "Down", 0, 10, 1},
                         Key{QT_TR_NOOP("Nearer"), "+", 0, 0, 1.15}, Key{QT_TR_NOOP("Farther"), "-", 0, 0, 1 / 1.15}}) {
    QAction* one = action(tr(key.words), QKeySequence(key.keys), tr(key.words), [this, key] {
      if (!view_) return;
      key.zoom == 1.0 ? view_->turn(key.right_deg, key.up_deg) : view_->zoom(key.zoom);
    });
    // Elsewhere the arrows are those of sliders and boxes.
    one->setShortcutContext(Qt::WidgetShortcut);
    if (view_) view_->addAction(one);
    look->addAction(one);
  }
  look->addAction(action(tr("&Marks"), QKeySequence("M"), tr("Scale bar, directions and legend"), [this] {
    if (view_) view_->show_marks(!view_->shows_marks());
  }));
  look->addAction(action(tr("&Stereo"), QKeySequence("S"), tr("Flat, red-cyan, or side by side"), [this] {
    if (!view_) return;
    view_->set_stereo(static_cast<View3D::Stereo>((static_cast<int>(view_->stereo()) + 1) % 3));
  }));
  look->addAction(action(tr("&Full screen"), QKeySequence("F11"), tr("Nothing but the window"),
                         [this] { setWindowState(windowState() ^ Qt::WindowFullScreen); }));
  for (QDockWidget* dock : findChildren<QDockWidget*>()) look->addAction(dock->toggleViewAction());

  hold_ = action(tr("&No force"), QKeySequence("Space"), tr("Take the force away and give it back"), [this] {
    touch_.is_held() ? touch_.resume() : touch_.panic();
    hold_->setChecked(touch_.is_held());
  });
  hold_->setCheckable(true);
  record_ =
      action(tr("&Record"), QKeySequence("R"), tr("Record what is felt as a trace"), [this] { record(record_->isChecked()); });
  record_->setCheckable(true);
  feel->addAction(hold_);
  feel->addAction(record_);
  feel->addSeparator();
  feel->addAction(action(tr("Play a &stroke"), QKeySequence("Ctrl+T"), tr("A simulated hand strokes what is there"), [this] {
    if (document_.is_open()) play_hand({.trace = {}, .description = "sim:stroke"});
  }));
  feel->addAction(action(tr("Play a &recorded hand …"), QKeySequence("Ctrl+R"), tr("A recording moves the hand"), [this] {
    if (!document_.is_open()) return;
    const QString recording = QFileDialog::getOpenFileName(this, tr("A recorded hand"), settings_.value("folder").toString());
    if (!recording.isEmpty()) play_hand({.trace = {}, .description = recording.toStdString()});
  }));
  feel->addAction(action(tr("Compare with another &trace …"), QKeySequence("Ctrl+Shift+T"),
                         tr("Show a second trace beside the one that is open"), [this] {
                           if (!player_->has_trace()) return say(tr("Open a trace first, or play a hand (Ctrl+T)."));
                           const QString header =
                               QFileDialog::getOpenFileName(this, tr("The second trace (its trace.toml)"),
                                                            settings_.value("folder").toString(), tr("Traces (trace.toml)"));
                           if (!header.isEmpty()) compare_with(fs::path(header.toStdString()).parent_path());
                         }));
  feel->addAction(action(tr("&Play and pause"), QKeySequence("P"), tr("Play and pause the trace"), [this] {
    if (QToolButton* play = player_->findChild<QToolButton*>("play")) play->toggle();
  }));
  film_action_ = action(tr("&Film"), QKeySequence("Ctrl+F"), tr("Make a film of the trace, as PNG pictures and with ffmpeg"),
                        [this] { film(film_action_->isChecked()); });
  film_action_->setCheckable(true);
  feel->addAction(film_action_);
  feel->addAction(action(tr("Next &break-through"), QKeySequence("N"), tr("Go to the next break-through of the trace"),
                         [this] { player_->step_to_event(1); }));
  feel->addAction(action(tr("Break-through &before"), QKeySequence("B"), tr("Go to the break-through before"),
                         [this] { player_->step_to_event(-1); }));
  feel->addAction(
      action(tr("Feel it &yourself"), QKeySequence("Escape"), tr("Leave the trace: the hand is yours again"), [this] {
        if (!player_->has_trace()) return;
        player_dock_->hide();
        if (player_->has_trace()) stop_playing();
      }));
  feel->addSeparator();
  for (int number = 1; number <= 9; ++number) {
    feel->addAction(action(tr("Mode %1 on and off").arg(number), QKeySequence(QString("Ctrl+%1").arg(number)),
                           tr("Turn a mode on or off"), [this, number] {
                             if (!document_.is_open() || document_.scene().modes().size() < static_cast<std::size_t>(number))
                               return;
                             const std::string name = document_.scene().modes()[static_cast<std::size_t>(number - 1)].name;
                             document_.edit(tr("turn %1 on or off").arg(QString::fromStdString(name)), -1, [&](Scene& scene) {
                               SceneMode& mode = *scene.find_mode(name);
                               mode.enabled = !mode.enabled;
                             });
                           }));
  }
  help->addAction(action(tr("&Keys and mouse"), QKeySequence("F1"), tr("What keys and mouse do"), [this] { show_help(); }));

  auto* bar = addToolBar(tr("Main"));
  bar->setObjectName("main_bar");
  bar->setMovable(false);
  bar->setToolButtonStyle(Qt::ToolButtonTextOnly);
  for (QAction* one : {open_file, save_scene, undo, redo}) bar->addAction(one);
  bar->addSeparator();
  bar->addAction(record_);
  bar->addAction(hold_);
}

void MainWindow::open(const fs::path& path, const fs::path& second_trace) {
  const QString name = QString::fromStdString(path.filename().string());
  jobs_.begin<Opened>(
      Jobs::Purpose::open, tr("reading %1").arg(name),
      [path, folders = options_.data_folders](std::stop_token stop) { return open_any(path, folders, stop); },
      [this, path, second_trace](Opened opened) {
        remember(path);
        message_bar_->hide();
        second_trace_ = second_trace;
        document_.open(std::move(opened));
      },
      [this](const QString& why) { say(why, true); });
}

void MainWindow::opened(const Opened& opened) {
  const Scene& scene = opened.loaded.scene;
  setWindowTitle(tr("%1[*] – Palpa").arg(opened.title));
  if (pages_->currentIndex() != 1) {
    pages_->setCurrentIndex(1);
    for (QDockWidget* dock : scene_docks_) dock->show();
    resizeDocks({scene_docks_[0]}, {360}, Qt::Horizontal);
    resizeDocks({scene_docks_[1]}, {210}, Qt::Vertical);
  }
  trail_.clear();
  drawn_.clear();
  record_->setChecked(false);
  look_ = slice_look_of(scene);
  flow_.reset();
  flow_seen_at_m_ = {1e9, 1e9, 1e9};
  for (const std::string& name : field_names(scene)) {
    const FieldPtr field = scene.field({name}).field;
    if (field->components() != 3) continue;
    flow_ = detail::in_hand_frame(frozen(field, scene.time.at(0.0)), scene.hand_to_world());
    break;
  }
  Box bounds{{-0.08, -0.08, -0.08}, {0.08, 0.08, 0.08}};
  if (look_.field) bounds = look_.field->bounds_m();
  if (view_) view_->start(scene);
  for (SliceView* slice : slices_) slice->start(look_, bounds);
  QStringList warnings;
  for (const std::string& warning : opened.loaded.warnings) warnings << QString::fromStdString(warning);
  if (!warnings.isEmpty()) say(warnings.join("\n"));
  scene_changed();
  player_->show_trace({});
  player_dock_->hide();
  if (!opened.trace.empty()) return play_hand({.trace = opened.trace, .description = {}});
  // The hand begins in front of the middle.
  touch_.put_hand({0.0, 0.0, 0.5 * bounds.size_m().z + 0.01});
  begin_touch();
}

void MainWindow::begin_touch(const fs::path& out) {
  if (options_.device.empty()) return feel_with(nullptr, out);
  touch_.end();
  jobs_.begin<std::unique_ptr<Device>>(
      Jobs::Purpose::device, tr("opening the device %1").arg(QString::fromStdString(options_.device)),
      [name = options_.device](std::stop_token) { return open_device(device_description(name)); },
      [this, out](std::unique_ptr<Device> device) { feel_with(std::move(device), out); },
      [this, out](const QString& why) {
        say(tr("%1\nThe mouse takes its place.").arg(why), true);
        options_.device.clear();
        feel_with(nullptr, out);
      });
}

void MainWindow::feel_with(std::unique_ptr<Device> device, const fs::path& out) {
  std::vector<std::string> modes;
  for (const SceneMode& mode : document_.scene().modes()) modes.push_back(mode.name);
  instruments_->start(modes);
  hold_->setChecked(false);
  try {
    touch_.begin(document_.loaded(), std::move(device), out);
    if (!out.empty()) say(tr("Recording into %1; press R to end it.").arg(QString::fromStdString(out.string())));
  } catch (const std::exception& error) {
    say(QString::fromUtf8(error.what()), true);
    if (!out.empty()) begin_touch();  // it is felt all the same
  }
  record_->setChecked(touch_.is_recorded());
}

void MainWindow::scene_changed() {
  const Scene& scene = document_.scene();
  feel_->refresh();
  see_->refresh();
  if (touch_.is_felt()) {
    if (touch_.is_recorded()) say(tr("The scene changed while it was recorded: the trace can be felt again up to here."));
    touch_.change(scene);
  }
  if (player_->has_trace()) feel_what_if();
  if (editor_dock_->isVisible()) show_functions();
  redraw_layers();
  setWindowModified(!document_.undo().isClean());
}

void MainWindow::redraw_layers() {
  if (!view_) return;
  // Only what is seen matters.
  Scene seen = document_.scene();
  // A mode that is switched off is seen all the same.
  for (const SceneMode& mode : document_.scene().modes()) seen.find_mode(mode.name)->enabled = true;
  seen.layers = detail::layers_of(seen);
  Scene compared = seen;
  while (!compared.modes().empty()) compared.remove_mode(std::string(compared.modes().front().name));
  compared.coupling = {};
  const std::string key = to_toml(compared);
  if (key == drawn_) return;
  drawn_ = key;
  const Vec3 towards = view_->view().towards;
  jobs_.begin<Drawing>(
      Jobs::Purpose::draw, tr("drawing"), [seen, towards](std::stop_token) { return draw_for_window(seen, towards); },
      [this, seen](Drawing drawing) { view_->show_drawing(std::move(drawing), seen); },
      [this](const QString& why) { say(why, true); });
}

void MainWindow::edit_strength(std::size_t mode, std::size_t row) {
  const SceneMode& edited = document_.scene().modes()[mode];
  const std::vector<ParameterRow> rows = rows_of([&](ParameterVisitor& v) { look_through(edited.mode, v); });
  const auto* strength = std::get_if<Strength>(&rows[row].value);
  if (!strength) return;
  edited_ = Edited{.what = Edited::What::strength, .mode = edited.name, .number = row};
  if (strength->is_constant()) {
    // As strong as it is, over all values of the field that the mode reads.
    std::string field;
    for (const ParameterRow& one : rows)
      if (const auto* ref = std::get_if<FieldRef>(&one.value); ref && field.empty()) field = ref->name;
    if (field.empty()) return say(tr("This mode reads no field: its strength is a number."));
    if (document_.scene().field({field}).field->components() != 1) field = "magnitude(" + field + ")";
    const Extent extent = document_.scene().field({field}).field->extents()[0];
    const double n = strength->constant_n;
    document_.edit(tr("strength as a function"), -1, [&](Scene& scene) {
      set_row([&](ParameterVisitor& v) { scene.find_mode(edited_->mode)->mode.visit(v); }, row,
              Strength(FieldRef{field}, TransferFunction({{extent.min, n}, {extent.max, n}}, n)));
    });
  }
  show_editor();
}

void MainWindow::edit_mask(std::size_t mode, std::size_t mask) {
  edited_ = Edited{.what = Edited::What::mask, .mode = document_.scene().modes()[mode].name, .number = mask};
  show_editor();
}

void MainWindow::edit_colors(std::size_t layer) {
  edited_ = Edited{.what = Edited::What::colors, .number = layer, .layer = layer};
  show_editor();
}

void MainWindow::show_editor() {
  show_functions();
  editor_dock_->show();
  editor_dock_->raise();
}

void MainWindow::show_functions() {
  if (!edited_) return;
  const Scene& scene = document_.scene();
  FunctionEditor::Shown shown;
  try {
    if (edited_->what == Edited::What::colors) {
      const std::vector<ViewLayer> layers = detail::layers_of(scene);
      if (edited_->number >= layers.size()) return edited_.reset();
      const ViewLayer& layer = layers[edited_->number];
      shown.title = tr("How layer %1 is seen").arg(edited_->number + 1);
      shown.field = layer.field.name;
      shown.colors = layer.colors;
    } else {
      const auto mode =
          std::find_if(scene.modes().begin(), scene.modes().end(), [&](const SceneMode& m) { return m.name == edited_->mode; });
      if (mode == scene.modes().end()) return edited_.reset();
      const QString name = QString::fromStdString(mode->name);
      if (edited_->what == Edited::What::mask) {
        if (edited_->number >= mode->masks.size()) return edited_.reset();
        const Mask& mask = mode->masks[edited_->number];
        shown.title = tr("Where %1 is felt").arg(name);
        shown.field = mask.of.name;
        shown.strength = mask.curve;
        shown.largest = 1.0;
      } else {
        const std::vector<ParameterRow> rows = rows_of([&](ParameterVisitor& v) { look_through(mode->mode, v); });
        const Strength* strength =
            edited_->number < rows.size() ? std::get_if<Strength>(&rows[edited_->number].value) : nullptr;
        if (!strength || strength->is_constant()) return;
        const std::string& group = rows[edited_->number].group;
        shown.title = tr("How strong %1 is felt").arg(group.empty() ? name : name + ", " + QString::fromStdString(group));
        shown.field = strength->of.name;
        shown.strength = strength->curve;
        shown.result_unit = "N";
        shown.largest = 0.1;
        for (const auto& point : strength->curve.points()) shown.largest = std::max(shown.largest, 1.25 * point.result);
        // The scale stays while a point is dragged.
        if (editor_->shown().title == shown.title) shown.largest = std::max(editor_->shown().largest, shown.largest);
      }
    }
    if (edited_->what != Edited::What::colors) {
      // What is seen of the same values is shown with it, where colours say it.
      const std::vector<ViewLayer> layers = detail::layers_of(scene);
      edited_->layer.reset();
      for (std::size_t i = 0; i < layers.size() && !edited_->layer; ++i)
        if (layers[i].field.name == shown.field && layers[i].colors.size() > 1) edited_->layer = i;
      if (edited_->layer) shown.colors = layers[*edited_->layer].colors;
    }
    const VolumeField named = scene.field({shown.field});
    shown.unit = named.unit;
    const std::vector<Extent> extents = named.field->extents();
    shown.low = named.field->components() == 1 ? extents[0].min : 0.0;
    shown.high = extents[0].max;
    for (const Extent& extent : extents) shown.high = std::max(shown.high, extent.max);
    if (shown.colors && shown.colors->empty()) {
      const std::string low = "#303030", high = "#f4ead8";
      shown.colors = {{shown.low, low, 0.0}, {0.5 * (shown.low + shown.high), "#a8907a", 0.3}, {shown.high, high, 0.9}};
    }
    const bool other = editor_->shown().field != shown.field;
    editor_->show_functions(shown);
    if (other)
      jobs_.begin<Histogram>(
          Jobs::Purpose::look, tr("counting values"),
          [field = named.field](std::stop_token) { return statistics(*field).histogram; },
          [this](Histogram histogram) { editor_->show_histogram(histogram); }, [this](const QString& why) { say(why, true); });
  } catch (const std::exception& error) {
    say(QString::fromUtf8(error.what()), true);
  }
}

void MainWindow::give_value_to_level(double value) {
  // The nearest level of the first mode that has levels on this field.
  for (const SceneMode& mode : document_.scene().modes()) {
    const std::vector<ParameterRow> rows = rows_of([&](ParameterVisitor& v) { look_through(mode.mode, v); });
    std::optional<std::size_t> nearest;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      if (rows[i].info.kind != ParameterKind::level) continue;
      const auto away = [&](std::size_t row) { return std::abs(std::get<double>(rows[row].value) - value); };
      if (!nearest || away(i) < away(*nearest)) nearest = i;
    }
    if (!nearest) continue;
    document_.edit(tr("level"), -1, [&](Scene& scene) {
      set_row([&](ParameterVisitor& v) { scene.find_mode(mode.name)->mode.visit(v); }, *nearest, value);
    });
    return say(tr("%1, %2: now at %3")
                   .arg(QString::fromStdString(mode.name), QString::fromStdString(rows[*nearest].group))
                   .arg(value));
  }
}

void MainWindow::play_hand(const PlayedHand& hand) {
  touch_.end();
  played_ = hand;
  played_first_.reset();
  jobs_.begin<FeltTrace>(
      Jobs::Purpose::feel_again, tr("feeling the trace"),
      [hand, loaded = document_.loaded()](std::stop_token stop) { return feel_again(hand, loaded, stop); },
      [this](FeltTrace felt) {
        played_first_ = std::make_shared<const FeltTrace>(std::move(felt));
        player_->show_trace(played_first_);
        player_dock_->show();
        player_dock_->raise();
        if (!second_trace_.empty()) compare_with(std::exchange(second_trace_, {}));
      },
      [this](const QString& why) {
        say(why, true);
        begin_touch();
      });
}

void MainWindow::feel_what_if() {
  jobs_.begin<FeltTrace>(
      Jobs::Purpose::feel_again, tr("feeling the changed scene"),
      [hand = played_, loaded = document_.loaded()](std::stop_token stop) { return feel_again(hand, loaded, stop); },
      [this](FeltTrace felt) {
        felt.name = tr("in the changed scene").toStdString();
        show_beside(std::move(felt));
      },
      [this](const QString& why) { say(why, true); });
}

void MainWindow::compare_with(const fs::path& trace) {
  jobs_.begin<FeltTrace>(
      Jobs::Purpose::feel_again, tr("feeling the second trace"),
      [trace, folders = options_.data_folders](std::stop_token stop) {
        const Opened opened = open_any(trace, folders, stop);
        if (opened.trace.empty()) throw LoadError(trace.string() + ": is no trace; choose the trace.toml of one");
        return feel_again({.trace = trace, .description = {}}, opened.loaded, stop);
      },
      [this](FeltTrace felt) { show_beside(std::move(felt)); }, [this](const QString& why) { say(why, true); });
}

void MainWindow::show_beside(FeltTrace second) {
  if (!played_first_) return;
  const double at_s = player_->at_s();
  player_->show_trace(played_first_, std::make_shared<const FeltTrace>(std::move(second)));
  player_->seek(at_s);
}

void MainWindow::stop_playing() {
  player_->show_trace({});
  played_first_.reset();
  trail_.clear();
  begin_touch();
}

void MainWindow::show_played() {
  if (!player_->has_trace()) return;
  const FeltTrace& trace = *player_->trace();
  const double most_n = document_.scene().coupling.max_force_n;
  trail_.clear();
  for (const std::size_t row : player_->trail(trail_points))
    trail_.push_back({trace.rows[row].proxy_m, norm(trace.rows[row].command_n)});
  const Moment moment = player_->moment();
  if (view_) view_->show_touch(moment, trail_, most_n);
  show_flow_near(moment.proxy_m);
  for (SliceView* slice : slices_) {
    slice->set_cross(moment.proxy_m);
    slice->show_touch(moment, trail_, most_n);
  }
}

void MainWindow::tick() {
  touch_.beat(1e-3 * frame_ms);
  if (film_ && !player_->has_trace()) film(false);
  if (film_) return film_next();
  if (player_->has_trace()) player_->pass(1e-3 * frame_ms);
  if (!touch_.is_felt() || pages_->currentIndex() != 1) return;
  const Moment& moment = touch_.moment();
  const double most_n = document_.scene().coupling.max_force_n;
  if (moment.tick >= 0) {
    // A hand that was put elsewhere leaves no trail on the way.
    if (!trail_.empty() && distance(trail_.back().at_m, moment.proxy_m) > jump_m) trail_.clear();
    if (trail_.empty() || distance(trail_.back().at_m, moment.proxy_m) > 2e-4)
      trail_.push_back({moment.proxy_m, norm(moment.command_n)});
    if (trail_.size() > trail_points) trail_.erase(trail_.begin());
    if (view_) view_->show_touch(moment, trail_, most_n);
    show_flow_near(moment.proxy_m);
    for (SliceView* slice : slices_) {
      if (is_held_) slice->set_cross(moment.proxy_m);
      slice->show_touch(moment, trail_, most_n);
    }
  }
  instruments_->update_from(touch_.samples());
  if (ticks_++ % 8 == 0) {
    LiveLoop& loop = *touch_.loop();
    const LiveView& seen = loop.look();
    const LoopAccount account = loop.account();
    instruments_->show_account(account, seen.frame, seen.device_fault);
    if (touch_.is_recorded() && account.unrecorded > unrecorded_)
      say(tr("%1 ticks could not be recorded: the disk is full or too slow. What was written before stays in %2; press R to "
             "end the "
             "recording.")
              .arg(account.unrecorded)
              .arg(QString::fromStdString(touch_.trace().string())),
          true);
    unrecorded_ = account.unrecorded;
  }
  if (const std::string problem = touch_.take_problem(); !problem.empty()) say(QString::fromStdString(problem), true);
  if (view_)
    view_->show_words(words_of_fault(),
                      hint_seen_
                          ? QString()
                          : tr("Press on the surface and drag to feel it; the wheel presses deeper. Drag beside it to turn."));
}

QString MainWindow::words_of_fault() {
  if (touch_.is_held()) return tr("No force: press Space to feel again");
  LiveLoop* loop = touch_.loop();
  if (!loop) return {};
  const LiveView& seen = loop->look();
  if (seen.device_fault) return QString(seen.device_fault);
  if (touch_.is_by_mouse() && seen.frame.guard_cause == GuardCause::no_position) return {};
  switch (seen.frame.guard_cause) {
    case GuardCause::not_finite: return tr("The force is no number: the scene has a fault. Undo the last change.");
    case GuardCause::no_position: return tr("The device does not know where it is: move it to its start position.");
    case GuardCause::link_lost: return tr("The device does not answer: check its cable and power.");
    case GuardCause::speed: return tr("The hand was too fast: hold still for a moment.");
    default: return {};
  }
}

void MainWindow::record(bool on) {
  if (!document_.is_open()) return record_->setChecked(false);
  if (!on) {
    const QString folder = QString::fromStdString(touch_.trace().string());
    const std::string lost = touch_.end();
    lost.empty() ? say(tr("Recorded in %1").arg(folder)) : say(QString::fromStdString(lost), true);
    return begin_touch();
  }
  const QString folder = settings_.value("traces", QDir::homePath()).toString();
  const QString name =
      QFileInfo(document_.opened().title).completeBaseName() + QDateTime::currentDateTime().toString("-yyyyMMdd-HHmmss");
  begin_touch(fs::path(QDir(folder).filePath(name).toStdString()));
}

bool MainWindow::save(bool under_another_name) {
  if (!document_.is_open()) return false;
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
    say(tr("Saved as %1").arg(QString::fromStdString(file.string())));
    return true;
  } catch (const std::exception& error) {
    say(QString::fromUtf8(error.what()), true);
    return false;
  }
}

void MainWindow::screenshot() {
  if (!document_.is_open()) return;
  const QString folder =
      settings_.value("pictures", QStandardPaths::writableLocation(QStandardPaths::PicturesLocation)).toString();
  QDir().mkpath(folder);
  const QString file = QDir(folder).filePath("palpa" + QDateTime::currentDateTime().toString("-yyyyMMdd-HHmmss-zzz") + ".png");
  const QImage picture = view_ ? view_->picture() : pages_->grab().toImage();
  picture.save(file) ? say(tr("Saved %1").arg(file))
                     : say(tr("%1: cannot be written; free some space or change the folder's rights").arg(file), true);
}

void MainWindow::show_flow_near(const Vec3& proxy_m) {
  if (!view_ || !flow_ || distance(proxy_m, flow_seen_at_m_) < flow_step_m) return;
  flow_seen_at_m_ = proxy_m;
  const Vec3 reach{flow_reach_m, flow_reach_m, flow_reach_m};
  const Box near = detail::shared_part(flow_->bounds_m(), {proxy_m - reach, proxy_m + reach});
  if (!(largest_component(near.size_m()) > 0.0)) return view_->show_streamlines({});
  view_->show_streamlines(detail::streamlines(*flow_, near, flow_lines));
}

void MainWindow::film(bool on) {
  if (!on || !player_->has_trace()) {
    if (on) say(tr("A film is of a trace: open one, or play a hand (Ctrl+T)."));
    film_.reset();
    film_action_->setChecked(false);
    return;
  }
  const QString folder =
      QDir(settings_.value("pictures", QStandardPaths::writableLocation(QStandardPaths::PicturesLocation)).toString())
          .filePath("palpa-film" + QDateTime::currentDateTime().toString("-yyyyMMdd-HHmmss"));
  if (!QDir().mkpath(folder)) {
    film_action_->setChecked(false);
    return say(tr("%1: cannot be made; change the folder's rights or free some space").arg(folder), true);
  }
  player_->play(false);
  player_->seek(0.0);
  film_ = Film{.folder = folder};
}

void MainWindow::film_next() {
  const auto end = [this] {
    film_.reset();
    film_action_->setChecked(false);
  };
  const QString file = QDir(film_->folder).filePath(QString("%1.png").arg(film_->picture, 5, 10, QChar('0')));
  if (!(view_ ? view_->picture() : pages_->grab().toImage()).save(file)) {
    say(tr("%1: cannot be written; free some space. The pictures before it are there.").arg(file), true);
    return end();
  }
  const double t_s = ++film_->picture / film_hz;
  const double duration_s = player_->trace()->duration_s;
  message_->setText(tr("Filming %1 s of %2 s into %3").arg(t_s, 0, 'f', 1).arg(duration_s, 0, 'f', 1).arg(film_->folder));
  message_bar_->show();
  if (t_s <= duration_s) return player_->seek(t_s);
  const QString folder = film_->folder, ffmpeg = QStandardPaths::findExecutable("ffmpeg");
  const int pictures = film_->picture;
  end();
  if (ffmpeg.isEmpty())
    return say(tr("%1 pictures in %2; with ffmpeg installed they would be a film, too").arg(pictures).arg(folder));
  jobs_.begin<int>(
      Jobs::Purpose::film, tr("making the film"),
      [folder, ffmpeg](std::stop_token stop) {
        QProcess process;
        process.setProcessChannelMode(QProcess::ForwardedChannels);
        // An even number of pixels each way is what most players need.
        process.start(
            ffmpeg, {"-y", "-nostdin", "-loglevel", "error", "-framerate", QString::number(film_hz), "-i", folder + "/%05d.png",
                     "-vf", "crop=trunc(iw/2)*2:trunc(ih/2)*2", "-pix_fmt", "yuv420p", folder + "/film.mp4"});
        while (!process.waitForFinished(100) && process.state() != QProcess::NotRunning)
          if (stop.stop_requested()) process.kill();
        return process.exitStatus() == QProcess::NormalExit && process.error() == QProcess::UnknownError ? process.exitCode()
                                                                                                         : -1;
      },
      [this, folder](int code) {
        code == 0 ? say(tr("The film is %1/film.mp4").arg(folder))
                  : say(tr("ffmpeg made no film (code %1); its pictures are in %2").arg(code).arg(folder), true);
      },
      [this](const QString& why) { say(why, true); });
}

void MainWindow::show_help() { (new HelpSheet(actions(), this))->show(); }

void MainWindow::ask_file() {
  const QString folder = settings_.value("folder", QDir::homePath()).toString();
  const QString file = QFileDialog::getOpenFileName(this, tr("Open a scene, data, or a trace (its trace.toml)"), folder);
  if (file.isEmpty()) return;
  settings_.setValue("folder", QFileInfo(file).absolutePath());
  const fs::path path = file.toStdString();
  open(path.filename() == "trace.toml" ? path.parent_path() : path);
}

void MainWindow::remember(const fs::path& path) {
  QStringList recent = settings_.value("recent").toStringList();
  const QString name = QString::fromStdString(fs::absolute(path).lexically_normal().string());
  recent.removeAll(name);
  recent.prepend(name);
  while (recent.size() > most_recent) recent.removeLast();
  settings_.setValue("recent", recent);
  start_page_->show_recent(recent);
}

void MainWindow::say(const QString& words, bool is_problem) {
  message_->setText(words);
  message_bar_->setStyleSheet(is_problem ? "QFrame#message_bar { background: #fbe3dc; } QLabel { color: #5c1a0c; }"
                                         : "QFrame#message_bar { background: #e3eefb; } QLabel { color: #12304f; }");
  message_bar_->show();
  if (!is_problem)
    QTimer::singleShot(8000, message_bar_, [this, words] {
      if (message_->text() == words) message_bar_->hide();
    });
}

void MainWindow::show_job() {
  const QString words = jobs_.words();
  job_words_->setText(words);
  for (QWidget* widget :
       {static_cast<QWidget*>(job_words_), static_cast<QWidget*>(job_bar_), static_cast<QWidget*>(job_cancel_)})
    widget->setVisible(!words.isEmpty());
}

void MainWindow::dragEnterEvent(QDragEnterEvent* event) {
  if (event->mimeData()->hasUrls()) event->acceptProposedAction();
}

void MainWindow::dropEvent(QDropEvent* event) {
  for (const QUrl& url : event->mimeData()->urls()) {
    if (!url.isLocalFile()) continue;
    const fs::path path = url.toLocalFile().toStdString();
    open(path.filename() == "trace.toml" ? path.parent_path() : path);
    break;
  }
}

void MainWindow::closeEvent(QCloseEvent* event) {
  // First of all the motors.
  const std::string lost = touch_.end();
  if (!lost.empty()) std::fprintf(stderr, "palpa-explorer: %s\n", lost.c_str());
  timer_.stop();
  // What was not saved is kept where the next start finds it.
  if (document_.is_open() && !document_.undo().isClean()) {
    const QString folder = QStandardPaths::writableLocation(QStandardPaths::AppDataLocation);
    QDir().mkpath(folder);
    const QString file = folder + "/unsaved-" + QFileInfo(document_.opened().title).completeBaseName() + ".toml";
    if (QFile out(file); out.open(QIODevice::WriteOnly) && out.write(QByteArray::fromStdString(document_.text())) >= 0) {
      std::fprintf(stderr, "The scene was not saved; it is kept in %s\n", qPrintable(file));
      remember(file.toStdString());
    }
  }
  event->accept();
}

}  // namespace palpa::explorer
