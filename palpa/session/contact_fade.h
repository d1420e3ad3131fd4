// What becomes of a mode's plane whose level jumps between two frames of the data instead of moving.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "palpa/mode/crossings.h"
#include "palpa/solver/primitives.h"

namespace palpa {

/// Such a level carries nothing along: its mode lets go of it in 50 ms, and takes hold again in 50 ms of where it is then.
/// Trivially copyable. One thread.
class ContactFade {
 public:
  /// The mode is felt in full.
  void clear() noexcept;

  double share() const noexcept { return share_; }          ///< [1] of the mode's strengths
  bool is_leaving() const noexcept { return is_leaving_; }  ///< what the mode had placed fades; it places nothing else

  /// Goes on by `time_step_s` [s]; `is_known`: where the data have carried the proxy. True where the mode is to begin anew.
  bool advance(bool is_known, double time_step_s) noexcept;
  /// The mode has placed what it has in `placed`.
  void keep(std::size_t mode, const PrimitiveSet& placed) noexcept;
  /// Begins to fade out what was kept; false where none of it stands on a level.
  bool let_go(Samples& samples) noexcept;
  /// Places what fades, of a sub-step that begins at `start_m` [m].
  void place(const Vec3& start_m, PrimitiveSet& out) const noexcept;
  /// While it fades nothing is crossed in the mode's field; whoever is beyond the level afterwards has crossed it.
  void configure_events(std::int32_t field, Crossings& crossings, EventPolicy& policy) noexcept;

 private:
  static constexpr std::size_t most_primitives = 16;  // [1] that fade; any more of a mode go at once. More costs memory
  double share_ = 1.0;
  bool is_leaving_ = false;
  bool returns_ = false;
  bool is_free_above_ = false;  // `level_` is free on its side of higher values
  Threshold level_;             // on which a plane of the mode stands; of no field where none does
  std::int32_t plane_ = 0;      // that plane, among what was kept
  std::int32_t size_ = 0;
  std::array<Primitive, most_primitives> last_;
};

}  // namespace palpa
