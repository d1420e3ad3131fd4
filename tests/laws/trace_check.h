// A trace's balances checked by the formula of docs/trace.md, from its files alone: no solver of ours, no
// session, and arithmetic of 113 bits. For the tests and for bench_traces.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "palpa/solver/vec3.h"
#include "palpa/trace/csv.h"

namespace palpa::test {

/// The rows of a CSV file, one at a time, cells by the names of their columns. Holds one row.
class CsvRows {
 public:
  /// Throws LoadError where there is no such file, or it has no header.
  explicit CsvRows(const std::filesystem::path& file);

  /// Goes to the next whole row; false after the last. Throws LoadError where a row has too few cells.
  bool next();
  bool has(const std::string& column) const { return columns_.contains(column); }
  /// Cells of the row. They throw LoadError with file and line on a missing column and on what is no number.
  std::string_view text(const std::string& column) const;
  double number(const std::string& column) const;
  std::int64_t integer(const std::string& column) const;
  /// NAME_x_UNIT and its two neighbours; without a unit NAME_x.
  Vec3 vector(const std::string& name, const std::string& unit) const;
  /// "FILE:LINE" of the row.
  std::string place() const { return lines_.place(); }

 private:
  detail::LineFile lines_;
  std::map<std::string, std::size_t, std::less<>> columns_;
  std::vector<std::string_view> cells_;
};

/// A row of balances.csv and what the formula says of it.
struct CheckedBalance {
  std::int64_t tick = 0;
  std::int64_t sub_step = 0;
  std::string_view status;
  double claimed_m = 0.0;  ///< error_bound_m, as the trace has it
  double bound_m = 0.0;    ///< the formula's
  /// What the formula may say more than the claim, because the files hold doubles: the position is one, and
  /// a force is as long as its strength to a few ulp only. The bound has a root over both.
  double rounding_m = 0.0;
};

/// Visits every balance of a trace that was recorded with its primitives, in order; those that promise no
/// bound (bad input, an earlier system's law) too. Throws LoadError on a folder that is no such
/// trace, and where rows of the two files do not belong together: a killed recording may end like that, after
/// all whole balances were visited.
void check_balances(const std::filesystem::path& trace, const std::function<void(const CheckedBalance&)>& visit);

/// The last balance of a tick, judged where the proxy is.
struct CheckedRest {
  std::int64_t tick = 0;
  bool directed = false;  ///< a directed force acts
  double pull_n = 0.0;    ///< of the spring: k |proxy − probe|
  /// What of the pull, and of the directed forces, no choice of forces bears that the primitives can exert at the proxy. A
  /// primitive that is nearer to it than the tolerance can exert each of its forces; one further away that one alone which
  /// docs/theory.md, 1.3, names.
  double left_n = 0.0;
};

/// Visits the last balance of every tick that rests. \param tolerance_m  [m] how near a primitive is that the proxy lies on.
/// Throws as check_balances.
void check_rests(const std::filesystem::path& trace, double tolerance_m, const std::function<void(const CheckedRest&)>& visit);

/// What a primitive brought in, from its rows of balances.csv, primitives.csv and, where its data moved, works.csv.
struct CheckedWork {
  std::int64_t tick = 0;
  std::int64_t sub_step = 0;
  std::string_view mode;
  bool directed = false;
  bool exact = false;        ///< its balance is
  double claimed_j = 0.0;    ///< work_j, as the trace has it; without a row that worked out
  double work_j = 0.0;       ///< force · (proxy − start − move_fraction · carried)
  double moved_j = 0.0;      ///< force · move_fraction · carried
  double carried_m = 0.0;    ///< how far
  double may_bring_j = 0.0;  ///< at most: |force| |position − start − carried|
};

/// Visits the work of every primitive of a trace that was recorded with them, in order. Throws as check_balances.
void check_works(const std::filesystem::path& trace, const std::function<void(const CheckedWork&)>& visit);

/// What elastic levels hold after a tick: of each half its stiffness times the square of how far the proxy is behind its
/// planes, up to its strength. One that slips holds that if it yields, nothing if it breaks, which the files do not say.
struct ElasticEnergy {
  double least_j = 0.0, most_j = 0.0;
  std::string mode;  ///< whose the last of them is
};

/// By tick, of those with balances. Throws as check_balances.
std::map<std::int64_t, ElasticEnergy> elastic_energies(const std::filesystem::path& trace);

}  // namespace palpa::test
