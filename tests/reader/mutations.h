// Real files, damaged at random, through palpa-read.
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "damage.h"
#include "sets_to_damage.h"

namespace palpa::test {

/// What became of the damaged copies of one set.
struct MutationResult {
  int read = 0;                    ///< gave a volume
  int refused = 0;                 ///< gave one line
  std::vector<std::string> ended;  ///< of these: palpa-read crashed or had to be ended, which costs its user one line
  std::string refused_undamaged;   ///< why the set is refused as it is; empty where it can be read
  double slowest_s = 0.0;          ///< of the processor, this process and its palpa-read
  double peak_bytes = 0.0;  ///< most resident memory of a palpa-read; of the undamaged file: `true_peak_bytes`
  double true_peak_bytes = 0.0;
  std::vector<std::string> wrong;  ///< what must not be: two lines, no place, no remedy, a value that is not finite
};

/// A set in a folder of its own, of which one file at a time is damaged: the file itself, one in the folder, or one that is
/// read with it. Memory is that of all children of this process so far.
class DamagedSet {
 public:
  /// Reads it undamaged. Throws runtime_error where the set is not there.
  DamagedSet(const SetToDamage& set, const ReadOptions& options);
  ~DamagedSet();

  /// Damages a file, reads the set, adds what came of it to the result, and repairs the file. Of whatever was wrong or ended a
  /// copy takes the place of the folder `keep`, unless that is empty.
  void damage_once(Damage& damage, const fs::path& keep, MutationResult& result);

 private:
  class State;
  std::unique_ptr<State> state_;
};

/// Damages a set so `count` times. The same seed gives the same damage.
MutationResult read_mutations(const SetToDamage& set, int count, std::uint32_t seed, const ReadOptions& options);

}  // namespace palpa::test
