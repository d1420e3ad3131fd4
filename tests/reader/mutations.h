// Real files, damaged at random, through palpa-read.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "sets_to_damage.h"

namespace palpa::test {

/// What became of the damaged copies of one set.
struct MutationResult {
  int read = 0;                    ///< gave a volume
  int refused = 0;                 ///< gave one line
  std::vector<std::string> ended;  ///< of these: palpa-read crashed or had to be ended, which costs its user one line
  std::string refused_undamaged;   ///< why the set is refused as it is; empty where it can be read
  double slowest_s = 0.0;
  double peak_bytes = 0.0;  ///< most resident memory of a palpa-read; of the undamaged file: `true_peak_bytes`
  double true_peak_bytes = 0.0;
  std::vector<std::string> wrong;  ///< what must not be: two lines, no place, no remedy, a value that is not finite
};

/// Damages the file, a file in the folder, or one that is read with it, `count` times: cut off, bits flipped, characters of the
/// header and its numbers changed, bytes taken out, put in or zeroed, empty, a link to itself, a folder, gone. The same
/// seed gives the same damage. Of whatever was wrong or ended a copy is put into `keep`, unless that is empty. Memory is that
/// of all children of this process so far. Throws runtime_error where the set is not there.
MutationResult read_mutations(const SetToDamage& set, int count, std::uint32_t seed, const ReadOptions& options,
                              const fs::path& keep = {});

}  // namespace palpa::test
