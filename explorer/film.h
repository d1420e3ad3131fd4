// A film of a trace: its pictures, one after the other, and a film of them where ffmpeg is there.
#pragma once

#include <QImage>
#include <QObject>
#include <functional>

#include "explorer/jobs.h"
#include "explorer/player.h"

namespace palpa::explorer {

/// Goes through the trace that the player shows and keeps a picture of each moment. For the window's thread.
class Film : public QObject {
  Q_OBJECT
 public:
  /// \param picture  what the window shows now
  Film(Player& player, Jobs& jobs, std::function<QImage()> picture, QObject* parent);

  /// Begins at the trace's start. \param folder  where the pictures go; it is made
  void begin(const QString& folder);
  void end();
  bool is_under_way() const { return !folder_.isEmpty(); }
  /// Keeps one picture more and goes on to the next moment.
  void next();

 Q_SIGNALS:
  void said(const QString& words, bool is_problem);
  void ended();

 private:
  void make_with_ffmpeg(const QString& ffmpeg, const QString& folder);

  Player& player_;
  Jobs& jobs_;
  std::function<QImage()> picture_;
  QString folder_;
  int pictures_ = 0;
};

}  // namespace palpa::explorer
