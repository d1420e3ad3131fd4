#include "palpa/scene/first_workspace_table.h"

#include <algorithm>
#include <cmath>

#include "palpa/base/wording.h"
#include "palpa/data/octave_parts.h"
#include "palpa/scene/first_levels.h"
#include "palpa/scene/first_scene_lines.h"

namespace palpa::detail {
namespace {

// Length of the hand's motion over the longest side of the object; also in sentences below. More: beyond the reach of small
// devices; less: details become too small for a hand.
constexpr double reach_m = 0.15;

/// Comment on the width of voxels for the hand. \param zoom  [1] of the hand's metres, per metre of the data
std::string words_of_octaves(const Octaves& octaves, double zoom) {
  const int last = octaves.count() - 1;
  const auto of_hand = [&](int octave) { return size_words({std::ldexp(octaves.spacing_m(), octave) * zoom}); };
  return "# A voxel takes " + of_hand(0) + " of the hand, one of the coarsest octave, " + std::to_string(last) + ", " +
         of_hand(last) + "; a hand of 0.05 m/s goes 50 um in a tick of 1 ms.\n";
}

}  // namespace

Facing facing_of(const Volume& volume, bool is_flow, const Vec3& size_m, double lying_at_y) {
  // [1] Height over the next longer side, below which a scan is a slab of slices, not a part of a body. More: parts of bodies
  // are seen from the feet; less: slabs are seen edge-on.
  constexpr double flat = 0.6;
  if (volume.medical_frame && size_m.z < flat * std::min(size_m.x, size_m.y))
    return {"inferior",
            "anterior",
            "a slab of slices, seen as they are read: from the feet,",
            "the patient's front is up",
            {0, 0, -1}};
  if (volume.medical_frame)
    return {"anterior", "superior", "the patient's front faces the user,", "the head is up", {0, -1, 0}};
  const std::string turn = "; turn both if that is wrong";
  const bool is_scan = !is_flow && (volume.format == "nrrd" || volume.format == "metaimage" || volume.format == "nifti");
  if (is_scan && lying_at_y < -0.5)
    return {"+y",
            "+z",
            "the file does not say where its axes point: what looks like a head rest or a table lies at its low y,",
            "so its y is the front, and its z is taken as up" + turn,
            {0, 1, 0}};
  if (is_scan)
    return {"-y",
            "+z",
            "the file does not say where its axes point: taken as most scanners have them,",
            "y to the back and z to the head" + turn,
            {0, -1, 0}};
  const double sides_m[] = {size_m.x, size_m.y, size_m.z};
  // The shortest side, z if no other is clearly shorter.
  const int shortest = sides_m[2] <= 1.1 * std::min(sides_m[0], sides_m[1]) ? 2 : sides_m[1] <= sides_m[0] ? 1 : 0;
  const bool is_cube = largest_component(size_m) <= 1.1 * std::min({sides_m[0], sides_m[1], sides_m[2]});
  // Flat data of this width are air or sea, and are seen from above. Less: large machines are taken for weather; more: small
  // parts of weather are not.
  constexpr double wide_m = 1e4;
  const bool is_weather = largest_component(size_m) >= wide_m && 2.0 * sides_m[shortest] < largest_component(size_m);
  const std::string face = is_weather ? "seen from above, as on a map: the flat side of the data faces the user,"
                           : is_cube  ? "the file does not say where its axes point: its z comes towards the user,"
                                      : "the largest side of the object faces the user,";
  if (shortest == 2) return {"+z", "+y", face, "its x is to the right, its y is up" + turn, {0, 0, 1}};
  if (shortest == 0) return {"+x", "+z", face, "its y is to the right, its z is up" + turn, {1, 0, 0}};
  if (is_weather) return {"+y", "-z", face, "its x is to the right, its y is the height" + turn, {0, 1, 0}};
  return {"-y", "+z", face, "its x is to the right, its z is up" + turn, {0, -1, 0}};
}

std::string workspace_table(const Volume& volume, const Field& felt, const SceneNames& names, const Box& object_m,
                            const Facing& facing, const CloseUp& close, double cell_m) {
  const Box data_m = volume.bounds_m();
  const Vec3 size_m = object_m.size_m();
  const double longest_m = largest_component(size_m), span_m = largest_component(data_m.size_m());
  const bool whole = largest_component(object_m.low_m - data_m.low_m) <= 1.5 * cell_m &&
                     largest_component(object_m.high_m - data_m.high_m) <= 1.5 * cell_m;
  const auto scale = [&](double side_m) { return "scale = " + toml_number(rounded(side_m / reach_m, side_m / reach_m)); };
  const auto centre = [&](const Vec3& at_m) {
    const auto along = [&](double m) { return toml_number(rounded(m, 0.1 * span_m)); };
    return "center = [" + along(at_m.x) + ", " + along(at_m.y) + ", " + along(at_m.z) + "]";
  };
  std::string out = "[workspace]\n";
  if (whole) {
    out += reasoned("fit = " + toml_string(names.volume),
                    "all of it, " + size_words(size_m) + ": its longest side becomes 0.15 m of hand");
  } else {
    out += reasoned(scale(longest_m), "all of the object, " + size_words(size_m) + " of the data's " +
                                          size_words(data_m.size_m()) + ": its longest side becomes 0.15 m of hand");
    out += reasoned(centre(object_m.centre_m()), "its middle");
  }
  if (const Octaves* octaves = octaves_of(felt)) out += words_of_octaves(*octaves, reach_m / longest_m);
  out += reasoned("towards_user = " + toml_string(facing.towards_user), facing.why_towards_user);
  out += reasoned("up = " + toml_string(facing.up), facing.why_up);
  const std::string instead = whole ? "fit" : "scale and center";
  out += "# A close-up of " + close.what + ", " + size_words({close.side_m}) + " of it: these two lines instead of " + instead +
         ".\n";
  out += reasoned("# " + scale(close.side_m), "0.15 m of hand are " + size_words({close.side_m}) + " of the data");
  out += reasoned("# " + centre(close.centre_m), close.what);
  return out;
}

}  // namespace palpa::detail
