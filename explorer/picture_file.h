// Picture files.
#pragma once

#include <QImage>
#include <QString>

namespace palpa::explorer {

/// Writes a new PNG file atomically. Throws LoadError, also if the file exists.
void save_picture(const QImage& picture, const QString& file);

}  // namespace palpa::explorer
