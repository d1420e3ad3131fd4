#include "palpa/mode/surface_and_friction.h"

#include <algorithm>

#include "palpa/mode/placement.h"

namespace palpa {

namespace {
constexpr std::uint16_t surface_slot = 0;
constexpr std::uint16_t friction_slot = 1;
constexpr std::uint16_t flat_slot = 2;

// The level that the surface's plane was placed on.
double captured_value(const Settled& settled) noexcept {
  for (const SlotState& slot : settled.slots) {
    if (slot.slot == surface_slot) return slot.captured.value;
  }
  return 0.0;
}
}  // namespace

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
  if (!flat_strength_n.is_constant() || flat_strength_n.constant_n != 0.0) {
    if (noise_per_m == 0.0) return "flat_strength_n is given without noise_per_m, which says what is flat; give both";
    if (!levels.empty() && solid == Solid::both)
      return "flat_strength_n is felt in the solid, and solid = \"both\" says of no side that it is; give high or low";
  }
  return {};
}

void SurfaceAndFriction::place(const Here& here, const Memory& memory, PrimitiveSet& out) const noexcept {
  if (!levels.empty() && !memory.captured && noise_per_m == 0.0) return;  // nothing is met, and nothing is flat
  const ScalarSample& sample = here.scalar(field);
  if (!sample.inside) return;
  const double weight = detail::gradient_weight(here, sample.gradient, noise_per_m);
  if (weight < 1.0 && is_solid(sample.value))
    out.point(flat_slot, here.proxy_m, (1.0 - weight) * here.newtons(flat_strength_n));
  const bool material = levels.empty();
  if (!(norm(sample.gradient) > 0.0) || (!memory.captured && !material)) return;

  const Captured level{field.index, memory.captured ? memory.value : here.value_at_start(field)};
  const bool from_low = memory.captured ? memory.from_low : solid != Solid::low;
  const Vec3 uphill = normalized(sample.gradient);
  const Vec3 normal = from_low ? -uphill : uphill;
  const auto solid_side = from_low ? TransferFunction::Side::above : TransferFunction::Side::below;

  const Level* shell = material ? nullptr : &levels[static_cast<std::size_t>(memory.level)];
  out.plane(surface_slot, detail::foot_on_level_m(here, sample, level.value), normal,
            weight * here.newtons(shell ? shell->strength_n : strength_n, level, solid_side), level);

  // Through the proxy itself, so that friction is dissipation and nothing else.
  const bool own_friction = shell && (shell->friction_n || shell->friction_coefficient);
  const double coefficient = own_friction ? shell->friction_coefficient.value_or(0.0) : friction_coefficient;
  const double constant_n = own_friction ? shell->friction_n.value_or(0.0) : friction_n;
  if (coefficient > 0.0) {
    out.friction(friction_slot, surface_slot, here.proxy_m, coefficient);
  } else if (constant_n > 0.0) {
    out.line(friction_slot, here.proxy_m, normal, weight * here.newtons(constant_n));
  }
}

// Of material, every value is: its strengths say how much.
bool SurfaceAndFriction::is_solid(double value) const noexcept {
  return levels.empty() || std::any_of(levels.begin(), levels.end(), [&](const Level& level) {
           return solid == Solid::high ? value > level.value : value < level.value;
         });
}

void SurfaceAndFriction::settle(const Settled& settled, Memory& memory) const noexcept {
  if (!levels.empty() && !memory.captured && settled.crossings.empty()) return;
  const ScalarSample& sample = settled.here.scalar(field);
  if (!sample.inside) {
    memory = {};
    return;
  }
  const PrimitiveState state = settled.state(surface_slot);

  if (levels.empty()) {
    memory.from_low = solid != Solid::low;
    memory.captured = settled.placed(surface_slot) && state != PrimitiveState::off;
    if (state == PrimitiveState::slip) memory.value = sample.value;  // pressed through: the next value carries
    if (state == PrimitiveState::stick) memory.value = captured_value(settled);
    return;
  }

  if (memory.captured && state == PrimitiveState::slip) memory.captured = false;  // the shell lets go
  for (const Crossing& crossing : settled.crossings) {
    if (crossing.field != field.index) continue;
    const bool inwards = solid == Solid::both || crossing.up == (solid == Solid::high);
    for (std::size_t i = 0; i < levels.size(); ++i) {
      if (levels[i].value != crossing.value) continue;
      const bool leaves = memory.captured && memory.value == crossing.value && memory.from_low != crossing.up;
      if (leaves) memory.captured = false;
      if (inwards && !leaves) memory = {true, crossing.up, static_cast<std::int32_t>(i), crossing.value};
    }
  }
}

}  // namespace palpa
