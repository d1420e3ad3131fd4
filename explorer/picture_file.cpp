#include "explorer/picture_file.h"

#include <QBuffer>
#include <algorithm>

#include "palpa/base/new_file.h"

namespace palpa::explorer {

QImage with_alpha(const QImage& on_black, const QImage& on_white) {
  QImage made(on_black.size(), QImage::Format_ARGB32_Premultiplied);
  for (int y = 0; y < made.height(); ++y) {
    auto* const to = reinterpret_cast<QRgb*>(made.scanLine(y));
    for (int x = 0; x < made.width(); ++x) {
      const QRgb black = on_black.pixel(x, y), white = on_white.pixel(x, y);
      const int through = std::max({qRed(white) - qRed(black), qGreen(white) - qGreen(black), qBlue(white) - qBlue(black), 0});
      const int alpha = 255 - through;
      to[x] = qRgba(std::min(qRed(black), alpha), std::min(qGreen(black), alpha), std::min(qBlue(black), alpha), alpha);
    }
  }
  return made;
}

void save_picture(const QImage& picture, const QString& file) {
  QBuffer png;
  picture.save(&png, "PNG");
  const QByteArray& bytes = png.data();
  detail::write_whole(file.toStdString(), {bytes.constData(), static_cast<std::size_t>(bytes.size())},
                      detail::Existing::refused);
}

}  // namespace palpa::explorer
