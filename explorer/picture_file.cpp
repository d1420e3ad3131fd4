#include "explorer/picture_file.h"

#include <QBuffer>

#include "palpa/base/new_file.h"

namespace palpa::explorer {

void save_picture(const QImage& picture, const QString& file) {
  QBuffer png;
  picture.save(&png, "PNG");
  const QByteArray& bytes = png.data();
  detail::write_whole(file.toStdString(), {bytes.constData(), static_cast<std::size_t>(bytes.size())},
                      detail::Existing::refused);
}

}  // namespace palpa::explorer
