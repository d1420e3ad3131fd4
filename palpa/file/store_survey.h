// Sample of a store's chunks: range of values, lost chunks, stored size.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "palpa/file/store_reader.h"

namespace palpa {

struct StoreSurvey {
  struct Values {
    double min = 0.0, max = 0.0;  ///< [raw] of finite numbers, of all components; min > max: none were found
    bool about = true;            ///< of a sample
  };
  std::vector<Values> values;   ///< of each field, at octave 0
  double chunks = 0.0;          ///< [1] of octave 0, in all frames and fields
  std::int64_t looked_for = 0;  ///< of these: whether the store has them; of a prepared store all that time allows
  std::int64_t looked_at = 0;   ///< of these: decoded
  std::int64_t absent = 0;      ///< of those looked for: the store has no such chunk
  std::int64_t lost = 0;        ///< of the absent: the next octave, or the chunk's facts, have values there
  std::int64_t damaged = 0;     ///< of those looked at: does not decode, or has another checksum than its facts
  std::string damage;           ///< sentence of a damaged one
  double stored_share = 0.0;    ///< [1] bytes in the store, of those of the chunks that are present; 0: unknown
  bool can_tell_lost = true;    ///< false: there is neither a next octave nor facts
};

/// Looks at up to 4096 random chunks of octave 0, and for values at 64 of them, as long as `longest_s` [s] allows. Of a
/// prepared store first at the facts of all chunks, and for all chunks, as long as `longest_facts_s` [s] allows, a few
/// megabytes at a time. The reader has no request pending. Blocks. Throws as StoreReader. Equal stores give equal results, but
/// for the time.
/// \param facts_suffice  no chunk of a store with facts is looked at: neither damage nor the stored size is found
StoreSurvey survey(StoreReader& reader, double longest_s, double longest_facts_s, bool facts_suffice = false);

/// [1] Voxels in the chunks that a window of 128 × 128 × 128 voxels reads, per voxel of the window: mean over its places in
/// steps of 32. Allocates nothing; any thread.
double waste_of_chunks(const StoreOctave& octave) noexcept;

}  // namespace palpa
