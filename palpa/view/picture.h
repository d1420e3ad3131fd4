// Pictures: in memory, as PNG, and of a scene: its layers, the paths of probe and proxy, the primitives of one moment.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "palpa/scene/scene.h"
#include "palpa/session/session.h"

namespace palpa {

/// Rows from top to bottom, three bytes red, green, blue each.
struct Picture {
  int width_px = 0;
  int height_px = 0;
  std::vector<std::uint8_t> rgb;
};

/// The PNG file of a picture, as bytes; the same picture gives the same bytes.
std::string png_of(const Picture& picture);
/// Writes it, in place of a file that has the name already; never through a link. Throws LoadError where it cannot be written.
void save_png(const Picture& picture, const std::filesystem::path& file);

/// One point of what was felt, in the hand frame.
struct PathPoint {
  Vec3 probe_m;
  Vec3 proxy_m;
  Vec3 force_n;          ///< that reached the hand
  Vec3 asked_n{};        ///< that the coupling asked for
  bool limited = false;  ///< the guard shortened it; where a level was broken the two differ without that
};

/// The primitives of one sub-step, to be drawn: a plane as a disc with its normal, a line as a rod, a
/// point as a ball, a directed force as an arrow; and the pull of the spring between proxy and probe.
struct Moment {
  Vec3 probe_m;
  Vec3 proxy_m;
  std::vector<PlacedPrimitive> primitives;
  std::vector<std::string> mode_names;  ///< by PrimitiveId::mode, for the legend
  double time_s = 0.0;                  ///< since the session began: data that change are drawn as they were then
};

/// A picture's size, and from where the scene is seen.
struct ScenePictureOptions {
  int width_px = 1200;
  int height_px = 900;
  Vec3 from{0.45, 0.35, 1.0};  ///< [1] direction to the viewer, hand frame; as the user, a little from above and the right
  Vec3 up{0.0, 1.0, 0.0};      ///< [1] direction that is up in the picture, hand frame
  /// Half the height of the whole picture [hand m]; 0: what was felt, and of the data as much as leaves it
  /// legible. The projection is parallel.
  double half_height_m = 0.0;
  /// What lies in the picture's middle [hand m]; none: what is shown, or with `half_height_m` the moment, lies in the
  /// middle of the part beside title and legend.
  std::optional<Vec3> centre_m{};
};

/// How the whole of a path is best seen: from where the scene says; or straight on where the hand stayed in a plane across the
/// user's sight, or from where most of the path in contact is not hidden and spreads out, not far from where the user sits.
ScenePictureOptions overview(const Scene& scene, std::span<const PathPoint> path);
/// How a moment is best seen: its surroundings, from where the proxy is not hidden and the spring lies across.
ScenePictureOptions close_up(const Scene& scene, const Moment& moment);

/// Draws the scene's layers, the path coloured by the force on the hand and banded where the guard held force back (the
/// probe's as a thin grey line), the moment's primitives in front of all (with `half_height_m` only
/// the stretch of the path that leads through it); beside it, where nothing else is drawn, title,
/// legend, a colour bar in newtons up to the largest force that reached the hand, a scale bar in millimetres (or what
/// fits) of the data's world, and axes x y z of the world; in a medical frame instead of them the patient's directions
/// (L R A P S I) at the edges. Legend and colour bars have the colours that are seen on what faces the viewer. Data that change
/// with time are drawn as at the moment, without one as at first. A scene that names no layers shows the levels of its modes as
/// surfaces and their first vector field as streamlines, or else a scalar field as slices.
///
/// Needs no X; one picture at a time is drawn in a process, a second thread waits. The same input gives the
/// same bytes on one machine. Throws LoadError where nothing can be drawn (no EGL), on a layer of the wrong
/// kind of field, on a size not within 200 x 150 to 8000 x 8000 pixels, and on `from` along `up`.
Picture scene_picture(const Scene& scene, std::span<const PathPoint> path, const std::optional<Moment>& moment,
                      const ScenePictureOptions& options = {});

}  // namespace palpa
