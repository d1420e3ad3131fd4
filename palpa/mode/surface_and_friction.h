// Surfaces of a scalar field, with friction.
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
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
    };
    std::array<Held, most_held> held;  ///< levels, in any order; of material the friction of the first
    bool captured = false;             ///< by material, that gives way
    double value = 0.0;                ///< of it, in the field's own unit
  };
  void place(const Here& here, const Memory& memory, PrimitiveSink out) const noexcept;
  void settle(const Settled& settled, Memory& memory) const noexcept;

 private:
  struct Standing;
  double texture_factor(const Here& here, std::uint16_t slot) const noexcept;
  void stand(const Here& here, const Standing& on, PrimitiveSink out) const noexcept;
  void rub(const Settled& settled, Memory& memory) const noexcept;
  void meet(Memory& memory, std::int32_t level, bool from_low) const noexcept;
  bool is_solid(double value) const noexcept;
};

}  // namespace palpa
