// Menus, tool bar and keys of the main window.
#include <QAction>
#include <QActionGroup>
#include <QApplication>
#include <QCheckBox>
#include <QDialogButtonBox>
#include <QDir>
#include <QDockWidget>
#include <QFileDialog>
#include <QFileInfo>
#include <QFormLayout>
#include <QGridLayout>
#include <QHBoxLayout>
#include <QLineEdit>
#include <QMenuBar>
#include <QMessageBox>
#include <QSpinBox>
#include <QStackedWidget>
#include <QStatusBar>
#include <QStyle>
#include <QToolBar>
#include <QToolButton>

#include "explorer/help_sheet.h"
#include "explorer/main_window.h"
#include "explorer/picture_file.h"
#include "palpa/base/load_error.h"
#include "palpa/version.h"

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

void MainWindow::make_file_actions() {
  QMenu* file = menuBar()->addMenu(tr("&File"));
  const QList<QAction*> opening = make_opening_actions();
  opening.front()->setIcon(style()->standardIcon(QStyle::SP_DialogOpenButton));
  QAction* save_scene = action(tr("&Save scene"), QKeySequence::Save, tr("Save the scene"), [this] { save(false); });
  save_scene->setIcon(style()->standardIcon(QStyle::SP_DialogSaveButton));
  file->addActions(opening);
  QMenu* recent = file->addMenu(tr("&Recent"));
  recent->setObjectName("recent");
  connect(recent, &QMenu::aboutToShow, this, [this, recent] { make_recent(recent); });
  file->addAction(save_scene);
  file->addAction(action(tr("Save scene &as …"), QKeySequence("Ctrl+Shift+S"), tr("Save the scene under another name"),
                         [this] { save(true); }));
  file->addAction(action(tr("Save a &picture"), QKeySequence("Ctrl+P"), tr("Save the view as PNG"), [this] { screenshot(); }));
  file->addAction(action(tr("Save a picture of a si&ze …"), QKeySequence("Ctrl+Shift+P"),
                         tr("Save the view as PNG of a chosen size and name"), [this] { picture_of_size(); }));
  file->addAction(action(tr("&Start page"), QKeySequence("Ctrl+Home"), tr("The scenes that come with Palpa"),
                         [this] { pages_->setCurrentIndex(0); }));
  file->addSeparator();
  file->addAction(action(tr("&Quit"), QKeySequence("Ctrl+Q"), tr("End Palpa"), [this] {
    if (may_close()) close();
  }));
  tools_ = {opening.front(), save_scene};
}

void MainWindow::make_recent(QMenu* menu) {
  menu->clear();
  for (const QString& file : settings_.recent()) {
    const QString words = words_of_recent(file), path = QDir::toNativeSeparators(file);
    const bool is_unsaved = words != QFileInfo(file).fileName();
    menu->addAction(is_unsaved ? words + "   –   " + path : path, this, [this, file] { open(file.toStdString()); });
  }
  if (menu->isEmpty()) menu->addAction(tr("No file yet"))->setEnabled(false);
}

void MainWindow::make_actions() {
  make_file_actions();
  make_edit_actions();
  make_view_actions();
  make_feel_actions();
  make_help_actions();
  make_tool_bar();
}

void MainWindow::make_edit_actions() {
  QMenu* edit = menuBar()->addMenu(tr("&Edit"));
  QAction* undo = document_.undo().createUndoAction(this, tr("Undo"));
  undo->setShortcut(QKeySequence::Undo);
  QAction* redo = document_.undo().createRedoAction(this, tr("Redo"));
  redo->setShortcut(QKeySequence::Redo);
  undo->setIcon(style()->standardIcon(QStyle::SP_ArrowBack));
  redo->setIcon(style()->standardIcon(QStyle::SP_ArrowForward));
  edit->addAction(undo);
  edit->addAction(redo);
  tools_ << undo << redo;
}

void MainWindow::make_feel_actions() {
  QMenu* feel = menuBar()->addMenu(tr("F&eel"));
  hold_ = action(tr("Force &off"), QKeySequence("Space"), tr("Turn the force off and on"), [this] {
    touch_.is_held() ? touch_.resume() : touch_.panic();
    hold_->setChecked(touch_.is_held());
  });
  hold_->setCheckable(true);
  record_ = action(tr("&Record"), QKeySequence("R"), tr("Record a trace"), [this] { record(record_->isChecked()); });
  record_->setCheckable(true);
  next_hand_ = action(tr("&Other hand"), QKeySequence("H"), tr("The mouse leads another hand of the scene"),
                      [this] { lead_hand(static_cast<int>(touch_.led()) + 1); });
  feel->addAction(hold_);
  feel->addAction(record_);
  feel->addAction(next_hand_);
  feel->addSeparator();
  feel->addAction(action(tr("Simulated &hand"), QKeySequence("Ctrl+T"), tr("A simulated hand strokes the surface"), [this] {
    if (document_.is_open()) play({.trace = {}, .description = "sim:stroke", .number = touch_.led()});
  }));
  feel->addAction(action(tr("&Recorded hand …"), QKeySequence("Ctrl+R"), tr("A recording moves the hand"), [this] {
    if (!document_.is_open()) return;
    const QString recording = QFileDialog::getOpenFileName(this, tr("A recorded hand"), settings_.traces());
    if (!recording.isEmpty()) play({.trace = {}, .description = recording.toStdString(), .number = touch_.led()});
  }));
  make_trace_actions(feel);
  make_mode_actions(feel);
}

void MainWindow::make_trace_actions(QMenu* feel) {
  feel->addAction(action(tr("Compare with another &trace …"), QKeySequence("Ctrl+Shift+T"),
                         tr("Show a second trace beside the one that is open"), [this] {
                           if (!player_->has_trace()) return say(tr("Open a trace first, or play a hand (Ctrl+T)."));
                           ask_trace(tr("The second trace (its trace.toml)"),
                                     [this](const fs::path& trace) { compare_with(trace); });
                         }));
  feel->addAction(action(tr("&Play and pause"), QKeySequence("P"), tr("Play and pause the trace, or moving data"), [this] {
    QWidget* const bar = player_->has_trace() ? static_cast<QWidget*>(player_) : time_bar_;
    if (auto* play = bar->findChild<QToolButton*>("play")) play->toggle();
  }));
  const auto film = [this, feel](const QString& words, const char* keys, const QString& tip, std::function<QImage()> picture) {
    QAction* made = action(words, QKeySequence(keys), tip, [this, picture] {
      film_->is_under_way() ? film_->end() : film_->begin(settings_.new_film(), picture);
    });
    made->setCheckable(true);
    connect(film_, &Film::ended, made, [made] { made->setChecked(false); });
    feel->addAction(made);
  };
  film(tr("&Film"), "Ctrl+F", tr("Make a film of the trace, as PNG pictures and with ffmpeg"), [this] { return picture(); });
  film(tr("Film of the &window"), "Ctrl+Shift+F", tr("Make a film with slices, curves and both hands"),
       [this] { return grab().toImage().convertToFormat(QImage::Format_RGB32); });
  feel->addAction(action(tr("Next &event"), QKeySequence("N"), tr("Go to the next event of the trace"),
                         [this] { player_->step_to_event(1); }));
  feel->addAction(action(tr("Pre&vious event"), QKeySequence("B"), tr("Go to the previous event of the trace"),
                         [this] { player_->step_to_event(-1); }));
  feel->addAction(action(tr("Back to my &hand"), QKeySequence("Escape"), tr("Leave the trace: back to your own hand"), [this] {
    if (!player_->has_trace()) return;
    player_dock_->hide();
    if (player_->has_trace()) stop_playing();
  }));
}

void MainWindow::make_mode_actions(QMenu* feel) {
  feel->addSeparator();
  for (int number = 0; number < 9; ++number) {
    mode_actions_ << action({}, QKeySequence(QString("Ctrl+%1").arg(number + 1)), tr("Turn a mode on or off"), [this, number] {
      if (!document_.is_open() || document_.scene().modes().size() <= static_cast<std::size_t>(number)) return;
      const std::string name = document_.scene().modes()[static_cast<std::size_t>(number)].name;
      document_.edit(tr("turn %1 on or off").arg(QString::fromStdString(name)), -1,
                     [&](Scene& scene) { scene.edit_mode(name, [](SceneMode& mode) { mode.enabled = !mode.enabled; }); });
    });
    mode_actions_.last()->setCheckable(true);
    mode_actions_.last()->setVisible(false);
    feel->addAction(mode_actions_.last());
  }
}

void MainWindow::make_help_actions() {
  QMenu* help = menuBar()->addMenu(tr("&Help"));
  help->addAction(action(tr("&Keys and mouse"), QKeySequence("F1"), tr("Keys and mouse actions"),
                         [this] { (new HelpSheet(actions(), this))->show(); }));
  help->addAction(action(tr("&Pages"), QKeySequence("Shift+F1"), tr("Pages of the documentation"), [this] {
    const fs::path folder = pages_folder();
    if (folder.empty()) return say(tr("The pages are not installed: the package libpalpa-dev has them."));
    (new Pages(folder / "explorer.md", this))->show();
  }));
  help->addAction(action(tr("&About Palpa"), {}, tr("Version and licence"), [this] {
    QMessageBox::about(this, tr("About Palpa"),
                       tr("Palpa %1\nTouch volumetric data by haptics.\nLicence: Apache 2.0. Manual: palpa explore --help, and "
                          "Help ▸ Pages.")
                           .arg(version));
  }));
}

void MainWindow::make_view_actions() {
  QMenu* look = menuBar()->addMenu(tr("&View"));
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
  look->addAction(action(tr("&Cut open"), QKeySequence("C"),
                         tr("Hide what is in front of the slice that faces you; that slice's wheel moves the cut"), [view] {
                           if (view) view->set_cut(!view->is_cut());
                         }));
  look->addAction(action(tr("&Stereo"), QKeySequence("S"), tr("Flat, red-cyan, or side by side"), [view] {
    if (!view) return;
    view->set_stereo(static_cast<View3D::Stereo>((static_cast<int>(view->stereo()) + 1) % 3));
  }));
  make_layout_actions(look);
  for (QDockWidget* dock : findChildren<QDockWidget*>()) look->addAction(dock->toggleViewAction());
  QAction* instruments = scene_docks_[1]->toggleViewAction();
  instruments->setShortcut(QKeySequence("I"));
  instruments->setStatusTip(tr("Show or hide the force curve, on the full screen, too"));
  addAction(instruments);  // the full screen has no menu
}

void MainWindow::make_layout_actions(QMenu* look) {
  look->addSeparator();
  struct Layout {
    const char* words;
    SceneViews::Layout layout;
  };
  for (const Layout& one : {Layout{QT_TR_NOOP("Slices &beside"), SceneViews::Layout::slices_beside},
                            Layout{QT_TR_NOOP("Slices be&low"), SceneViews::Layout::slices_below},
                            Layout{QT_TR_NOOP("&Without slices"), SceneViews::Layout::without_slices},
                            Layout{QT_TR_NOOP("Slices al&one"), SceneViews::Layout::slices_alone}})
    look->addAction(
        action(tr(one.words), {}, tr("Layout of the views"), [this, one] { views_->set_layout_of_views(one.layout); }));
  look->addAction(
      action(tr("Next la&yout"), QKeySequence("L"), tr("Next layout of the views; a double click enlarges one"), [this] {
        const int next = (static_cast<int>(views_->layout_of_views()) + 1) % 4;
        views_->set_layout_of_views(static_cast<SceneViews::Layout>(next));
      }));
  look->addSeparator();
  look->addAction(action(tr("&Full screen"), QKeySequence("F11"),
                         tr("The views alone, on the full screen; I adds the force curve"),
                         [this] { present(!isFullScreen()); }));
  look->addAction(action(tr("&Dark"), {}, tr("Dark or light colours"),
                         [this] { set_dark(palette().color(QPalette::Window).lightness() >= 128); }));
}

void MainWindow::make_tool_bar() {
  const auto disc = [](const QColor& color, bool square) {
    QPixmap sign(16, 16);
    sign.fill(Qt::transparent);
    QPainter painter(&sign);
    painter.setRenderHint(QPainter::Antialiasing);
    painter.setPen(Qt::NoPen);
    painter.setBrush(color);
    square ? painter.drawRect(2, 2, 12, 12) : painter.drawEllipse(2, 2, 12, 12);
    return QIcon(sign);
  };
  record_->setIcon(disc(QColor(200, 30, 20), false));
  hold_->setIcon(disc(Qt::white, true));
  auto* pointer = new QActionGroup(this);
  QAction* touch = action(tr("&Touch"), {}, tr("A left drag on the surface touches it"), [this] {
    if (views_->view()) views_->view()->set_turning(false);
  });
  QAction* turn = action(tr("T&urn"), {}, tr("A left drag turns the view, on the surface, too"), [this] {
    if (views_->view()) views_->view()->set_turning(true);
  });
  touch->setObjectName("touch");
  turn->setObjectName("turn");
  for (QAction* one : {touch, turn}) {
    one->setCheckable(true);
    pointer->addAction(one);
  }
  touch->setChecked(true);
  action(tr("Touch or turn"), QKeySequence("T"), tr("A left drag touches, or turns the view"),
         [touch, turn] { (touch->isChecked() ? turn : touch)->trigger(); });
  auto* bar = addToolBar(tr("Main"));
  bar->setObjectName("main_bar");
  bar->setMovable(false);
  bar->setIconSize({18, 18});
  bar->setToolButtonStyle(Qt::ToolButtonTextBesideIcon);
  for (QAction* one : tools_) bar->addAction(one);
  bar->addSeparator();
  bar->addAction(touch);
  bar->addAction(turn);
  bar->addSeparator();
  make_hand_box();
  hand_box_action_ = bar->addWidget(hand_box_);
  for (QAction* one : {hand_box_action_, next_hand_}) one->setVisible(false);
  bar->addAction(record_);
  bar->addAction(hold_);
  // The safety action stands out.
  bar->widgetForAction(hold_)->setStyleSheet(
      "QToolButton { background: #b02a14; color: white; font-weight: bold; border-radius: 4px; padding: 3px 10px; }"
      "QToolButton:checked { background: #5c1a0c; }");
  bar->widgetForAction(record_)->setObjectName("record_button");
  message_place_ = new QWidget;
  message_place_->setSizePolicy(QSizePolicy::Expanding, QSizePolicy::Ignored);
  place_message(false);
  bar->addWidget(message_place_);
}

void MainWindow::name_modes() {
  const std::vector<SceneMode>& modes = document_.scene().modes();
  for (int number = 0; number < mode_actions_.size(); ++number) {
    const bool is_there = static_cast<std::size_t>(number) < modes.size();
    mode_actions_[number]->setVisible(is_there);
    if (!is_there) continue;
    mode_actions_[number]->setText(QString::fromStdString(modes[static_cast<std::size_t>(number)].name));
    mode_actions_[number]->setChecked(modes[static_cast<std::size_t>(number)].enabled);
  }
}

void MainWindow::show_recording() {
  const bool on = touch_.is_recorded();
  const int seconds = on ? static_cast<int>(touch_.moment().t_s) : 0;
  const QString words = on ? tr("Recording %1:%2").arg(seconds / 60).arg(seconds % 60, 2, 10, QChar('0')) : tr("&Record");
  if (words == record_->text()) return;
  record_->setText(words);
  if (QWidget* button = findChild<QWidget*>("record_button"))
    button->setStyleSheet(on ? "QToolButton { color: #c81e14; font-weight: bold; }" : "");
}

/// Without a tool bar a message lies at the views' foot, where no control is.
void MainWindow::place_message(bool presents) {
  const bool is_shown = message_->isVisible();
  if (presents) {
    static_cast<QGridLayout*>(centralWidget()->layout())->addWidget(message_, 0, 0, Qt::AlignBottom);
  } else {
    if (!message_place_->layout()) (new QHBoxLayout(message_place_))->setContentsMargins(10, 0, 0, 0);
    message_place_->layout()->addWidget(message_);
  }
  message_->setVisible(is_shown);
}

void MainWindow::present(bool on) {
  if (on == isFullScreen()) return;
  place_message(on);
  if (on) {
    for (QWidget* widget : QList<QWidget*>{menuBar(), statusBar(), findChild<QToolBar*>("main_bar")})
      hidden_for_presenting_ << widget;
    for (QDockWidget* dock : findChildren<QDockWidget*>())
      if (dock->isVisible()) hidden_for_presenting_ << dock;
  }
  for (QWidget* widget : hidden_for_presenting_) widget->setVisible(!on);
  if (!on) hidden_for_presenting_.clear();
  if (on && !message_->isVisible()) say(tr("F11 leaves the full screen, I shows the force curve."));
  setWindowState(on ? windowState() | Qt::WindowFullScreen : windowState() & ~Qt::WindowFullScreen);
}

void MainWindow::set_dark(bool dark) {
  QPalette colors = dark ? QPalette(QColor(53, 53, 58), QColor(40, 40, 44)) : QPalette(QColor(239, 239, 239));
  if (dark) {
    colors.setColor(QPalette::Base, QColor(30, 30, 34));
    colors.setColor(QPalette::AlternateBase, QColor(44, 44, 48));
    colors.setColor(QPalette::Link, QColor(120, 180, 255));
  }
  QApplication::setPalette(colors);
  settings_.set_dark(dark);
}

void MainWindow::picture_of_size() {
  View3D* view = views_->view();
  if (!document_.is_open() || !view) return say(tr("A picture needs a scene: open one."));
  QDialog dialog(this);
  dialog.setWindowTitle(tr("Save a picture"));
  auto* form = new QFormLayout(&dialog);
  auto* width = new QSpinBox;
  auto* height = new QSpinBox;
  for (QSpinBox* box : {width, height}) {
    box->setRange(100, 7680);
    box->setSuffix(tr(" pixels"));
  }
  width->setObjectName("picture_width");
  height->setObjectName("picture_height");
  width->setValue(2 * view->width());
  height->setValue(2 * view->height());
  auto* file = new QLineEdit(settings_.new_picture());
  file->setObjectName("picture_file");
  file->setMinimumWidth(360);
  auto* transparent = new QCheckBox(tr("Transparent ground"));
  transparent->setObjectName("picture_transparent");
  auto* buttons = new QDialogButtonBox(QDialogButtonBox::Save | QDialogButtonBox::Cancel);
  connect(buttons, &QDialogButtonBox::accepted, &dialog, &QDialog::accept);
  connect(buttons, &QDialogButtonBox::rejected, &dialog, &QDialog::reject);
  form->addRow(tr("Width"), width);
  form->addRow(tr("Height"), height);
  form->addRow(tr("File"), file);
  form->addRow(QString(), transparent);
  form->addRow(buttons);
  if (dialog.exec() != QDialog::Accepted) return;
  QDir().mkpath(QFileInfo(file->text()).path());
  try {
    const View3D::Ground ground = transparent->isChecked() ? View3D::Ground::transparent : View3D::Ground::own;
    save_picture(view->picture({width->value(), height->value()}, ground), file->text());
    say(tr("Saved %1").arg(file->text()));
  } catch (const LoadError& error) {
    say(QString::fromUtf8(error.what()), true);
  }
}

}  // namespace palpa::explorer
