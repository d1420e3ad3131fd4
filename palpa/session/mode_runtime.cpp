#include "palpa/session/mode_runtime.h"

#include <algorithm>
#include <limits>
#include <tuple>

#include "palpa/data/box.h"

namespace palpa {

ModeRuntime::ModeRuntime(StateArena& live, const Scene& scene, const Similarity& map, const Tool& tool,
                         const ContactTable& contacts)
    : map_(map), tool_(tool), modes_(scene.modes()), size_(modes_.size()), contacts_(contacts), most_n_(live.add<double>()) {
  most_n_ = std::numeric_limits<double>::infinity();
  for (const SceneVolume& volume : scene.volumes()) {
    for (const VolumeField& field : volume.volume.fields) fields_.push_back(field.field);
  }
  parts_.resize(size_);
  finest_m_ = std::numeric_limits<double>::infinity();
  for (std::size_t m = 0; m < size_; ++m) {
    Part& part = parts_[m];
    part.inputs = resolve(modes_[m], scene, fields_);
    part.masks = modes_[m].masks;
    part.memory = memory_units_;
    part.has_memory = modes_[m].mode.memory_bytes() > 0;
    part.at_all_feet = modes_[m].acts_at(1);
    memory_units_ += (modes_[m].mode.memory_bytes() + sizeof(MemoryUnit) - 1) / sizeof(MemoryUnit);
    if (!enabled(m)) continue;
    watches_.insert(watches_.end(), part.inputs.watches.begin(), part.inputs.watches.end());
    for (const std::int32_t f : part.inputs.fields) {
      const double spacing_m = map_.length_to_hand(fields_[f]->spacing_m());
      part.finest_m = std::min(part.finest_m, std::max(spacing_m, Samples::min_spacing_m));
      part.box_m = f == part.inputs.fields.front() ? fields_[f]->bounds_m() : intersection(part.box_m, fields_[f]->bounds_m());
    }
    finest_m_ = std::min(finest_m_, part.finest_m);
  }
  for (std::size_t foot = 0; foot < tool_.feet(); ++foot) samples_.push_back(std::make_unique<Samples>(fields_, map_));
  live_ = live.add<Live>(tool_.feet() * size_);
  memories_ = live.add<MemoryUnit>(tool_.feet() * memory_units_);
  start();
}

double ModeRuntime::data_end_s() const noexcept {
  double end_s = 0.0;
  for (const FieldPtr& field : fields_) {
    if (const TimedField* const changing = timed(*field)) end_s = std::max(end_s, changing->cycle_s());
  }
  return end_s;
}

void ModeRuntime::start() noexcept {
  for_each_part([&](std::size_t m, std::size_t foot) {
    modes_[m].mode.start(memory(m, foot));
    live_[part_of(m, foot)] = {};
  });
}

void ModeRuntime::arrive() noexcept {
  motion_.furthest_m = -1.0;  // contacts have changed
  if (furthest_carried_m_ == 0.0) return;
  furthest_carried_m_ = 0.0;
  for (Live& live : live_) live.carried_m = {};
}

double ModeRuntime::motion_m(const Pose& proxy, DataTime from, DataTime to) noexcept {
  if (motion_.furthest_m >= 0.0 && motion_.proxy == proxy && motion_.from == from && motion_.to == to)
    return motion_.furthest_m;
  double furthest_m = 0.0;
  for_each_part([&](std::size_t m, std::size_t foot) {
    if (!acts(m, foot)) return;
    const Vec3 by_m = carried_at(m, foot, tool_.foot_m(proxy, foot));
    furthest_m = std::max(furthest_m, distance(samples_[foot]->carried_m(parts_[m].inputs.main_field, by_m, from, to), by_m));
  });
  motion_ = {proxy, from, to, furthest_m};
  return furthest_m;
}

void ModeRuntime::configure_events(std::size_t foot, Crossings& crossings, EventPolicy& policy, const Vec3& start_m) noexcept {
  for (std::size_t m = 0; m < size_; ++m) {
    const std::int32_t field = parts_[m].inputs.main_field;
    if (field >= 0) live_[part_of(m, foot)].fade.configure_events(foot, field, crossings, policy);
  }
  const DataTime now = samples(foot).time(), before = samples(foot).came_from();
  for (std::int32_t f = 0; now != before && f < static_cast<std::int32_t>(fields_.size()); ++f)
    policy.fields[f].carried_m = samples(foot).carried_m(f, start_m, before, now) - start_m;
}

ModeContext ModeRuntime::here_at(std::size_t m, const Foot& foot, const StepContext& context, const Vec3& start_m,
                                 const Vec3& at_m) noexcept {
  ModeContext here(samples(foot.number), at_m, parts_[m].masks, parts_[m].inputs.fields);
  here.proxy_m = start_m;
  here.probe_m = foot.probe_m;
  here.time_step_s = context.time_step_s;
  here.stiffness_n_per_m = context.stiffness_n_per_m;
  here.finest_m = context.spacing_m;
  here.most_n = most_n_;
  here.contacts = contacts_.of(m, foot.number);
  return here;
}

void ModeRuntime::place(const StepContext& context, const Pose& at, const Pose& level, double data_fraction,
                        PrimitiveSet& out) noexcept {
  out.clear(context.start.position_m);
  for (std::size_t foot = 0; foot < tool_.feet(); ++foot) {
    const Vec3 foot_at_m = tool_.foot_m(at, foot), foot_level_m = tool_.foot_m(level, foot);
    const Foot of_tool = foot_of(foot, context);
    out.begin_foot(static_cast<std::uint16_t>(foot), tool_.foot_m(context.start, foot));
    for (std::size_t m = 0; m < size_; ++m) {
      if (!acts(m, foot)) continue;
      Live& live = live_[part_of(m, foot)];
      const std::size_t first = out.size();
      const auto stands_at = [&](bool is_level) {
        out.truncate(first);
        is_level ? place_mode(m, of_tool, context, live.origin_m, foot_level_m, carried_along, out)
                 : place_mode(m, of_tool, context, live.origin_m, foot_at_m, data_fraction, out);
        bool stands = false;
        for (std::size_t i = first; i < out.size(); ++i) stands = stands || out.captured(i).any();
        return stands;
      };
      // First guess: the mode stands on a level if it did last time.
      const bool stood = live.stands;
      const bool stands = live.stands = stands_at(stood);
      if (stands != stood && (!tool_.are_one(level, at) || data_fraction > 0.0)) stands_at(stands);
    }
  }
}

int ModeRuntime::body_work_of(const PrimitiveSet& placed) const noexcept {
  std::size_t parts = size_;
  for (std::size_t i = 0; i < placed.size(); ++i) {
    const bool begins = i == 0 || placed[i].id.mode != placed[i - 1].id.mode || placed[i].id.foot != placed[i - 1].id.foot;
    parts += begins ? 1 : 0;
  }
  return samples_[0]->work_of_modes(parts);
}

void ModeRuntime::place_mode(std::size_t m, const Foot& foot, const StepContext& context, const Vec3& origin_m,
                             const Vec3& at_m, double data_fraction, PrimitiveSet& out) noexcept {
  Live& live = live_[part_of(m, foot.number)];
  const std::size_t first = out.size();
  out.begin_mode(static_cast<std::uint16_t>(m), origin_m);
  if (live.fade.is_leaving()) {
    live.fade.place(origin_m, out);
  } else {
    const ModeContext here = here_at(m, foot, context, origin_m, seen_by(m, foot.number, at_m, data_fraction));
    modes_[m].mode.place(here, memory(m, foot.number), out);
    live.at_edge = false;
    for (std::size_t i = first; i < out.size(); ++i) live.at_edge = live.at_edge || out.captured(i).limited;
  }
  const std::size_t end = out.size();
  if (live.fade.share() < 1.0) {
    for (std::size_t i = first; i < end; ++i) out.fade(i, live.fade.share());
  }
  if (tool_.share() < 1.0 && parts_[m].at_all_feet && !live.fade.is_leaving()) {
    for (std::size_t i = first; i < end; ++i) out.bear(i, tool_.share());
  }
  if (most_n_ == std::numeric_limits<double>::infinity()) return;
  for (std::size_t i = first; i < end; ++i) {
    if (!(out[i].strength_n > most_n_) || !is_level(out.captured(i))) continue;
    // A level stronger than the force limit never yields: raise it above the spring's largest pull.
    double longest_m = distance(foot.probe_m, at_m);
    if (!tool_.is_point()) longest_m += tool_.pull_m(tool_.motion(context.start, context.probe));
    out.set_strength(i, out[i].strength_n + context.stiffness_n_per_m * longest_m);
  }
}

void ModeRuntime::on_step_accepted(const StepContext& context, const Pose& proxy, double data_fraction,
                                   const PrimitiveSet& placed, std::span<const Event> events) noexcept {
  const bool is_timed = any_timed();
  for_each_part([&](std::size_t m, std::size_t foot) {
    if (!(is_timed || has_memory(m)) || !acts(m, foot)) return;
    ContactFade& fade = live_[part_of(m, foot)].fade;
    if (fade.is_leaving()) return;
    if (is_timed) fade.keep(m, foot, placed);
    if (!has_memory(m)) return;
    const Vec3 foot_m = tool_.foot_m(proxy, foot);
    const ModeContext here = here_at(m, foot_of(foot, context), context, foot_m, seen_by(m, foot, foot_m, data_fraction));
    modes_[m].mode.on_step_accepted({here, here.contacts, events[foot].crossings}, memory(m, foot));
  });
}

bool ModeRuntime::is_free_at(const StepContext& context, std::vector<std::int32_t>& entered) noexcept {
  entered.clear();
  scratch_.clear(context.start.position_m);
  for (std::size_t foot = 0; foot < tool_.feet(); ++foot) {
    const Vec3 foot_m = tool_.foot_m(context.start, foot);
    scratch_.begin_foot(static_cast<std::uint16_t>(foot), foot_m);
    for (std::size_t m = 0; m < size_; ++m) {
      const Vec3 origin_m = foot_m + live_[part_of(m, foot)].carried_m;
      if (acts(m, foot)) place_mode(m, foot_of(foot, context), context, origin_m, foot_m, carried_along, scratch_);
    }
  }
  if (scratch_.can_pull()) return false;
  bool is_free = true;
  for_each_part([&](std::size_t m, std::size_t foot) {
    is_free = is_free && (!acts(m, foot) || silence_is_watched(m, foot, tool_.foot_m(context.start, foot), entered));
  });
  if (!is_free) entered.clear();
  return is_free;
}

// Whether a mode that places nothing stays silent until a watched event: data of one of its fields begin, a mask or a strength
// leaves an interval on which it is zero, or a level is met.
bool ModeRuntime::silence_is_watched(std::size_t m, std::size_t foot, const Vec3& at_m,
                                     std::vector<std::int32_t>& entered) noexcept {
  const ModeInputs& inputs = parts_[m].inputs;
  Samples& samples = this->samples(foot);
  const auto has_no_data = [&](std::int32_t f) { return !samples.scalar(f, at_m).inside && !samples.vector(f, at_m).inside; };
  const auto stays_zero_at = [&](const FieldRef& of, const TransferFunction& curve) {
    return curve.stays_zero_at(samples.scalar(detail::field_numbers(of).field, at_m).value);
  };
  const auto outside = std::find_if(inputs.fields.begin(), inputs.fields.end(), has_no_data);
  if (outside != inputs.fields.end()) {
    entered.push_back(*outside);
    return true;
  }
  for (const Mask& mask : modes_[m].masks) {
    if (stays_zero_at(mask.of, mask.curve)) return true;
  }
  return inputs.onset_is_watched &&
         std::all_of(inputs.strengths.begin(), inputs.strengths.end(),
                     [&](const Strength* strength) { return stays_zero_at(strength->of, strength->curve); });
}

double ModeRuntime::finest_m(const Pose& at, const Pose& from, const Pose& to) const noexcept {
  double finest = std::numeric_limits<double>::infinity();
  if (finest_m_ == finest) return finest;  // no data anywhere
  for (std::size_t foot = 0; foot < tool_.feet() && finest > finest_m_; ++foot) {
    const Vec3 world_m = map_.to_world(tool_.foot_m(at, foot)), b = map_.to_world(tool_.foot_m(to, foot));
    const Vec3 a = tool_.are_one(from, at) ? world_m : map_.to_world(tool_.foot_m(from, foot));
    for (std::size_t m = 0; m < size_; ++m) {
      if ((foot > 0 && !parts_[m].at_all_feet) || finest <= parts_[m].finest_m || !may_meet(parts_[m].box_m, a, b)) continue;
      for (const std::int32_t f : parts_[m].inputs.fields) {
        if (finest <= parts_[m].finest_m) break;
        finest = std::min(finest, samples_[foot]->local_spacing_m(f, world_m));
      }
    }
  }
  return finest;
}

bool ModeRuntime::has_same_contacts_as(const ModeRuntime& other) const noexcept {
  const auto key = [](const SceneMode& mode) {
    return std::tuple(mode.mode.type(), std::string_view(mode.name), mode.enabled);
  };
  return std::ranges::equal(modes_, other.modes_, {}, key, key) && fields_ == other.fields_ && watches_ == other.watches_ &&
         tool_ == other.tool_;
}

}  // namespace palpa
