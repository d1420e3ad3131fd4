// Recorder without a thread: ticks are written at once, into the module's memory.
#include "palpa/base/load_error.h"
#include "palpa/loop/loop.h"

namespace palpa {

class Recorder::Ring {
 public:
  explicit Ring(TraceWriter& to) : writer(to) {}
  TraceWriter& writer;
  bool has_failed = false;
};

Recorder::Recorder(TraceWriter& writer, std::size_t) : ring_(std::make_unique<Ring>(writer)) {}
Recorder::~Recorder() = default;

void Recorder::make_resident() noexcept {}

bool Recorder::offer(const TickFrame& frame, const Session& session) noexcept {
  return offer(frame, session.modes(), session.sub_steps(), session.primitives(), session.events());
}

bool Recorder::offer(const TickFrame& frame, std::span<const ModeForce> modes, std::span<const SubStep> sub_steps,
                     std::span<const PlacedPrimitive> placed, std::span<const SessionEvent> events) noexcept {
  if (ring_->has_failed) return false;
  try {
    ring_->writer.append(frame, modes, sub_steps, placed, events);
  } catch (const std::exception&) {
    ring_->has_failed = true;
  }
  return !ring_->has_failed;
}

void Recorder::keep_up(std::int64_t) {}
void Recorder::finish() { ring_->writer.flush(); }

}  // namespace palpa
