// A picture of what is in a file: three slices, a histogram, and of vectors streamlines.
#pragma once

#include <string>

#include "palpa/survey/statistics.h"
#include "palpa/view/picture.h"
#include "palpa/volume/volume.h"

namespace palpa {

struct VolumePictureOptions {
  int width_px = 1200;
  int height_px = 860;
};

/// Draws one field of a volume: slices across the world's axes through the middle of its box, side by side to one scale, with
/// the patient's directions (L R A P S I) or the world's axes at their edges, where they lie, a bar that explains their
/// colours in the field's unit, and a length; below them the histogram. Of a vector field the slices and the histogram are of
/// the length, and streamlines are drawn beside it, without those of noise. A CT is shown in the window in which most is seen
/// (ct_window), which the bar names, and its first slice again in another; a label map in a colour for each label, directions
/// in red along x, green along y and blue along z. Where there are no data a slice is checkered.
///
/// \param field   number of the field in the volume
/// \param values  its statistics
/// \param title   the file, and what it is; nothing else of a file's text is drawn but the field's name and unit
/// Needs no X. Throws LoadError where nothing can be drawn (no EGL), or on a size not within 600 x 400 to 8000 x 8000 pixels.
Picture volume_picture(const Volume& volume, std::size_t field, const Statistics& values, const std::string& title,
                       const VolumePictureOptions& options = {});

/// [m] One of the file's own units of length, in which lengths are written where no unit is known and no patient lies in the
/// volume; else 0. Reads only its argument; any thread.
double file_unit_m(const Volume& volume);
/// [m] The same for a scene: all of its volumes have this unit; else 0.
double file_unit_m(const Scene& scene);

}  // namespace palpa
