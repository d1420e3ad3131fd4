#include "palpa/data/octaves.h"

#include <algorithm>
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

}  // namespace

/// Windows made last.
class Octaves::Kept {
 public:
  static constexpr std::int64_t most_bytes = 256'000'000;  // of voxels. More: memory; less: windows are made again
  struct Entry {
    int octave;
    std::array<std::int64_t, 3> first, dims;
    OctaveWindow window;
  };
  std::mutex busy;
  std::vector<Entry> entries;  // the last used is the last
  std::int64_t bytes = 0;
};

Octaves::Octaves(Shape shape) : shape_(std::move(shape)), kept_(std::make_shared<Kept>()) {
  if (const char* problem = problem_with(shape_.finest)) throw std::invalid_argument(problem);
  if (shape_.count < 1 || shape_.count > most) throw std::invalid_argument("a grid in octaves has 1 to 24 of them");
  if (!shape_.source) throw std::invalid_argument("a grid in octaves has a source of voxels");
  if (shape_.ranges.size() != static_cast<std::size_t>(shape_.components))
    throw std::invalid_argument("a grid in octaves has a range for each of its components");
  for (int octave = 0; octave < shape_.count; ++octave) grids_.push_back(sampled_grid_of(shape_.finest, dims(octave), octave));
  const int last = shape_.count - 1;
  coarsest_ = made_window(last, {}, grids_.back().dims);
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

std::array<std::int64_t, 3> Octaves::dims(int octave) const noexcept {
  std::array<std::int64_t, 3> dims = shape_.finest.dims;
  for (std::int64_t& n : dims) n = std::max<std::int64_t>((n + (std::int64_t{1} << octave) - 1) >> octave, 1);
  return dims;
}

/// Voxels of a box of the octave as it is sampled; none if some are lost. Border voxels repeat the outermost.
Voxels Octaves::voxels_of(int octave, const std::array<std::int64_t, 3>& first, const std::array<std::int64_t, 3>& dims) const {
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
  if (!shape_.source->read(octave, low, size, inner.get())) return {};
  if (!has_border) return {shape_.type, shape_.components, inner};
  const std::shared_ptr<std::byte[]> out = room(dims);
  std::byte* to = out.get();
  const auto inside = [&](std::size_t a, std::int64_t n) {
    return std::clamp<std::int64_t>(first[a] - border(octave) + n - low[a], 0, size[a] - 1);
  };
  for (std::int64_t k = 0; k < dims[2]; ++k) {
    for (std::int64_t j = 0; j < dims[1]; ++j) {
      const std::int64_t row = size[0] * (inside(1, j) + size[1] * inside(2, k));
      for (std::int64_t i = 0; i < dims[0]; ++i, to += voxel)
        std::memcpy(to, inner.get() + static_cast<std::size_t>(row + inside(0, i)) * voxel, voxel);
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
  const std::lock_guard lock(kept_->busy);
  std::vector<Kept::Entry>& all = kept_->entries;
  const auto known = std::ranges::find_if(
      all, [&](const Kept::Entry& entry) { return entry.octave == octave && entry.first == first && entry.dims == dims; });
  if (known != all.end()) {
    std::rotate(known, known + 1, all.end());
    return all.back().window;
  }
  const auto bytes_of = [&](const std::array<std::int64_t, 3>& n) {
    return n[0] * n[1] * n[2] * static_cast<std::int64_t>(size_of(shape_.type)) * shape_.components;
  };
  Kept::Entry made{octave, first, dims, made_window(octave, first, dims)};
  while (!all.empty() && kept_->bytes + bytes_of(dims) > Kept::most_bytes) {
    kept_->bytes -= bytes_of(all.front().dims);
    all.erase(all.begin());
  }
  all.push_back(std::move(made));
  kept_->bytes += bytes_of(dims);
  return all.back().window;
}

OctaveWindow Octaves::made_window(int octave, const std::array<std::int64_t, 3>& first,
                                  const std::array<std::int64_t, 3>& dims) const {
  Voxels voxels = voxels_of(octave, first, dims);
  if (!voxels.data) return {};
  const GridGeometry& whole = sampled_grid(octave);
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
  const FieldPtr field = window_field(whole, window, std::move(voxels), shape_.filter, shape_.scale, shape_.offset);
  OctaveWindow made{std::dynamic_pointer_cast<const detail::GridBase>(field)};
  if (shape_.components == 1) {
    constexpr int places = 1024;  // [1] more: slower windows; fewer: a less certain median
    made.noise = detail::noise_of_gradient(*field, places, [&](int n) {
      const auto along = [&](std::size_t a, double share) {
        return static_cast<double>(first[a]) + share * static_cast<double>(dims[a] - 1);
      };
      return whole.to_world({along(0, detail::radical_inverse<2>(n)), along(1, detail::radical_inverse<3>(n)),
                             along(2, detail::radical_inverse<5>(n))});
    });
  }
  return made;
}

Octaves::Between Octaves::between(DataTime at) const noexcept {
  const int last = shape_.count - 1;
  if (!at.stock) return {last, 0.0};
  const double octave = std::clamp(std::isfinite(at.octave) ? at.octave : 0.0, 0.0, static_cast<double>(last));
  const double whole = std::floor(octave);
  return {static_cast<int>(whole), octave - whole};
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
  const auto sample = [](const detail::GridBase& grid, detail::GridBase::Place& place) { return grid.scalar_in(place); };
  const Between t = between(at);
  const ScalarSample a = sampled_in(t.a, world_m, at, sample);
  return t.u == 0.0 ? a : detail::blend(a, sampled_in(t.a + 1, world_m, at, sample), t.u);
}

VectorSample Octaves::vector_at(const Vec3& world_m, DataTime at) const noexcept {
  const auto sample = [](const detail::GridBase& grid, detail::GridBase::Place& place) { return grid.vector_in(place); };
  const Between t = between(at);
  const VectorSample a = sampled_in(t.a, world_m, at, sample);
  return t.u == 0.0 ? a : detail::blend(a, sampled_in(t.a + 1, world_m, at, sample), t.u);
}

Mat3 Octaves::hessian_at(const Vec3& world_m, DataTime at) const noexcept {
  const auto sample = [&](const detail::GridBase& grid, detail::GridBase::Place&) { return grid.hessian(world_m); };
  const Between t = between(at);
  const Mat3 a = sampled_in(t.a, world_m, at, sample);
  if (t.u == 0.0) return a;
  if (!scalar_at(world_m, at).inside) return {};
  return detail::blend(a, sampled_in(t.a + 1, world_m, at, sample), t.u);
}

LipschitzBound Octaves::lipschitz_bound_at(const Vec3& world_m, DataTime at) const noexcept {
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
// reaches, and the largest counts. Without holes in the coarsest octave there are none.
double Octaves::depth_at(const Vec3& world_m, DataTime at) const noexcept {
  const int finest = between(at).a;
  const detail::GridBase* first = in_force(finest, at).grid.get();
  const double of_box_m = (first ? first : coarsest_.grid.get())->box_depth_m(world_m);
  if (!coarsest_.grid->has_holes()) return of_box_m;
  double depth_m = coarsest_.grid->depth_m(world_m);
  for (int octave = finest; octave < shape_.count - 1; ++octave) {
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
  const Between t = between(at);
  if (t.u == 0.0) return piece_of(t.a, from_m, to_m, begin, quiet, at);
  return detail::blended_piece(begin, t.u, quiet, [&](bool second, const ValueRange& within) {
    return piece_of(t.a + (second ? 1 : 0), from_m, to_m, begin, within, at);
  });
}

Carried Octaves::carried(const Vec3& world_m, DataTime from, DataTime to) const noexcept {
  if (components() != 1 || from.octave == to.octave) return {world_m};
  return carried_with_level(world_m, from, to, in_force(between(to).a, to).noise);
}

Stock::Stock(std::span<const FieldPtr> fields) {
  for (const FieldPtr& field : fields) {
    const MovingView* moved = moving_of(*field);
    const auto* octaves = dynamic_cast<const Octaves*>(moved ? moved->field.get() : field.get());
    if (!octaves || store_of(*octaves)) continue;
    stores_.push_back({octaves, moved, std::vector<Slot>(static_cast<std::size_t>(octaves->count() - 1))});
    count_ = std::max(count_, octaves->count());
  }
}

void Stock::lay(std::size_t n, int octave, const OctaveWindow& window) noexcept {
  if (n >= stores_.size() || octave < 0 || static_cast<std::size_t>(octave) >= stores_[n].slots.size() || !window.grid) return;
  Slot& slot = stores_[n].slots[static_cast<std::size_t>(octave)];
  const int other = slot.windows[slot.in_force].grid ? 1 - slot.in_force : slot.in_force;
  slot.windows[other] = window;
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
    if (from) std::ranges::copy(from->slots, store.slots.begin());
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
  for (std::size_t n = 0; n < stores_.size(); ++n)
    room_m = std::min(room_m, room_of_m(n, octave, world_m, pose_time, less_voxels));
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
  for (const Store& store : stores_) {
    if (octave >= store.of->count() - 1) continue;
    const Similarity pose = store.pose(pose_time);
    const Slot& slot = store.slots[static_cast<std::size_t>(octave)];
    const detail::GridBase* grid = slot.windows[slot.in_force].grid.get();
    if (!grid) return 0.0;
    const Vec3 velocity = pose.direction_to_hand(velocity_m_per_s) / pose.scale;
    for (const Vec3& at_m : world_m) time_s = std::min(time_s, grid->stays_s(pose.to_hand(at_m), velocity, less_voxels));
  }
  return time_s;
}

}  // namespace palpa
