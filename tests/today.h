// A day's part of long checks; with PALPA_TESTS_LONG in the environment all of them.
#pragma once

#include <chrono>
#include <cstdint>
#include <cstdlib>

namespace palpa::test {

inline bool all_days() { return std::getenv("PALPA_TESTS_LONG") != nullptr; }

/// The number of today's date, in days.
inline std::int64_t today() {
  using namespace std::chrono;
  return floor<days>(system_clock::now()).time_since_epoch().count();
}

/// Whether today runs this case of a list: each day one in so many, others the next day.
inline bool is_of_today(std::int64_t number, int one_in) { return all_days() || (number + today()) % one_in == 0; }

}  // namespace palpa::test
