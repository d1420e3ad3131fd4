// Picture files.
#pragma once

#include <QImage>
#include <QString>

namespace palpa::explorer {

/// One picture with alpha of two, drawn on black and on white ground, of one size. Pixels that differ by the whole of white are
/// transparent.
QImage with_alpha(const QImage& on_black, const QImage& on_white);

/// Writes a new PNG file atomically. Throws LoadError, also if the file exists.
void save_picture(const QImage& picture, const QString& file);

}  // namespace palpa::explorer
