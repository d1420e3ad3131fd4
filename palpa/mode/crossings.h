// Event search along straight paths: crossings of levels and breakpoints.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "palpa/mode/mode.h"
#include "palpa/mode/tick_work.h"
#include "palpa/solver/state_arena.h"

namespace palpa {

/// Value of a scalar field at which a mode's behaviour may set in or jump.
struct Threshold {
  std::int32_t field = -1;
  double value = 0.0;  ///< the field's own unit
  friend bool operator==(const Threshold&, const Threshold&) = default;
};

/// Stop conditions of an event search. Made by Crossings::policy; refilled for each search.
struct EventPolicy {
  /// Effect of a watched value, by the plane that stands on it.
  enum class CrossingRule : std::uint8_t {
    stops,        ///< no plane, or a plane that is pressed through: stops at the crossing
    held,         ///< the plane holds the proxy, which is on the level to within rounding: no crossing
    leaves_up,    ///< the proxy lifts off the plane towards higher values: a crossing, without a stop
    leaves_down,  ///< likewise towards lower values
    passes,       ///< a crossing in either direction, without a stop
  };
  struct OfField {
    Vec3 carried_m;               ///< [m] motion of the contact with the field's data; shifts the start of the path
    ValueRange allowed;           ///< the field's own unit; beyond it the proxy would be too deep in its level
    bool stops_at_edges = false;  ///< also stops where its data begin or end; scalar and vector fields
    bool is_ignored = false;      ///< its watched values have no effect
  };
  std::vector<CrossingRule> passing;  ///< by watch; see Crossings::configure_events
  std::vector<OfField> fields;        ///< by the session's index

  /// Every watch stops, nothing is carried, all values are allowed. Allocates nothing.
  void clear() noexcept;
};

/// Result of an event search; caches for the next. Made by Crossings::event.
struct Event {
  enum class Kind : std::uint8_t {
    none,
    crossing,     ///< a watched value is crossed
    edge,         ///< data of a field that stops at edges begin or end
    pierced,      ///< a value that is not allowed
    out_of_work,  ///< budget exhausted; no event up to there
  };
  Kind kind = Kind::none;
  double share = 1.0;               ///< [1] of the path
  std::vector<Crossing> crossings;  ///< up to there, in order

  /// Where nothing can be met.
  void clear() noexcept {
    kind = Kind::none;
    share = 1.0;
    crossings.clear();
    on_way_.clear();
  }

 private:
  friend class Crossings;
  enum class Side : std::uint8_t { none, below, above };
  // Value and gradient of a field at a point and a moment, and its Lipschitz bound around it.
  struct Ball {
    Vec3 center_m;
    std::uint64_t moment = 0;
    double value = 0.0;
    Vec3 gradient;  // [unit/m]
    bool inside = false;
    LipschitzBound lipschitz_bound;
  };
  std::vector<Ball> balls_;           // by field
  std::vector<Side> sides_;           // by watch, after the share
  std::vector<std::int32_t> on_way_;  // fields in which an event is possible
};

/// Side of every foot at every watched value. Sides change only by located crossings, so rounding next to a level can neither
/// lose nor invent a contact. Construction, `policy` and `event` allocate; nothing else does. One thread.
class Crossings {
 public:
  /// \param live     keeps the sides
  /// \param watches  duplicates are removed, and values without a field
  /// \param fields   [1] number of the session's fields
  /// \param feet     [1] of the tool
  Crossings(StateArena& live, std::span<const Threshold> watches, std::size_t fields, std::size_t feet = 1);
  EventPolicy policy() const;
  Event event() const;

  /// Whether this value is watched: a shell's level is, the value at which a material was met is not.
  bool is_watched(const Threshold& watch) const noexcept { return index_of(watch) >= 0; }
  bool any_watched() const noexcept { return !watches_.empty(); }
  /// Sets the rule of a watched value; of two planes on a level the holding plane decides.
  void configure_events(EventPolicy& policy, const Threshold& watch, EventPolicy::CrossingRule passing) const noexcept;

  /// Clears all sides; a search determines them at its start, or where data begin.
  void reset() noexcept;
  /// Sets the side of a watched value that a foot counts as being on; the other side is then a crossing.
  void take_side(std::size_t foot, const Threshold& watch, bool above) noexcept;

  /// Finds the first stop of the policy on a foot's straight path [m] of any length; else its end. No change of the interpolant
  /// is missed: a wall thinner than a voxel, a dip within a cell (Field::piece_along); touching a level is no crossing. The
  /// point lies just beyond the change, to 1e-9 of the field's spacing or as rounding permits: a sample there is on the other
  /// side. A start on the other side with a return within a quarter of a spacing is no crossing.
  /// \param work  spent by pieces of the path (PolynomialPiece; Samples::work_of_look). Even without work left, each search
  /// makes progress: it evaluates one piece of each field, and slivers before that.
  void first_event(std::size_t foot, const Vec3& start_m, const Vec3& end_m, const EventPolicy& policy, Samples& samples,
                   WorkBudget& work, Event& event) const noexcept;
  /// Moves a foot to its event.
  void apply(std::size_t foot, const Event& event) noexcept {
    if (!event.on_way_.empty()) std::ranges::copy(event.sides_, sides_of(foot).begin());
  }

 private:
  using Side = Event::Side;
  struct FieldOnWay;
  struct Range {
    std::int32_t first = 0, last = 0;  // watches of a field
  };
  std::int32_t index_of(const Threshold& watch) const noexcept;
  std::span<Side> sides_of(std::size_t foot) const noexcept { return sides_.subspan(foot * watches_.size(), watches_.size()); }
  bool has_sides(std::int32_t field, std::span<const Side> sides) const noexcept;
  void forget(std::int32_t field, std::span<Side> sides) const noexcept;
  [[gnu::always_inline]] inline std::int32_t border(const EventPolicy& policy, std::int32_t field, std::span<const Side> sides,
                                                    bool up) const noexcept;
  ValueRange quiet(const EventPolicy& policy, std::int32_t field, std::span<const Side> sides) const noexcept;
  bool is_safe(std::int32_t field, std::span<const Side> sides, const Vec3& start_m, const Vec3& end_m,
               const EventPolicy& policy, Samples& samples, Event& event) const noexcept;

  std::vector<Threshold> watches_;  // by field, then by value
  std::vector<Range> ranges_;       // by field
  std::span<Side> sides_;           // by foot, then watch; none if its field has no data
};

}  // namespace palpa
