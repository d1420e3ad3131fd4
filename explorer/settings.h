// What is remembered of a user from one start to the next, and where the files go that are named by the time.
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

  /// Files that were open or saved, the last one first.
  QStringList recent() const;
  void remember(const std::filesystem::path& file);
  /// Where a file was opened last; `otherwise` before the first.
  QString folder(const QString& otherwise = {}) const;
  void set_folder(const QString& folder);
  /// Whether the hand has once pressed on something.
  bool hint_seen() const { return hint_seen_; }
  void set_hint_seen();

  /// Folder of a new trace. \param name  that it begins with
  std::filesystem::path new_trace(const QString& name) const;
  /// File of a new picture.
  QString new_picture() const;
  /// Folder of a new film.
  QString new_film() const;

 private:
  QString in_pictures(const QString& name, const QString& time) const;

  QSettings kept_;
  bool hint_seen_;
};

}  // namespace palpa::explorer
