// Scene: volumes, modes, coupling, workspace, law. All inputs of a session but the device.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "palpa/base/load_error.h"
#include "palpa/data/grid.h"
#include "palpa/data/timed_field.h"
#include "palpa/data/volume.h"
#include "palpa/mode/mode.h"
#include "palpa/solver/coupling.h"
#include "palpa/solver/similarity.h"
#include "palpa/solver/tool.h"

namespace palpa {

/// Placement of the device's workspace in the world.
struct Workspace {
  std::string fit;               ///< volume whose longest side is scaled to 0.15 m in the hand frame; empty: use `scale`
  std::optional<double> scale;   ///< [1] world metres per hand metre, > 0
  std::string center_volume;     ///< the workspace is centred on this volume's box
  std::optional<Vec3> center_m;  ///< workspace centre [m, world], instead of `center_volume`; neither: centre of `fit`
  std::string towards_user;      ///< world direction facing the user: "anterior", "+x", …; empty: default of the frame
  std::string up;                ///< world direction that points up; empty: default of the frame
  friend bool operator==(const Workspace&, const Workspace&) = default;
};

/// Progress of the data's time during a session ([time]).
struct TimeOptions {
  enum class Play : std::uint8_t {
    hold,  ///< the time stays at `start_s`
    once,  ///< the time stops at the end of the data
    loop,  ///< the data repeat, each volume after its own length; the last frame of a series blends into the first
  };
  Play play = Play::hold;
  double speed = 1.0;    ///< [1] seconds of data per second, > 0
  double start_s = 0.0;  ///< [s] initial time of the data, >= 0

  /// Time of the data after `elapsed_s` [s] of a session.
  DataTime at(double elapsed_s) const noexcept;
  friend bool operator==(const TimeOptions&, const TimeOptions&) = default;
};

/// Invalid scene.
class SceneError : public LoadError {
 public:
  using LoadError::LoadError;
};

/// A volume of a scene.
struct SceneVolume {
  std::string name;
  Volume volume;  ///< posed: its fields are in the world of the scene
  Similarity pose;
  PoseTrack poses;           ///< motion, in place of `pose`; empty for a static volume
  double smoothing_m = 0.0;  ///< [m] standard deviation of smoothing on loading; 0: two sample spacings
  std::string source;        ///< body of its TOML table as given, for printing; empty for a volume from code
};

/// Layer of pictures of the scene ([[view.layer]]). Does not affect the forces.
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
  std::optional<double> level{};  ///< of a surface: its value, in the field's own unit
  std::vector<ColorPoint> colors{};
  std::string name{};      ///< in the legend; empty: the name of a mode's level, or of the field
  bool all_parts = false;  ///< of a surface: also parts much smaller than the largest
  friend bool operator==(const ViewLayer&, const ViewLayer&) = default;
};

/// A mode of a scene.
struct SceneMode {
  /// Feet of the tool at which a mode samples the data and places primitives.
  enum class Feet : std::uint8_t { all, first };
  std::string name;
  Mode mode;
  bool enabled = true;
  std::vector<Mask> masks;
  std::optional<Feet> feet{};  ///< none: all of a mode with levels, else the first, so that a tool in a flow feels as a point

  /// Whether the mode acts at the foot of this number, 0 of a point tool. Allocates nothing; any thread.
  bool acts_at(std::size_t foot) const noexcept { return foot == 0 || (feet ? *feet == Feet::all : mode.has_levels()); }
};

/// One of several hands of a scene ([[hand]]), with its tool.
struct SceneHand {
  std::string name;    ///< plain word
  Vec3 at_m{};         ///< [m] middle of its reach in the hand frame of the workspace; each within 1 m
  ToolOptions tool{};  ///< in its own hand frame
  friend bool operator==(const SceneHand&, const SceneHand&) = default;
};

namespace detail {
/// Mode of a scene with valid parameters: checked once, by its constructor, as far as that needs no data. Fields are left to
/// `Scene::add`.
class CheckedMode {
 public:
  /// \param number  of the mode in the scene. Throws SceneError.
  CheckedMode(SceneMode mode, std::size_t number);
  const SceneMode& get() const noexcept { return mode_; }

 private:
  SceneMode mode_;
};
}  // namespace detail

/// Options of pictures of the scene ([view]). Do not affect the forces.
struct ViewOptions {
  std::optional<Vec3> from{};  ///< [1] direction of the world towards the camera; none: chosen for the trace
  friend bool operator==(const ViewOptions&, const ViewOptions&) = default;
};

/// A scene, as a value: copyable (voxels are shared), comparable, printable as TOML. Valid at any time: each part is checked
/// once, where it enters, by the functions that add, set or edit it; they throw SceneError with nothing changed. A session
/// takes a scene without checking it again. Not for the tick: members may allocate.
class Scene {
 public:
  explicit Scene(const CouplingOptions& coupling = {});

  // Not felt, hence free.
  std::string title;
  std::vector<std::string> needs;  ///< mode types of required plug-ins
  std::vector<ViewLayer> layers;
  ViewOptions view;

  const CouplingOptions& coupling() const noexcept { return std::get<CouplingOptions>(options_); }
  const Workspace& workspace() const noexcept { return std::get<Workspace>(options_); }
  const TimeOptions& time() const noexcept { return std::get<TimeOptions>(options_); }
  /// Of a scene of several hands: the first hand's.
  const ToolOptions& tool() const noexcept { return std::get<ToolOptions>(options_); }
  /// Empty: one hand without a name, with `tool`.
  const std::vector<SceneHand>& hands() const noexcept { return hands_; }
  /// \param hand  below the number of hands, or 0
  const ToolOptions& tool_of(std::size_t hand) const noexcept { return hands_.empty() ? tool() : hands_[hand].tool; }
  const std::string& law() const noexcept { return law_; }
  /// Replaces the coupling, the workspace, the progress of time or the tool of a hand. A workspace may name a volume that is
  /// added later.
  void set(const CouplingOptions& coupling);
  void set(const Workspace& workspace);
  void set(const TimeOptions& time);
  /// \param hand  below the number of hands, or 0
  void set(const ToolOptions& tool, std::size_t hand = 0);
  /// Replaces the law by the law of this name ("exact", …).
  void set_law(std::string name);
  /// Changes one of these structs: calls `change` with an Options&.
  template <class Options, class Change>
  void edit(Change&& change) {
    Options changed = std::get<Options>(options_);
    change(changed);
    set(changed);
  }

  /// Adds a hand with a new name, at most 8. A session of the scene is that of the first; `of_hand` makes those of the others.
  void add_hand(SceneHand hand);
  /// The scene of a single hand: no other, and its tool. The voxels are shared.
  /// \param number  of the hand, below the number of hands, or 0
  Scene of_hand(std::size_t number) const;
  /// Likewise by name. Throws SceneError if no hand has it.
  Scene of_hand(std::string_view name) const;

  /// Adds a volume, moved by `pose`; returns the name of its first field. The name must be a new plain word. Its grids are
  /// interpolated with `filter`; without one, trilinear grids get the default filter for their data, and other fields keep
  /// theirs (`filtered`, volume.h).
  FieldRef add(std::string name, Volume volume, const Similarity& pose = {}, std::optional<Filter> filter = {});
  /// Adds a volume that moves from pose to pose.
  FieldRef add_moving(std::string name, Volume volume, const PoseTrack& poses, std::optional<Filter> filter = {});
  /// Adds a volume with all that belongs to it, not yet posed.
  FieldRef add(SceneVolume volume, std::optional<Filter> filter = {});
  /// Adds a mode with a new name; its fields must exist.
  void add(std::string name, Mode mode, std::vector<Mask> masks = {}, bool enabled = true);
  void add(detail::CheckedMode mode);

  /// Changes the parameters of a mode: calls `change` with an M&. Throws SceneError if no mode has this name and type, or if
  /// the changed mode is not valid, or the exceptions of `change`, with nothing changed.
  template <class M, class Change>
  void edit(std::string_view name, Change&& change) {
    edit_mode(name, [&](SceneMode& mode) {
      M* const parameters = mode.mode.as<M>();
      if (!parameters) throw SceneError(not_of_type(mode, M::type));
      change(*parameters);
    });
  }
  /// Likewise a mode of any type, with its name, its masks and whether it is enabled: calls `change` with a SceneMode&.
  template <class Change>
  void edit_mode(std::string_view name, Change&& change) {
    const std::size_t number = number_of_mode(name);
    SceneMode changed = modes_[number];
    change(changed);
    replace_mode(number, std::move(changed));
  }
  /// Removes a mode, if it exists.
  void remove_mode(std::string_view name) noexcept;

  const std::vector<SceneVolume>& volumes() const noexcept { return volumes_; }
  const std::vector<SceneMode>& modes() const noexcept { return modes_; }
  /// nullptr if there is none of this name; valid until the scene changes.
  const SceneVolume* find_volume(std::string_view name) const noexcept;
  const SceneMode* find_mode(std::string_view name) const noexcept;

  /// Field of a reference; throws SceneError if there is none, or if a bare volume name has several fields. A derived field is
  /// computed on first use, and cached, also for copies of the scene. Any thread.
  VolumeField field(const FieldRef& ref) const;
  /// Field derived by `derivation` from the field of a reference, likewise cached.
  FieldPtr field(const FieldRef& ref, Derivation derivation) const;
  /// Number of a field among those of all volumes; -1 for a derived field. Throws as `field` does.
  std::int32_t index_of(const FieldRef& ref) const;

  /// Map from the hand frame to the world by the workspace (design.md, Frames); the identity without volumes. Of a scene of
  /// several hands: from the first hand's own frame, whose origin is at its `at_m`. Throws SceneError if the workspace has no
  /// place among the volumes.
  Similarity hand_to_world() const;

  /// Warnings about the scene (level outside the data's range, …). Throws SceneError as `hand_to_world` does.
  std::vector<std::string> check() const;

 private:
  class DerivedFields;
  static std::string not_of_type(const SceneMode& mode, std::string_view type);
  std::size_t number_of_mode(std::string_view name) const;
  void replace_mode(std::size_t number, SceneMode mode);
  std::tuple<CouplingOptions, Workspace, TimeOptions, ToolOptions> options_;
  std::string law_ = "exact";
  std::vector<SceneVolume> volumes_;
  std::vector<SceneMode> modes_;
  std::vector<SceneHand> hands_;  // the first one's tool is that of `options_`
  std::shared_ptr<DerivedFields> derived_;
};

/// Scene as TOML, readable by `load_scene`.
std::string to_toml(const Scene& scene);
/// True if TOML and data are equal (shared voxels or equal files).
bool operator==(const Scene& a, const Scene& b);

}  // namespace palpa
