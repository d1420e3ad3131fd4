// Pictures in memory and as PNG; pictures of a scene: layers, paths of probe and proxy, primitives of one moment.
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

/// PNG file of a picture, as bytes; equal pictures give equal bytes.
std::string png_of(const Picture& picture);
/// Writes the PNG file, replacing an existing file; never follows a link. Throws LoadError on failure.
void save_png(const Picture& picture, const std::filesystem::path& file);

/// One point of a recorded path, in the hand frame.
struct PathPoint {
  Vec3 probe_m;
  Vec3 proxy_m;
  Vec3 force_n;          ///< on the hand
  Vec3 asked_n{};        ///< of the coupling, before limits
  bool limited = false;  ///< by the guard; at a break-through the forces differ without it
};

/// Primitives of one sub-step: a plane is drawn as a disc with its normal, a line as a rod, a point as a ball, a directed force
/// as an arrow; the spring between proxy and probe; and the feet of the scene's tool at the proxy, red by the force on each,
/// with a paler copy at the probe.
struct Moment {
  Vec3 probe_m;
  Vec3 proxy_m;
  std::vector<PlacedPrimitive> primitives;
  std::vector<std::string> mode_names;  ///< by PrimitiveId::mode, for the legend
  double time_s = 0.0;                  ///< since the session began; data that change are drawn at this time
  Turn probe_turn{}, proxy_turn{};      ///< of the scene's tool; unused for a point
};

/// Size and viewpoint of a picture.
struct ScenePictureOptions {
  int width_px = 1200;
  int height_px = 900;
  Vec3 from{0.45, 0.35, 1.0};  ///< [1] to the viewer, hand frame; by default the user, a little above and to the right
  Vec3 up{0.0, 1.0, 0.0};      ///< [1] upward direction of the picture, hand frame
  /// Half the picture's height [hand m]; 0: fits the path, and as much of the data as keeps it legible. The projection is
  /// parallel.
  double half_height_m = 0.0;
  /// Centre of the picture [hand m]; none: the content, or with `half_height_m` the moment, is centred beside title and legend.
  std::optional<Vec3> centre_m{};
};

/// View of a whole path: the scene's own; or straight on, if the hand stayed in a plane across the user's sight; or from near
/// the user, with most contacts visible and spread out.
ScenePictureOptions overview(const Scene& scene, std::span<const PathPoint> path);
/// View of a moment and its surroundings: the proxy visible, the spring oblique to the line of sight.
ScenePictureOptions close_up(const Scene& scene, const Moment& moment);

/// Draws the scene's layers, the path coloured by the force on the hand and banded where the guard limited it (the probe's as a
/// thin grey line), and the moment's primitives in front of all (with `half_height_m` only the path near the moment).
/// Annotations beside the scene: title, legend, colour bar in newtons up to the largest force on the hand, scale bar in
/// millimetres (or a unit that fits) of the data's world, axes x y z of the world or, in a medical frame, the patient's
/// directions (L R A P S I) at the edges. Legend and colour bars have the colours of surfaces that face the viewer. Changing
/// data are drawn at the moment's time, by default the first. Default layers: the levels of the modes as surfaces and their
/// first vector field as streamlines, or else a scalar field as slices.
///
/// Needs no X; one picture at a time per process, other threads block. Equal input gives equal bytes on one machine. Throws
/// LoadError without EGL, on a layer of the wrong kind of field, on a size not within 200 x 150 to 8000 x 8000 pixels, and on
/// `from` along `up`.
Picture scene_picture(const Scene& scene, std::span<const PathPoint> path, const std::optional<Moment>& moment,
                      const ScenePictureOptions& options = {});

}  // namespace palpa
