#include <algorithm>

#include "palpa/mode/modes.h"
#include "palpa/mode/placement.h"

namespace palpa {

namespace {

// Each shell in the memory has a plane and a line; material uses the first pair.
constexpr std::uint16_t surface_slot(std::size_t place) noexcept {
  return static_cast<std::uint16_t>(place == 0 ? 0 : 2 * place + 1);
}
constexpr std::uint16_t friction_slot(std::size_t place) noexcept { return surface_slot(place) + 1; }
constexpr std::uint16_t flat_slot = 2;

// Static friction returns after so long without sliding. Shorter: a slow hand on an encoder seems still between two steps (3
// mm/s, 55 um); longer: it grips late.
constexpr double grips_after_s = 0.020;

}  // namespace

// Support of a plane.
struct SurfaceAndFriction::Standing {
  std::size_t place = 0;         // index in the memory
  const Level* shell = nullptr;  // null: material
  double value = 0.0;
  double pressed_to = value;
  bool from_low = true;
  bool grips = true;  // static friction
};

std::string SurfaceAndFriction::problem() const {
  const bool material = !strength_n.is_constant() || strength_n.constant_n != 0.0;
  if (levels.empty() && !material)
    return "neither levels nor strength_n are given; give [[mode.level]] tables, or strength_n as a function of the field";
  if (!levels.empty() && material) return "levels and strength_n are both given; give one of them";
  if (friction_n > 0.0 && friction_coefficient > 0.0)
    return "friction_n and friction_coefficient are both given; give one of them";
  for (const Level& level : levels) {
    if (level.friction_n && level.friction_coefficient) {
      return "level '" + level.name + "' has both friction_n and friction_coefficient; give one of them";
    }
  }
  const bool of_levels = std::ranges::any_of(levels, [](const Level& level) {
    return level.friction_n.value_or(0.0) > 0.0 || level.friction_coefficient.value_or(0.0) > 0.0;
  });
  if (texture_ratio > 0.0 && !(friction_n > 0.0) && !(friction_coefficient > 0.0) && !of_levels)
    return "texture_ratio is given without the friction that it varies; give friction_coefficient or friction_n, too";
  if (!flat_strength_n.is_constant() || flat_strength_n.constant_n != 0.0) {
    if (noise_per_m == 0.0) return "flat_strength_n is given without noise_per_m, which says what is flat; give both";
    if (!levels.empty() && solid == Solid::both)
      return "flat_strength_n is felt in the solid, and solid = \"both\" says of no side that it is; give high or low";
  }
  return {};
}

void SurfaceAndFriction::place(const ModeContext& here, const Memory& memory, PrimitiveSink out) const noexcept {
  const auto is_placed = [](const Memory::Shell& shell) { return shell.level >= 0; };
  const bool material = levels.empty();
  if (!material && noise_per_m == 0.0 && std::ranges::none_of(memory.shells, is_placed)) return;  // nothing to place
  const ScalarSample sample = here.scalar(field);
  if (!sample.inside) return;
  if (noise_per_m > 0.0) {
    const double weight = detail::gradient_weight(here, sample.gradient, noise_per_m);
    if (weight < 1.0 && is_solid(sample.value))
      out.point(flat_slot, here.proxy_m, (1.0 - weight) * here.newtons(flat_strength_n));
  }
  if (material) {
    stand(here,
          {.value = memory.stays ? memory.value : here.value_at_start(field),
           .from_low = solid != Solid::low,
           .grips = !(memory.shells[0].kinetic_s > 0.0)},
          out);
  }
  for (std::size_t i = 0; i < memory.shells.size(); ++i) {
    const Memory::Shell& shell = memory.shells[i];
    if (!is_placed(shell)) continue;
    const Level& level = levels[static_cast<std::size_t>(shell.level)];
    stand(here, {i, &level, level.value, shell.pressed_to, shell.from_low, !(shell.kinetic_s > 0.0)}, out);
  }
}

void SurfaceAndFriction::stand(const ModeContext& here, const Standing& on, PrimitiveSink out) const noexcept {
  const std::uint16_t slot = surface_slot(on.place);
  const Vec3 x_m = here.footing_m(slot);
  const ScalarSample sample = here.scalar(field, x_m);
  if (!sample.inside || !(norm(sample.gradient) > 0.0)) return;
  const double weight = detail::gradient_weight(here, sample.gradient, noise_per_m);
  HeldLevel level{here.number_of(field), on.value, on.pressed_to};
  const Vec3 uphill = normalized(sample.gradient);
  const Vec3 normal = on.from_low ? -uphill : uphill;
  const Vec3 nearest_m = detail::nearest_on_level_m(here, x_m, sample, on.pressed_to);
  const auto solid_side = on.from_low ? TransferFunction::Side::above : TransferFunction::Side::below;
  const LevelStrength bears = here.newtons(on.shell ? on.shell->strength_n : strength_n, level, solid_side);
  level.limited = bears.limited;
  level.goes_along = !on.shell;
  const double strength = weight * bears.newtons;
  if (on.shell && on.shell->stiffness_n_per_m) {
    out.elastic_plane(slot, nearest_m, normal, strength, *on.shell->stiffness_n_per_m, level);
  } else {
    out.plane(slot, nearest_m, normal, strength, level);
  }

  // Through the proxy itself, so that friction is pure dissipation.
  const bool own_friction = on.shell && (on.shell->friction_n || on.shell->friction_coefficient);
  const double coefficient = own_friction ? on.shell->friction_coefficient.value_or(0.0) : friction_coefficient;
  const double constant_n = own_friction ? on.shell->friction_n.value_or(0.0) : friction_n;
  const double ratio = on.grips ? static_friction_ratio : 1.0;
  const double drag_ns_per_m = strength > 0.0 ? weight * here.drag(friction_ns_per_m) : 0.0;
  const double rough = texture_factor(here, slot);
  if (coefficient > 0.0) {
    out.friction(friction_slot(on.place), slot, here.proxy_m, rough * (ratio * coefficient), drag_ns_per_m);
  } else if (constant_n > 0.0 || drag_ns_per_m > 0.0) {
    out.line(friction_slot(on.place), here.proxy_m, normal, rough * (ratio * (weight * here.newtons(constant_n))),
             drag_ns_per_m);
  }
}

// Factor of the texture on friction, [1] 0…2: rougher where the voxels exceed the filter. Sampled at the start of the step, the
// origin of friction: sampled at the end, no end might fit its own friction.
double SurfaceAndFriction::texture_factor(const ModeContext& here, std::uint16_t slot) const noexcept {
  return has_texture() ? 1.0 + texture_ratio * here.companion_scalar(field, here.proxy_m + here.footing_offset_m(slot)).value
                       : 1.0;
}

// Every value of a material is solid, to the degree of its strength.
bool SurfaceAndFriction::is_solid(double value) const noexcept {
  return levels.empty() || std::any_of(levels.begin(), levels.end(), [&](const Level& level) {
           return solid == Solid::high ? value > level.value : value < level.value;
         });
}

void SurfaceAndFriction::on_step_accepted(const StepResult& result, Memory& memory) const noexcept {
  const auto is_placed = [](const Memory::Shell& shell) { return shell.level >= 0; };
  if (!levels.empty() && result.crossings.empty() && std::ranges::none_of(memory.shells, is_placed)) return;
  const ScalarSample sample = result.here.scalar(field);
  if (!sample.inside) {
    memory = {};
    return;
  }
  rub(result, memory);
  if (levels.empty()) {
    const PrimitiveState state = result.state(surface_slot(0));
    memory.stays = result.placed(surface_slot(0)) && state != PrimitiveState::off;
    if (state == PrimitiveState::slip) memory.value = sample.value;  // pressed through: the next value bears
    if (state == PrimitiveState::stick) memory.value = result.captured(surface_slot(0)).value;
    return;
  }

  for (std::size_t i = 0; i < memory.shells.size(); ++i) {
    if (is_placed(memory.shells[i])) give_way(result, surface_slot(i), memory.shells[i]);
  }
  for (const Crossing& crossing : result.crossings) {
    if (crossing.field != result.here.number_of(field)) continue;
    const bool inwards = solid == Solid::both || crossing.up == (solid == Solid::high);
    for (std::size_t i = 0; i < levels.size(); ++i) {
      if (levels[i].value != crossing.value) continue;
      const auto level = static_cast<std::int32_t>(i);
      const auto on = std::ranges::find(memory.shells, level, &Memory::Shell::level);
      if (on != memory.shells.end() && on->from_low != crossing.up) {
        *on = {};
      } else if (inwards) {
        cross(memory, level, crossing.up);
      }
    }
  }
}

// A level that slips is released. A level that only yields bears on, as material does, where it has been pressed to: in its old
// place the proxy would be deep in it, without a free point nearby.
void SurfaceAndFriction::give_way(const StepResult& result, std::uint16_t slot, Memory::Shell& shell) const noexcept {
  const PrimitiveState state = result.state(slot);
  const double value = levels[static_cast<std::size_t>(shell.level)].value;
  if (state == PrimitiveState::slip && !result.yields(slot)) shell = {};
  const bool follows = state == PrimitiveState::slip || (state == PrimitiveState::off && shell.pressed_to != value);
  if (shell.level < 0 || !follows) return;
  const ScalarSample at = result.here.scalar(field, result.here.footing_m(slot));
  if (at.inside) shell.pressed_to = shell.from_low ? std::max(value, at.value) : std::min(value, at.value);
}

// After sliding, friction stays kinetic for a while.
void SurfaceAndFriction::rub(const StepResult& result, Memory& memory) const noexcept {
  if (static_friction_ratio == 1.0) return;
  for (std::size_t i = 0; i < memory.shells.size(); ++i) {
    double& kinetic_s = memory.shells[i].kinetic_s;
    const bool slides = result.state(friction_slot(i)) == PrimitiveState::slip;
    kinetic_s = slides ? grips_after_s : std::max(0.0, kinetic_s - result.here.time_step_s);
  }
}

// A rigid level behind the proxy is no longer placed; elastic levels, which let it in, still are.
void SurfaceAndFriction::cross(Memory& memory, std::int32_t level, bool from_low) const noexcept {
  for (Memory::Shell& shell : memory.shells) {
    const bool gives_way = shell.level >= 0 && levels[static_cast<std::size_t>(shell.level)].stiffness_n_per_m.has_value();
    if (!gives_way || shell.level == level) shell = {};
  }
  const auto room = std::ranges::find(memory.shells, -1, &Memory::Shell::level);
  Memory::Shell& shell = room != memory.shells.end() ? *room : memory.shells.back();
  shell = {level, from_low, 0.0, levels[static_cast<std::size_t>(level)].value};
}

}  // namespace palpa
