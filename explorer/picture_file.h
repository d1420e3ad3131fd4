// Pictures as files.
#pragma once

#include <QImage>
#include <QString>

namespace palpa::explorer {

/// Writes a new PNG file, whole or not at all. Throws LoadError, also where the file is there already.
void save_picture(const QImage& picture, const QString& file);

}  // namespace palpa::explorer
