#include "palpa/tick/contacts.h"

#include <algorithm>

namespace palpa {

Contacts::Contacts(LiveBlock& live, std::size_t modes) : told_(live.add<Told>(modes)) { events_.reserve(max_events); }

void Contacts::clear() noexcept {
  events_.clear();
  for (Told& told : told_) told.contact = {};
}

void Contacts::begin_tick() noexcept {
  events_.clear();
  for (Told& told : told_) told.met = told.broken = false;
}

void Contacts::emit(const SessionEvent& event) noexcept {
  if (events_.size() < max_events) events_.push_back(event);
}

void Contacts::warn(std::size_t mode, const char* sentence) noexcept {
  emit({SessionEventKind::warning, static_cast<std::int32_t>(mode), 0.0, sentence});
}

void Contacts::tell_held_back(std::size_t mode) noexcept {
  if (!told_[mode].held_back) warn(mode, "a directed force changes faster than half the coupling's stiffness and is held back");
  told_[mode].held_back = true;
}

void Contacts::stop_at_bound(const LocalModel& model) noexcept {
  for (const LevelContact& held : model.contacts()) {
    if (held.state == PrimitiveState::slip) told_[held.id.mode].at_bound = true;
  }
}

void Contacts::update(const LocalModel& model, double depth_m, Crossings& crossings) noexcept {
  const auto is_free = [](const Told& told) { return told.contact.state == Contact::State::free; };
  if (model.contacts().empty() && model.set().dropped() == 0 && std::ranges::all_of(told_, is_free)) return;
  for (std::size_t m = 0; m < told_.size(); ++m) {
    Contact now;
    for (const LevelContact& held : model.contacts()) {
      if (held.id.mode != m || held.state == PrimitiveState::off || now.state != Contact::State::free) continue;
      const bool yields = (held.state == PrimitiveState::slip || told_[m].at_bound) && held.can_break;
      now = {yields ? Contact::State::yielding : Contact::State::held, held.level};
    }
    told_[m].at_bound = false;
    // Material that yields goes on bearing: nothing is broken through.
    change(m, now, depth_m, crossings.is_watched({now.level.field, now.level.value}));
  }
  for (const LevelContact& held : model.contacts()) {
    if (held.state == PrimitiveState::slip) crossings.take_side({held.level.field, held.level.value}, held.solid_is_high);
  }
  for (const Refused& refused : model.set().refused()) {
    std::uint32_t& refusals = told_[refused.id.mode].refusals;
    const std::uint32_t bit = 1u << static_cast<unsigned>(refused.reason);
    if ((refusals & bit) == 0) emit({SessionEventKind::fault, refused.id.mode, 0.0, sentence_of(refused.reason)});
    refusals |= bit;
  }
}

void Contacts::change(std::size_t mode, Contact now, double depth_m, bool is_shell) noexcept {
  using State = Contact::State;
  Told& told = told_[mode];
  const Contact& before = told.contact;
  if (before.state == State::yielding && now.level == before.level) now.state = State::yielding;
  const bool meets = now.state != State::free && before.state == State::free && !told.met;
  const bool breaks = is_shell && now.state == State::yielding && before.state != State::yielding && !told.broken;
  told.met = told.met || meets;
  told.broken = told.broken || breaks;
  const auto m = static_cast<std::int32_t>(mode);
  if (meets) emit({SessionEventKind::onset, m, now.level.value, nullptr});
  if (breaks) emit({SessionEventKind::break_through, m, now.level.value, nullptr, depth_m});
  told.contact = now;
}

}  // namespace palpa
