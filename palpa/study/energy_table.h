// Where the energy of a run came from and where it went: two columns with the same sum.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace palpa {

struct Summary;

/// One line of the table.
struct EnergyEntry {
  std::string key;    ///< as in JSON: hand, guard_held_back, data, ticks; modes by name, let_go, damper, spring
  std::string label;  ///< for a person
  double energy_j = 0.0;
};

/// The energy of a run. In came what the hand put in, and the little that holding each force for a tick brought in. Out went
/// what the modes and the damper took, what was lost where something let go, and what is left in the spring; both sums are the
/// same. Any entry may be below zero: a wind that drives the hand gives energy. docs/concepts.md reads such a table,
/// docs/theory.md derives it.
struct EnergyTable {
  std::vector<EnergyEntry> in;
  std::vector<EnergyEntry> out;
  /// What the ticks that brought in energy brought in. The entry `ticks` is less, by what other ticks took out.
  double ticks_gained_j = 0.0;
  /// k/2 Σ|Δp|²: the most that ticks bring in where each is one balance (docs/theory.md 7.7).
  double ticks_bound_j = 0.0;
  /// [N·s/m] Damping of a hand that takes out all of `ticks_gained_j`, in the same ticks.
  double covering_damping_ns_per_m = 0.0;

  double in_j() const noexcept;
  /// The same as `in_j`, to rounding.
  double out_j() const noexcept;
};

EnergyTable energy_table(const Summary& summary);
/// For a person: each entry below zero as a positive one of the other side. Both sums grow by the same amount.
EnergyTable without_negative_entries(EnergyTable table);
/// The table as text, in millijoules, without negative entries.
std::string to_table(const EnergyTable& table);
/// The entries as JSON in joules, by their keys: {"in": {…}, "out": {…}}.
std::string to_json(const EnergyTable& table);

}  // namespace palpa
