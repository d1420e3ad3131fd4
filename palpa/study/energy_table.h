// Energy balance of a run: two columns with equal sums.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace palpa {

struct Summary;

struct EnergyEntry {
  std::string key;    ///< as in JSON: hand, guard_held_back, data, ticks; modes by name, let_go, damper, spring
  std::string label;  ///< for a person
  double energy_j = 0.0;
};

/// Energy of a run. In: input by the hand, and the little injected by holding each force for a tick. Out: dissipation of the
/// modes and the damper, losses at releases, and energy stored in the spring; the sums are equal. Any entry may be negative: a
/// wind that drives the hand gives energy. docs/concepts.md reads such a table, docs/theory.md derives it.
struct EnergyTable {
  std::vector<EnergyEntry> in;
  std::vector<EnergyEntry> out;
  /// Energy injected by the ticks that inject. The entry `ticks` is smaller, by the energy removed in other ticks.
  double sampling_gained_j = 0.0;
  /// k/2 Σ|Δp|²: upper bound for ticks of a single balance each (docs/theory.md 7.7).
  double sampling_bound_j = 0.0;
  /// [N·s/m] Damping of a hand that dissipates all of `sampling_gained_j`, in those ticks.
  double covering_damping_ns_per_m = 0.0;

  double in_j() const noexcept;
  /// Equal to `in_j`, to rounding.
  double out_j() const noexcept;
};

EnergyTable energy_table(const Summary& summary);
/// Moves each negative entry to the other side, as positive. Both sums grow equally.
EnergyTable without_negative_entries(EnergyTable table);
/// Formats the table as text, in millijoules, without negative entries.
std::string to_table(const EnergyTable& table);
/// Formats the entries as JSON in joules, by their keys: {"in": {…}, "out": {…}}.
std::string to_json(const EnergyTable& table);

}  // namespace palpa
