// Menus, tool bar and keys of the main window.
#include <QAction>
#include <QApplication>
#include <QDockWidget>
#include <QFileDialog>
#include <QMenuBar>
#include <QStackedWidget>
#include <QToolBar>
#include <QToolButton>

#include "explorer/help_sheet.h"
#include "explorer/main_window.h"

namespace palpa::explorer {

namespace fs = std::filesystem;

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

  const QList<QAction*> opening = make_opening_actions();
  QAction* open_file = opening.front();
  QAction* save_scene = action(tr("&Save scene"), QKeySequence::Save, tr("Save the scene"), [this] { save(false); });
  file->addActions(opening);
  file->addAction(save_scene);
  file->addAction(action(tr("Save scene &as …"), QKeySequence("Ctrl+Shift+S"), tr("Save the scene under another name"),
                         [this] { save(true); }));
  file->addAction(action(tr("Save a &picture"), QKeySequence("Ctrl+P"), tr("Save the view as PNG"), [this] { screenshot(); }));
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

  View3D* view = views_->view();
  const auto from = [view](double x, double y, double z) {
    if (view) view->look_from({x, y, z}, std::abs(y) > 0.9 ? Vec3{0, 0, -y} : Vec3{0, 1, 0});
  };
  look->addAction(action(tr("Show &all"), QKeySequence("Home"), tr("Show all of the data"), [view] {
    if (view) view->show_all();
  }));
  look->addAction(
      action(tr("From the &front"), QKeySequence("1"), tr("Look from the side of the hand"), [from] { from(0, 0, 1); }));
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
                         Key{QT_TR_NOOP("Zoom in"), "+", 0, 0, 1.15}, Key{QT_TR_NOOP("Zoom out"), "-", 0, 0, 1 / 1.15}}) {
    QAction* one = action(tr(key.words), QKeySequence(key.keys), tr(key.words), [view, key] {
      if (!view) return;
      key.zoom == 1.0 ? view->turn(key.right_deg, key.up_deg) : view->zoom(key.zoom);
    });
    // In other widgets the arrow keys belong to sliders and boxes.
    one->setShortcutContext(Qt::WidgetShortcut);
    if (view) view->addAction(one);
    look->addAction(one);
  }
  look->addAction(action(tr("&Marks"), QKeySequence("M"), tr("Scale bar, directions and legend"), [view] {
    if (view) view->show_marks(!view->shows_marks());
  }));
  look->addAction(action(tr("&Stereo"), QKeySequence("S"), tr("Flat, red-cyan, or side by side"), [view] {
    if (!view) return;
    view->set_stereo(static_cast<View3D::Stereo>((static_cast<int>(view->stereo()) + 1) % 3));
  }));
  look->addAction(action(tr("&Full screen"), QKeySequence("F11"), tr("Full screen"),
                         [this] { setWindowState(windowState() ^ Qt::WindowFullScreen); }));
  for (QDockWidget* dock : findChildren<QDockWidget*>()) look->addAction(dock->toggleViewAction());

  hold_ = action(tr("Force &off"), QKeySequence("Space"), tr("Turn the force off and on"), [this] {
    touch_.is_held() ? touch_.resume() : touch_.panic();
    hold_->setChecked(touch_.is_held());
  });
  hold_->setCheckable(true);
  record_ = action(tr("&Record"), QKeySequence("R"), tr("Record a trace"), [this] { record(record_->isChecked()); });
  record_->setCheckable(true);
  feel->addAction(hold_);
  feel->addAction(record_);
  feel->addSeparator();
  feel->addAction(action(tr("Play a &stroke"), QKeySequence("Ctrl+T"), tr("A simulated hand strokes the surface"), [this] {
    if (document_.is_open()) play({.trace = {}, .description = "sim:stroke"});
  }));
  feel->addAction(action(tr("Play a &recorded hand …"), QKeySequence("Ctrl+R"), tr("A recording moves the hand"), [this] {
    if (!document_.is_open()) return;
    const QString recording = QFileDialog::getOpenFileName(this, tr("A recorded hand"), settings_.folder());
    if (!recording.isEmpty()) play({.trace = {}, .description = recording.toStdString()});
  }));
  feel->addAction(action(tr("Compare with another &trace …"), QKeySequence("Ctrl+Shift+T"),
                         tr("Show a second trace beside the one that is open"), [this] {
                           if (!player_->has_trace()) return say(tr("Open a trace first, or play a hand (Ctrl+T)."));
                           const QString header = QFileDialog::getOpenFileName(this, tr("The second trace (its trace.toml)"),
                                                                               settings_.folder(), tr("Traces (trace.toml)"));
                           if (!header.isEmpty()) compare_with(fs::path(header.toStdString()).parent_path());
                         }));
  feel->addAction(action(tr("&Play and pause"), QKeySequence("P"), tr("Play and pause the trace"), [this] {
    if (QToolButton* play = player_->findChild<QToolButton*>("play")) play->toggle();
  }));
  QAction* film = action(tr("&Film"), QKeySequence("Ctrl+F"), tr("Make a film of the trace, as PNG pictures and with ffmpeg"),
                         [this] { film_->is_under_way() ? film_->end() : film_->begin(settings_.new_film()); });
  film->setCheckable(true);
  connect(film_, &Film::ended, film, [film] { film->setChecked(false); });
  feel->addAction(film);
  feel->addAction(action(tr("Next &break-through"), QKeySequence("N"), tr("Go to the next break-through of the trace"),
                         [this] { player_->step_to_event(1); }));
  feel->addAction(action(tr("Pre&vious break-through"), QKeySequence("B"), tr("Go to the previous break-through"),
                         [this] { player_->step_to_event(-1); }));
  feel->addAction(action(tr("Back to my &hand"), QKeySequence("Escape"), tr("Leave the trace: back to your own hand"), [this] {
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
                               scene.edit_mode(name, [](SceneMode& mode) { mode.enabled = !mode.enabled; });
                             });
                           }));
  }
  help->addAction(action(tr("&Keys and mouse"), QKeySequence("F1"), tr("Keys and mouse actions"),
                         [this] { (new HelpSheet(actions(), this))->show(); }));

  auto* bar = addToolBar(tr("Main"));
  bar->setObjectName("main_bar");
  bar->setMovable(false);
  bar->setToolButtonStyle(Qt::ToolButtonTextOnly);
  for (QAction* one : {open_file, save_scene, undo, redo}) bar->addAction(one);
  bar->addSeparator();
  bar->addAction(record_);
  bar->addAction(hold_);
}

}  // namespace palpa::explorer
