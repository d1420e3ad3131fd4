#include "palpa/data/octaves.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <mutex>
#include <stdexcept>
#include <utility>

#include "palpa/data/blend.h"
#include "palpa/data/halton.h"

namespace palpa {
namespace {

constexpr double unbounded = std::numeric_limits<double>::infinity();
// [1] spacings of depth half way from the last octave that is felt to the first that is not: there the widest border begins to
// weaken a level. More: strengths fall late, and faster; less: early.
constexpr double fade_spacings = 4.0;

/// Grid of an octave with its border voxels.
GridGeometry sampled_grid_of(const GridGeometry& finest, const std::array<std::int64_t, 3>& dims, int octave) {
  GridGeometry grid = finest;
  if (octave == 0) return grid;
  const double width = std::ldexp(1.0, octave);  // [voxels of octave 0]
  const double first = 0.5 * (width - 1.0) - width * static_cast<double>(Octaves::border(octave));
  grid.origin_m = finest.to_world({first, first, first});
  for (Vec3& row : grid.index_to_world_m.row) row = width * row;
  for (std::size_t a = 0; a < 3; ++a) grid.dims[a] = dims[a] + 2 * Octaves::border(octave);
  return grid;
}

std::atomic<std::int64_t> fields_made{0};

}  // namespace

class KeptWindows {
 public:
  static constexpr std::int64_t most_bytes = 256'000'000;  // of voxels. More: memory; less: windows are made again
  struct Entry {
    std::int64_t field;
    int octave;
    std::array<std::int64_t, 3> first, dims;
    OctaveWindow window;
    std::int64_t bytes;
  };
  std::mutex busy;
  std::vector<Entry> entries;  // the last used is the last
  std::int64_t bytes = 0;
};

Octaves::Octaves(Shape shape) : shape_(std::move(shape)), number_(fields_made.fetch_add(1)) {
  if (!shape_.kept) shape_.kept = std::make_shared<KeptWindows>();
  if (const char* problem = problem_with(shape_.finest)) throw std::invalid_argument(problem);
  if (shape_.count < 1 || shape_.count > most) throw std::invalid_argument("a grid in octaves has 1 to 24 of them");
  if (!shape_.source) throw std::invalid_argument("a grid in octaves has a source of voxels");
  if (shape_.ranges.size() != static_cast<std::size_t>(shape_.components))
    throw std::invalid_argument("a grid in octaves has a range for each of its components");
  constexpr double hair = 1e-9;  // [1] of a width, for rounding
  const double widest_m = voxel_width_m(shape_.finest);
  while (first_unfelt_ < shape_.count && std::ldexp(widest_m, first_unfelt_) <= (1.0 + hair) * shape_.coarsest_m)
    ++first_unfelt_;
  if (first_unfelt_ == 0) throw std::invalid_argument("the voxels of octave 0 are wider than the coarsest that are felt");
  for (int octave = 0; octave < shape_.count; ++octave) grids_.push_back(sampled_grid_of(shape_.finest, dims(octave), octave));
  const int last = shape_.count - 1;
  coarsest_ = window_from(*shape_.source, last, {}, grids_.back().dims);
  if (!coarsest_.grid) throw std::invalid_argument("the coarsest octave cannot be read");
  const Vec3 low = shape_.finest.to_world({});
  bounds_m_ = {low, low};
  for (int corner = 0; corner < 8; ++corner) {
    const auto end = [&](std::size_t a) {
      const std::int64_t n = shape_.finest.dims[a];
      const double half = n > 1 ? 0.0 : 0.5;
      return corner >> a & 1 ? static_cast<double>(n - 1) + half : -half;
    };
    const Vec3 at = shape_.finest.to_world({end(0), end(1), end(2)});
    bounds_m_.low_m = {std::min(bounds_m_.low_m.x, at.x), std::min(bounds_m_.low_m.y, at.y), std::min(bounds_m_.low_m.z, at.z)};
    bounds_m_.high_m = {std::max(bounds_m_.high_m.x, at.x), std::max(bounds_m_.high_m.y, at.y),
                        std::max(bounds_m_.high_m.z, at.z)};
  }
  for (const ValueRange& range : shape_.ranges) largest_ = std::max({largest_, std::abs(range.min), std::abs(range.max)});
  spacing_m_ = std::ldexp(coarsest_.grid->spacing_m(), -last);
}

double Octaves::voxel_width_m(const GridGeometry& finest) noexcept {
  const Mat3& steps_m = finest.index_to_world_m;
  return std::max({norm(steps_m * Vec3{1, 0, 0}), norm(steps_m * Vec3{0, 1, 0}), norm(steps_m * Vec3{0, 0, 1})});
}

std::array<std::int64_t, 3> Octaves::dims(int octave) const noexcept {
  std::array<std::int64_t, 3> dims = shape_.finest.dims;
  for (std::int64_t& n : dims) n = std::max<std::int64_t>((n + (std::int64_t{1} << octave) - 1) >> octave, 1);
  return dims;
}

/// Voxels of a box of the octave as it is sampled; none if some are lost. Border voxels repeat the outermost.
Voxels Octaves::voxels_of(VoxelSource& source, int octave, const std::array<std::int64_t, 3>& first,
                          const std::array<std::int64_t, 3>& dims) const {
  const std::size_t voxel = size_of(shape_.type) * static_cast<std::size_t>(shape_.components);
  const std::array<std::int64_t, 3> all = this->dims(octave);
  std::array<std::int64_t, 3> low{}, size{};
  bool has_border = false;
  for (std::size_t a = 0; a < 3; ++a) {
    const std::int64_t from = first[a] - border(octave), end = from + dims[a];
    low[a] = std::max<std::int64_t>(from, 0);
    size[a] = std::min(end, all[a]) - low[a];
    has_border = has_border || from < 0 || end > all[a];
  }
  const auto room = [&](const std::array<std::int64_t, 3>& n) {
    return std::shared_ptr<std::byte[]>(new std::byte[static_cast<std::size_t>(n[0] * n[1] * n[2]) * voxel]);
  };
  const std::shared_ptr<std::byte[]> inner = room(size);
  if (!source.read(octave, low, size, inner.get())) return {};
  if (!has_border) return {shape_.type, shape_.components, inner};
  const std::shared_ptr<std::byte[]> out = room(dims);
  std::byte* to = out.get();
  const auto inside = [&](std::size_t a, std::int64_t n) {
    return std::clamp<std::int64_t>(first[a] - border(octave) + n - low[a], 0, size[a] - 1);
  };
  const std::int64_t before = low[0] - (first[0] - border(octave));
  for (std::int64_t k = 0; k < dims[2]; ++k) {
    for (std::int64_t j = 0; j < dims[1]; ++j) {
      const std::byte* row = inner.get() + static_cast<std::size_t>(size[0] * (inside(1, j) + size[1] * inside(2, k))) * voxel;
      const std::byte* last = row + static_cast<std::size_t>(size[0] - 1) * voxel;
      for (std::int64_t i = 0; i < before; ++i, to += voxel) std::memcpy(to, row, voxel);
      std::memcpy(to, row, static_cast<std::size_t>(size[0]) * voxel);
      to += static_cast<std::size_t>(size[0]) * voxel;
      for (std::int64_t i = before + size[0]; i < dims[0]; ++i, to += voxel) std::memcpy(to, last, voxel);
    }
  }
  return {shape_.type, shape_.components, out};
}

Vec3 Octaves::steps_of(int octave, const Vec3& world_m) const noexcept {
  const GridGeometry& grid = sampled_grid(octave);
  return detail::scaled_inverse(grid.index_to_world_m) * (world_m - grid.origin_m);
}

OctaveWindow Octaves::window(int octave, const std::array<std::int64_t, 3>& first,
                             const std::array<std::int64_t, 3>& dims) const {
  KeptWindows& kept = *shape_.kept;
  const std::lock_guard lock(kept.busy);
  std::vector<KeptWindows::Entry>& all = kept.entries;
  const auto known = std::ranges::find_if(all, [&](const KeptWindows::Entry& entry) {
    return entry.field == number_ && entry.octave == octave && entry.first == first && entry.dims == dims;
  });
  if (known != all.end()) {
    std::rotate(known, known + 1, all.end());
    return all.back().window;
  }
  const auto voxel = static_cast<std::int64_t>(size_of(shape_.type)) * shape_.components;
  KeptWindows::Entry made{
      number_, octave, first, dims, window_from(*shape_.source, octave, first, dims), dims[0] * dims[1] * dims[2] * voxel};
  while (!all.empty() && kept.bytes + made.bytes > KeptWindows::most_bytes) {
    kept.bytes -= all.front().bytes;
    all.erase(all.begin());
  }
  kept.bytes += made.bytes;
  all.push_back(std::move(made));
  return all.back().window;
}

std::shared_ptr<const detail::GridBase> Octaves::grid_of(VoxelSource& source, int octave,
                                                         const std::array<std::int64_t, 3>& first,
                                                         const std::array<std::int64_t, 3>& dims) const {
  Voxels voxels = voxels_of(source, octave, first, dims);
  if (!voxels.data) return nullptr;
  GridWindow window{first, dims, {}, {}};
  const double width = std::ldexp(1.0, octave);
  for (std::size_t a = 0; a < 3; ++a) {
    const std::int64_t n = shape_.finest.dims[a];
    const double half = n > 1 ? 0.0 : 0.5;
    const auto at = [&](double finest) {  // [steps] of a position in voxels of octave 0
      return octave == 0 ? finest : (finest - 0.5 * (width - 1.0)) / width + static_cast<double>(border(octave));
    };
    window.data_low[a] = at(-half), window.data_high[a] = at(static_cast<double>(n - 1) + half);
  }
  return std::dynamic_pointer_cast<const detail::GridBase>(
      window_field(sampled_grid(octave), window, std::move(voxels), shape_.filter, shape_.scale, shape_.offset));
}

OctaveWindow Octaves::window_from(VoxelSource& source, int octave, const std::array<std::int64_t, 3>& first,
                                  const std::array<std::int64_t, 3>& dims) const {
  OctaveWindow made{grid_of(source, octave, first, dims)};
  if (!made.grid || shape_.components != 1) return made;
  constexpr int places = 1024;  // [1] more: slower windows; fewer: a less certain median
  made.noise = detail::noise_of_gradient(*made.grid, places, [&](int n) {
    const auto along = [&](std::size_t a, double share) {
      return static_cast<double>(first[a]) + share * static_cast<double>(dims[a] - 1);
    };
    return sampled_grid(octave).to_world({along(0, detail::radical_inverse<2>(n)), along(1, detail::radical_inverse<3>(n)),
                                          along(2, detail::radical_inverse<5>(n))});
  });
  return made;
}

double Octaves::noise_of_finest(int places, const std::function<Vec3(int)>& place) const {
  /// Octave 0 by a window of a few voxels about a place.
  class Samples final : public Field {
   public:
    explicit Samples(const Octaves& of) : of_(of) {}
    int components() const noexcept override { return 1; }
    double spacing_m() const noexcept override { return of_.spacing_m(); }
    Box bounds_m() const noexcept override { return of_.bounds_m(); }
    double depth_m(const Vec3& world_m) const noexcept override { return of_.depth_m(world_m); }
    std::vector<ValueRange> value_ranges() const override { return of_.value_ranges(); }
    VectorSample vector(const Vec3&) const noexcept override { return {}; }
    ScalarSample scalar(const Vec3& world_m) const noexcept override {
      return window_ ? window_->scalar(world_m) : ScalarSample{};
    }

    void lay_about(const Vec3& world_m) {
      const Vec3 steps = of_.steps_of(0, world_m);
      const double at[3] = {steps.x, steps.y, steps.z};
      std::array<std::int64_t, 3> first{}, dims{};
      for (std::size_t a = 0; a < 3; ++a) {
        constexpr std::int64_t reach = 4;  // [voxels] of a step of a spacing and a sample, along the axes of any grid
        const std::int64_t all = of_.dims(0)[a], middle = static_cast<std::int64_t>(at[a]);
        first[a] = std::clamp<std::int64_t>(middle - reach, 0, all - 1) / 8 * 8;
        dims[a] = std::min(middle + reach + 1, all) - first[a];
      }
      const bool is_within = std::ranges::all_of(dims, [](std::int64_t n) { return n > 0; });
      window_ = is_within ? of_.grid_of(*of_.shape_.source, 0, first, dims) : nullptr;
    }

   private:
    const Octaves& of_;
    std::shared_ptr<const detail::GridBase> window_;
  };
  Samples samples(*this);
  return detail::noise_of_gradient(samples, places, [&](int n) {
    const Vec3 at = place(n);
    samples.lay_about(at);
    return at;
  });
}

Octaves::Between Octaves::between(DataTime at) const noexcept {
  const int last = shape_.count - 1;
  if (!at.stock) return {last, 0.0};
  const double octave = std::clamp(std::isfinite(at.octave) ? at.octave : 0.0, 0.0, static_cast<double>(last));
  const double whole = std::floor(octave);
  return {static_cast<int>(whole), octave - whole};
}

/// Limit [m] of depths by the felt octave: none up to the last octave that is felt, zero from the next one on.
double Octaves::fade_m(DataTime at) const noexcept {
  const Between t = between(at);
  const double left = first_unfelt_ - t.a - t.u;  // [octaves]
  if (!at.stock || left >= 1.0) return unbounded;
  return left > 0.0 ? fade_spacings * std::ldexp(spacing_m_, first_unfelt_ - 1) * left / (1.0 - left) : 0.0;
}

const OctaveWindow& Octaves::in_force(int octave, DataTime at) const noexcept {
  if (octave >= shape_.count - 1 || !at.stock) return coarsest_;
  const Stock::Store* store = at.stock->store_of(*this);
  if (!store) return coarsest_;
  const Stock::Slot& slot = store->slots[static_cast<std::size_t>(octave)];
  return slot.windows[slot.in_force];
}

/// Calls `sample(grid, place)` for the finest octave from `octave` on whose window holds the position.
template <class Sample>
auto Octaves::sampled_in(int octave, const Vec3& world_m, DataTime at, Sample&& sample) const noexcept {
  for (; octave < shape_.count - 1; ++octave) {
    const detail::GridBase* grid = in_force(octave, at).grid.get();
    if (!grid) continue;
    detail::GridBase::Place place = grid->place_of(world_m);
    if (place.inside || grid->room_voxels(world_m) >= 0.0) return sample(*grid, place);
  }
  detail::GridBase::Place place = coarsest_.grid->place_of(world_m);
  return sample(*coarsest_.grid, place);
}

ScalarSample Octaves::scalar_at(const Vec3& world_m, DataTime at) const noexcept {
  if (!is_felt(at)) return {};
  const auto sample = [](const detail::GridBase& grid, detail::GridBase::Place& place) { return grid.scalar_in(place); };
  const Between t = between(at);
  const ScalarSample a = sampled_in(t.a, world_m, at, sample);
  return t.u == 0.0 ? a : detail::blend(a, sampled_in(t.a + 1, world_m, at, sample), t.u);
}

VectorSample Octaves::vector_at(const Vec3& world_m, DataTime at) const noexcept {
  if (!is_felt(at)) return {};
  const auto sample = [](const detail::GridBase& grid, detail::GridBase::Place& place) { return grid.vector_in(place); };
  const Between t = between(at);
  const VectorSample a = sampled_in(t.a, world_m, at, sample);
  return t.u == 0.0 ? a : detail::blend(a, sampled_in(t.a + 1, world_m, at, sample), t.u);
}

Mat3 Octaves::hessian_at(const Vec3& world_m, DataTime at) const noexcept {
  if (!is_felt(at)) return {};
  const auto sample = [&](const detail::GridBase& grid, detail::GridBase::Place&) { return grid.hessian(world_m); };
  const Between t = between(at);
  const Mat3 a = sampled_in(t.a, world_m, at, sample);
  if (t.u == 0.0) return a;
  if (!scalar_at(world_m, at).inside) return {};
  return detail::blend(a, sampled_in(t.a + 1, world_m, at, sample), t.u);
}

LipschitzBound Octaves::lipschitz_bound_at(const Vec3& world_m, DataTime at) const noexcept {
  if (!is_felt(at)) return {};
  const Between t = between(at);
  const auto bound_of = [&](int octave) {
    const detail::GridBase* grid = in_force(octave, at).grid.get();
    return grid ? grid->lipschitz_bound(world_m) : LipschitzBound{};
  };
  const LipschitzBound a = bound_of(t.a);
  return t.u == 0.0 || a.radius_m == 0.0 ? a : detail::blend(a, bound_of(t.a + 1), t.u, largest_);
}

double Octaves::local_spacing_at(const Vec3& world_m, DataTime at) const noexcept {
  return sampled_in(between(at).a, world_m, at,
                    [&](const detail::GridBase& grid, detail::GridBase::Place&) { return grid.local_spacing_m(world_m); });
}

// Finite parts: a coarser octave is a hole wherever a finer one is, so that each window gives a bound from below, as far as it
// reaches, and the largest counts, of a blend from its coarser octave on. Without holes in the coarsest octave there are none.
double Octaves::depth_at(const Vec3& world_m, DataTime at) const noexcept {
  const Between t = between(at);
  const detail::GridBase* first = in_force(t.a, at).grid.get();
  const double of_box_m = std::min((first ? first : coarsest_.grid.get())->box_depth_m(world_m), fade_m(at));
  if (!coarsest_.grid->has_holes()) return of_box_m;
  double depth_m = coarsest_.grid->depth_m(world_m);
  for (int octave = t.u == 0.0 ? t.a : t.a + 1; octave < shape_.count - 1; ++octave) {
    const detail::GridBase* grid = in_force(octave, at).grid.get();
    if (!grid) continue;
    const double reach_m = grid->room_voxels(world_m) * grid->spacing_m();
    depth_m = std::max(depth_m, std::min(grid->depth_m(world_m), reach_m));
  }
  return std::min(depth_m, of_box_m);
}

/// Piece of the octave whose window holds its begin, up to the window's end or that of a finer octave.
PolynomialPiece Octaves::piece_of(int octave, const Vec3& from_m, const Vec3& to_m, double begin, const ValueRange& quiet,
                                  DataTime at) const noexcept {
  double end = 1.0;
  for (; octave < shape_.count - 1; ++octave) {
    const detail::GridBase* grid = in_force(octave, at).grid.get();
    if (!grid) continue;
    const auto [enters, leaves] = grid->passage(from_m, to_m);
    if (!(leaves > begin)) continue;
    end = std::min(end, enters > begin ? enters : leaves);
    if (enters <= begin) break;
  }
  PolynomialPiece piece = in_force(octave, at).grid->piece_along(from_m, to_m, begin, quiet);
  if (piece.end > end) {
    if (piece.degree > 0) detail::keep_first(piece, (end - begin) / (piece.end - begin));
    piece.end = end;
  }
  return piece;
}

PolynomialPiece Octaves::piece_along_at(const Vec3& from_m, const Vec3& to_m, double begin, const ValueRange& quiet,
                                        DataTime at) const noexcept {
  if (!is_felt(at)) return {};
  const Between t = between(at);
  if (t.u == 0.0) return piece_of(t.a, from_m, to_m, begin, quiet, at);
  return detail::blended_piece(begin, t.u, quiet, [&](bool second, const ValueRange& within) {
    return piece_of(t.a + (second ? 1 : 0), from_m, to_m, begin, within, at);
  });
}

Carried Octaves::carried(const Vec3& world_m, DataTime from, DataTime to) const noexcept {
  if (components() != 1 || from.octave == to.octave || !is_felt(to)) return {world_m};
  return carried_with_level(world_m, from, to, in_force(between(to).a, to).noise);
}

Stock::Stock(std::span<const FieldPtr> fields) {
  const auto add = [&](const Field& field, const MovingView* moved) {
    const auto* octaves = static_cast<const Octaves*>(&field);
    by_field_.emplace_back(octaves, stores_.size());
    stores_.push_back({octaves, moved, std::vector<Slot>(static_cast<std::size_t>(octaves->count() - 1))});
    count_ = std::max(count_, octaves->count());
  };
  for (const FieldPtr& field : fields) {
    const MovingView* moved = moving_of(*field);
    const Field& still = moved ? *moved->field : *field;
    const SeriesView* series = series_of(still);
    const auto* first = dynamic_cast<const Octaves*>(series ? series->frames.front().get() : &still);
    if (!first || std::ranges::find(stores_, first, &Store::of) != stores_.end()) continue;
    fields_.push_back({stores_.size(), series});
    if (!series) add(still, moved);
    for (std::size_t frame = 0; series && frame < series->frames.size(); ++frame) add(*series->frames[frame], moved);
  }
  std::ranges::sort(by_field_);
}

const Stock::Store* Stock::store_of(const Octaves& of) const noexcept {
  const auto found = std::ranges::lower_bound(by_field_, &of, {}, &std::pair<const Octaves*, std::size_t>::first);
  return found != by_field_.end() && found->first == &of ? &stores_[found->second] : nullptr;
}

void Stock::keep_frames(DataTime from, DataTime to) noexcept {
  for (Store& store : stores_) store.is_kept = false;
  for_each_sampled(from, to, [&](std::size_t n) { stores_[n].is_kept = true; });
  for (Store& store : stores_) {
    if (store.is_kept || !std::exchange(store.has_windows, false)) continue;
    std::ranges::fill(store.slots, Slot{});
  }
}

void Stock::lay(std::size_t n, int octave, const OctaveWindow& window) noexcept {
  if (n >= stores_.size() || octave < 0 || static_cast<std::size_t>(octave) >= stores_[n].slots.size() || !window.grid) return;
  Slot& slot = stores_[n].slots[static_cast<std::size_t>(octave)];
  const int other = slot.windows[slot.in_force].grid ? 1 - slot.in_force : slot.in_force;
  slot.windows[other] = window;
  stores_[n].has_windows = true;
}

void Stock::lay(const Octaves& of, int octave, const OctaveWindow& window) noexcept {
  for (std::size_t n = 0; n < stores_.size(); ++n)
    if (stores_[n].of == &of) lay(n, octave, window);
}

void Stock::clear() noexcept {
  for (Store& store : stores_) std::ranges::fill(store.slots, Slot{});
}

void Stock::put_in_force(std::span<const Vec3> world_m, std::span<const Vec3> ahead_m, DataTime pose_time) noexcept {
  for (Store& store : stores_) {
    if (!store.has_windows) continue;
    const Similarity pose = store.pose(pose_time);
    for (Slot& slot : store.slots) {
      const auto room = [&](int n, std::span<const Vec3> positions_m) {
        double least = slot.windows[n].grid ? unbounded : -unbounded;
        for (const Vec3& at_m : positions_m)
          if (slot.windows[n].grid) least = std::min(least, slot.windows[n].grid->room_voxels(pose.to_hand(at_m)));
        return least;
      };
      const int other = 1 - slot.in_force;
      const double rooms[2] = {std::min(room(0, world_m), room(0, ahead_m)), std::min(room(1, world_m), room(1, ahead_m))};
      const bool is_better = std::max(rooms[0], rooms[1]) >= 0.0 ? rooms[other] > rooms[slot.in_force]
                                                                 : room(other, world_m) > room(slot.in_force, world_m);
      if (is_better) slot.in_force = other;
    }
  }
}

void Stock::take_windows_of(const Stock& other) noexcept {
  if (complete_) return;
  for (Store& store : stores_) {
    const Store* from = other.store_of(*store.of);
    if (!from) continue;
    std::ranges::copy(from->slots, store.slots.begin());
    store.has_windows = from->has_windows;
  }
}

double Stock::room_of_m(std::size_t n, int octave, std::span<const Vec3> world_m, DataTime pose_time,
                        double less_voxels) const noexcept {
  const Store& store = stores_[n];
  if (octave >= store.of->count() - 1) return unbounded;
  const Similarity pose = store.pose(pose_time);
  const Slot& slot = store.slots[static_cast<std::size_t>(octave)];
  const detail::GridBase* grid = slot.windows[slot.in_force].grid.get();
  double room_m = grid ? unbounded : -unbounded;
  for (const Vec3& at_m : world_m) {
    if (grid) room_m = std::min(room_m, pose.scale * grid->spacing_m() * (grid->room_voxels(pose.to_hand(at_m)) - less_voxels));
  }
  return room_m;
}

double Stock::share_within(std::size_t n, int octave, std::span<const Vec3> from_m, std::span<const Vec3> to_m,
                           DataTime pose_time, double less_voxels) const noexcept {
  const Store& store = stores_[n];
  if (octave >= store.of->count() - 1) return 1.0;
  const Similarity pose = store.pose(pose_time);
  const Slot& slot = store.slots[static_cast<std::size_t>(octave)];
  const detail::GridBase* grid = slot.windows[slot.in_force].grid.get();
  if (!grid) return -1.0;
  double share = 1.0;
  for (std::size_t i = 0; i < from_m.size(); ++i) {
    const Vec3 from = pose.to_hand(from_m[i]), to = pose.to_hand(to_m[i]);
    const double way = distance(from, to), leaves = grid->passage(from, to)[1];
    if (leaves < 1.0) share = std::min(share, leaves - less_voxels * grid->spacing_m() / std::max(way, 1e-300));
  }
  return share;
}

double Stock::room_m(int octave, std::span<const Vec3> world_m, DataTime pose_time, double less_voxels) const noexcept {
  double room_m = unbounded;
  for_each_sampled(pose_time,
                   [&](std::size_t n) { room_m = std::min(room_m, room_of_m(n, octave, world_m, pose_time, less_voxels)); });
  return room_m;
}

std::optional<std::array<Vec3, 8>> Stock::corners_m(std::size_t n, int octave, DataTime pose_time) const noexcept {
  const Store& store = stores_[n];
  if (octave < 0 || octave >= store.of->count() - 1) return std::nullopt;
  const Slot& slot = store.slots[static_cast<std::size_t>(octave)];
  const detail::GridBase* grid = slot.windows[slot.in_force].grid.get();
  if (!grid) return std::nullopt;
  const detail::GridBase::Extent& extent = grid->extent();
  const Similarity pose = store.pose(pose_time);
  std::array<Vec3, 8> corners_m;
  for (std::size_t corner = 0; corner < 8; ++corner) {
    const auto end = [&](std::size_t a) { return corner >> a & 1 ? extent.high[a] : extent.low[a]; };
    corners_m[corner] = pose.to_world(grid->view().geometry.to_world({end(0), end(1), end(2)}));
  }
  return corners_m;
}

double Stock::stays_s(int octave, std::span<const Vec3> world_m, const Vec3& velocity_m_per_s, DataTime pose_time,
                      double less_voxels) const noexcept {
  double time_s = unbounded;
  for_each_needed_live(pose_time, [&](std::size_t n, double wait_s) {
    const Store& store = stores_[n];
    if (octave >= store.of->count() - 1) return;
    if (wait_s > 0.0) {  // a frame that is sampled next
      if (room_of_m(n, octave, world_m, pose_time, less_voxels) < 0.0) time_s = std::min(time_s, wait_s);
      return;
    }
    const Similarity pose = store.pose(pose_time);
    const Slot& slot = store.slots[static_cast<std::size_t>(octave)];
    const detail::GridBase* grid = slot.windows[slot.in_force].grid.get();
    if (!grid) time_s = 0.0;
    const Vec3 velocity = pose.direction_to_hand(velocity_m_per_s) / pose.scale;
    for (const Vec3& at_m : world_m)
      if (grid) time_s = std::min(time_s, grid->stays_s(pose.to_hand(at_m), velocity, less_voxels));
  });
  return time_s;
}

}  // namespace palpa
