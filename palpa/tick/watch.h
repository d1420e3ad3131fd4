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

/// On which side of every watched value the proxy is, and where along a straight way it changes sides. Sides
/// change only by crossings that were located, so rounding next to a level can neither lose nor invent
/// a contact. Takes its memory at construction.
class Watches {
 public:
  Watches() = default;
  /// Duplicates are watched once.
  explicit Watches(std::span<const Watch> watches);
  std::size_t size() const noexcept { return watches_.size(); }

  /// Whether this value is among those watched: a shell's level is, the value that a material was met at is not.
  bool is_watched(const Watch& watch) const noexcept;

  /// Forgets all sides.
  void reset() noexcept;
  /// Takes the sides of watches that have none from the samples' position; where a field has no data
  /// its watches have no side.
  void look(Samples& samples) noexcept;

  /// How a level counts in the next search, by the plane that stands on it.
  enum class Attention : std::uint8_t {
    stop,        ///< no plane, or one that is pressed through: the path stops where it is crossed
    held,        ///< the plane holds the proxy: it is on the level, to within rounding, and crosses nothing
    leave_up,    ///< the proxy lifts off the plane towards higher values: one such crossing counts, but nothing sets in there
                 ///< to stop for; any other stops
    leave_down,  ///< the same towards lower values
  };
  /// No plane stands on any level, and no data have moved.
  void attend_all() noexcept;
  void attend(const Watch& watch, Attention attention) noexcept;
  /// In the next search, seen from the data of this field, the proxy sets out `carried_m` [m] from the start: so far have
  /// they carried what was under it.
  void carry(std::int32_t field, const Vec3& carried_m) noexcept;
  /// The proxy counts as above, or below, a watched value from here on, wherever it is: being on the other side is a crossing.
  void take_side(const Watch& watch, bool above) noexcept;
  /// In the next search nothing is crossed in this field.
  void ignore(std::int32_t field) noexcept;
  /// From now on the path also stops where these fields' data begin or end; scalar and vector fields, whether watched or
  /// not. None at first. Allocates for fields that were never named before.
  void attend_edges(std::span<const std::int32_t> fields);

  /// The most pieces of the way (Stretch) that one search looks at, over all fields.
  static constexpr int most_stretches = 512;  // [1]

  struct Met {
    double share = 1.0;  ///< [1] of the way, up to the stop
    bool stopped = false;
    bool edge = false;         ///< stopped where data of a field of `attend_edges` begin or end
    bool out_of_work = false;  ///< stopped where `most_stretches` were looked at: nothing happens up to there
  };
  /// Finds the first point of the straight way [m], of any length, at which a watch that is to stop the path changes
  /// sides; the way's end where none does. No change is missed that the interpolant makes: a wall thinner than a voxel, a
  /// dip within a cell (Field::stretch); a level that is only touched is not crossed. The point lies just beyond the
  /// change, to 1e-9 of the field's spacing or as close as rounding permits: there a sample shows the other side. A
  /// proxy that starts on the other side and is back within a quarter of a spacing has crossed nothing. Where data begin
  /// on the way, watches without a side take theirs.
  /// `crossings` (cleared by the caller) gets what has changed up to there, in the order met, and the sides follow; those of
  /// `leave` too. Moves the samples.
  Met first_crossing(Samples& samples, const Vec3& start_m, const Vec3& end_m, std::vector<Crossing>& crossings) noexcept;

 private:
  enum class Side : std::uint8_t { none, below, above };

  struct Way {
    Vec3 start_m, end_m;
    double length_m = 0.0;
    double rounding_share = 0.0;  ///< [1] what positions are rounded by

    Vec3 at(double share) const noexcept { return share < 1.0 ? start_m + share * (end_m - start_m) : end_m; }
  };

  /// One field along the way: the piece that the search has come to, and the first change of sides on it.
  struct FieldOnWay {
    std::int32_t field = -1;
    std::size_t first = 0, last = 0;  ///< its watches: [first, last)
    bool stops_at_edges = false;
    Vec3 carried_m;         ///< by its data
    Way way;                ///< as they see it
    bool has_data = false;  ///< at the end of the piece before
    bool begins = true;     ///< no piece before
    double begin = 0.0;     ///< [1] of the piece
    Stretch piece;
    double event = 2.0;     ///< [1] share of the way of the first change; beyond 1: none on this piece
    std::size_t watch = 0;  ///< that changes there
    bool at_edge = false;   ///< what happens there is that data begin or end
    double hair = 0.0;      ///< [1] of the way: a billionth of the spacing
  };
  Side side_at(Samples& samples, const Watch& watch) const noexcept;
  FieldOnWay& on_way(std::int32_t field);
  void advance(FieldOnWay& at, Samples& samples) const noexcept;
  void enter(FieldOnWay& at, Samples& samples) noexcept;
  void stop_at_edge(FieldOnWay& at, Samples& samples) const noexcept;
  void search(FieldOnWay& at, double from, bool again, Samples& samples) noexcept;
  double located(const FieldOnWay& at, std::size_t watch, double share, Samples& samples) const noexcept;
  bool is_rounding(const FieldOnWay& at, std::size_t watch, double share, Samples& samples) const noexcept;
  double passage(const FieldOnWay& at, std::size_t watch, double from) noexcept;
  void change_others(const FieldOnWay& at, Samples& samples, std::vector<Crossing>& crossings) noexcept;
  void change(std::size_t watch, std::vector<Crossing>& crossings) noexcept;

  std::vector<Watch> watches_;  ///< by field
  std::vector<Side> sides_;
  std::vector<Attention> attention_;
  std::vector<std::uint8_t> displaced_;  ///< starts on the other side and is on its way back
  std::vector<FieldOnWay> fields_;
};

/// The first share [1] of the way between two positions of the hand frame [m] at which a scalar field's value passes
/// `value`, in the field's own unit, upwards or downwards; 1 where it does not, or after as many pieces as one search of
/// Watches may have. Moves the samples.
double first_beyond(Samples& samples, std::int32_t field, double value, bool upwards, const Vec3& start_m,
                    const Vec3& end_m) noexcept;

}  // namespace palpa
