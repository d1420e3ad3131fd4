// Check of a trace's balances by docs/trace.md from its files alone, in arithmetic of 113 bits; for tests and bench_traces.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "palpa/solver/pose.h"
#include "palpa/trace/csv.h"

namespace palpa::test {

/// Rows of a CSV file, one at a time, cells by column name. Holds one row.
class CsvRows {
 public:
  /// Throws LoadError without the file or its header.
  explicit CsvRows(const std::filesystem::path& file);

  /// Advances to the next whole row; false after the last. Throws LoadError on a row with too few cells.
  bool next();
  bool has(const std::string& column) const { return columns_.contains(column); }
  /// Cells of the row. They throw LoadError with file and line on a missing column or an invalid number.
  std::string_view text(const std::string& column) const;
  double number(const std::string& column) const;
  std::int64_t integer(const std::string& column) const;
  /// NAME_x_UNIT and its two neighbours; without a unit NAME_x.
  Vec3 vector(const std::string& name, const std::string& unit) const;
  Turn turn(const std::string& name) const;
  std::string place() const { return lines_.place(); }

 private:
  detail::LineFile lines_;
  std::map<std::string, std::size_t, std::less<>> columns_;
  std::vector<std::string_view> cells_;
};

/// A row of balances.csv and its formula.
struct CheckedBalance {
  std::int64_t tick = 0;
  std::int64_t sub_step = 0;
  std::string_view status;
  double claimed_m = 0.0;  ///< error_bound_m of the trace
  double bound_m = 0.0;
  /// Permitted excess of the formula over the claim: position and forces are doubles (a force's length is its strength to a few
  /// ulp), and the bound has a root over both.
  double rounding_m = 0.0;
};

/// Visits every balance of a trace with primitives, in order, also those without a bound (bad input, an earlier system's law).
/// Throws LoadError on any other folder, and where rows of the two files do not match: a killed recording may end like that,
/// after all whole balances were visited.
void check_balances(const std::filesystem::path& trace, const std::function<void(const CheckedBalance&)>& visit);

/// The last balance of a tick, judged at the proxy.
struct CheckedRest {
  std::int64_t tick = 0;
  bool directed = false;
  double pull_n = 0.0;  ///< of the spring: k |proxy − probe|
  /// Remainder of the pull and the directed forces over the best choice of primitive forces at the proxy: any admissible force
  /// of a primitive within the tolerance, of a farther one only the force of docs/theory.md, 1.3.
  double left_n = 0.0;
};

/// Visits the last balance of every resting tick. \param tolerance_m  [m] largest distance of a touched primitive. Throws as
/// check_balances.
void check_rests(const std::filesystem::path& trace, double tolerance_m, const std::function<void(const CheckedRest&)>& visit);

/// Work of a primitive, from its rows of balances.csv, primitives.csv and, where its data moved, works.csv.
struct CheckedWork {
  std::int64_t tick = 0;
  std::int64_t sub_step = 0;
  std::string_view mode;
  bool directed = false;
  bool exact = false;
  double claimed_j = 0.0;      ///< work_j of the trace; without a row, recomputed
  double work_j = 0.0;         ///< force · (proxy − start − move_fraction · carried)
  double data_motion_j = 0.0;  ///< force · move_fraction · carried
  double carried_m = 0.0;
  double may_bring_j = 0.0;  ///< at most: |force| |position − start − carried|
};

/// Visits the work of every primitive of a trace with primitives, in order. Throws as check_balances.
void check_works(const std::filesystem::path& trace, const std::function<void(const CheckedWork&)>& visit);

/// Energy of elastic levels after a tick: half the stiffness times the square of the proxy's depth behind each one's planes, up
/// to its strength. A slipping level keeps its energy if it yields and has none if it breaks, which the files do not record.
struct ElasticEnergy {
  double least_j = 0.0, most_j = 0.0;
  std::string mode;
};

/// By tick, of ticks with balances. Throws as check_balances.
std::map<std::int64_t, ElasticEnergy> elastic_energies(const std::filesystem::path& trace);

}  // namespace palpa::test
