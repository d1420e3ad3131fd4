// Preparation of an OME-Zarr store for feeling: its coarser octaves, and facts of every chunk.
#pragma once

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "palpa/file/read_volume.h"
#include "palpa/file/work_part.h"

namespace palpa {

struct PrepareOptions {
  WorkPart part;             ///< contiguous units, in their order
  bool is_one_part = false;  ///< other processes make other parts: the last octaves and the attributes are left to a last call
  std::filesystem::path into;  ///< store for octaves and facts, beside one that must not be written; empty: the same
  int threads = 0;             ///< [1] that compute, each with a reader; 0: one for each core, for one part one
  const std::atomic<bool>* stop = nullptr;  ///< set from any thread: ends with LoadError "interrupted"
  std::function<void(double)> progress{};   ///< called with the share done [1] by one of the threads; may be empty
  ReadOptions read;
};

/// Result of a preparation, or of a check.
struct PreparedStore {
  std::int64_t units = 0;                            ///< [1] of this part
  std::int64_t units_before = 0;                     ///< [1] of them that were done before
  std::int64_t units_missing = 0;                    ///< [1] of the whole store, afterwards
  std::array<std::int64_t, 3> unit{};                ///< [voxels] of octave 0
  int first_octave = 1, last_octave = 0;             ///< made; none if the last is before the first
  std::int64_t chunks_read = 0, chunks_written = 0;  ///< [1]
  std::int64_t voxels = 0;                           ///< [1] of octave 0, in the units made
  double seconds = 0.0;                              ///< [s]
  int threads = 1;                                   ///< [1]
  bool is_finished = false;                          ///< all octaves and the attributes are written
  std::int64_t wrong = 0;                            ///< [1] chunks, of a check
  std::vector<std::string> wrong_chunks;             ///< the first of them, a sentence each
};

/// Writes the missing octaves, means of 2 × 2 × 2 voxels, until no side is longer than 128 voxels, and for each chunk of each
/// octave its ChunkFacts (palpa/facts/N). Works by units of 1024³ voxels, larger where the store's chunks do not divide that,
/// each read once, in a few megabytes of memory. A unit is done when the facts of its coarsest octave are there, which are
/// written last: a process that was killed continues, and any number of parts, in any order, also twice at once, gives the same
/// bytes. No locks, no messages. Throws LoadError "STORE: problem; remedy", also for a damaged chunk, which it names.
PreparedStore prepare_store(const std::filesystem::path& store, const PrepareOptions& options = {});

/// Reads a prepared store anew: each chunk is there, decodes, and has its facts; octaves that palpa made are the means of the
/// one before. Writes nothing. Throws LoadError on a store that is not prepared.
PreparedStore check_prepared_store(const std::filesystem::path& store, const PrepareOptions& options = {});

}  // namespace palpa
