// Parallel loops for loading.
#pragma once

#include <algorithm>
#include <cstdint>
#include <exception>
#include <thread>
#include <vector>

namespace palpa::detail {

/// Calls `act(first, last)` concurrently for parts of 0…count, one per core, and returns after the last; for all of it if
/// `count` is small. Rethrows an exception of a part.
/// \param least  [1] size of a part: smaller ones are not worth a thread
template <class Act>
void in_parts(std::int64_t count, std::int64_t least, const Act& act) {
  const std::int64_t cores = std::max<std::int64_t>(std::thread::hardware_concurrency(), 1);
  const std::int64_t parts = std::clamp<std::int64_t>(count / std::max<std::int64_t>(least, 1), 1, cores);
  if (parts == 1) return act(0, count);
  std::vector<std::exception_ptr> problems(static_cast<std::size_t>(parts));
  const auto run = [&](std::int64_t part) {
    try {
      act(count * part / parts, count * (part + 1) / parts);
    } catch (...) {
      problems[static_cast<std::size_t>(part)] = std::current_exception();
    }
  };
  {
    std::vector<std::jthread> others;
    for (std::int64_t part = 1; part < parts; ++part) others.emplace_back(run, part);
    run(0);
  }
  for (const std::exception_ptr& problem : problems) {
    if (problem) std::rethrow_exception(problem);
  }
}

}  // namespace palpa::detail
