// A campaign: many tries to break a promise, one after another from a seed. All campaigns share what is here:
//
//     seed ──► choices ──► case ──► judge ──► (what broke it, made smaller) ──► a row of the table
//
// Each brings only the middle: a function that makes a case of its choices and judges what comes of it.
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

/// What came of one case.
struct Tried {
  std::string broken{};      ///< the promise that was broken, in one line; empty: all was kept
  std::int64_t tries = 1;    ///< that it was: ticks of a session, runs of a program
  double slowest_s = -1.0;   ///< of these; below 0: it was one try, whose time the frame takes
  std::int64_t refused = 0;  ///< [cases] 1: its answer was a refusal in words, which is all that could be judged
};

/// Makes a case and judges it. Whatever it writes it writes into the folder, which is there, empty and its own.
using Attempt = std::function<Tried(Choices& choices, const fs::path& folder)>;

struct Campaign {
  std::string name;
  std::string of;               ///< what it counts: "ticks", "files"
  std::int64_t long_tries = 0;  ///< of a long run
  /// Makes what all tries of one process share (a corpus, say), in a folder of its own, and gives what makes each of them.
  std::function<Attempt(const fs::path& folder)> begin;
  double patience_s = 60.0;                        ///< a case that takes longer counts as one that never ends
  std::function<std::string()> missing = nullptr;  ///< why it cannot run on this machine; empty: it can
};

/// A campaign's row of the table, and where it goes on.
struct Row {
  std::uint64_t next_seed = 1;
  std::int64_t tries = 0;
  std::int64_t failures = 0;
  std::int64_t cases = 0;    ///< of which the tries were made
  std::int64_t refused = 0;  ///< of the cases
  double slowest_s = 0.0;
  std::uint64_t slowest_seed = 0;
  double peak_bytes = 0.0;  ///< most resident memory of a process
  double spent_s = 0.0;     ///< by all processes that tried
};

/// The rows by name. In a file: one line each, the cells with tabs between.
using Table = std::map<std::string, Row>;

/// Empty where there is no such file. Throws std::runtime_error on one that is no table.
Table load_table(const fs::path& file);
/// Replaces the file at once: who reads it finds the old table or the new one.
void save_table(const fs::path& file, const Table& table);
/// As markdown, with a line below for all of them.
void print_table(std::ostream& out, const Table& table, const std::vector<Campaign>& campaigns);

struct RunOptions {
  int jobs = 1;           ///< processes that try at the same time
  fs::path findings{};    ///< folder for what broke a promise: its choices, and what it wrote
  double round_s = 10.0;  ///< after so long the table is given to `save`
  std::function<void(const Row&)> save = nullptr;
  std::ostream* says = nullptr;  ///< gets a line for each failure
};

/// Tries until the row counts at least `tries`, or `interrupted`. A case that crashes or never ends costs the process that
/// tried it, is a failure like any other, and the next seed goes on. Every failure is made smaller, as long as that breaks the
/// same promise, and kept in `findings/NAME/SEED`.
void run(const Campaign& campaign, std::int64_t tries, Row& row, const RunOptions& options);

/// Set by a signal: ends `run` with all that was counted.
extern volatile int interrupted;

/// What is left of a list of choices after it was made smaller. Calls `broken` for ever smaller lists, at most `most` times.
/// \param broken  the promise that these choices break; empty: none. Smaller ones have to break the same as `choices`
std::vector<std::uint64_t> shrunk(std::vector<std::uint64_t> choices, int most,
                                  const std::function<std::string(const std::vector<std::uint64_t>&)>& broken);

/// Whether two broken promises are the same one: they may differ in their numbers.
bool is_same_promise(const std::string& a, const std::string& b);

/// The choices that a finding was kept with, `findings/NAME/SEED/choices`, and its campaign.
struct Finding {
  std::string campaign;
  std::vector<std::uint64_t> choices;
};
/// Throws std::runtime_error on a file that is none.
Finding load_finding(const fs::path& file);

}  // namespace palpa::fuzz
