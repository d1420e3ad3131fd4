// Volumes larger than memory: octaves of a grid, felt through windows about the proxy.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "palpa/data/grid_base.h"
#include "palpa/data/grid_window.h"
#include "palpa/data/timed_field.h"

namespace palpa {

/// Checksum of a chunk of voxels, the unit in which a source reads.
struct ChunkSum {
  int octave = 0;
  std::array<std::int64_t, 3> at{};  ///< [chunks] along i, j, k
  std::uint32_t crc32 = 0;           ///< of the voxels within the octave
  friend bool operator==(const ChunkSum&, const ChunkSum&) = default;
};

/// Window of an octave, ready to be felt. Immutable.
struct OctaveWindow {
  std::shared_ptr<const detail::GridBase> grid;
  double noise = 0.0;  ///< [unit/m] of its gradient, below which its direction is not used
};

/// Voxels of all octaves, wherever they are kept.
class VoxelSource {
 public:
  virtual ~VoxelSource() = default;
  /// Copies a box of voxels of an octave, without border voxels. May block; one thread at a time.
  /// \param first  [voxels] along i, j, k
  /// \param dims   [voxels] along i, j, k
  /// \param to     i fastest, components of a voxel together
  /// Returns false if some of them are lost or damaged.
  virtual bool read(int octave, const std::array<std::int64_t, 3>& first, const std::array<std::int64_t, 3>& dims,
                    std::byte* to) = 0;
  /// Checksums of the chunks read, in the order of their first reads, from number `from` [1] on. Allocates; any thread.
  virtual std::vector<ChunkSum> sums_from(std::size_t from) const { return static_cast<void>(from), std::vector<ChunkSum>{}; }
  /// From now on `read` throws LoadError, with the chunk's name, on a chunk with another checksum than this. Any thread.
  virtual void expect(const std::vector<ChunkSum>& sums) { static_cast<void>(sums); }
  /// Sentences about chunks that are lost, damaged or changed, each chunk once and the first 16 alone, from number `from` [1]
  /// on. Allocates; any thread.
  virtual std::vector<std::string> problems_from(std::size_t from) const {
    return static_cast<void>(from), std::vector<std::string>{};
  }
  /// Another source of these voxels, for pictures: reads of either delay none of the other; nullptr if there is
  /// none. Blocks, allocates; throws LoadError if the voxels cannot be opened any more. Any thread.
  virtual std::shared_ptr<VoxelSource> beside() const { return nullptr; }
};

/// Grid in octaves, larger than memory. Octave 0 are the voxels of the file; a voxel of octave n is the mean of the 2 × 2 × 2
/// of octave n − 1 that exist. The coarsest octave is in memory as a whole, of every other octave a window for each session
/// (`Stock`).
///
/// A timed field: at a moment with the felt octave λ (`DataTime::octave`) its value is the blend (1 − u) φ_a + u φ_{a+1}, a =
/// ⌊λ⌋, u = λ − a, as between two frames of a series, so that a change of λ is data that move. At λ = 0 every sample is that of
/// the whole grid, to the bit. Where a window ends the next coarser octave with data continues. Without a stock, as for
/// pictures, the coarsest octave alone. Outside of the box of octave 0 there are no data in any octave.
///
/// Octaves wider than `Shape::coarsest_m` are no data: from one octave finer on, depths fall to zero as λ comes to the first of
/// them, so that strengths fade as at an edge.
class Octaves final : public TimedField {
 public:
  static constexpr int most = 24;  ///< [1] octaves

  /// Properties of all octaves.
  struct Shape {
    GridGeometry finest;  ///< of octave 0; not rectilinear
    int count = 1;        ///< [1] octaves, up to `most`
    VoxelType type = VoxelType::float32;
    int components = 1;
    Filter filter = Filter::trilinear;  ///< not cubic
    double scale = 1.0;                 ///< the field's own unit, per raw step
    double offset = 0.0;                ///< the field's own unit
    std::vector<ValueRange> ranges{};   ///< of each component, in all of octave 0
    std::shared_ptr<VoxelSource> source{};
    double coarsest_m = std::numeric_limits<double>::infinity();  ///< [m] voxels wider along any axis are no data
    /// Windows made last, up to 256 MB: shared by all fields made from copies of `Octaves::shape`, as the frames of a series.
    std::shared_ptr<class KeptWindows> kept{};
  };
  /// Reads the coarsest octave. Throws std::invalid_argument, with a sentence, on an invalid shape or if it cannot be read.
  explicit Octaves(Shape shape);

  const Shape& shape() const noexcept { return shape_; }
  int count() const noexcept { return shape_.count; }
  /// [voxels] of an octave along i, j, k, without border voxels: half of the finer one's, rounded up.
  std::array<std::int64_t, 3> dims(int octave) const noexcept;
  /// Grid of an octave as it is sampled: octaves from 1 on have a border of one voxel, which repeats the outermost, since
  /// their first voxel's centre is within the box of octave 0, where samples continue.
  const GridGeometry& sampled_grid(int octave) const noexcept { return grids_[static_cast<std::size_t>(octave)]; }
  /// Position [steps] in `sampled_grid` of a place [m].
  Vec3 steps_of(int octave, const Vec3& world_m) const noexcept;
  /// Width [m] of octave 0's voxels along the axis on which they are widest.
  static double voxel_width_m(const GridGeometry& finest) noexcept;
  /// [voxels] Border on each side.
  static std::int64_t border(int octave) noexcept { return octave > 0 ? 1 : 0; }
  /// Window of an octave, read from the source; without a grid if voxels are lost or damaged. Blocks; about 1.5 ms for 128³
  /// beside reading. Allocates; throws std::invalid_argument as `window_field`.
  /// \param first   [voxels] of `sampled_grid`, multiples of 8
  /// \param dims    [voxels] along i, j, k
  /// The windows made last are kept, for sessions that feel near each other. Any thread; one makes a window at a time.
  OctaveWindow window(int octave, const std::array<std::int64_t, 3>& first, const std::array<std::int64_t, 3>& dims) const;
  /// Likewise from another source of the same voxels, and not kept. Any thread, if no other reads from the source.
  OctaveWindow window_from(VoxelSource& source, int octave, const std::array<std::int64_t, 3>& first,
                           const std::array<std::int64_t, 3>& dims) const;
  /// The coarsest octave.
  const OctaveWindow& coarsest() const noexcept { return coarsest_; }
  /// Noise of the gradient [unit/m] of octave 0 at `places` [1] places, as `detail::noise_of_gradient`. Reads the voxels there:
  /// blocks. Allocates.
  double noise_of_finest(int places, const std::function<Vec3(int)>& place) const;
  /// Noise of the gradient [unit/m] at the octave that is felt at a moment.
  double noise_at(DataTime at) const noexcept { return in_force(between(at).a, at).noise; }
  /// Whether voxels are no wider than `Shape::coarsest_m` at a moment.
  bool is_felt(DataTime at) const noexcept { return fade_m(at) > 0.0; }

  int components() const noexcept override { return shape_.components; }
  /// Of one octave; a blend takes twice as many (`values_per_sample_at`).
  int values_per_sample() const noexcept override { return coarsest_.grid->values_per_sample(); }
  int values_per_sample_at(DataTime at) const noexcept override { return (between(at).u == 0.0 ? 1 : 2) * values_per_sample(); }
  double spacing_m() const noexcept override { return spacing_m_; }
  Box bounds_m() const noexcept override { return bounds_m_; }
  std::vector<ValueRange> value_ranges() const override { return shape_.ranges; }
  double cycle_s() const noexcept override { return 1.0; }
  double time_spacing_s() const noexcept override { return 1.0; }

  ScalarSample scalar_at(const Vec3& world_m, DataTime at) const noexcept override;
  VectorSample vector_at(const Vec3& world_m, DataTime at) const noexcept override;
  Mat3 hessian_at(const Vec3& world_m, DataTime at) const noexcept override;
  /// From the share `begin` [1] on.
  PolynomialPiece piece_along_at(const Vec3& from_m, const Vec3& to_m, double begin, const ValueRange& quiet,
                                 DataTime at) const noexcept override;
  LipschitzBound lipschitz_bound_at(const Vec3& world_m, DataTime at) const noexcept override;
  double depth_at(const Vec3& world_m, DataTime at) const noexcept override;          ///< [m]
  double local_spacing_at(const Vec3& world_m, DataTime at) const noexcept override;  ///< [m]
  Carried carried(const Vec3& world_m, DataTime from, DataTime to) const noexcept override;

 private:
  struct Between {
    int a = 0;
    double u = 0.0;  ///< [1] share of octave a + 1; 0: a alone
  };
  Between between(DataTime at) const noexcept;
  double fade_m(DataTime at) const noexcept;
  const OctaveWindow& in_force(int octave, DataTime at) const noexcept;
  std::shared_ptr<const detail::GridBase> grid_of(VoxelSource& source, int octave, const std::array<std::int64_t, 3>& first,
                                                  const std::array<std::int64_t, 3>& dims) const;
  Voxels voxels_of(VoxelSource& source, int octave, const std::array<std::int64_t, 3>& first,
                   const std::array<std::int64_t, 3>& dims) const;
  PolynomialPiece piece_of(int octave, const Vec3& from_m, const Vec3& to_m, double begin, const ValueRange& quiet,
                           DataTime at) const noexcept;
  template <class Sample>
  auto sampled_in(int octave, const Vec3& world_m, DataTime at, Sample&& sample) const noexcept;

  Shape shape_;
  std::vector<GridGeometry> grids_;
  int first_unfelt_ = 0;  ///< octave from which on voxels are too wide; `count` if none are
  double spacing_m_ = 0.0;
  double largest_ = 0.0;  ///< the field's own unit: of all values
  Box bounds_m_;
  OctaveWindow coarsest_;
  std::int64_t number_ = 0;  ///< of this field among all
};

/// Windows of one session: of each octave of each field that is larger than memory two, one of them in force. Each frame of a
/// series is a field of its own, which has windows about the moments at which it is sampled. `lay` and `put_in_force` are
/// called between samples, by the thread that samples; they allocate nothing, and free nothing while the maker of the windows
/// keeps them.
class Stock {
 public:
  /// Fields in octaves among these, also under a pose, and frames. Allocates.
  explicit Stock(std::span<const FieldPtr> fields);

  bool empty() const noexcept { return stores_.empty(); }
  /// [1] Fields in octaves, and frames.
  std::size_t size() const noexcept { return stores_.size(); }
  const Octaves& octaves(std::size_t n) const noexcept { return *stores_[n].of; }
  /// Octaves of the field with the most.
  int count() const noexcept { return count_; }

  /// Windows are laid before each tick for all of its way, as in runs without a hand in real time; the finest octave is felt.
  void set_complete(bool complete) noexcept { complete_ = complete; }
  bool is_complete() const noexcept { return complete_; }

  /// Finest octave that may be felt, 0 by default: a source that is slower than the hand holds the felt octave steady there.
  void set_finest(int octave) noexcept { finest_ = octave; }
  int finest() const noexcept { return finest_; }

  /// Rate at which series play. \param speed  [1] seconds of data per second, ≥ 0; 1 by default
  void set_data_speed(double speed) noexcept { data_speed_ = speed; }
  /// Calls `visit(n)` for each field n that is sampled at a moment: of a series one frame or two.
  template <class Visit>
  void for_each_sampled(DataTime at, Visit&& visit) const noexcept {
    for_each_until(at, 0.0, [&](std::size_t n, double wait_s) {
      if (wait_s == 0.0) visit(n);
    });
  }
  /// Calls `visit(n, wait_s)` for each field n that a live hand needs windows of at a moment: it is sampled then, or in
  /// `frames_ahead_s`, after `wait_s` [s].
  template <class Visit>
  void for_each_needed_live(DataTime at, Visit&& visit) const noexcept {
    for_each_until(at, frames_ahead_s * data_speed_, [&](std::size_t n, double wait_s) {
      if (wait_s == 0.0 || data_speed_ > 0.0) visit(n, wait_s == 0.0 ? 0.0 : wait_s / data_speed_);
    });
  }
  /// Calls `visit(n)` for each field n that is sampled at any moment from one to another.
  template <class Visit>
  void for_each_sampled(DataTime from, DataTime to, Visit&& visit) const noexcept {
    const double time_s = to.time_s - from.time_s;
    for_each_until(from, time_s, [&](std::size_t n, double wait_s) {
      if (wait_s == 0.0 || time_s > 0.0) visit(n);
    });
  }
  /// Drops the windows of frames that are not sampled from one moment to another. Frees memory unless their maker keeps them.
  void keep_frames(DataTime from, DataTime to) noexcept;

  /// Takes another session's windows for the fields that both have; complete windows stay.
  void take_windows_of(const Stock& other) noexcept;
  /// Replaces the window of an octave that is not in force. A window that has no grid is ignored.
  void lay(std::size_t n, int octave, const OctaveWindow& window) noexcept;
  /// Likewise for a field; ignored if it is not among these.
  void lay(const Octaves& of, int octave, const OctaveWindow& window) noexcept;
  /// Drops all windows. Frees memory.
  void clear() noexcept;
  /// Puts the window with the most room about the positions in force, in each octave: about `ahead_m` [m, world] as well, if a
  /// window has room for these. The data are posed as at `pose_time`.
  void put_in_force(std::span<const Vec3> world_m, std::span<const Vec3> ahead_m, DataTime pose_time) noexcept;

  /// Least way [m] of any position to a face of the windows in force of an octave, of fields that are sampled then, less
  /// `less_voxels` [1]; infinite where windows reach to the borders of their grids, negative without a window.
  double room_m(int octave, std::span<const Vec3> world_m, DataTime pose_time, double less_voxels) const noexcept;
  /// Likewise of one field, less `less_voxels` [1].
  double room_of_m(std::size_t n, int octave, std::span<const Vec3> world_m, DataTime pose_time,
                   double less_voxels) const noexcept;
  /// Share [1] of the straight ways of all positions that is within the window in force of an octave of a field, less
  /// `less_voxels` [1] at its end: 1 where all end in it, negative where one begins outside.
  double share_within(std::size_t n, int octave, std::span<const Vec3> from_m, std::span<const Vec3> to_m, DataTime pose_time,
                      double less_voxels) const noexcept;
  /// Pose of a field.
  Similarity pose(std::size_t n, DataTime pose_time) const noexcept { return stores_[n].pose(pose_time); }
  /// Corners [m, world] of the window in force of an octave of field n, bit a of the number: the high end of axis a; none for
  /// the coarsest octave, and without a window.
  std::optional<std::array<Vec3, 8>> corners_m(std::size_t n, int octave, DataTime pose_time) const noexcept;
  /// Least time [s] after which any position, moving at this velocity [m/s], leaves the windows of an octave, less
  /// `less_voxels` [1], or a frame without a window is sampled.
  double stays_s(int octave, std::span<const Vec3> world_m, const Vec3& velocity_m_per_s, DataTime pose_time,
                 double less_voxels) const noexcept;

  /// [voxels] Beside a position, of a sample and its derivatives.
  static constexpr double sample_voxels = 2.0;
  /// [voxels] Beside a position, in a tick of 32 sub-steps of half a voxel.
  static constexpr double margin_voxels = sample_voxels + 16.0;
  /// [s] More: windows of more frames; less: a frame is sampled before its windows have come.
  static constexpr double frames_ahead_s = 0.1;

 private:
  friend class Octaves;
  struct Slot {
    OctaveWindow windows[2];
    int in_force = 0;
  };
  struct Store {
    const Octaves* of = nullptr;
    const MovingView* moved = nullptr;  ///< nullptr: the field is in the world's frame
    std::vector<Slot> slots{};          ///< of all octaves but the coarsest
    bool is_kept = true;                ///< by `keep_frames`
    bool has_windows = false;

    Similarity pose(DataTime at) const noexcept { return moved ? pose_at(moved->track, at) : Similarity{}; }
  };
  /// Field of a session: its store, or those of its frames.
  struct Frames {
    std::size_t first = 0;
    const SeriesView* series = nullptr;  ///< nullptr: one store
  };
  /// Calls `visit(n, wait_s)` for each store that is sampled at a moment or within `until_s` [s] of data, with the time to
  /// then, which is 0 for those at the moment alone.
  template <class Visit>
  void for_each_until(DataTime at, double until_s, Visit&& visit) const noexcept {
    for (const Frames& field : fields_) {
      if (!field.series) {
        visit(field.first, 0.0);
        continue;
      }
      const bool is_blended = field.series->between_frames == BetweenFrames::linear;
      const std::size_t count = field.series->frames.size();
      const double position = frame_at(*field.series, at);  // [frames]
      const double nearest = is_blended ? std::floor(position) : std::round(position);
      for (std::size_t ahead = 0; ahead < count; ++ahead) {
        const std::size_t frame = static_cast<std::size_t>(nearest) + ahead;
        if (frame >= count && !at.loop) break;
        // A blend begins at the frame before; at a frame itself that alone is sampled.
        const double begins = nearest + static_cast<double>(ahead) - (is_blended ? 1.0 : 0.5), left = begins - position;
        const bool is_sampled = ahead == 0 || (is_blended && left < 0.0);
        if (!is_sampled && !(left * field.series->period_s <= until_s)) break;
        visit(field.first + frame % count, is_sampled ? 0.0 : std::max(left * field.series->period_s, least_wait_s));
      }
    }
  }
  static constexpr double least_wait_s = 1e-9;  ///< [s] of what is not sampled yet
  const Store* store_of(const Octaves& of) const noexcept;

  std::vector<Store> stores_;
  std::vector<Frames> fields_;
  std::vector<std::pair<const Octaves*, std::size_t>> by_field_;  ///< numbers of stores, in the order of addresses
  double data_speed_ = 1.0;
  int count_ = 0;
  int finest_ = 0;
  bool complete_ = false;
};

}  // namespace palpa
