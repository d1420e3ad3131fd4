// Opening of files by the main window: dialogs, drop, choice of parts, added data.
#include <QAction>
#include <QDir>
#include <QFileDialog>
#include <QFileInfo>
#include <QMimeData>
#include <QStackedWidget>
#include <algorithm>

#include "explorer/main_window.h"
#include "explorer/part_chooser.h"

namespace palpa::explorer {

namespace fs = std::filesystem;

namespace {

QString name_of(const fs::path& path) {
  return QString::fromStdString((path.has_filename() ? path : path.parent_path()).filename().string());
}

/// A trace by its header, which a file dialog can choose.
fs::path chosen_path(const QString& file) {
  const fs::path path = file.toStdString();
  return path.filename() == "trace.toml" ? path.parent_path() : path;
}

/// Data that are open, to be opened otherwise.
Wanted again(const Opened& opened) {
  return {.paths = opened.request.files, .series = opened.request.series, .fields = opened.request.fields, .is_decided = true};
}

}  // namespace

QList<QAction*> MainWindow::make_opening_actions() {
  return {
      action(tr("&Open …"), QKeySequence::Open, tr("Open a scene, data or a trace"), [this] { ask_file(); }),
      action(tr("Open a &folder …"), QKeySequence("Ctrl+Shift+O"),
             tr("Open a folder: a DICOM series, an OpenFOAM case, a trace"), [this] { ask_folder(); }),
      action(tr("Open a r&ecording …"), QKeySequence("Ctrl+Shift+R"), tr("Open a trace, by its trace.toml"),
             [this] { ask_trace(tr("Open a recording (its trace.toml)"), [this](const fs::path& trace) { open(trace); }); }),
      action(tr("A&dd data …"), QKeySequence("Ctrl+Shift+A"), tr("Add a second volume, on a grid of its own, to the scene"),
             [this] { ask_data(); }),
      action(tr("&Choose series or arrays …"), QKeySequence("Ctrl+Shift+C"),
             tr("Open another series of the folder, other arrays of the file, or three of them as one vector"),
             [this] { ask_parts(); })};
}

void MainWindow::open(const fs::path& path, const fs::path& second_trace) {
  open(Wanted{.paths = {path}, .second_trace = second_trace});
}

void MainWindow::open(const Wanted& wanted) {
  if (!document_.is_open()) pages_->setCurrentIndex(2);
  jobs_.begin<Found>(
      Jobs::Purpose::open, tr("reading %1").arg(name_of(wanted.paths.front())),
      [wanted, folders = options_.data_folders](std::stop_token stop) { return open_or_ask(wanted, folders, stop); },
      [this, wanted](Found found) {
        if (!found.opened) {
          if (!document_.is_open()) pages_->setCurrentIndex(0);
          return choose(found.to_choose, wanted, [this](const Wanted& chosen) { open(chosen); });
        }
        keep_unsaved();
        remember(wanted.paths.front());
        message_->hide();
        document_.open(std::move(*found.opened));
      },
      [this](const QString& why) {
        if (!document_.is_open()) pages_->setCurrentIndex(0);
        say(why, true);
      });
}

void MainWindow::say_of(const Opened& opened) {
  QStringList words = opened.notes;
  for (const std::string& warning : opened.loaded.warnings) words << QString::fromStdString(warning);
  if (!options_.has_opengl) words << tr("No OpenGL 3.2: slices only. On Debian, the package libgl1-mesa-dri brings it.");
  QList<MessageBar::Offer> offers;
  if (!opened.beside.empty()) {
    words << tr("%1 lies beside it and may show where the flow is.").arg(name_of(opened.beside));
    Wanted both = again(opened);
    both.beside = opened.beside;
    offers.append({tr("Use it"), [this, both] { open(both); }});
  }
  if (!words.isEmpty()) say(words.join("\n"), false, offers);
}

void MainWindow::choose(const FileContents& contents, const Wanted& wanted, const std::function<void(const Wanted&)>& then) {
  auto* chooser = new PartChooser(contents, wanted, this);
  chooser->setAttribute(Qt::WA_DeleteOnClose);
  connect(chooser, &QDialog::accepted, this, [chooser, then] { then(chooser->chosen()); });
  chooser->open();
}

void MainWindow::ask_parts() {
  if (!document_.is_open() || document_.opened().request.files.empty())
    return say(tr("The open scene names its series and arrays itself: open the data by themselves to choose others."));
  const Wanted wanted = again(document_.opened());
  const fs::path file = place_in_file(wanted.paths.front()).file;
  jobs_.begin<FileContents>(
      Jobs::Purpose::open, tr("reading %1").arg(name_of(file)), [file](std::stop_token stop) { return list_parts(file, stop); },
      [this, wanted](const FileContents& contents) {
        if (contents.series.size() < 2 && contents.alternatives.empty() && contents.arrays.size() < 2)
          return say(tr("%1 holds one array: there is nothing to choose.").arg(name_of(wanted.paths.front())));
        choose(contents, wanted, [this](const Wanted& chosen) { open(chosen); });
      },
      [this](const QString& why) { say(why, true); });
}

void MainWindow::ask_file() {
  const QStringList files = QFileDialog::getOpenFileNames(this, tr("Open a scene, data, or a trace (its trace.toml)"),
                                                          settings_.folder(QDir::homePath()));
  if (files.isEmpty()) return;
  settings_.set_folder(QFileInfo(files.front()).absolutePath());
  open_chosen(files);
}

void MainWindow::ask_folder() {
  const QString folder = QFileDialog::getExistingDirectory(this, tr("Open a DICOM series, an OpenFOAM case or a trace"),
                                                           settings_.folder(QDir::homePath()));
  if (folder.isEmpty()) return;
  settings_.set_folder(folder);
  open(folder.toStdString());
}

// Traces lie in a folder of their own, not in that of the last data.
void MainWindow::ask_trace(const QString& title, const std::function<void(const fs::path&)>& then) {
  const QString header = QFileDialog::getOpenFileName(this, title, settings_.traces(), tr("Traces (trace.toml)"));
  if (!header.isEmpty()) then(chosen_path(header));
}

void MainWindow::ask_data() {
  if (!document_.is_open()) return ask_file();
  const QString file = QFileDialog::getOpenFileName(this, tr("Add data to the scene"), settings_.folder(QDir::homePath()));
  if (file.isEmpty()) return;
  settings_.set_folder(QFileInfo(file).absolutePath());
  add({.paths = {file.toStdString()}});
}

void MainWindow::open_chosen(const QStringList& files) {
  Wanted wanted;
  for (const QString& file : files) wanted.paths.push_back(chosen_path(file));
  const bool are_data = std::ranges::all_of(wanted.paths, [](const fs::path& path) {
    std::error_code ignored;
    return fs::is_regular_file(path, ignored) && path.extension() != ".toml";
  });
  if (wanted.paths.size() > 1 && !are_data) {
    if (is_trace(wanted.paths[0]) && is_trace(wanted.paths[1])) wanted.second_trace = wanted.paths[1];
    wanted.paths.resize(1);
  }
  open(wanted);
}

void MainWindow::add(Wanted wanted) {
  const QString name = name_of(wanted.paths.front());
  if (wanted.paths.front().extension() == ".toml" || is_trace(wanted.paths.front()))
    return say(tr("%1 is a scene or a trace, not data: File ▸ Open opens it.").arg(name), true);
  wanted.taken.clear();
  for (const SceneVolume& volume : document_.scene().volumes()) wanted.taken.push_back(volume.name);
  jobs_.begin<Found>(
      Jobs::Purpose::open, tr("reading %1").arg(name),
      [wanted, folders = options_.data_folders](std::stop_token stop) { return open_or_ask(wanted, folders, stop); },
      [this, wanted, name](const Found& found) {
        if (!found.opened) return choose(found.to_choose, wanted, [this](const Wanted& chosen) { add(chosen); });
        QStringList remarks = found.opened->notes;
        if (!document_.edit(tr("add %1").arg(name), -1,
                            [&](Scene& scene) { remarks += add_to(scene, found.opened->loaded.scene); }))
          return;
        for (const std::string& warning : found.opened->loaded.warnings) remarks << QString::fromStdString(warning);
        say((QStringList(tr("Added %1; Undo takes it out again.").arg(name)) + remarks).join("\n"));
      },
      [this](const QString& why) { say(why, true); });
}

void MainWindow::dragEnterEvent(QDragEnterEvent* event) {
  if (event->mimeData()->hasUrls()) event->acceptProposedAction();
}

void MainWindow::dropEvent(QDropEvent* event) {
  QStringList files;
  for (const QUrl& url : event->mimeData()->urls())
    if (url.isLocalFile()) files << url.toLocalFile();
  if (files.isEmpty()) return say(tr("Only files and folders of this machine can be dropped here."), true);
  event->acceptProposedAction();
  open_chosen(files);
}

}  // namespace palpa::explorer
