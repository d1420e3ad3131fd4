// A campaign: random cases from a seed that test a promise. The shared frame:
//
//     seed ──► choices ──► case ──► judge ──► (minimised failure) ──► a row of the table
//
// A campaign adds only the middle: a function that makes a case of its choices and judges it.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <iosfwd>
#include <map>
#include <string>
#include <vector>

#include "tests/fuzz/choices.h"

namespace palpa::fuzz {

namespace fs = std::filesystem;

struct Tried {
  std::string broken{};      ///< the broken promise, in one line; empty: none
  std::int64_t tries = 1;    ///< ticks of a session, runs of a program
  double slowest_s = -1.0;   ///< of these; below 0: a single try, timed by the frame
  std::int64_t refused = 0;  ///< [cases] 1: refused with a message, and nothing else to judge
};

/// Makes a case and judges it. Writes only into the folder, which exists and is empty.
using Attempt = std::function<Tried(Choices& choices, const fs::path& folder)>;

struct Campaign {
  std::string name;
  std::string of;  ///< unit of the tries: "ticks", "files"
  std::int64_t long_tries = 0;
  /// Makes the shared parts of a process's tries (a corpus, say) in a folder of its own; returns the function of a try.
  std::function<Attempt(const fs::path& folder)> begin;
  double patience_s = 60.0;                        ///< longer cases count as endless
  std::function<std::string()> missing = nullptr;  ///< missing requirement of this machine; empty: none
};

/// A campaign's row of the table, and its next seed.
struct Row {
  std::uint64_t next_seed = 1;
  std::int64_t tries = 0;
  std::int64_t failures = 0;
  std::int64_t cases = 0;  ///< made for the tries
  std::int64_t refused = 0;
  double slowest_s = 0.0;
  std::uint64_t slowest_seed = 0;
  double peak_bytes = 0.0;  ///< most resident memory of a process
  double spent_s = 0.0;     ///< sum over all processes
};

/// The rows by name. In a file: one line each, the cells with tabs between.
using Table = std::map<std::string, Row>;

/// Empty without the file. Throws std::runtime_error on an invalid table.
Table load_table(const fs::path& file);
/// Replaces the file atomically.
void save_table(const fs::path& file, const Table& table);
/// As Markdown, with a line of sums.
void print_table(std::ostream& out, const Table& table, const std::vector<Campaign>& campaigns);

struct RunOptions {
  int jobs = 1;           ///< parallel processes
  fs::path findings{};    ///< folder of failures: choices and output files
  double round_s = 10.0;  ///< interval of calls of `save`
  std::function<void(const Row&)> save = nullptr;
  std::ostream* says = nullptr;  ///< gets a line for each failure
};

/// Tries until the row counts at least `tries`, or `interrupted`. A crashed or endless case ends its process and counts as a
/// failure; the next seed goes on. Failures are minimised under an unchanged promise, and kept in `findings/NAME/SEED`.
void run(const Campaign& campaign, std::int64_t tries, Row& row, const RunOptions& options);

/// Set by a signal: ends `run` with all counts.
extern volatile int interrupted;

/// A minimised list of choices. Calls `broken` for ever smaller lists, at most `most` times.
/// \param broken  the promise that these choices break; empty: none. Smaller lists must break the promise of `choices`
std::vector<std::uint64_t> shrunk(std::vector<std::uint64_t> choices, int most,
                                  const std::function<std::string(const std::vector<std::uint64_t>&)>& broken);

/// True if two broken promises differ at most in their numbers.
bool is_same_promise(const std::string& a, const std::string& b);

/// The choices of a kept finding, `findings/NAME/SEED/choices`, and its campaign.
struct Finding {
  std::string campaign;
  std::vector<std::uint64_t> choices;
};
/// Throws std::runtime_error on an invalid file.
Finding load_finding(const fs::path& file);

}  // namespace palpa::fuzz
