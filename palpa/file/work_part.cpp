#include "palpa/file/work_part.h"

#include <charconv>
#include <cstdlib>
#include <optional>
#include <string_view>

#include "palpa/base/load_error.h"
#include "palpa/base/wording.h"

namespace palpa {
namespace {

constexpr int most_parts = 1 << 20;

std::optional<int> number(std::string_view text) {
  int value = 0;
  const auto found = std::from_chars(text.data(), text.data() + text.size(), value);
  return found.ec == std::errc{} && found.ptr == text.data() + text.size() ? std::optional(value) : std::nullopt;
}

std::optional<int> variable(const char* name) {
  const char* text = std::getenv(name);
  return text ? number(text) : std::nullopt;
}

struct Launcher {
  const char* rank;
  const char* count;
  const char* first;  ///< rank of the first process; nullptr: 0
};
// Tasks of a Slurm job before its array: a job of an array may have both.
constexpr Launcher launchers[] = {{"OMPI_COMM_WORLD_RANK", "OMPI_COMM_WORLD_SIZE", nullptr},
                                  {"PMI_RANK", "PMI_SIZE", nullptr},
                                  {"SLURM_PROCID", "SLURM_NTASKS", nullptr},
                                  {"SLURM_ARRAY_TASK_ID", "SLURM_ARRAY_TASK_COUNT", "SLURM_ARRAY_TASK_MIN"}};

WorkPart part_of_environment() {
  std::optional<WorkPart> single;
  for (const Launcher& launcher : launchers) {
    const std::optional<int> rank = variable(launcher.rank), count = variable(launcher.count);
    if (!rank || !count) continue;
    const WorkPart part{*rank - (launcher.first ? variable(launcher.first).value_or(0) : 0) + 1, *count};
    if (part.of < 1 || part.of > most_parts || part.number < 1 || part.number > part.of) {
      throw LoadError(std::string("--part auto: ") + launcher.rank + "=" + std::to_string(*rank) + " is none of " +
                      launcher.count + "=" + std::to_string(*count) + "; give --part I/N");
    }
    // A job of an array with one task has the array's count behind it.
    if (part.of > 1) return part;
    single = part;
  }
  if (single) return *single;
  throw LoadError(
      "--part auto: no launcher says how many processes there are (OMPI_COMM_WORLD_SIZE, PMI_SIZE, SLURM_NTASKS, "
      "SLURM_ARRAY_TASK_COUNT); start it by mpirun or sbatch, or give --part I/N");
}

}  // namespace

WorkPart work_part(const std::string& text) {
  if (text == "auto") return part_of_environment();
  const std::size_t at = text.find('/');
  const std::optional<int> part = number(std::string_view(text).substr(0, at));
  const std::optional<int> of = at == std::string::npos ? std::nullopt : number(std::string_view(text).substr(at + 1));
  if (!part || !of || *of < 1 || *of > most_parts || *part < 1 || *part > *of) {
    throw LoadError("--part " + detail::one_line(text) +
                    ": is no part of a whole; write number and count, as in 3/64 (from 1/64 to 64/64), or auto");
  }
  return {*part, *of};
}

}  // namespace palpa
