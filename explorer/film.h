// Film of a trace: one picture per moment, joined by ffmpeg if installed, else as a GIF.
#pragma once

#include <QImage>
#include <QObject>
#include <functional>

#include "explorer/jobs.h"
#include "explorer/player.h"

namespace palpa::explorer {

/// Steps the player through its trace and saves a picture of each moment. For the window's thread.
class Film : public QObject {
  Q_OBJECT
 public:
  Film(Player& player, Jobs& jobs, QObject* parent);

  /// Starts at the beginning of the trace. \param folder  of the pictures; created
  /// \param picture  returns the current picture of a view or the window
  void begin(const QString& folder, std::function<QImage()> picture);
  void end();
  bool is_under_way() const { return !folder_.isEmpty(); }
  /// Saves a picture and advances to the next moment.
  void next();

 Q_SIGNALS:
  void said(const QString& words, bool is_problem);
  void ended();

 private:
  void make_with_ffmpeg(const QString& ffmpeg, const QString& folder);
  void make_gif(const QString& folder, int pictures);

  Player& player_;
  Jobs& jobs_;
  std::function<QImage()> picture_;
  QString folder_;
  int pictures_ = 0;
};

}  // namespace palpa::explorer
