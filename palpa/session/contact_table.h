// Contacts of a session, and their events.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "palpa/mode/crossings.h"
#include "palpa/session/session.h"
#include "palpa/solver/state_arena.h"

namespace palpa {

class ContactProblem;

/// Contacts with the levels, and with the primitives of modes with a memory, in the last sub-step, by foot and mode; and the
/// events of a tick. Their only owner. Emits onsets and break-throughs once a tick for each primitive, a break-through after
/// its onset; refusals and warnings once a session. Keeps the contacts in a StateArena; allocates at construction only; one
/// thread.
class ContactTable {
 public:
  /// \param modes     [1] their number
  /// \param feet      [1] of the tool
  /// \param capacity  [1] of contacts; a surplus is dropped
  ContactTable(StateArena& live, std::size_t modes, std::size_t feet, std::size_t capacity);

  /// Removes all contacts; reported refusals stay reported.
  void clear() noexcept;
  void begin_tick() noexcept;
  std::span<const SessionEvent> events() const noexcept { return events_; }

  std::span<const Contact> all() const noexcept { return contacts_.first(firsts_.back()); }
  /// Contacts of a mode at a foot, in the order placed.
  std::span<const Contact> of(std::size_t mode, std::size_t foot) const noexcept {
    const std::size_t part = part_of(mode, foot);
    return contacts_.subspan(firsts_[part], firsts_[part + 1] - firsts_[part]);
  }
  /// Vector from its foot to the footing on a primitive [m]; zero without contact.
  Vec3 offset_m(const PrimitiveId& id) const noexcept;
  /// Whether the proxy presses an elastic level in.
  bool any_pressed_in() const noexcept;

  /// Emits a warning about a mode, or the session, at each call.
  void warn(std::size_t mode, const char* sentence) noexcept;
  void warn(const char* sentence) noexcept { emit({SessionEventKind::warning, -1, 0.0, sentence}); }
  /// Warns once a session that a directed force of a mode changes too fast.
  void warn_held_back(std::size_t mode) noexcept;
  /// Replaces the contacts by those of an accepted sub-step that ends with the proxy at `proxy` [m] and its balance `to`
  /// `depth_m` [m] from the probe, and emits its events. A broken level counts as crossed, wherever the proxy is: at an edge of
  /// a surface its planes can lead back out of it; it would then be met, and break, in every sub-step.
  void update(const ContactProblem& problem, const Pose& proxy, const Balance& to, double depth_m,
              Crossings& crossings) noexcept;

 private:
  static constexpr std::size_t max_events = 16;  // [1] per tick; further events are dropped. More costs memory only
  struct Reported {
    bool held_back = false;      // warned that its directed force changes too fast
    std::uint32_t refusals = 0;  // bit set of refusals reported
  };
  std::size_t part_of(std::size_t mode, std::size_t foot) const noexcept { return foot * reported_.size() + mode; }
  std::size_t part_of(const Contact& contact) const noexcept { return part_of(contact.id.mode, contact.id.foot); }
  void emit(const SessionEvent& event, const PrimitiveId& id = {}) noexcept;
  bool has_emitted(SessionEventKind kind, const PrimitiveId& id) const noexcept;
  void insert(const Contact& contact) noexcept;
  void follow(Contact& now, double depth_m, const Crossings& crossings) noexcept;

  std::span<Contact> contacts_;      // by foot, then mode
  std::span<std::uint32_t> firsts_;  // first contact by foot, then mode; and the end
  std::span<Reported> reported_;     // by mode
  std::vector<Contact> before_;      // contacts of the sub-step before
  std::vector<SessionEvent> events_;
  std::vector<PrimitiveId> event_ids_;  // their primitives
};

}  // namespace palpa
