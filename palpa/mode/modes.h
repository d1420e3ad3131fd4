// Modes of the library, for scenes made in a program.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "palpa/mode/mode.h"

namespace palpa {

/// Surface and friction (paper, Fig. 4): a plane on a surface of a scalar field, and a line along its normal that resists
/// sliding.
///
/// The surface is one of the levels (shells: each bears until k·depth reaches its strength, then breaks; a level with a
/// stiffness of its own yields before, so that levels below are felt through it), or, with `strength_n` as a transfer function
/// of the field (material), at the proxy: every value is a surface that yields at its own strength.
///
/// With φ the field, g = ∇φ, σ = +1 where high values are solid: normal n = −σ g/|g|, and the plane stands on the captured
/// level φ_c, one Newton step from the proxy: a = x + g (φ_c − φ)/|g|². A plane left at the proxy would drift off a sphere by
/// π·speed·T per turn.
///
/// Static friction exceeds kinetic friction by a ratio, and friction has a viscous part; both are off by default (the paper's
/// law). It becomes static after 20 ms without sliding, not at the first repeated position: to an encoder a slow hand stands
/// still most of the time (zero-velocity band: Karnopp, Computer simulation of stick-slip friction in mechanical dynamic
/// systems, J. Dyn. Syst. Meas. Control 107(1), 1985).
///
/// Texture, off by default, modulates friction by the detail that the field's filter removes (Derivation::detail): roughness
/// along the surface, as in M. Minsky et al., Feeling and seeing: issues in force display, Symp. Interactive 3D Graphics, 1990,
/// and, by friction as here, C.-H. Ho, C. Basdogan and M. A. Srinivasan, Efficient point-based rendering techniques for haptic
/// display of virtual objects, Presence 8(5), 1999. It is no law of the paper and no property of the scanned object. It only
/// scales resistance, so it dissipates energy and the surface stays in place.
///
/// Where the field is as flat as its noise a gradient has a random direction: there the surface fades, and in the solid a point
/// at the proxy may replace it.
struct SurfaceAndFriction {
  static constexpr auto type = "surface_and_friction";
  static constexpr auto summary = "Surfaces that one stands on, slides over and presses through.";

  enum class Solid { high, low, both };

  struct Level {
    std::string name{};
    double value = 0.0;  ///< the field's own unit
    Strength strength_n{1.0};
    std::optional<double> stiffness_n_per_m{};  ///< none: rigid
    std::optional<double> friction_n{};
    std::optional<double> friction_coefficient{};  ///< [1]

    static constexpr auto parameters() {
      return std::tuple{
          param("name", &Level::name, "what the level is called in reports and --set; events have its value"),
          level_param("value", &Level::value, "value of the field that is felt as a surface, in the field's own unit"),
          param("strength_n", &Level::strength_n, "force at which the hand presses through"),
          param("stiffness_n_per_m", &Level::stiffness_n_per_m,
                "stiffness of its own, in series with the coupling's: how it gives way before; left out: rigid", Range{1, 1e6}),
          param("friction_n", &Level::friction_n, "force that resists sliding; left out: the mode's", Range{0, 100}),
          param("friction_coefficient", &Level::friction_coefficient,
                "friction as a share of the force on the surface; left out: the mode's", Range{0, 10})};
    }
    friend bool operator==(const Level&, const Level&) = default;
  };

  FieldRef field{};
  Solid solid = Solid::high;
  std::vector<Level> levels{};
  Strength strength_n{0.0};
  double friction_n = 0.0;
  double friction_coefficient = 0.0;   ///< [1]
  double static_friction_ratio = 1.0;  ///< [1]
  double friction_ns_per_m = 0.0;
  double noise_per_m = 0.0;  ///< [unit of the field per world metre]
  Strength flat_strength_n{0.0};
  double texture_ratio = 0.0;  ///< [1]

  static constexpr auto parameters() {
    using S = SurfaceAndFriction;
    return std::tuple{
        param("field", &S::field, "scalar field whose surfaces are felt"),
        choice_param("solid", &S::solid, "which side of a level is solid: one is held on the other side", "high", "low",
                     "both"),
        list_param("level", &S::levels,
                   "surfaces at given values; each holds from where it is met until it is left or pressed through"),
        param("strength_n", &S::strength_n, "material, instead of levels: strength as a function of the field's value"),
        param("friction_n", &S::friction_n, "force that resists sliding on a surface", Range{0, 100}),
        param("friction_coefficient", &S::friction_coefficient,
              "friction as a share of the force on the surface, instead of friction_n", Range{0, 10}),
        param("static_friction_ratio", &S::static_friction_ratio,
              "static over kinetic friction: so many times as strong until it slides, and again once it has held for 20 ms",
              Range{1, 10}),
        param("friction_ns_per_m", &S::friction_ns_per_m, "viscous part of friction: force per speed along the surface",
              Range{0, 100}),
        param("noise_per_m", &S::noise_per_m,
              "steepness of noise, in the field's unit per metre of the world: no surface where the field is not steeper, the "
              "whole of it from three times that on",
              Range{0, std::numeric_limits<double>::infinity()}),
        param("flat_strength_n", &S::flat_strength_n,
              "resistance to all motion in the solid, as far as noise_per_m leaves no surface there"),
        param("texture_ratio", &S::texture_ratio,
              "by how much friction varies, as a share of it, with detail too fine for the field's smooth filter", Range{0, 1}),
        companion_param(&S::field, Derivation::detail, &S::has_texture)};
  }
  bool has_texture() const { return texture_ratio > 0.0; }
  /// Checks: levels or material, friction as a force or as a coefficient; flat strength needs a noise and a solid side, texture
  /// needs friction.
  std::string problem() const;

  /// Largest number of shells placed at once: a rigid one below elastic ones.
  static constexpr std::size_t most_placed = 4;
  /// Input of the next placement, from the path: side of the proxy at each shell that it has crossed, and positions of planes
  /// in the field. No contact: a placed plane may be off, and a shell stays where its plane cannot be placed, in flat data.
  /// Contacts of the proxy are in the session's ContactTable alone, from where `place` reads them (`ModeContext::contacts`).
  struct Memory {
    struct Shell {
      std::int32_t level = -1;  ///< index; -1: none
      bool from_low = true;     ///< crossed from lower values: the low side is free
      double kinetic_s = 0.0;   ///< remaining time of kinetic friction
      double pressed_to = 0.0;  ///< position of the plane, in the field's own unit: the level's value until it yields
    };
    std::array<Shell, most_placed> shells;  ///< to place, in any order; for material the friction of the first
    bool stays = false;                     ///< the material's plane stays at `value`; else it is placed at the proxy
    double value = 0.0;                     ///< position of the material's plane, in the field's own unit
  };
  void place(const ModeContext& here, const Memory& memory, PrimitiveSink out) const noexcept;
  void on_step_accepted(const StepResult& result, Memory& memory) const noexcept;

 private:
  struct Standing;
  double texture_factor(const ModeContext& here, std::uint16_t slot) const noexcept;
  void stand(const ModeContext& here, const Standing& on, PrimitiveSink out) const noexcept;
  void give_way(const StepResult& result, std::uint16_t slot, Memory::Shell& shell) const noexcept;
  void rub(const StepResult& result, Memory& memory) const noexcept;
  void cross(Memory& memory, std::int32_t level, bool from_low) const noexcept;
  bool is_solid(double value) const noexcept;
};

/// Viscosity: a point primitive at the proxy. Its strength resists motion with equal force at any speed (Coulomb; the paper's
/// mode); its drag in proportion to the speed (f = c v).
struct Viscosity {
  static constexpr auto type = "viscosity";
  static constexpr auto summary = "Resistance to motion in every direction, where the data say so.";

  FieldRef field{};
  Strength strength_n{0.0};
  double drag_ns_per_m = 0.0;

  static constexpr auto parameters() {
    return std::tuple{
        optional_field_param("field", &Viscosity::field, "field in whose data the resistance is felt; left out: everywhere"),
        param("strength_n", &Viscosity::strength_n, "force that motion has to overcome, whatever its speed"),
        param("drag_ns_per_m", &Viscosity::drag_ns_per_m, "force per speed: true viscosity", Range{0, 100})};
  }
  /// Checks: strength or drag is set.
  std::string problem() const;
  void place(const ModeContext& here, PrimitiveSink out) const noexcept;
};

/// Gradient force (paper: directed force): a pull uphill or downhill in a scalar field, smoothed on loading. A pull whose
/// direction turns within less than 2s/k would buzz at the top of a hill, so it is limited there: s ≤ (k/2)·|g|/‖∂g/∂x‖ with g
/// the gradient.
struct GradientForce {
  static constexpr auto type = "gradient_force";
  static constexpr auto summary = "A pull uphill or downhill in a scalar field.";

  enum class Towards { high, low };

  FieldRef field{};
  Strength strength_n{0.5};
  Towards towards = Towards::high;
  double noise_per_m = 0.0;  ///< [unit of the field per world metre]

  static constexpr auto parameters() {
    using M = GradientForce;
    return std::tuple{derived_param("field", &M::field, Derivation::smooth, "scalar field whose slope is felt"),
                      param("strength_n", &M::strength_n,
                            "force of the pull; a function of gradient_magnitude(FIELD) makes steep places pull more"),
                      choice_param("towards", &M::towards, "which way it pulls: towards high or low values", "high", "low"),
                      param("noise_per_m", &M::noise_per_m,
                            "steepness of noise, in the field's unit per metre of the world: no pull where the slope is not "
                            "above it, all of it from three times that on",
                            Range{0, std::numeric_limits<double>::infinity()})};
  }
  void place(const ModeContext& here, PrimitiveSink out) const noexcept;
};

/// Follow: a line primitive along the field: motion across it costs force, motion along it is free. The field's sign has no
/// effect.
struct Follow {
  static constexpr auto type = "follow";
  static constexpr auto summary = "A rail along the field: free along it, held across it.";

  FieldRef field{};
  Strength strength_n{0.5};
  double drag_ns_per_m = 0.0;

  static constexpr auto parameters() {
    return std::tuple{
        vector_param("field", &Follow::field, "vector field to follow"),
        param("strength_n", &Follow::strength_n, "force that holds the hand on the line; above it the hand slides across"),
        param("drag_ns_per_m", &Follow::drag_ns_per_m, "viscous resistance to motion across the field", Range{0, 100})};
  }
  void place(const ModeContext& here, PrimitiveSink out) const noexcept;
};

/// Front shape: a plane across the field at the proxy. Motion with the field and along its front is free, motion against it
/// costs force.
struct FrontShape {
  static constexpr auto type = "front_shape";
  static constexpr auto summary = "A wall across the field: one moves with it, not against it.";

  FieldRef field{};
  Strength strength_n{0.5};
  double drag_ns_per_m = 0.0;

  static constexpr auto parameters() {
    return std::tuple{
        vector_param("field", &FrontShape::field, "vector field whose front is felt"),
        param("strength_n", &FrontShape::strength_n, "force at which the hand gets through against the field"),
        param("drag_ns_per_m", &FrontShape::drag_ns_per_m, "viscous resistance to motion against the field", Range{0, 100})};
  }
  void place(const ModeContext& here, PrimitiveSink out) const noexcept;
};

/// Transverse damping: a line primitive along the field whose drag resists motion across the field, f = −c (v − (v·q) q);
/// motion along it is free. A strength resists at any speed, as in `follow`.
struct TransverseDamping {
  static constexpr auto type = "transverse_damping";
  static constexpr auto summary = "A flow thick as honey across, free along it.";

  FieldRef field{};
  double drag_ns_per_m = 5.0;
  Strength strength_n{0.0};

  static constexpr auto parameters() {
    using M = TransverseDamping;
    return std::tuple{
        vector_param("field", &M::field, "vector field along which motion is free"),
        param("drag_ns_per_m", &M::drag_ns_per_m, "force per speed of motion across the field", Range{0, 100}),
        param("strength_n", &M::strength_n, "force that motion across the field has to overcome, whatever its speed")};
  }
  /// Checks: drag or strength is set.
  std::string problem() const;
  void place(const ModeContext& here, PrimitiveSink out) const noexcept;
};

/// Vector force: a directed force along the field: the flow carries the hand. Where the direction turns within less than 2s/k
/// it is limited, s ≤ (k/2)·|V|/‖J‖, so that it fades at stagnation points and in cores.
struct VectorForce {
  static constexpr auto type = "vector_force";
  static constexpr auto summary = "A push along the field: one is carried by the flow.";

  FieldRef field{};
  Strength strength_n{0.5};

  static constexpr auto parameters() {
    return std::tuple{vector_param("field", &VectorForce::field, "vector field that pushes"),
                      param("strength_n", &VectorForce::strength_n,
                            "force of the push; a function of magnitude(FIELD) makes fast places push more")};
  }
  void place(const ModeContext& here, PrimitiveSink out) const noexcept;
};

/// All vortex modes find vortices by Q = (|W|² − |S|²)/2 of the smoothed velocity, which is positive where the flow rotates
/// more than it deforms, and is independent of a moving observer. A constant strength applies where Q is at least 5 % of its
/// maximum in the data, limited from there to k/2 × the depth; a strength that is a function sets its own region, best as a
/// function of q(FIELD).
///
/// Direction to the core:
///   q                 ∇Q: exact in a smooth round vortex, and independent of the observer. Zero in a core in solid rotation,
///                     where Q is constant.
///   vorticity         ω × (u − b), of the literature: correct if the vortex is at rest for the observer moving at b, the
///                     `background`, and ω keeps its sign.
///   reduced_velocity  the Newton step to where u − b has no component across the axis of rotation: correct, with the distance,
///                     in any core, also in solid rotation, for that observer alone.
enum class VortexDirection { q, vorticity, reduced_velocity };

/// Vortex force (paper: vortex core, directed force): a pull towards the core, fading where its direction turns.
struct VortexForce {
  static constexpr auto type = "vortex_force";
  static constexpr auto summary = "A pull towards the core of a vortex.";

  FieldRef field{};  ///< Q of the velocity; its companion: the smoothed velocity
  Strength strength_n{0.5};
  VortexDirection direction = VortexDirection::q;
  Vec3 background{};  ///< [unit of the field] along the axes of the world

  static constexpr auto parameters() {
    using M = VortexForce;
    return std::tuple{derived_param("field", &M::field, Derivation::q, "velocity field whose vortices are felt"),
                      companion_param(&M::field, Derivation::smooth_vector, &M::needs_velocity),
                      param("strength_n", &M::strength_n,
                            "force of the pull; a number: where Q is at least 5 % of its maximum; or a function of q(FIELD)"),
                      choice_param("direction", &M::direction, "what points to the core", "q", "vorticity", "reduced_velocity"),
                      param("background", &M::background, background_sentence)};
  }
  bool needs_velocity() const { return direction != VortexDirection::q; }
  /// Checks: a background only if the direction depends on it.
  std::string problem() const;
  void place(const ModeContext& here, PrimitiveSink out) const noexcept;

  /// Description of that parameter in all vortex modes.
  static constexpr std::string_view background_sentence =
      "velocity at which the vortex moves along, in the field's unit along the world's axes; not with direction = \"q\"";
};

/// Vortex plane (paper: vortex shape, plane): a tube that is free to enter and holds the hand inside. The plane's normal points
/// to the core. With direction q it stands on the level of Q that the proxy has reached, else at the proxy.
struct VortexPlane {
  static constexpr auto type = "vortex_plane";
  static constexpr auto summary = "A tube around the core of a vortex: free to enter, held inside.";

  FieldRef field{};  ///< Q of the velocity; its companion: the smoothed velocity
  Strength strength_n{0.5};
  VortexDirection direction = VortexDirection::q;
  Vec3 background{};  ///< [unit of the field] along the axes of the world

  static constexpr auto parameters() {
    using M = VortexPlane;
    return std::tuple{derived_param("field", &M::field, Derivation::q, "velocity field whose vortices are felt"),
                      companion_param(&M::field, Derivation::smooth_vector, &M::needs_velocity),
                      param("strength_n", &M::strength_n,
                            "force that holds the hand in the vortex; a number: where Q is at least 5 % of its maximum; or a "
                            "function of q(FIELD)"),
                      choice_param("direction", &M::direction, "what points to the core", "q", "vorticity", "reduced_velocity"),
                      param("background", &M::background, VortexForce::background_sentence)};
  }
  bool needs_velocity() const { return direction != VortexDirection::q; }
  /// Checks: a background only if the direction depends on it.
  std::string problem() const;

  /// Position of the plane for the next placement; no contact, as in SurfaceAndFriction.
  struct Memory {
    bool stays = false;  ///< the plane stays on the level `value`; else it is placed on the proxy's
    double value = 0.0;  ///< Q of the plane's level, [1/s²] where velocities are in m/s
  };
  void place(const ModeContext& here, const Memory& memory, PrimitiveSink out) const noexcept;
  void on_step_accepted(const StepResult& result, Memory& memory) const noexcept;
};

/// Vortex line: a line primitive on the core line of the vortex around the proxy, one Newton step from it. Within reach of its
/// strength the hand is held on the core and free along it; further away it is attracted.
///
/// Unlike the other resisting primitives, it does not pass through the proxy, so it injects energy, like a directed force. It
/// buzzes less: the line hardly depends on the sample position, so it keeps its whole strength at the core, where a directed
/// force has to fade.
struct VortexLine {
  static constexpr auto type = "vortex_line";
  static constexpr auto summary = "A pull onto the core line of a vortex, which holds the hand there, free along it.";

  /// Method to find the core: the ridge of Q, or the zero of the reduced velocity across the axis.
  enum class By { q, reduced_velocity };

  FieldRef field{};  ///< Q of the velocity; its companion: the smoothed velocity
  Strength strength_n{0.5};
  By direction = By::q;
  Vec3 background{};  ///< [unit of the field] along the axes of the world

  static constexpr auto parameters() {
    using M = VortexLine;
    return std::tuple{
        derived_param("field", &M::field, Derivation::q, "velocity field whose vortices are felt"),
        companion_param(&M::field, Derivation::smooth_vector, &M::needs_velocity),
        param("strength_n", &M::strength_n,
              "force onto the core; a number: where Q is at least 5 % of its maximum; or a function of q(FIELD)"),
        choice_param("direction", &M::direction, "what the step to the core is taken from", "q", "reduced_velocity"),
        param("background", &M::background, VortexForce::background_sentence)};
  }
  bool needs_velocity() const { return true; }  // for the axis
  /// Checks: a background only if the step depends on it.
  std::string problem() const;
  void place(const ModeContext& here, PrimitiveSink out) const noexcept;
};

}  // namespace palpa
