#include "explorer/settings.h"

#include <QCoreApplication>
#include <QDateTime>
#include <QDir>
#include <QFileInfo>
#include <QStandardPaths>

namespace palpa::explorer {
namespace {

constexpr int most_recent = 8;

}  // namespace

QString words_of_recent(const QString& file) {
  const QString name = QFileInfo(file).fileName(), prefix(Settings::unsaved);
  if (!name.startsWith(prefix) || !name.endsWith(".toml")) return name;
  return QCoreApplication::translate("Settings", "%1 (unsaved changes)")
      .arg(QFileInfo(name.mid(prefix.size())).completeBaseName());
}

Settings::Settings(const std::string& file)
    : kept_(file.empty() ? QSettings().fileName() : QString::fromStdString(file), QSettings::IniFormat) {}

QStringList Settings::recent() const { return kept_.value("recent").toStringList(); }

void Settings::remember(const std::filesystem::path& file) {
  QStringList files = recent();
  const QString name = QString::fromStdString(std::filesystem::absolute(file).lexically_normal().string());
  files.removeAll(name);
  files.prepend(name);
  while (files.size() > most_recent) files.removeLast();
  kept_.setValue("recent", files);
}

QString Settings::folder(const QString& otherwise) const { return kept_.value("folder", otherwise).toString(); }

void Settings::set_folder(const QString& folder) { kept_.setValue("folder", folder); }

QByteArray Settings::window() const { return kept_.value("window").toByteArray(); }

void Settings::set_window(const QByteArray& geometry) { kept_.setValue("window", geometry); }

QByteArray Settings::panels() const { return kept_.value("panels").toByteArray(); }

void Settings::set_panels(const QByteArray& state) { kept_.setValue("panels", state); }

std::optional<bool> Settings::dark() const {
  const QVariant kept = kept_.value("dark");
  return kept.isValid() ? std::optional(kept.toBool()) : std::nullopt;
}

QString Settings::traces() const { return kept_.value("traces", QDir::homePath()).toString(); }

std::filesystem::path Settings::new_trace(const QString& name) const {
  return QDir(traces()).filePath(name + QDateTime::currentDateTime().toString("-yyyyMMdd-HHmmss")).toStdString();
}

QString Settings::new_picture() const { return in_pictures("palpa", "-yyyyMMdd-HHmmss-zzz") + ".png"; }

QString Settings::new_film() const { return in_pictures("palpa-film", "-yyyyMMdd-HHmmss"); }

QString Settings::in_pictures(const QString& name, const QString& time) const {
  const QDir folder(kept_.value("pictures", QStandardPaths::writableLocation(QStandardPaths::PicturesLocation)).toString());
  return folder.filePath(name + QDateTime::currentDateTime().toString(time));
}

}  // namespace palpa::explorer
