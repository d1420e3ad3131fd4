// Contact states by mode; emits contact events.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "palpa/mode/crossings.h"
#include "palpa/mode/state_arena.h"
#include "palpa/session/contact_problem.h"
#include "palpa/session/session.h"

namespace palpa {

/// The level that a mode holds the proxy on: free → held → yielding → free.
struct Contact {
  enum class State : std::uint8_t { free, held, yielding };
  State state = State::free;
  HeldLevel level;  ///< none while free
  bool is_free() const noexcept { return state == State::free; }
};

/// Contact states of a session and events of a tick; their only writer. Emits onsets and break-throughs once a tick for each
/// contact, a break-through after its onset; refusals and warnings once a session. Keeps the contacts in a StateArena; one
/// thread.
class Contacts {
 public:
  /// \param modes  [1] their number
  Contacts(StateArena& live, std::size_t modes);

  /// Frees all contacts; reported refusals stay reported.
  void clear() noexcept;
  void begin_tick() noexcept;
  std::span<const SessionEvent> events() const noexcept { return events_; }

  /// Emits a warning about a mode, or the session, at each call.
  void warn(std::size_t mode, const char* sentence) noexcept;
  void warn(const char* sentence) noexcept { emit({SessionEventKind::warning, -1, 0.0, sentence}); }
  /// Warns once a session that a directed force of a mode changes too fast.
  void tell_held_back(std::size_t mode) noexcept;
  /// Updates the contacts after a sub-step whose balance is `depth_m` [m] from the probe, and emits its events. A broken level
  /// counts as crossed, wherever the proxy is: at an edge of a surface its planes can lead back out of it; it would then be
  /// met, and break, in every sub-step.
  void update(const ContactProblem& model, double depth_m, Crossings& crossings) noexcept;

 private:
  static constexpr std::size_t max_events = 16;  // [1] per tick; further events are dropped. More costs memory only
  struct Report {
    Contact contact;
    bool met = false;     // onset emitted in this tick
    bool broken = false;  // break-through emitted in this tick
  };
  struct OfMode {
    std::array<Report, 4> levels;  // elastic levels, and one below; a mode that stands on a single level uses the first
    bool held_back = false;        // warned that its directed force changes too fast
    std::uint32_t refusals = 0;    // bit set of refusals reported
  };
  void emit(const SessionEvent& event) noexcept;
  void change(std::size_t mode, Report& report, Contact now, double depth_m, const Crossings& crossings) noexcept;

  std::span<OfMode> modes_;
  std::vector<SessionEvent> events_;
};

}  // namespace palpa
