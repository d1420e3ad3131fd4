// Comparison of two runs of one hand: where forces differ, by how much, and whether a person would notice.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "palpa/study/felt.h"

namespace palpa {

/// Discrimination threshold of forces, as a share [1] of their mean strength: 7 % from 2.5 to 10 N (Pang, Tan and Durlach 1991)
/// …
inline constexpr double discrimination_share = 0.07;
/// … at least this [N], the threshold of fingers at small forces …
inline constexpr double discrimination_min_n = 0.03;
/// … and of directions: 25 to 35° were measured.
inline constexpr double discrimination_deg = 30.0;

/// Discrimination threshold in strength [N] of these two forces [N]. Symmetric.
double discrimination_threshold_n(const Vec3& first_n, const Vec3& second_n) noexcept;
/// Angle between two forces [°]; 0 if one is too weak for its direction to be felt.
double turned_deg(const Vec3& first_n, const Vec3& second_n) noexcept;
/// Whether a person would distinguish these forces in succession, by strength or direction.
bool are_distinguishable(const Vec3& first_n, const Vec3& second_n) noexcept;

/// Interval of ticks with a noticeable difference; short gaps are bridged.
struct NoticeableInterval {
  std::size_t first = 0, last = 0;  ///< index of its first and its last tick
  std::size_t largest = 0;          ///< index of the tick with the largest difference
};

/// Difference of two runs of one hand.
struct FeltDifference {
  std::vector<double> difference_n;           ///< |first − second| of the forces at the hand, by tick; 0 without a known hand
  std::vector<std::uint8_t> noticeable;       ///< 1 for ticks with a noticeable difference
  std::vector<NoticeableInterval> intervals;  ///< in order
  std::size_t largest = 0;                    ///< index of the tick with the largest difference
  double rms_n = 0.0;                         ///< root mean square of the difference, over ticks with a force in either
  double noticeable_share = 0.0;              ///< [1] of ticks with a force in either
  std::size_t in_contact = 0;                 ///< ticks with a force in either
};

/// First difference between the hands of two runs, as half a sentence: "from tick 12 (0.012 s) on the probe is 0.4 mm
/// elsewhere". Empty: the hands are equal, over the shorter run.
std::string where_hands_part(const FeltRun& first, const FeltRun& second);

/// Compares the forces at the hand, over the shorter run. Programming error (assert) unless `where_hands_part` is empty.
FeltDifference compare_felt(const FeltRun& first, const FeltRun& second);

}  // namespace palpa
