// Levels and breakpoints along the proxy's path.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "palpa/mode/mode.h"
#include "palpa/tick/session.h"

namespace palpa {

/// A value of a scalar field at which a mode's behaviour may set in or jump.
struct Watch {
  std::int32_t field = -1;
  double value = 0.0;  ///< the field's own unit
  friend bool operator==(const Watch&, const Watch&) = default;
};

/// On which side of every watched value the proxy is, and where along a step it changes sides. Sides
/// change only by crossings that were located, so rounding next to a level can neither lose nor invent
/// a contact. Takes its memory at construction.
class Watches {
 public:
  Watches() = default;
  /// Duplicates are watched once.
  explicit Watches(std::span<const Watch> watches);
  std::size_t size() const noexcept { return watches_.size(); }

  /// Forgets all sides.
  void reset() noexcept;
  /// Takes the sides of watches that have none from the samples' position; where a field has no data
  /// its watches have no side.
  void look(Samples& samples) noexcept;

  /// How a level counts in the next search, by the plane that stands on it.
  enum class Attention : std::uint8_t {
    stop,   ///< no plane, or one that is pressed through: the path stops where it is crossed
    held,   ///< the plane holds the proxy: it is on the level, to within rounding, and crosses nothing
    leave,  ///< the proxy lifts off the plane: a crossing counts, but nothing sets in there to stop for
  };
  void attend_all() noexcept;
  void attend(const Watch& watch, Attention attention) noexcept;

  struct Met {
    double share = 1.0;  ///< [1] of the segment, up to the stop
    bool stopped = false;
  };
  /// Finds the first point of the segment [m] at which a watch that is to stop the path changes sides,
  /// to a thousandth of the segment, just beyond the change; its end where none does. `crossings`
  /// (cleared by the caller) gets what has changed there, and the sides follow. Moves the samples.
  Met first_crossing(Samples& samples, const Vec3& start_m, const Vec3& end_m, std::vector<Crossing>& crossings) noexcept;

 private:
  enum class Side : std::uint8_t { none, below, above };
  Side side_at(Samples& samples, const Watch& watch) const noexcept;

  std::vector<Watch> watches_;
  std::vector<Side> sides_;
  std::vector<Attention> attention_;
};

}  // namespace palpa
