#include "palpa/tick/contact_events.h"

namespace palpa {

namespace {

constexpr std::size_t max_events = 16;

}  // namespace

ContactEvents::ContactEvents(std::size_t modes) : told_(modes) { events_.reserve(max_events); }

void ContactEvents::clear() noexcept {
  events_.clear();
  for (Told& told : told_) {
    told.standing = {};
    told.through = false;
  }
}

void ContactEvents::continue_from(const ContactEvents& other) noexcept {
  for (std::size_t m = 0; m < told_.size(); ++m) told_[m] = other.told_[m];
}

void ContactEvents::begin_tick() noexcept {
  events_.clear();
  for (Told& told : told_) told.met = told.broken = false;
}

void ContactEvents::emit(const SessionEvent& event) noexcept {
  if (events_.size() < max_events) events_.push_back(event);
}

void ContactEvents::warn(std::size_t mode, const char* sentence) noexcept {
  emit({SessionEventKind::warning, static_cast<std::int32_t>(mode), 0.0, sentence});
}

void ContactEvents::tell_held_back(std::size_t mode) noexcept {
  if (told_[mode].held_back) return;
  told_[mode].held_back = true;
  warn(mode, "a directed force changes faster than half the coupling's stiffness and is held back");
}

void ContactEvents::stop_at_bound(const LocalModel& model) noexcept {
  for (const LevelContact& contact : model.contacts()) {
    if (contact.state == PrimitiveState::slip) told_[contact.id.mode].at_bound = true;
  }
}

void ContactEvents::tell(const LocalModel& model, double depth_m) noexcept {
  const PrimitiveSet& set = model.set();
  for (std::size_t m = 0; m < told_.size(); ++m) {
    Told& told = told_[m];
    Captured standing;
    bool through = false;
    for (const LevelContact& contact : model.contacts()) {
      if (contact.id.mode != m || contact.state == PrimitiveState::off || standing.any()) continue;
      standing = contact.level;
      through = (contact.state == PrimitiveState::slip || told.at_bound) && contact.bounds;
    }
    told.at_bound = false;
    through = through || (told.through && standing == told.standing);
    const auto mode = static_cast<std::int32_t>(m);
    const bool meets = standing.any() && !told.standing.any() && !told.met;
    const bool breaks = through && !told.through && !told.broken;
    told.met = told.met || meets;
    told.broken = told.broken || breaks;
    if (meets) emit({SessionEventKind::onset, mode, standing.value, nullptr});
    if (breaks) emit({SessionEventKind::break_through, mode, standing.value, nullptr, depth_m});
    told.standing = standing;
    told.through = through;
  }
  for (const Refused& refused : set.refused()) {
    Told& told = told_[refused.id.mode];
    const std::uint32_t bit = 1u << static_cast<unsigned>(refused.reason);
    if ((told.refusals & bit) == 0) {
      told.refusals |= bit;
      emit({SessionEventKind::fault, refused.id.mode, 0.0, sentence_of(refused.reason)});
    }
  }
}

}  // namespace palpa
