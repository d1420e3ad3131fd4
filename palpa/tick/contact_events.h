// What is told of contacts: when a level is met, when it gives way, what was refused.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "palpa/tick/local_model.h"
#include "palpa/tick/session.h"

namespace palpa {

/// The events of a tick. Onsets and break-throughs are told once a tick for each mode, a break-through after the onset of
/// its level; refusals and warnings once a session. Takes its memory at construction; one thread.
class ContactEvents {
 public:
  /// \param modes  their number
  explicit ContactEvents(std::size_t modes);

  /// Forgets what holds; what was refused stays told.
  void clear() noexcept;
  void continue_from(const ContactEvents& other) noexcept;
  void begin_tick() noexcept;
  std::span<const SessionEvent> events() const noexcept { return events_; }

  /// Tells, each time, what a mode's data did.
  void warn(std::size_t mode, const char* sentence) noexcept;
  /// Tells, once, that a directed force of a mode changes too fast.
  void tell_held_back(std::size_t mode) noexcept;
  /// From here on the levels that give way in the last balance hold to the end of the sub-step, and give way beyond it.
  void stop_at_bound(const LocalModel& model) noexcept;
  /// Tells what a sub-step that ended in a balance, with the proxy `depth_m` [m] from the probe, has met and broken through.
  void tell(const LocalModel& model, double depth_m) noexcept;

 private:
  struct Told {
    Captured standing;           // the level that holds, or held, in the last sub-step
    bool through = false;        // that level gave way
    bool met = false;            // an onset, in this tick …
    bool broken = false;         // … and a break-through
    bool at_bound = false;       // it holds here, and gives way beyond
    bool held_back = false;      // told that a directed force of it changes too fast
    std::uint32_t refusals = 0;  // a bit each
  };
  void emit(const SessionEvent& event) noexcept;

  std::vector<Told> told_;  // by mode
  std::vector<SessionEvent> events_;
};

}  // namespace palpa
