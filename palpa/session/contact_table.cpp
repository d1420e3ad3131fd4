#include "palpa/session/contact_table.h"

#include <algorithm>

#include "palpa/session/contact_problem.h"

namespace palpa {

ContactTable::ContactTable(StateArena& live, std::size_t modes, std::size_t feet, std::size_t capacity)
    : contacts_(live.add<Contact>(capacity)),
      firsts_(live.add<std::uint32_t>(modes * feet + 1)),
      reported_(live.add<Reported>(modes)) {
  before_.reserve(capacity);
  events_.reserve(max_events);
  event_ids_.reserve(max_events);
}

void ContactTable::clear() noexcept {
  begin_tick();
  std::ranges::fill(firsts_, 0);
}

void ContactTable::begin_tick() noexcept {
  events_.clear();
  event_ids_.clear();
}

Vec3 ContactTable::offset_m(const PrimitiveId& id) const noexcept {
  for (const Contact& contact : of(id.mode, id.foot)) {
    if (contact.id == id) return contact.offset_m;
  }
  return {};
}

bool ContactTable::any_pressed_in() const noexcept {
  return std::ranges::any_of(all(), [](const Contact& contact) { return contact.offset_m != Vec3{}; });
}

void ContactTable::emit(const SessionEvent& event, const PrimitiveId& id) noexcept {
  if (events_.size() == max_events) return;
  events_.push_back(event);
  event_ids_.push_back(id);
}

bool ContactTable::has_emitted(SessionEventKind kind, const PrimitiveId& id) const noexcept {
  for (std::size_t i = 0; i < events_.size(); ++i) {
    if (events_[i].kind == kind && event_ids_[i] == id) return true;
  }
  return false;
}

void ContactTable::warn(std::size_t mode, const char* sentence) noexcept {
  emit({SessionEventKind::warning, static_cast<std::int32_t>(mode), 0.0, sentence});
}

void ContactTable::warn_held_back(std::size_t mode) noexcept {
  if (!reported_[mode].held_back)
    warn(mode, "a directed force changes faster than half the coupling's stiffness and is held back");
  reported_[mode].held_back = true;
}

// Behind the contacts of its foot and mode, and of those before. Almost always the last.
void ContactTable::insert(const Contact& contact) noexcept {
  std::uint32_t& size = firsts_.back();
  if (size == contacts_.size()) return;
  std::uint32_t at = size++;
  for (; at > 0 && part_of(contacts_[at - 1]) > part_of(contact); --at) contacts_[at] = contacts_[at - 1];
  contacts_[at] = contact;
}

void ContactTable::update(const ContactProblem& problem, const Pose& proxy, const Balance& to, double depth_m,
                          Crossings& crossings) noexcept {
  const PrimitiveSet& set = problem.set();
  if (set.empty() && set.refused().empty() && all().empty()) return;
  before_.assign(all().begin(), all().end());
  firsts_.back() = 0;
  for (std::size_t i = 0; i < set.size(); ++i) {
    if (!problem.keeps_contact_at(i) || (i > 0 && set[i - 1].id == set[i].id)) continue;
    insert(problem.contact_at(i, proxy, to));
  }
  std::uint32_t first = 0;
  const std::uint32_t size = firsts_.back();
  for (std::size_t part = 0; part + 1 < firsts_.size(); ++part) {
    firsts_[part] = first;
    while (first < size && part_of(contacts_[first]) == part) follow(contacts_[first++], depth_m, crossings);
  }
  for (const LevelContact& held : problem.contacts()) {
    if (held.state == PrimitiveState::slip)
      crossings.take_side(held.id.foot, {held.level.field, held.level.value}, held.solid_is_high);
  }
  for (const Refused& refused : set.refused()) {
    std::uint32_t& refusals = reported_[refused.id.mode].refusals;
    const std::uint32_t bit = 1u << static_cast<unsigned>(refused.reason);
    if ((refusals & bit) == 0) emit({SessionEventKind::fault, refused.id.mode, 0.0, sentence_of(refused.reason)});
    refusals |= bit;
  }
}

// Emits what has changed since the sub-step before.
void ContactTable::follow(Contact& now, double depth_m, const Crossings& crossings) noexcept {
  using Phase = Contact::Phase;
  if (now.phase == Phase::free) return;
  const auto before = std::ranges::find(before_, now.id, &Contact::id);
  const Phase phase_before = before == before_.end() ? Phase::free : before->phase;
  if (phase_before == Phase::yielding && now.level == before->level) now.phase = Phase::yielding;
  const bool meets = phase_before == Phase::free && !has_emitted(SessionEventKind::onset, now.id);
  // Yielding material keeps bearing: no break-through.
  const bool breaks = now.phase == Phase::yielding && phase_before != Phase::yielding &&
                      crossings.is_watched({now.level.field, now.level.value}) &&
                      !has_emitted(SessionEventKind::break_through, now.id);
  if (meets) emit({SessionEventKind::onset, now.id.mode, now.level.value, nullptr}, now.id);
  if (breaks) emit({SessionEventKind::break_through, now.id.mode, now.level.value, nullptr, depth_m}, now.id);
}

}  // namespace palpa
