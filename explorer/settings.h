// User settings kept between starts, and time-stamped names of new files.
#pragma once

#include <QSettings>
#include <QStringList>
#include <filesystem>
#include <optional>
#include <string>

namespace palpa::explorer {

/// Name of a file in the list of recent ones: of a scene that was kept with its changes, "head (unsaved changes)"; else its
/// own.
QString words_of_recent(const QString& file);

class Settings {
 public:
  /// A scene that was not saved is kept in a file of this prefix.
  static constexpr const char* unsaved = "unsaved-";
  /// \param file  empty: the user's
  explicit Settings(const std::string& file);

  /// Files opened or saved, most recent first.
  QStringList recent() const;
  void remember(const std::filesystem::path& file);
  /// Folder of the last opened file; initially `otherwise`.
  QString folder(const QString& otherwise = {}) const;
  void set_folder(const QString& folder);
  /// Position and size of the window, as by QWidget::saveGeometry; initially empty.
  QByteArray window() const;
  void set_window(const QByteArray& geometry);
  /// Places and sizes of the panels of an open scene, as by QMainWindow::saveState; initially empty.
  QByteArray panels() const;
  void set_panels(const QByteArray& state);
  /// Colours of the window: true: dark, false: light, none: those of the desktop.
  std::optional<bool> dark() const;
  void set_dark(bool dark) { kept_.setValue("dark", dark); }

  /// Folder that holds the traces.
  QString traces() const;
  /// Folder of a new trace. \param name  prefix
  std::filesystem::path new_trace(const QString& name) const;
  QString new_picture() const;
  QString new_film() const;

 private:
  QString in_pictures(const QString& name, const QString& time) const;

  QSettings kept_;
};

}  // namespace palpa::explorer
