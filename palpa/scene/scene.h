// A scene: volumes, modes, coupling, workspace, law. All that a session needs but the device.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "palpa/base/load_error.h"
#include "palpa/data/grid.h"
#include "palpa/data/timed_field.h"
#include "palpa/data/volume.h"
#include "palpa/mode/mode.h"
#include "palpa/solver/coupling.h"
#include "palpa/solver/similarity.h"

namespace palpa {

/// How the hand's reach lies in the world.
struct Workspace {
  std::string fit;               ///< volume whose box's longest side becomes 0.15 m of hand; empty: `scale` holds
  std::optional<double> scale;   ///< [1] world metres per hand metre, > 0
  std::string center_volume;     ///< the middle of the reach touches this volume's box centre
  std::optional<Vec3> center_m;  ///< the middle of the reach [m, world], instead of that; neither: the fitted volume's centre
  std::string towards_user;      ///< world direction facing the user: "anterior", "+x", …; empty: by the frame
  std::string up;                ///< world direction that is up; empty: by the frame
  friend bool operator==(const Workspace&, const Workspace&) = default;
};

/// How the data's time goes while the hand feels ([time]).
struct TimeOptions {
  enum class Play : std::uint8_t {
    hold,  ///< the data stay at `start_s`
    once,  ///< they go on to their end and stay there
    loop,  ///< they begin again, each volume after its own length; of a series the last frame blends into the first
  };
  Play play = Play::hold;
  double speed = 1.0;    ///< [1] seconds of data per second, > 0
  double start_s = 0.0;  ///< [s] moment of the data that is felt first, >= 0

  /// The moment of the data when a session has gone on for so long [s].
  DataTime at(double elapsed_s) const noexcept;
  friend bool operator==(const TimeOptions&, const TimeOptions&) = default;
};

/// A scene that cannot be used.
class SceneError : public LoadError {
 public:
  using LoadError::LoadError;
};

/// A volume of a scene.
struct SceneVolume {
  std::string name;
  Volume volume;  ///< posed: its fields are where the scene puts them
  Similarity pose;
  PoseTrack poses;           ///< how it moves, in place of `pose`; empty for a volume that stays where it is
  double smoothing_m = 0.0;  ///< [m] standard deviation of what is smoothed when it is loaded; 0: two sample spacings
  std::string source;        ///< its TOML table's body as it was given, for printing; empty for a volume from code
};

/// Something that a picture of the scene shows ([[view.layer]]). Nothing that is felt depends on it.
struct ViewLayer {
  enum class Show : std::uint8_t { surface, slices, volume, streamlines, glyphs };
  struct ColorPoint {
    double value = 0.0;    ///< of the field, in its own unit; of a vector field: its magnitude
    std::string color;     ///< "#rrggbb"
    double opacity = 1.0;  ///< [1] 0…1
    friend bool operator==(const ColorPoint&, const ColorPoint&) = default;
  };
  Show show = Show::surface;
  FieldRef field{};
  std::optional<double> level{};  ///< of a surface: the value it is drawn at, in the field's own unit
  std::vector<ColorPoint> colors{};
  std::string name{};      ///< what the legend calls it; empty: as the level of a mode, or else the field, is called
  bool all_parts = false;  ///< of a surface: also parts that are small beside the largest
  friend bool operator==(const ViewLayer&, const ViewLayer&) = default;
};

/// A mode of a scene.
struct SceneMode {
  std::string name;
  Mode mode;
  bool enabled = true;
  std::vector<Mask> masks;
};

/// How pictures of the scene are taken ([view]). Nothing that is felt depends on it.
struct ViewOptions {
  std::optional<Vec3> from{};  ///< [1] direction of the world from which they look; none: chosen for what was felt
  friend bool operator==(const ViewOptions&, const ViewOptions&) = default;
};

/// A scene, as a value: copyable (voxels are shared), comparable, printable as TOML. Not for the tick:
/// everything here may allocate and throws SceneError on what cannot be used.
class Scene {
 public:
  explicit Scene(CouplingOptions coupling = {});

  std::string title;
  std::vector<std::string> needs;  ///< mode types that plug-ins must bring
  CouplingOptions coupling;
  std::string law = "exact";
  Workspace workspace;
  TimeOptions time;
  std::vector<ViewLayer> layers;
  ViewOptions view;

  /// Adds a volume, moved by `pose`; returns the name of its first field. The name is a plain word and
  /// not taken. Its grids are felt through `filter`; without one, trilinear grids get the default of their voxels and
  /// all else stays (`filtered`, volume.h).
  FieldRef add(std::string name, Volume volume, const Similarity& pose = {}, std::optional<Filter> filter = {});
  /// Adds a volume that moves from pose to pose.
  FieldRef add_moving(std::string name, Volume volume, const PoseTrack& poses, std::optional<Filter> filter = {});
  /// Adds a mode; its fields must be there. The name is not taken.
  void add(std::string name, Mode mode, std::vector<Mask> masks = {}, bool enabled = true);

  /// Changes the parameters of a mode: `change` gets them as an M&. Throws SceneError, with nothing changed, where no mode has
  /// this name or it is of another type, and what `change` throws.
  template <class M, class Change>
  void edit(std::string_view name, Change&& change) {
    SceneMode* const mode = find_mode(name);
    const M* const parameters = mode ? mode->mode.as<M>() : nullptr;
    if (!parameters) throw SceneError(no_mode_to_edit(name, M::type));
    M changed = *parameters;
    change(changed);
    mode->mode = std::move(changed);
  }
  /// Takes a mode away; nothing where there is none of this name.
  void remove_mode(std::string_view name) noexcept;

  const std::vector<SceneVolume>& volumes() const noexcept { return volumes_; }
  const std::vector<SceneMode>& modes() const noexcept { return modes_; }
  SceneVolume* find_volume(std::string_view name) noexcept;
  SceneMode* find_mode(std::string_view name) noexcept;

  /// The field that a reference names; throws SceneError when there is none, or when a bare volume name has
  /// several fields. A derived field is computed the first time that it is asked for, and kept: copies of
  /// the scene share it. Any thread.
  VolumeField field(const FieldRef& ref) const;
  /// A derivation of the field that a reference names, kept in the same way.
  FieldPtr field(const FieldRef& ref, Derivation derivation) const;
  /// The number of a field that is no derived one, counting the fields of all volumes in order; -1 for a
  /// derived one. Throws as `field` does.
  std::int32_t index_of(const FieldRef& ref) const;

  /// The map from the hand frame to the world that the workspace asks for (design.md, Frames). Without
  /// volumes it is the identity.
  Similarity hand_to_world() const;

  /// Checks everything that must fit together; throws SceneError at the first that does not. Returns
  /// warnings (level outside the data's range, …), without a place.
  std::vector<std::string> check() const;

 private:
  class DerivedFields;
  FieldRef add(SceneVolume volume, std::optional<Filter> filter);
  std::string no_mode_to_edit(std::string_view name, std::string_view type) const;
  std::vector<SceneVolume> volumes_;
  std::vector<SceneMode> modes_;
  std::shared_ptr<DerivedFields> derived_;
};

/// The scene as TOML, as `load_scene` reads it.
std::string to_toml(const Scene& scene);
/// Same TOML, same data (shared voxels or the same files).
bool operator==(const Scene& a, const Scene& b);

}  // namespace palpa
