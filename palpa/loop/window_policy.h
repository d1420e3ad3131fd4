// Choice of the windows that a live hand needs of volumes larger than memory.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <set>
#include <tuple>
#include <vector>

#include "palpa/data/field.h"
#include "palpa/data/octaves.h"
#include "palpa/session/session.h"

namespace palpa {

/// Place and motion of a tool's feet in the data. Trivially copyable.
struct FeetMotion {
  Box feet_m;               ///< [m, world] box of the feet
  Vec3 velocity_m_per_s;    ///< [world] of the proxy
  double hand_scale = 0.0;  ///< [1] metres in the world of a metre of the hand, > 0; else no windows are needed
  DataTime time;            ///< at which the data are posed; its stock is unused
};

/// Motion for the next tick of a session. \param need  of that tick  \param hand_scale  [1] as above
FeetMotion motion_of(const WindowNeed& need, double hand_scale) noexcept;

/// Whether a window is within its grid and no larger than a loader makes them. Any thread.
bool can_be_felt_live(const WindowPlace& place) noexcept;

/// Policy of the loader: of each octave a window about the place of the feet 30 ms ahead, coarse before fine, of a series those
/// of the frames that are sampled now or soon (`Stock::frames_ahead_s`), made again as that place has moved by three quarters
/// of a chunk of 32 voxels; no octave finer than half the way of 1 ms, or than 10 µm of the hand. The need is thus bounded by
/// the tick, not by the speed of the hand (docs/large.md). Has no clock: loader and studies in virtual time share it. One
/// thread.
class WindowPolicy {
 public:
  /// Copies the stock's fields, not its windows. \param stock  of a session; its fields must outlive this
  explicit WindowPolicy(const Stock& stock);

  /// Window to be made next; none if all that are needed were made. Allocates nothing.
  std::optional<WindowPlace> next(const FeetMotion& motion) noexcept;
  /// The window was made and is, or will be, laid.
  void made(const WindowPlace& place) noexcept;
  /// The window cannot be made, as voxels are lost: it is not wanted again. Allocates.
  void lost(const WindowPlace& place) { lost_.insert(key_of(place)); }
  /// Drops all that was made, for a session without windows.
  void forget() noexcept;
  /// Takes what another policy has made for the fields that both have.
  void take_over(const WindowPolicy& other) noexcept;

  /// [voxels] Least size of a window along an axis. More: slower windows; less: a fast hand leaves them at once.
  static constexpr std::int64_t size_voxels = 128;
  /// [bytes] Most of a window. More: a long tool on a fine grid, or a hand that jumps as by a bad sample, takes memory; less:
  /// they feel a coarser octave.
  static constexpr double most_bytes = 256e6;
  /// [voxels] Windows begin at multiples of it. More: rougher steps; less: windows share fewer chunks.
  static constexpr std::int64_t step_voxels = 32;

 private:
  using Key = std::tuple<const Octaves*, int, std::array<std::int64_t, 3>, std::array<std::int64_t, 3>>;
  static Key key_of(const WindowPlace& place) noexcept { return {place.of, place.octave, place.first, place.dims}; }
  struct Wish {
    WindowPlace place;
    std::array<double, 3> first{};  ///< [voxels] without the rounding
  };
  std::optional<Wish> wish(std::size_t field, int octave, const FeetMotion& motion) const noexcept;
  static bool serves(const WindowPlace& laid, const Wish& wish) noexcept;

  Stock stock_;  ///< poses alone
  /// Windows of a field that were made last.
  struct Laid {
    std::vector<WindowPlace> places;  ///< by octave
    double wait_s = 0.0;              ///< [s] until the field is sampled; negative: it is not needed
  };
  std::vector<Laid> laid_;  ///< by field
  std::set<Key> lost_;
};

}  // namespace palpa
