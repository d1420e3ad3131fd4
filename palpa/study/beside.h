// Two runs of the same hand beside each other: where what it felt differs, by how much, and whether a hand would tell.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "palpa/study/felt.h"

namespace palpa {

/// A hand tells two forces apart that differ by more than this share [1] of their mean strength: 7 % from 2.5 to 10 N (Pang,
/// Tan and Durlach 1991) …
inline constexpr double told_apart_share = 0.07;
/// … but not by less than this [N], which is what fingers tell of small forces …
inline constexpr double told_apart_n = 0.03;
/// … and two directions that are this far apart: 25 to 35° were measured.
inline constexpr double told_apart_deg = 30.0;

/// The difference in strength [N] above which a hand tells these two forces [N] apart. The same when they change places.
double told_apart_above_n(const Vec3& first_n, const Vec3& second_n) noexcept;
/// The angle between two forces [°]; 0 where one of them is too weak to have a direction that a hand feels.
double turned_deg(const Vec3& first_n, const Vec3& second_n) noexcept;
/// Whether a hand that got one of these forces and then the other would tell them apart, by strength or direction.
bool are_told_apart(const Vec3& first_n, const Vec3& second_n) noexcept;

/// Ticks one after another in which a hand would tell the two runs apart; short gaps are bridged.
struct ToldStretch {
  std::size_t first = 0, last = 0;  ///< index of its first and its last tick
  std::size_t largest = 0;          ///< index of the tick with the largest difference
};

/// How two runs of the same hand differ.
struct FeltDifference {
  std::vector<double> difference_n;    ///< |first − second| of what reached the hand, tick by tick; 0 where no hand was known
  std::vector<std::uint8_t> told;      ///< 1 for ticks in which a hand would tell
  std::vector<ToldStretch> stretches;  ///< in order
  std::size_t largest = 0;             ///< index of the tick with the largest difference
  double rms_n = 0.0;                  ///< root mean square of the difference, over ticks in which either pushes
  double told_share = 0.0;             ///< [1] of ticks in which either pushes
  std::size_t in_contact = 0;          ///< ticks in which either pushes
};

/// Where the hands of two runs begin to differ, as half a sentence: "from tick 12 (0.012 s) on the probe is 0.4 mm elsewhere".
/// Empty: it is the same hand at the same times, as far as both go.
std::string where_hands_part(const FeltRun& first, const FeltRun& second);

/// Compares what reached the hand, as far as both go. Programming error (assert) where `where_hands_part` says something.
FeltDifference compare_felt(const FeltRun& first, const FeltRun& second);

}  // namespace palpa
