#include "explorer/gif_film.h"

#include <gif_lib.h>

#include <QVector>
#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "palpa/base/load_error.h"

namespace palpa::explorer {
namespace {

// [1] Colours of a picture; the last index is transparent: unchanged.
constexpr int most_colors = 255, unchanged = 255;

/// Most frequent colours of a picture, each the mean of its neighbours.
QVector<QRgb> frequent_colors(const QImage& picture, const QRect& part) {
  struct Bin {
    std::int64_t count = 0, red = 0, green = 0, blue = 0;
  };
  std::vector<Bin> bins(1U << 12);
  for (int y = part.top(); y <= part.bottom(); ++y) {
    const auto* line = reinterpret_cast<const QRgb*>(picture.constScanLine(y));
    for (int x = part.left(); x <= part.right(); ++x) {
      Bin& bin = bins[static_cast<std::size_t>((qRed(line[x]) >> 4) << 8 | (qGreen(line[x]) >> 4) << 4 | qBlue(line[x]) >> 4)];
      ++bin.count;
      bin.red += qRed(line[x]);
      bin.green += qGreen(line[x]);
      bin.blue += qBlue(line[x]);
    }
  }
  std::sort(bins.begin(), bins.end(), [](const Bin& a, const Bin& b) { return a.count > b.count; });
  QVector<QRgb> table;
  for (const Bin& bin : bins) {
    if (bin.count == 0 || table.size() == most_colors) break;
    table.append(qRgb(static_cast<int>(bin.red / bin.count), static_cast<int>(bin.green / bin.count),
                      static_cast<int>(bin.blue / bin.count)));
  }
  return table;
}

/// Smallest rectangle of all pixels that differ; one pixel if none does: a GIF has no empty picture.
QRect changed_part(const QImage& before, const QImage& now) {
  if (before.isNull()) return now.rect();
  int left = now.width(), right = -1, top = now.height(), bottom = -1;
  for (int y = 0; y < now.height(); ++y) {
    const auto* a = reinterpret_cast<const QRgb*>(before.constScanLine(y));
    const auto* b = reinterpret_cast<const QRgb*>(now.constScanLine(y));
    for (int x = 0; x < now.width(); ++x) {
      if (a[x] == b[x]) continue;
      left = std::min(left, x);
      right = std::max(right, x);
      top = std::min(top, y);
      bottom = y;
    }
  }
  return right < 0 ? QRect(0, 0, 1, 1) : QRect(QPoint(left, top), QPoint(right, bottom));
}

}  // namespace

GifFilm::GifFilm(const QString& file, const QSize& size, int hundredths) : file_(file), size_(size), hundredths_(hundredths) {
  int error = 0;
  gif_ = EGifOpenFileName(file.toLocal8Bit().constData(), false, &error);
  if (!gif_) fail(error);
  EGifSetGifVersion(gif_, true);
  static constexpr unsigned char forever[] = {1, 0, 0};
  const bool done = EGifPutScreenDesc(gif_, size.width(), size.height(), 8, 0, nullptr) == GIF_OK &&
                    EGifPutExtensionLeader(gif_, APPLICATION_EXT_FUNC_CODE) == GIF_OK &&
                    EGifPutExtensionBlock(gif_, 11, "NETSCAPE2.0") == GIF_OK &&
                    EGifPutExtensionBlock(gif_, 3, forever) == GIF_OK && EGifPutExtensionTrailer(gif_) == GIF_OK;
  if (!done) fail(gif_->Error);
}

GifFilm::~GifFilm() {
  int ignored = 0;
  if (gif_) EGifCloseFile(gif_, &ignored);
}

void GifFilm::fail(int error) const {
  const char* const words = GifErrorString(error);
  throw LoadError(file_.toStdString() + ": cannot be written (" + (words ? words : "unknown error") +
                  "); free some space, or choose another folder");
}

void GifFilm::add(const QImage& picture) {
  const QImage now = picture.convertToFormat(QImage::Format_RGB32).copy(QRect({}, size_));
  put(changed_part(before_, now), now);
  before_ = now;
}

void GifFilm::put(const QRect& changed, const QImage& picture) {
  const QVector<QRgb> table = frequent_colors(picture, changed);
  const QImage indexed = picture.copy(changed).convertToFormat(QImage::Format_Indexed8, table, Qt::ThresholdDither);
  ColorMapObject* map = GifMakeMapObject(256, nullptr);
  if (!map) fail(E_GIF_ERR_NOT_ENOUGH_MEM);
  for (int i = 0; i < table.size(); ++i)
    map->Colors[i] = {static_cast<GifByteType>(qRed(table[i])), static_cast<GifByteType>(qGreen(table[i])),
                      static_cast<GifByteType>(qBlue(table[i]))};
  GraphicsControlBlock control{};
  control.DisposalMode = DISPOSE_DO_NOT;
  control.DelayTime = hundredths_;
  control.TransparentColor = unchanged;
  std::array<GifByteType, 4> bytes{};
  EGifGCBToExtension(&control, bytes.data());
  bool done = EGifPutExtension(gif_, GRAPHICS_EXT_FUNC_CODE, static_cast<int>(bytes.size()), bytes.data()) == GIF_OK &&
              EGifPutImageDesc(gif_, changed.left(), changed.top(), changed.width(), changed.height(), false, map) == GIF_OK;
  GifFreeMapObject(map);
  std::vector<GifByteType> line(static_cast<std::size_t>(changed.width()));
  for (int y = 0; done && y < changed.height(); ++y) {
    std::copy_n(indexed.constScanLine(y), changed.width(), line.begin());
    if (!before_.isNull()) {
      const auto* was = reinterpret_cast<const QRgb*>(before_.constScanLine(changed.top() + y)) + changed.left();
      const auto* is = reinterpret_cast<const QRgb*>(picture.constScanLine(changed.top() + y)) + changed.left();
      for (int x = 0; x < changed.width(); ++x)
        if (was[x] == is[x]) line[static_cast<std::size_t>(x)] = unchanged;
    }
    done = EGifPutLine(gif_, line.data(), changed.width()) == GIF_OK;
  }
  if (!done) fail(gif_->Error);
}

void GifFilm::close() {
  int error = 0;
  if (EGifCloseFile(std::exchange(gif_, nullptr), &error) != GIF_OK) fail(error);
}

}  // namespace palpa::explorer
