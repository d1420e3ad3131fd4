// The loop: read → tick → guard → write, and a recorder that can never slow it.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "palpa/device/device.h"
#include "palpa/tick/session.h"
#include "palpa/trace/record.h"
#include "palpa/trace/trace.h"

namespace palpa {

/// Takes whole ticks from the loop through a bounded ring and has its own thread format and write them.
class Recorder {
 public:
  /// \param ring_bytes  memory of the ring, taken at construction
  explicit Recorder(TraceWriter& writer, std::size_t ring_bytes = std::size_t{16} << 20);
  ~Recorder();

  /// Puts one whole tick into the ring. Never blocks: false when there is no room (a real-time loop
  /// counts that; a headless one waits with `wait_for_room` first).
  bool offer(const TickFrame& frame, const Session& session) noexcept;
  /// Blocks until the writer has emptied half of the ring. Not for a real-time loop.
  void wait_for_room();
  /// Writes what is left, joins the thread. Throws what the writer threw.
  void finish();

 private:
  class Ring;
  std::unique_ptr<Ring> ring_;
};

struct LoopOptions {
  double rate_hz = 1000.0;
  double duration_s = 10.0;
  bool time_ticks = true;               ///< measure each tick with the monotonic clock
};

/// Called after every tick, on the loop's thread; what a summary is gathered with.
using TickObserver = std::function<void(const TickFrame&, const Session&)>;

/// Runs `session` with `device` on a simulated clock: as fast as it can, the same bits every time.
/// Returns the number of ticks. `stop` ends it after the tick under way (an interrupt).
std::int64_t run_simulated(Session& session, SimulatedDevice& device, const LoopOptions& options, Recorder* recorder,
                           const TickObserver& observer, const std::atomic<bool>* stop = nullptr);

}  // namespace palpa
