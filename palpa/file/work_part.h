// Part of a job that several processes share, without talking to each other.
#pragma once

#include <cstdint>
#include <string>

namespace palpa {

/// Part of a job: number `number` of `of`.
struct WorkPart {
  int number = 1;  ///< [1] 1…of
  int of = 1;      ///< [1]
  bool is_whole() const noexcept { return of == 1; }
  /// First of `count` items of this part, in contiguous blocks of nearly equal size; its last is before the next part's first.
  std::int64_t first(std::int64_t count) const noexcept { return split(count, number - 1); }
  std::int64_t end(std::int64_t count) const noexcept { return split(count, number); }
  friend bool operator==(const WorkPart&, const WorkPart&) = default;

 private:
  std::int64_t split(std::int64_t count, std::int64_t at) const noexcept { return count / of * at + count % of * at / of; }
};

/// Parses "3/64"; or "auto": number and count of the processes from the environment of Open MPI, PMI (MPICH, Intel MPI), Slurm
/// tasks or a Slurm array, in this order. Throws LoadError "--part TEXT: problem; remedy". Allocates; reads the environment.
WorkPart work_part(const std::string& text);

}  // namespace palpa
