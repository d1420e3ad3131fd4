// User settings kept between starts, and time-stamped names of new files.
#pragma once

#include <QSettings>
#include <QStringList>
#include <filesystem>
#include <string>

namespace palpa::explorer {

class Settings {
 public:
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
  /// True once the hand has pressed on a surface.
  bool hint_seen() const { return hint_seen_; }
  void set_hint_seen();

  /// Folder of a new trace. \param name  prefix
  std::filesystem::path new_trace(const QString& name) const;
  QString new_picture() const;
  QString new_film() const;

 private:
  QString in_pictures(const QString& name, const QString& time) const;

  QSettings kept_;
  bool hint_seen_;
};

}  // namespace palpa::explorer
