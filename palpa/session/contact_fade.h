// Fade-out and fade-in of a mode whose level jumps between two frames of the data.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "palpa/mode/crossings.h"
#include "palpa/solver/primitives.h"

namespace palpa {

/// A level that jumps cannot carry the proxy: its mode fades out in 50 ms, and in again in 50 ms at the new position. Trivially
/// copyable. One thread.
class ContactFade {
 public:
  void clear() noexcept;

  double share() const noexcept { return share_; }          ///< [1] of the mode's strengths
  bool is_leaving() const noexcept { return is_leaving_; }  ///< the mode's last primitives fade out; it places no others

  /// The mode fades, or has just begun anew.
  bool is_under_way() const noexcept { return share_ < 1.0 || is_leaving_ || returns_; }

  /// Advances the fade by `time_step_s` [s]. Returns true where the mode restarts with fresh memory.
  /// \param is_known  the motion of the data at the proxy is defined
  bool advance(bool is_known, double time_step_s) noexcept;
  /// Stores the primitives of a mode at a foot.
  void keep(std::size_t mode, std::size_t foot, const PrimitiveSet& placed) noexcept;
  /// Begins to fade out the stored primitives; false if none of them stands on a level.
  bool begin_fade_out(Samples& samples) noexcept;
  /// Adds the fading primitives to the set of a sub-step that begins at `start_m` [m].
  void place(const Vec3& start_m, PrimitiveSet& out) const noexcept;
  /// Disables events of the mode's field during the fade; a foot then beyond the level counts as across.
  void configure_events(std::size_t foot, std::int32_t field, Crossings& crossings, EventPolicy& policy) noexcept;

 private:
  static constexpr std::size_t most_primitives = 16;  // [1] that fade; a surplus is removed at once. More costs memory
  double share_ = 1.0;
  bool is_leaving_ = false;
  bool returns_ = false;
  bool is_free_above_ = false;  // the free side of `level_` has the higher values
  Threshold level_;             // of a plane of the mode; without a field if there is none
  std::int32_t plane_ = 0;      // index of that plane among the stored primitives
  std::int32_t size_ = 0;
  std::array<Primitive, most_primitives> last_;
};

}  // namespace palpa
