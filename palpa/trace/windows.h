// Windows and chunks of volumes larger than memory in traces.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "palpa/data/octaves.h"
#include "palpa/scene/scene.h"
#include "palpa/session/session.h"

namespace palpa {

/// Field of a volume larger than memory.
struct TracedField {
  std::string volume;  ///< its name in the scene
  std::string field;   ///< its name in the volume
  FieldPtr posed;      ///< keeps the octaves
  const Octaves* octaves = nullptr;
  int frame = 0;  ///< [1] of a series
};
/// Fields of a scene that are larger than memory, and frames of these, in its order. Allocates; any thread.
std::vector<TracedField> traced_fields(const Scene& scene);

/// Window that was laid in a recorded live run, for a field of `traced_fields`.
struct TracedWindow {
  std::int64_t tick = 0;  ///< before which it was laid
  std::string volume, field;
  WindowPlace place{};  ///< without the octaves
  int frame = 0;        ///< [1] of a series
};
/// Windows in the trace of a live run, in the order of ticks; none in other traces. Throws as `TraceReader::ticks`.
std::vector<TracedWindow> traced_windows(const std::filesystem::path& trace);

/// Chunks that were read in a recorded run.
struct TracedChunks {
  std::string volume, field;
  std::vector<ChunkSum> sums{};
  int frame = 0;  ///< [1] of a series
};
/// Chunks in a trace, by field and frame. Throws as `TraceReader::ticks`.
std::vector<TracedChunks> traced_chunks(const std::filesystem::path& trace);

}  // namespace palpa
