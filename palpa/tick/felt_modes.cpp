#include "palpa/tick/felt_modes.h"

#include <algorithm>
#include <cassert>
#include <limits>
#include <utility>

namespace palpa {

namespace {

constexpr double fade_s = 0.05;         // out, and in again, where a level jumps
constexpr std::size_t max_fading = 16;  // primitives of a mode

// Zero here, and on both sides of here: between two points of the function it stays so.
bool stays_zero(const TransferFunction& curve, double value) noexcept {
  using Side = TransferFunction::Side;
  return curve.at(value, Side::below) == 0.0 && curve.at(value, Side::above) == 0.0 &&
         curve.slope_at(value, Side::below) == 0.0 && curve.slope_at(value, Side::above) == 0.0;
}

bool boxes_meet(const Box& box, const Vec3& a, const Vec3& b) noexcept {
  return std::max(a.x, b.x) >= box.low_m.x && std::min(a.x, b.x) <= box.high_m.x && std::max(a.y, b.y) >= box.low_m.y &&
         std::min(a.y, b.y) <= box.high_m.y && std::max(a.z, b.z) >= box.low_m.z && std::min(a.z, b.z) <= box.high_m.z;
}

}  // namespace

// Finds every field that a mode reads, and gives its references their numbers: those of the scene's
// volumes, then what is derived from them, once each, behind.
class FeltModes::Resolver final : public ParameterVisitor {
 public:
  Resolver(const Scene& scene, std::vector<FieldPtr>& all, Part& part) : scene_(scene), all_(all), part_(part) {}

  void field(const ParameterInfo& info, FieldRef& ref) override {
    if (ref.name.empty()) return;
    resolve(ref, info.felt);
    if (info.name == "field") part_.main_field = ref.index;
  }
  void companion(FieldRef& ref, const FieldRef& of, Derivation felt) override {
    ref.name = of.name;
    resolve(ref, felt);
  }
  void strength(const ParameterInfo&, Strength& strength) override {
    if (strength.is_constant()) {
      constant_ = constant_ || strength.constant_n != 0.0;
      return;
    }
    part_.strengths.push_back(&strength);
    resolve(strength.of);
    watch(strength.of, strength.curve);
  }
  void number(const ParameterInfo& info, double& value) override {
    if (info.kind == ParameterKind::level) {
      has_levels_ = true;
      watches_.push_back({part_.main_field, value});
    } else if (info.name.ends_with("_ns_per_m")) {
      constant_ = constant_ || value != 0.0;
    }
  }
  void list(const ParameterInfo&, ParameterList& list) override {
    for (std::size_t i = 0; i < list.size(); ++i) list.visit(i, *this);
  }
  void mask(Mask& mask) {
    resolve(mask.of);
    watch(mask.of, mask.curve);
  }

  bool onset_is_watched() const noexcept { return has_levels_ || (!constant_ && !part_.strengths.empty()); }
  const std::vector<Watch>& watches() const noexcept { return watches_; }

 private:
  void resolve(FieldRef& ref, std::optional<Derivation> felt = {}) {
    ref.index = felt ? -1 : scene_.index_of(ref);
    if (ref.index < 0) {
      const FieldPtr field = felt ? scene_.field(ref, *felt) : scene_.field(ref).field;
      const auto found = std::find(all_.begin(), all_.end(), field);
      ref.index = static_cast<std::int32_t>(found - all_.begin());
      if (found == all_.end()) all_.push_back(field);
    }
    if (std::find(part_.fields.begin(), part_.fields.end(), ref.index) == part_.fields.end()) part_.fields.push_back(ref.index);
  }
  // A strength can set in, or jump, only at its points.
  void watch(const FieldRef& ref, const TransferFunction& curve) {
    for (const TransferFunction::Point& point : curve.points()) watches_.push_back({ref.index, point.value});
  }

  const Scene& scene_;
  std::vector<FieldPtr>& all_;
  Part& part_;
  std::vector<Watch> watches_;
  bool has_levels_ = false;
  bool constant_ = false;
};

FeltModes::FeltModes(const Scene& scene, const Similarity& map) : map_(map) {
  for (const SceneVolume& volume : scene.volumes()) {
    for (const VolumeField& field : volume.volume.fields) fields_.push_back(field.field);
  }
  std::size_t memory_bytes = 0;
  modes_ = scene.modes();
  finest_m_ = std::numeric_limits<double>::infinity();
  for (SceneMode& mode : modes_) {
    Part part;
    Resolver resolver(scene, fields_, part);
    mode.mode.visit(resolver);
    for (Mask& mask : mode.masks) resolver.mask(mask);
    part.onset_is_watched = resolver.onset_is_watched();
    part.memory = memory_bytes;
    memory_bytes += (mode.mode.memory_bytes() + 15) / 16 * 16;
    if (mode.enabled) {
      watches_.insert(watches_.end(), resolver.watches().begin(), resolver.watches().end());
      for (const std::int32_t f : part.fields)
        finest_m_ = std::min(finest_m_, map_.length_to_hand(fields_[static_cast<std::size_t>(f)]->spacing_m()));
    }
    parts_.push_back(std::move(part));
  }
  for (std::size_t m = 0; m < modes_.size(); ++m) {
    if (!enabled(m)) continue;
    double finest = std::numeric_limits<double>::infinity();
    for (const std::int32_t f : parts_[m].fields) {
      const Field& field = *fields_[static_cast<std::size_t>(f)];
      finest = std::min(finest, map_.length_to_hand(field.spacing_m()));
      reaches_.push_back({field.bounds_m(), finest, f == parts_[m].fields.back()});
      if (std::find(read_.begin(), read_.end(), f) == read_.end()) read_.push_back(f);
    }
  }
  samples_ = std::make_unique<Samples>(fields_, map_);
  memories_.resize(memory_bytes);
  slots_.reserve(256);
  carried_m_.resize(modes_.size());
  fades_.resize(modes_.size());
  stands_.resize(modes_.size());
  for (Fade& fade : fades_) fade.last.reserve(max_fading);
  start();
}

void FeltModes::start() noexcept {
  for (std::size_t m = 0; m < modes_.size(); ++m) {
    modes_[m].mode.start(memories_.data() + parts_[m].memory);
    fades_[m].share = 1.0;
    fades_[m].leaving = fades_[m].returns = false;
    stands_[m] = 0;
  }
}

void FeltModes::continue_from(const FeltModes& other) noexcept {
  assert(modes_.size() == other.modes_.size() && memories_.size() == other.memories_.size());
  std::copy(other.memories_.begin(), other.memories_.end(), memories_.begin());
  for (std::size_t m = 0; m < modes_.size(); ++m) {
    fades_[m] = other.fades_[m];  // within what is reserved
    stands_[m] = other.stands_[m];
  }
  samples_->set_time(other.samples_->time());
}

void FeltModes::arrive() noexcept {
  if (any_carried_) std::fill(carried_m_.begin(), carried_m_.end(), Vec3{});
  any_carried_ = false;
}

double FeltModes::furthest_carried_m() const noexcept {
  double furthest_m = 0.0;
  if (!any_carried_) return furthest_m;
  for (const Vec3& carried : carried_m_) furthest_m = std::max(furthest_m, norm(carried));
  return furthest_m;
}

double FeltModes::motion_m(const Vec3& at_m, DataTime from, DataTime to) const noexcept {
  double furthest_m = 0.0;
  for (std::size_t m = 0; m < modes_.size(); ++m) {
    if (!enabled(m)) continue;
    furthest_m = std::max(furthest_m, distance(samples_->carried_m(parts_[m].main_field, at_m, from, to), at_m));
  }
  return furthest_m;
}

void FeltModes::attend(Watches& watches, const Vec3& start_m) noexcept {
  for (std::size_t m = 0; m < modes_.size(); ++m) {
    Fade& fade = fades_[m];
    if (fade.leaving) watches.ignore(parts_[m].main_field);
    if (fade.returns) watches.take_side(fade.level, fade.free_above);
    fade.returns = false;
  }
  if (samples_->time() == samples_->came_from()) return;
  std::int32_t last = -1;
  for (const Watch& watch : watches_) {
    if (watch.field == last) continue;
    last = watch.field;
    watches.carry(last, samples_->carried_m(last, start_m, samples_->came_from(), samples_->time()) - start_m);
  }
}

// True where the mode begins to let go.
bool FeltModes::fade(std::size_t m, bool known, double time_step_s, const PrimitiveSet& placed) noexcept {
  Fade& fade = fades_[m];
  const double change = time_step_s / fade_s;
  if (fade.leaving) {
    fade.share = std::max(0.0, fade.share - change);
    if (fade.share == 0.0 && known) {
      fade.leaving = false;
      fade.returns = true;
      modes_[m].mode.start(memories_.data() + parts_[m].memory);
    }
    return false;
  }
  if (known) {
    fade.share = std::min(1.0, fade.share + change);
    return false;
  }
  bool stands = false;
  for (std::size_t i = 0; i < placed.size(); ++i) {
    if (placed[i].id.mode != m || !placed.captured(i).any() || !(placed[i].strength_n > 0.0)) continue;
    stands = true;
    fade.level = {placed.captured(i).field, placed.captured(i).value};
    const DataTime now = samples_->time(), before = samples_->came_from();
    samples_->set_time(before);
    samples_->move_to(placed[i].position_m);
    fade.free_above = dot(placed[i].direction, samples_->scalar(fade.level.field).gradient) > 0.0;
    samples_->set_time(now, before);
  }
  if (!stands) return false;  // what stands on no level cannot jump with it
  fade.leaving = true;
  fade.last.clear();
  for (std::size_t i = 0; i < placed.size() && fade.last.size() < max_fading; ++i) {
    Primitive p = placed[i];
    if (p.id.mode != m || p.id.slot >= first_slot_of_the_tick) continue;
    if (fade.share > 0.0) {  // as it is without the fade
      p.strength_n /= fade.share;
      p.drag_ns_per_m /= fade.share;
    }
    fade.last.push_back(p);
  }
  return true;
}

Here FeltModes::here_at(std::size_t m, const Situation& situation, const Vec3& start_m) noexcept {
  Here here(*samples_, modes_[m].masks, parts_[m].fields);
  here.proxy_m = start_m;
  here.probe_m = situation.probe_m;
  here.time_step_s = situation.time_step_s;
  here.stiffness_n_per_m = situation.stiffness_n_per_m;
  here.finest_m = finest_m_;
  return here;
}

void FeltModes::place(const Situation& situation, const Vec3& at_m, const Vec3& level_m, PrimitiveSet& out) noexcept {
  out.clear(situation.start_m);
  Situation at_level = situation;
  if (level_m != at_m) at_level.gone = std::min(1.0, 2.0 * situation.gone);
  for (std::size_t m = 0; m < modes_.size(); ++m) {
    if (!enabled(m)) continue;
    const std::size_t first = out.size();
    const auto look = [&](bool at_the_level) {
      out.truncate(first);
      at_the_level ? place_mode(m, at_level, level_m, out) : place_mode(m, situation, at_m, out);
      bool stands = false;
      for (std::size_t i = first; i < out.size(); ++i) stands = stands || out.captured(i).any();
      return stands;
    };
    // Nearly always it stands where it stood, or does not.
    const bool stood = stands_[m] != 0;
    const bool stands = look(stood);
    stands_[m] = stands;
    if (stands != stood && level_m != at_m) look(stands);
  }
  samples_->move_to(at_m);
}

void FeltModes::place_mode(std::size_t m, const Situation& situation, const Vec3& at_m, PrimitiveSet& out) noexcept {
  const Vec3 start_m = situation.start_m + carried_m_[m];
  const Fade& fade = fades_[m];
  const std::size_t first = out.size();
  out.begin_mode(static_cast<std::uint16_t>(m), start_m);
  if (fade.leaving) {
    for (Primitive p : fade.last) {
      if (p.kind != PrimitiveKind::plane) p.position_m = start_m;  // what it placed at the proxy
      out.add(p);
    }
  } else {
    samples_->move_to(seen_by(m, at_m, situation.gone));
    modes_[m].mode.place(here_at(m, situation, start_m), memories_.data() + parts_[m].memory, out);
  }
  for (std::size_t i = first; fade.share < 1.0 && i < out.size(); ++i) out.fade(i, fade.share);
}

bool FeltModes::silent_at(const Situation& situation, const Vec3& at_m, PrimitiveSet& scratch,
                          std::vector<std::int32_t>& entered) noexcept {
  entered.clear();
  place(situation, at_m, at_m, scratch);
  for (std::size_t i = 0; i < scratch.size(); ++i) {
    if (scratch[i].strength_n > 0.0 || scratch[i].drag_ns_per_m > 0.0 || scratch.friction_of(i).any()) return false;
  }
  for (std::size_t m = 0; m < modes_.size(); ++m) {
    if (enabled(m) && !silence_is_watched(m, entered)) return false;
  }
  return true;
}

// A mode that places nothing goes on placing nothing until one of its fields begins, until a mask or a strength
// leaves a piece on which it is zero, or until a level is met.
bool FeltModes::silence_is_watched(std::size_t m, std::vector<std::int32_t>& entered) noexcept {
  const Part& part = parts_[m];
  for (const std::int32_t f : part.fields) {
    if (samples_->scalar(f).inside || samples_->vector(f).inside) continue;
    entered.push_back(f);
    return true;
  }
  for (const Mask& mask : modes_[m].masks) {
    if (stays_zero(mask.curve, samples_->scalar(mask.of.index).value)) return true;
  }
  if (!part.onset_is_watched) return false;
  return std::all_of(part.strengths.begin(), part.strengths.end(), [&](const Strength* strength) {
    return stays_zero(strength->curve, samples_->scalar(strength->of.index).value);
  });
}

void FeltModes::prefetch(const Vec3& at_m) const noexcept {
  for (const std::int32_t f : read_) samples_->prefetch(f, at_m);
}

double FeltModes::finest_m(const Vec3& from_m, const Vec3& to_m) const noexcept {
  const Vec3 a = map_.to_world(from_m);
  const Vec3 b = map_.to_world(to_m);
  double finest = std::numeric_limits<double>::infinity();
  bool met = true;
  for (const Reach& reach : reaches_) {
    met = met && boxes_meet(reach.box_m, a, b);
    if (!reach.last_of_mode) continue;
    if (met) finest = std::min(finest, reach.finest_m);
    met = true;
  }
  return finest;
}

}  // namespace palpa
