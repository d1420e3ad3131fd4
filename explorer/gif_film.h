// Film of pictures as an animated GIF.
#pragma once

#include <QImage>
#include <QString>
#include <memory>

struct GifFileType;

namespace palpa::explorer {

/// Writes one GIF, picture by picture; of each only what changed. For one thread at a time.
class GifFilm {
 public:
  /// Creates the file. Throws LoadError. \param hundredths  [0.01 s] between pictures
  GifFilm(const QString& file, const QSize& size, int hundredths);
  ~GifFilm();
  GifFilm(const GifFilm&) = delete;
  GifFilm& operator=(const GifFilm&) = delete;

  /// Appends a picture, of the film's size. Allocates. Throws LoadError, as on a full disk.
  void add(const QImage& picture);
  /// Ends the file. Throws LoadError.
  void close();

 private:
  void put(const QRect& changed, const QImage& picture);
  [[noreturn]] void fail(int error) const;

  QString file_;
  QSize size_;
  int hundredths_;
  GifFileType* gif_ = nullptr;
  QImage before_;
};

}  // namespace palpa::explorer
