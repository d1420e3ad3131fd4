// Windows of volumes larger than memory, laid before each tick of a loop whose clock waits for them.
#pragma once

#include <array>
#include <cstdint>
#include <set>
#include <tuple>

#include "palpa/data/octaves.h"
#include "palpa/session/session.h"

namespace palpa {

/// Makes and lays the windows of the finest octave (`Stock::finest`) for all of a tick's way, so that a session feels the bits
/// of the volume in memory. Where voxels are lost or damaged the next coarser octave is laid. For simulated clocks, replays and
/// studies: it blocks while voxels are read. Free of cost for sessions without such volumes. One thread.
class WindowFeed {
 public:
  /// The session's windows are complete from now on. The session outlives this.
  explicit WindowFeed(Session& session);

  /// Before `Session::tick` with these arguments. Allocates. Throws LoadError if the source of voxels fails.
  /// \param time_step_s  [s]
  void lay_for(const Probe& probe, double time_step_s) {
    if (!session_.stock().empty()) lay(session_.window_need(probe, time_step_s));
  }
  /// `lay_for`, then the tick. \param time_step_s  [s]
  Tick tick(const Probe& probe, double time_step_s) {
    lay_for(probe, time_step_s);
    return session_.tick(probe, time_step_s);
  }

 private:
  void lay(const WindowNeed& need);
  bool lay_octave(std::size_t field, int octave, const WindowNeed& need, bool reaches_ahead);

  Session& session_;
  /// Windows that cannot be made: field, octave, first voxel.
  std::set<std::tuple<std::size_t, int, std::array<std::int64_t, 3>>> lost_;
};

}  // namespace palpa
