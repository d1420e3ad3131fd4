#include "explorer/film.h"

#include <QDir>
#include <QProcess>
#include <QStandardPaths>

#include "explorer/gif_film.h"
#include "explorer/picture_file.h"
#include "palpa/base/load_error.h"

namespace palpa::explorer {
namespace {

constexpr double pictures_hz = 25.0;  // usual for players
constexpr int gif_hundredths = 4;     // [0.01 s] between pictures of a GIF

}  // namespace

Film::Film(Player& player, Jobs& jobs, QObject* parent) : QObject(parent), player_(player), jobs_(jobs) {}

void Film::begin(const QString& folder, std::function<QImage()> picture) {
  if (!player_.has_trace()) {
    Q_EMIT said(tr("A film needs a trace: open one, or play a hand (Ctrl+T)."), false);
    Q_EMIT ended();
    return;
  }
  if (!QDir().mkpath(folder)) {
    Q_EMIT said(tr("%1: cannot be made; change the folder's rights or free some space").arg(folder), true);
    Q_EMIT ended();
    return;
  }
  player_.play(false);
  player_.seek(0.0);
  folder_ = folder;
  picture_ = std::move(picture);
  pictures_ = 0;
}

void Film::end() {
  folder_.clear();
  Q_EMIT ended();
}

void Film::next() {
  if (!player_.has_trace()) return end();
  const QString file = QDir(folder_).filePath(QString("%1.png").arg(pictures_, 5, 10, QChar('0')));
  try {
    save_picture(picture_(), file);
  } catch (const LoadError& error) {
    Q_EMIT said(tr("%1. The pictures before it are there.").arg(QString::fromUtf8(error.what())), true);
    return end();
  }
  const double t_s = ++pictures_ / pictures_hz;
  const double duration_s = player_.trace()->duration_s;
  Q_EMIT said(tr("Filming %1 s of %2 s into %3").arg(t_s, 0, 'f', 1).arg(duration_s, 0, 'f', 1).arg(folder_), false);
  if (t_s <= duration_s) return player_.seek(t_s);
  const QString folder = folder_, ffmpeg = QStandardPaths::findExecutable("ffmpeg");
  end();
  if (!ffmpeg.isEmpty()) return make_with_ffmpeg(ffmpeg, folder);
  make_gif(folder, pictures_);
}

void Film::make_gif(const QString& folder, int pictures) {
  jobs_.begin<int>(
      Jobs::Purpose::film, tr("making the film"),
      [folder, pictures](std::stop_token stop) {
        const auto picture = [&](int number) {
          return QImage(QDir(folder).filePath(QString("%1.png").arg(number, 5, 10, QChar('0'))));
        };
        GifFilm film(folder + "/film.gif", picture(0).size(), gif_hundredths);
        for (int number = 0; number < pictures && !stop.stop_requested(); ++number) film.add(picture(number));
        film.close();
        return pictures;
      },
      [this, folder](int) { Q_EMIT said(tr("The film is %1/film.gif").arg(folder), false); },
      [this](const QString& why) { Q_EMIT said(why, true); });
}

void Film::make_with_ffmpeg(const QString& ffmpeg, const QString& folder) {
  jobs_.begin<int>(
      Jobs::Purpose::film, tr("making the film"),
      [folder, ffmpeg](std::stop_token stop) {
        QProcess process;
        process.setProcessChannelMode(QProcess::ForwardedChannels);
        // Most players need even numbers of pixels.
        process.start(ffmpeg, {"-y", "-nostdin", "-loglevel", "error", "-framerate", QString::number(pictures_hz), "-i",
                               folder + "/%05d.png", "-vf", "crop=trunc(iw/2)*2:trunc(ih/2)*2", "-pix_fmt", "yuv420p",
                               folder + "/film.mp4"});
        if (!process.waitForStarted()) return -1;
        while (!process.waitForFinished(100) && process.state() != QProcess::NotRunning)
          if (stop.stop_requested()) process.kill();
        return process.exitStatus() == QProcess::NormalExit ? process.exitCode() : -1;
      },
      [this, folder](int code) {
        if (code == 0) {
          Q_EMIT said(tr("The film is %1/film.mp4").arg(folder), false);
        } else {
          Q_EMIT said(tr("ffmpeg made no film (code %1); its pictures are in %2").arg(code).arg(folder), true);
        }
      },
      [this](const QString& why) { Q_EMIT said(why, true); });
}

}  // namespace palpa::explorer
