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
#include <QMimeData>
#include <QProgressBar>
#include <QScrollArea>
#include <QSplitter>
#include <QStackedWidget>
#include <QStandardPaths>
#include <QStatusBar>
#include <QTabWidget>
#include <QToolButton>
#include <QVBoxLayout>
#include <algorithm>

#include "explorer/opening.h"
#include "explorer/picture_file.h"
#include "explorer/presets.h"
#include "palpa/core/shown.h"
#include "palpa/device/open_device.h"
#include "palpa/disk/new_file.h"
#include "palpa/scene/parts.h"
#include "palpa/study/check.h"
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

  message_ = new MessageBar;
  auto* central = new QWidget;
  auto* stack = new QVBoxLayout(central);
  stack->setContentsMargins(0, 0, 0, 0);
  stack->setSpacing(0);
  stack->addWidget(message_);
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
      if (desk_->isVisible()) return desk_->give_value_to_level(value);
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
  desk_ = new FunctionDesk(document_, jobs_, options_.has_opengl);
  addDockWidget(Qt::BottomDockWidgetArea, desk_);
  desk_->hide();
  connect(desk_, &FunctionDesk::said, this, &MainWindow::say);
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
  connect(player_, &Player::moved, this, &MainWindow::show_played);
  film_ = new Film(
      *player_, jobs_, [this] { return picture(); }, this);
  connect(film_, &Film::said, this, &MainWindow::say);
  connect(player_dock_->toggleViewAction(), &QAction::toggled, this, [this](bool shown) {
    if (!shown && player_->has_trace() && !player_dock_->isVisible()) stop_playing();
  });
  setCorner(Qt::BottomRightCorner, Qt::RightDockWidgetArea);
  scene_docks_ = {panel, below};
  for (QDockWidget* dock : scene_docks_) dock->hide();  // until there is a scene
}

void MainWindow::open(const fs::path& path, const fs::path& second_trace) {
  const QString name = QString::fromStdString(path.filename().string());
  jobs_.begin<Opened>(
      Jobs::Purpose::open, tr("reading %1").arg(name),
      [path, folders = options_.data_folders](std::stop_token stop) { return open_any(path, folders, stop); },
      [this, path, second_trace](Opened opened) {
        remember(path);
        message_->hide();
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
  using Checked = std::pair<std::unique_ptr<Device>, std::string>;  // and what a quick check says of the scene on it
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
  if (desk_->isVisible()) desk_->refresh();
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
  if (film_->is_under_way()) return film_->next();
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
  if (view_) view_->show_words(words_of_fault(), words_of_hint());
}

QString MainWindow::words_of_hint() const {
  const bool is_empty = view_->drawing().solid.empty() && view_->drawing().shells.empty();
  if (is_empty && jobs_.is_under_way(Jobs::Purpose::draw))
    return tr("The surfaces are being drawn; the slices can be touched.");
  if (hint_seen_) return {};
  return tr("Press on the surface and drag to feel it; the wheel presses deeper. Drag beside it to turn.");
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

QImage MainWindow::picture() { return view_ ? view_->picture() : pages_->grab().toImage(); }

QString MainWindow::picture_path(const QString& name, const QString& time) const {
  const QString folder =
      settings_.value("pictures", QStandardPaths::writableLocation(QStandardPaths::PicturesLocation)).toString();
  return QDir(folder).filePath(name + QDateTime::currentDateTime().toString(time));
}

void MainWindow::screenshot() {
  if (!document_.is_open()) return;
  const QString file = picture_path("palpa", "-yyyyMMdd-HHmmss-zzz") + ".png";
  QDir().mkpath(QFileInfo(file).path());
  try {
    save_picture(picture(), file);
    say(tr("Saved %1").arg(file));
  } catch (const LoadError& error) {
    say(QString::fromUtf8(error.what()), true);
  }
}

void MainWindow::show_flow_near(const Vec3& proxy_m) {
  if (!view_ || !flow_ || distance(proxy_m, flow_seen_at_m_) < flow_step_m) return;
  flow_seen_at_m_ = proxy_m;
  const Vec3 reach{flow_reach_m, flow_reach_m, flow_reach_m};
  const Box near = detail::shared_part(flow_->bounds_m(), {proxy_m - reach, proxy_m + reach});
  if (!(largest_component(near.size_m()) > 0.0)) return view_->show_streamlines({});
  view_->show_streamlines(detail::streamlines(*flow_, near, flow_lines));
}

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

void MainWindow::say(const QString& words, bool is_problem) { message_->say(words, is_problem); }

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
  if (!lost.empty()) std::fprintf(stderr, "palpa-explorer: %s\n", detail::shown(lost).c_str());
  timer_.stop();
  // What was not saved is kept where the next start finds it.
  if (document_.is_open() && !document_.undo().isClean()) {
    const QString folder = QStandardPaths::writableLocation(QStandardPaths::AppDataLocation);
    QDir().mkpath(folder);
    const QString file = folder + "/unsaved-" + QFileInfo(document_.opened().title).completeBaseName() + ".toml";
    try {
      detail::write_whole(file.toStdString(), document_.text(), detail::Existing::replaced);
      std::fprintf(stderr, "The scene was not saved; it is kept in %s\n", detail::shown(file.toStdString()).c_str());
      remember(file.toStdString());
    } catch (const LoadError& error) {
      std::fprintf(stderr, "palpa-explorer: %s\n", detail::shown(error.what()).c_str());
    }
  }
  event->accept();
}

}  // namespace palpa::explorer
