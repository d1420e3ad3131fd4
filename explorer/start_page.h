// Page shown while no scene is open: installed scenes, recent files, drop area.
#pragma once

#include <QStringList>
#include <QWidget>

class QVBoxLayout;

namespace palpa::explorer {

class StartPage : public QWidget {
  Q_OBJECT
 public:
  explicit StartPage(QWidget* parent = nullptr);
  /// Recent files, and below them those that are traces.
  void show_recent(const QStringList& files);

 Q_SIGNALS:
  void chosen(const QString& file);
  void open_asked();
  void folder_asked();

 protected:
  void keyPressEvent(QKeyEvent* event) override;

 private:
  void add_recent(const QString& file);

  QVBoxLayout* recent_;
};

}  // namespace palpa::explorer
