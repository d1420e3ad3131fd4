// On which side of levels and breakpoints the proxy is, and what happens first along a straight way.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "palpa/mode/mode.h"
#include "palpa/mode/state_arena.h"
#include "palpa/mode/tick_work.h"

namespace palpa {

/// A value of a scalar field at which a mode's behaviour may set in or jump.
struct Threshold {
  std::int32_t field = -1;
  double value = 0.0;  ///< the field's own unit
  friend bool operator==(const Threshold&, const Threshold&) = default;
};

/// What stops a search. Made by Crossings::policy; filled anew for each search.
struct EventPolicy {
  /// How a watched value counts, by the plane that stands on it.
  enum class CrossingRule : std::uint8_t {
    stops,        ///< no plane, or one that is pressed through: the way ends where it is crossed
    held,         ///< the plane holds the proxy: it is on the level, to within rounding, and crosses nothing
    leaves_up,    ///< the proxy lifts off the plane towards higher values: that is a crossing, but nothing sets in there
    leaves_down,  ///< the same towards lower values
    passes,       ///< it is crossed, either way, and the search goes on
  };
  struct OfField {
    Vec3 carried_m;               ///< [m] so far its data have carried what was under the proxy: there the proxy sets out
    ValueRange allowed;           ///< the field's own unit; elsewhere the proxy would be too deep in what holds it
    bool stops_at_edges = false;  ///< the way ends where its data begin or end, too; scalar and vector fields
    bool is_ignored = false;      ///< no watched value of it counts
  };
  std::vector<CrossingRule> passing;  ///< by watch; see Crossings::configure_events
  std::vector<OfField> fields;        ///< by the session's index

  /// Every watch stops, nothing is carried, all values are allowed. Allocates nothing.
  void clear() noexcept;
};

/// What a search has found, and its memory, for the next one. Made by Crossings::event.
struct Event {
  enum class Kind : std::uint8_t {
    none,
    crossing,     ///< a watched value is crossed
    edge,         ///< data of a field that stops at edges begin or end
    pierced,      ///< a value that is not allowed is met
    out_of_work,  ///< the budget is spent: nothing happens up to there
  };
  Kind kind = Kind::none;
  double share = 1.0;               ///< [1] of the way
  std::vector<Crossing> crossings;  ///< up to there, in the order met

 private:
  friend class Crossings;
  enum class Side : std::uint8_t { none, below, above };
  // What a field is at a place, and what bounds it around there.
  struct Ball {
    Vec3 center_m;
    double value = 0.0;
    bool inside = false;
    LipschitzBound lipschitz_bound;
  };
  std::vector<Ball> balls_;           // by field
  std::vector<Side> sides_;           // by watch, after the share
  std::vector<std::int32_t> on_way_;  // fields in which something may happen
};

/// On which side of every watched value the proxy is. Sides change only by crossings that were located, so rounding next to a
/// level can neither lose nor invent a contact. Construction, `policy` and `event` allocate; nothing else does. One thread.
class Crossings {
 public:
  /// \param live     keeps the sides
  /// \param watches  duplicates are watched once, and what no field has not at all
  /// \param fields   the number of the session's
  Crossings(StateArena& live, std::span<const Threshold> watches, std::size_t fields);
  EventPolicy policy() const;
  Event event() const;

  /// Whether this value is among those watched: a shell's level is, the value that a material was met at is not.
  bool is_watched(const Threshold& watch) const noexcept { return index_of(watch) >= 0; }
  /// Says how a value counts, if it is watched; of two planes on one level the one that holds decides.
  void configure_events(EventPolicy& policy, const Threshold& watch, EventPolicy::CrossingRule passing) const noexcept;

  /// Forgets all sides; a search takes them where it sets out, or where it meets data.
  void reset() noexcept;
  /// The proxy counts as above, or below, a watched value from here on, wherever it is: being on the other side is a crossing.
  void take_side(const Threshold& watch, bool above) noexcept;

  /// Finds the first point of the straight way [m], of any length, at which the policy stops; its end where it does not. No
  /// change is missed that the interpolant makes: a wall thinner than a voxel, a dip within a cell (Field::piece_along); a
  /// level that is only touched is not crossed. The point lies just beyond the change, to 1e-9 of the field's spacing or as
  /// close as rounding permits: there a sample shows the other side. A proxy that starts on the other side and is back within a
  /// quarter of a spacing has crossed nothing.
  /// \param work  spent by pieces of ways (PolynomialPiece; Samples::work_of_look). However little is left,
  ///                   each search gets on: it looks at one piece of each field, and at slivers before that.
  void first_event(const Vec3& start_m, const Vec3& end_m, const EventPolicy& policy, Samples& samples, WorkBudget& work,
                   Event& event) const noexcept;
  /// The proxy goes the way up to the event: the sides follow.
  void apply(const Event& event) noexcept {
    if (!event.on_way_.empty()) std::ranges::copy(event.sides_, sides_.begin());
  }

 private:
  using Side = Event::Side;
  struct FieldOnWay;
  struct Range {
    std::int32_t first = 0, last = 0;  // watches of a field
  };
  std::int32_t index_of(const Threshold& watch) const noexcept;
  bool has_sides(std::int32_t field, std::span<const Side> sides) const noexcept;
  void forget(std::int32_t field, std::span<Side> sides) const noexcept;
  std::int32_t border(const EventPolicy& policy, std::int32_t field, std::span<const Side> sides, bool up) const noexcept;
  ValueRange quiet(const EventPolicy& policy, std::int32_t field, std::span<const Side> sides) const noexcept;
  bool is_safe(std::int32_t field, const Vec3& start_m, const Vec3& end_m, const EventPolicy& policy, Samples& samples,
               Event& event) const noexcept;

  std::vector<Threshold> watches_;  // by field, then by value
  std::vector<Range> ranges_;       // by field
  std::span<Side> sides_;           // by watch; none where its field has no data
};

}  // namespace palpa
