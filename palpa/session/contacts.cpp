#include "palpa/session/contacts.h"

#include <algorithm>

namespace palpa {

Contacts::Contacts(StateArena& live, std::size_t modes) : modes_(live.add<OfMode>(modes)) { events_.reserve(max_events); }

void Contacts::clear() noexcept {
  events_.clear();
  for (OfMode& mode : modes_) {
    for (Report& report : mode.levels) report.contact = {};
  }
}

void Contacts::begin_tick() noexcept {
  events_.clear();
  for (OfMode& mode : modes_) {
    for (Report& report : mode.levels) report.met = report.broken = false;
  }
}

void Contacts::emit(const SessionEvent& event) noexcept {
  if (events_.size() < max_events) events_.push_back(event);
}

void Contacts::warn(std::size_t mode, const char* sentence) noexcept {
  emit({SessionEventKind::warning, static_cast<std::int32_t>(mode), 0.0, sentence});
}

void Contacts::tell_held_back(std::size_t mode) noexcept {
  if (!modes_[mode].held_back)
    warn(mode, "a directed force changes faster than half the coupling's stiffness and is held back");
  modes_[mode].held_back = true;
}

void Contacts::update(const ContactProblem& model, double depth_m, Crossings& crossings) noexcept {
  using State = Contact::State;
  const auto is_free = [](const Report& report) { return report.contact.is_free(); };
  const auto all_free = [&](const OfMode& mode) { return std::ranges::all_of(mode.levels, is_free); };
  if (model.contacts().empty() && model.set().dropped() == 0 && std::ranges::all_of(modes_, all_free)) return;
  for (std::size_t m = 0; m < modes_.size(); ++m) {
    const auto is_of_mode = [m](const LevelContact& held) { return held.id.mode == m; };
    if (all_free(modes_[m]) && std::ranges::none_of(model.contacts(), is_of_mode)) continue;
    auto& levels = modes_[m].levels;
    std::array<Contact, std::tuple_size_v<decltype(OfMode::levels)>> now;
    // Levels held before keep their slots; new levels take the first free slot.
    for (const bool is_new : {false, true}) {
      for (const LevelContact& held : model.contacts()) {
        if (held.id.mode != m || held.state == PrimitiveState::off) continue;
        const auto before = std::ranges::find(levels, held.level, [](const Report& report) { return report.contact.level; });
        if ((before == levels.end()) != is_new) continue;
        auto place = now.begin() + (before - levels.begin());
        if (is_new) place = std::ranges::find(now, State::free, &Contact::state);
        if (place == now.end() || !place->is_free()) continue;
        const bool yields = (held.state == PrimitiveState::slip || held.breaks_at_step_end) && held.can_break;
        *place = {yields ? State::yielding : State::held, held.level};
      }
    }
    for (std::size_t i = 0; i < now.size(); ++i) {
      if (!levels[i].contact.is_free() || !now[i].is_free()) change(m, levels[i], now[i], depth_m, crossings);
    }
  }
  for (const LevelContact& held : model.contacts()) {
    if (held.state == PrimitiveState::slip) crossings.take_side({held.level.field, held.level.value}, held.solid_is_high);
  }
  for (const Refused& refused : model.set().refused()) {
    std::uint32_t& refusals = modes_[refused.id.mode].refusals;
    const std::uint32_t bit = 1u << static_cast<unsigned>(refused.reason);
    if ((refusals & bit) == 0) emit({SessionEventKind::fault, refused.id.mode, 0.0, sentence_of(refused.reason)});
    refusals |= bit;
  }
}

void Contacts::change(std::size_t mode, Report& report, Contact now, double depth_m, const Crossings& crossings) noexcept {
  using State = Contact::State;
  const Contact& before = report.contact;
  if (before.state == State::yielding && now.level == before.level) now.state = State::yielding;
  const bool meets = !now.is_free() && before.is_free() && !report.met;
  const bool yields = now.state == State::yielding && before.state != State::yielding;
  // Yielding material keeps bearing: no break-through.
  const bool breaks = yields && !report.broken && crossings.is_watched({now.level.field, now.level.value});
  report.met = report.met || meets;
  report.broken = report.broken || breaks;
  const auto m = static_cast<std::int32_t>(mode);
  if (meets) emit({SessionEventKind::onset, m, now.level.value, nullptr});
  if (breaks) emit({SessionEventKind::break_through, m, now.level.value, nullptr, depth_m});
  report.contact = now;
}

}  // namespace palpa
