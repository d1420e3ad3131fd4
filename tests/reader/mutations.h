// Randomly damaged real files through palpa-read.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "damage.h"
#include "sets_to_damage.h"

namespace palpa::test {

/// Results of the damaged copies of one set.
struct MutationResult {
  int read = 0;
  int refused = 0;
  std::vector<std::string> ended;  ///< of these: palpa-read crashed or was killed, a one-line error for its user
  std::string refused_undamaged;   ///< reason of the undamaged set's refusal; empty: readable
  double slowest_s = 0.0;          ///< of the processor, this process and its palpa-read
  double peak_bytes = 0.0;         ///< most resident memory of a palpa-read; of the undamaged file: `true_peak_bytes`
  double true_peak_bytes = 0.0;
  std::vector<std::string> wrong;  ///< violations: two lines, no place, no remedy, a value that is not finite
};

/// A set in a folder of its own, with one damaged file at a time: the file itself, another in the folder, or a companion.
/// Memory is that of all children of this process so far.
class DamagedSet {
 public:
  /// Reads it undamaged. Throws runtime_error without the set.
  DamagedSet(const SetToDamage& set, const ReadOptions& options);
  ~DamagedSet();

  /// Damages a file, reads the set, adds the outcome to the result, and repairs the file. A violation or a crash is copied to
  /// the folder `keep`, unless that is empty.
  void damage_once(Damage& damage, const fs::path& keep, MutationResult& result);

 private:
  class State;
  std::unique_ptr<State> state_;
};

/// Damages a set so `count` times. Equal seeds give equal damage.
MutationResult read_mutations(const SetToDamage& set, int count, std::uint32_t seed, const ReadOptions& options);

}  // namespace palpa::test
