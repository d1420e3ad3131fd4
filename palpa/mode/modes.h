// The modes that Palpa brings, for scenes that are made in a program. Each is placed by the source of its name.
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

/// Surface and friction (paper, Fig. 4): a plane on a surface of a scalar field, and a line along its
/// normal that resists sliding.
///
/// The surface is either one of the levels (shells: one stands on them until k·depth reaches the
/// level's strength, then the shell lets go; one with a stiffness of its own gives way before, and what lies below is felt
/// through it), or, with `strength_n` as a transfer function of the field
/// (material), wherever the proxy is: every value is a surface that yields at its own strength.
///
/// With φ the field, g = ∇φ, σ = +1 where high values are solid: normal n = −σ g/|g|, and the plane
/// stands on the captured level φ_c, one Newton step from the proxy: a = x + g (φ_c − φ)/|g|². A plane
/// left at the proxy instead would drift off a sphere by π·speed·T per turn.
///
/// Friction grips harder while it holds than while it slides, by a ratio, and has a viscous part, both switched off at first:
/// the paper's law. It grips again where it has held for 20 ms, not at the first position that is the one before: to an
/// encoder a slow hand stands still most of the time (the band of velocity that counts as none: Karnopp, Computer simulation
/// of stick-slip friction in mechanical dynamic systems, J. Dyn. Syst. Meas. Control 107(1), 1985).
///
/// Texture, off at first, makes friction stronger and weaker by what the voxels say that the field's filter takes away
/// (Derivation::detail): roughness that is felt along the surface, as in M. Minsky et al., Feeling and seeing: issues in force
/// display, Symp. Interactive 3D Graphics, 1990, and, by friction as here, C.-H. Ho, C. Basdogan and M. A. Srinivasan,
/// Efficient point-based rendering techniques for haptic display of virtual objects, Presence 8(5), 1999. It is added: no law
/// of the paper and no property of what was scanned. It only scales what resists, so it takes energy and the surface stays
/// where it is.
///
/// Where the field is as flat as its noise a gradient has a random direction: there the surface fades, and in
/// the solid a point at the proxy may stand in, so that one feels that something is there without a wrong direction.
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
  FieldRef detail{};           ///< of the field, where there is texture

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
        companion_param(&S::detail, &S::field, Derivation::detail, &S::has_texture)};
  }
  bool has_texture() const { return texture_ratio > 0.0; }
  /// Levels or material, friction as a force or as a coefficient: one of each pair. What is flat needs a noise and a
  /// side that is solid, texture needs friction.
  std::string problem() const;

  /// So many levels can hold the proxy at once: one that is rigid, below others that give way.
  static constexpr std::size_t most_held = 4;
  struct Memory {
    struct Held {
      std::int32_t level = -1;  ///< its index; -1: none
      bool from_low = true;     ///< met from lower values: the low side is free
      double kinetic_s = 0.0;   ///< for so long yet its friction is the kinetic one
      double pressed_to = 0.0;  ///< where the level stands, in the field's own unit: at its value until it yields
    };
    std::array<Held, most_held> held;  ///< levels, in any order; of material the friction of the first
    bool captured = false;             ///< by material, that gives way
    double value = 0.0;                ///< of it, in the field's own unit
  };
  void place(const ModeContext& here, const Memory& memory, PrimitiveSink out) const noexcept;
  void on_step_accepted(const StepResult& result, Memory& memory) const noexcept;

 private:
  struct Standing;
  double texture_factor(const ModeContext& here, std::uint16_t slot) const noexcept;
  void stand(const ModeContext& here, const Standing& on, PrimitiveSink out) const noexcept;
  void give_way(const StepResult& result, std::uint16_t slot, Memory::Held& held) const noexcept;
  void rub(const StepResult& result, Memory& memory) const noexcept;
  void meet(Memory& memory, std::int32_t level, bool from_low) const noexcept;
  bool is_solid(double value) const noexcept;
};

/// Viscosity: a point primitive at the proxy. Its strength resists motion with the same force at any
/// speed (Coulomb; the paper's mode); its drag resists in proportion to the speed (true viscosity, f = c v).
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
  /// At least one of strength and drag.
  std::string problem() const;
  void place(const ModeContext& here, PrimitiveSink out) const noexcept;
};

/// Gradient force (paper: directed force): a pull uphill or downhill in a scalar field, smoothed when it
/// is loaded. A pull whose direction turns within less than 2s/k would buzz at the top of a hill, so there
/// it is weaker: s ≤ (k/2)·|g|/‖∂g/∂x‖ with g the gradient.
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

/// Follow: a line primitive along the field, so that moving across it costs force and moving along it
/// is free. The sign of the field does not matter.
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

/// Front shape: a plane across the field at the proxy, its normal along the field. One moves with the field and
/// along its front freely, and against it only with force.
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

/// Transverse damping: a line primitive along the field whose drag resists the part of the motion that goes
/// across the field, f = −c (v − (v·q) q); along it one is free. A strength resists at any speed, as `follow` does.
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
  /// At least one of drag and strength.
  std::string problem() const;
  void place(const ModeContext& here, PrimitiveSink out) const noexcept;
};

/// Vector force: a directed force along the field, the simplest mode of vector data: one is carried by
/// the flow. Where the direction turns within less than 2s/k it is weaker, s ≤ (k/2)·|V|/‖J‖, so that it
/// fades at stagnation points and in cores.
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

/// All vortex modes find vortices by Q = (|W|² − |S|²)/2 of the smoothed velocity, which is positive where the flow
/// turns more than it deforms, and does not depend on who moves along with it. A strength that is a number is
/// felt where Q is at least 5 % of its maximum in the data, from there on not more than k/2 × the depth; a
/// strength that is a function says itself where, best as a function of q(FIELD).
///
/// What points to the core is chosen:
///   q                 ∇Q: exact in a smooth vortex where it is round, and the same for any observer. Nothing in a core
///                     that turns like a solid, where Q is constant.
///   vorticity         ω × (u − b), of the literature: right where the vortex stands still for the observer who
///                     moves at b, the `background`, and ω keeps its sign.
///   reduced_velocity  the Newton step to where u − b has no part across the axis of the turning: right, and the distance
///                     with it, in any core, also a solid one, for that observer alone.
enum class VortexDirection { q, vorticity, reduced_velocity };

/// Vortex force (paper: vortex core, directed force): a pull towards the core, fading where its direction turns.
struct VortexForce {
  static constexpr auto type = "vortex_force";
  static constexpr auto summary = "A pull towards the core of a vortex.";

  FieldRef field{};     ///< Q of the velocity
  FieldRef velocity{};  ///< the velocity, smoothed
  Strength strength_n{0.5};
  VortexDirection direction = VortexDirection::q;
  Vec3 background{};  ///< [unit of the field] along the axes of the world

  static constexpr auto parameters() {
    using M = VortexForce;
    return std::tuple{derived_param("field", &M::field, Derivation::q, "velocity field whose vortices are felt"),
                      companion_param(&M::velocity, &M::field, Derivation::smooth_vector, &M::needs_velocity),
                      param("strength_n", &M::strength_n,
                            "force of the pull; a number: where Q is at least 5 % of its maximum; or a function of q(FIELD)"),
                      choice_param("direction", &M::direction, "what points to the core", "q", "vorticity", "reduced_velocity"),
                      param("background", &M::background, background_sentence)};
  }
  bool needs_velocity() const { return direction != VortexDirection::q; }
  /// A background only where the direction depends on it.
  std::string problem() const;
  void place(const ModeContext& here, PrimitiveSink out) const noexcept;

  /// How that parameter reads, for all vortex modes.
  static constexpr std::string_view background_sentence =
      "velocity at which the vortex moves along, in the field's unit along the world's axes; not with direction = \"q\"";
};

/// Vortex plane (paper: vortex shape, plane): a tube that one enters freely and leaves against force. The plane's
/// normal points to the core. By q it stands on the level of Q that the proxy has reached; the other directions know no
/// level, so there it stands at the proxy.
struct VortexPlane {
  static constexpr auto type = "vortex_plane";
  static constexpr auto summary = "A tube around the core of a vortex: free to enter, held inside.";

  FieldRef field{};     ///< Q of the velocity
  FieldRef velocity{};  ///< the velocity, smoothed
  Strength strength_n{0.5};
  VortexDirection direction = VortexDirection::q;
  Vec3 background{};  ///< [unit of the field] along the axes of the world

  static constexpr auto parameters() {
    using M = VortexPlane;
    return std::tuple{derived_param("field", &M::field, Derivation::q, "velocity field whose vortices are felt"),
                      companion_param(&M::velocity, &M::field, Derivation::smooth_vector, &M::needs_velocity),
                      param("strength_n", &M::strength_n,
                            "force that holds the hand in the vortex; a number: where Q is at least 5 % of its maximum; or a "
                            "function of q(FIELD)"),
                      choice_param("direction", &M::direction, "what points to the core", "q", "vorticity", "reduced_velocity"),
                      param("background", &M::background, VortexForce::background_sentence)};
  }
  bool needs_velocity() const { return direction != VortexDirection::q; }
  /// A background only where the direction depends on it.
  std::string problem() const;

  struct Memory {
    bool captured = false;
    double value = 0.0;  ///< Q of the level that the plane stands on, [1/s²] where velocities are in m/s
  };
  void place(const ModeContext& here, const Memory& memory, PrimitiveSink out) const noexcept;
  void on_step_accepted(const StepResult& result, Memory& memory) const noexcept;
};

/// Vortex line: a line primitive on the core line of the vortex around the proxy, one Newton step from it. Within reach
/// of its strength the hand is held on the core and free along it; further away it is drawn there.
///
/// Unlike the other primitives that resist, it does not pass through the proxy, so it brings energy in, like a
/// directed force. It buzzes less: the place of the line hardly depends on where it is looked for, so it may keep its
/// whole strength at the core, where a directed force has to fade.
struct VortexLine {
  static constexpr auto type = "vortex_line";
  static constexpr auto summary = "A pull onto the core line of a vortex, which holds the hand there, free along it.";

  /// How the core is found: by the ridge of Q, or where the reduced velocity has no part across the axis.
  enum class By { q, reduced_velocity };

  FieldRef field{};     ///< Q of the velocity
  FieldRef velocity{};  ///< the velocity, smoothed
  Strength strength_n{0.5};
  By direction = By::q;
  Vec3 background{};  ///< [unit of the field] along the axes of the world

  static constexpr auto parameters() {
    using M = VortexLine;
    return std::tuple{
        derived_param("field", &M::field, Derivation::q, "velocity field whose vortices are felt"),
        companion_param(&M::velocity, &M::field, Derivation::smooth_vector, &M::needs_velocity),
        param("strength_n", &M::strength_n,
              "force onto the core; a number: where Q is at least 5 % of its maximum; or a function of q(FIELD)"),
        choice_param("direction", &M::direction, "what the step to the core is taken from", "q", "reduced_velocity"),
        param("background", &M::background, VortexForce::background_sentence)};
  }
  bool needs_velocity() const { return true; }  // for the axis
  /// A background only where the step depends on it.
  std::string problem() const;
  void place(const ModeContext& here, PrimitiveSink out) const noexcept;
};

}  // namespace palpa
