// Overview picture of a file's field: three slices, a histogram, streamlines of vectors.
#pragma once

#include <string>

#include "palpa/data/statistics.h"
#include "palpa/data/volume.h"
#include "palpa/view/picture.h"

namespace palpa {

struct VolumePictureOptions {
  int width_px = 1200;
  int height_px = 860;
};

/// Draws one field of a volume: slices across the world's axes through the middle of its box, at one scale, with positions,
/// patient's directions (L R A P S I) or world axes, a colour bar in the field's unit, and a scale bar; below them the
/// histogram. Vector fields: slices and histogram of the magnitude, and streamlines without noise. CT: in the window for its
/// content (ct_window), named by the bar, and the first slice in a second window; label maps: a colour per label; directions:
/// red along x, green along y, blue along z. Slices are checkered where data are missing.
///
/// \param field   index of the field in the volume
/// \param values  its statistics
/// \param title   the file and its kind; of a file's text only the field's name and unit are drawn
/// Needs no X. Throws LoadError without EGL, or on a size not within 600 x 400 to 8000 x 8000 pixels.
Picture volume_picture(const Volume& volume, std::size_t field, const Statistics& values, const std::string& title,
                       const VolumePictureOptions& options = {});

/// [m] The file's own unit of length, for printed lengths, if its real unit is unknown and no patient lies in the volume; else
/// 0. Reads only its argument; any thread.
double file_unit_m(const Volume& volume);
/// [m] For a scene whose volumes all have this unit; else 0.
double file_unit_m(const Scene& scene);

}  // namespace palpa
