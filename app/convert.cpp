#include "palpa/file/convert.h"

#include <charconv>

#include "app/commands.h"
#include "app/output_names.h"
#include "app/terminal.h"
#include "palpa/file/fetch_process.h"
#include "palpa/file/sliced_file.h"
#include "palpa/file/store_writer.h"
#include "palpa/file/write_volume.h"

namespace palpa::app {
namespace {

/// `I0:I1,J0:J1,K0:K1` as voxels.
VoxelRange range_of(const std::string& text) {
  VoxelRange range;
  const char* next = text.data();
  const char* const end = next + text.size();
  const auto read = [&](std::int64_t& number, char behind) {
    const auto found = std::from_chars(next, end, number);
    const bool right =
        found.ec == std::errc{} && (behind == '\0' ? found.ptr == end : found.ptr != end && *found.ptr == behind);
    if (!right)
      throw LoadError("--crop " + text + ": is no range; write first and last voxel of i, j and k, as in 10:99,0:63,5:5");
    next = found.ptr + 1;
  };
  for (std::size_t a = 0; a < 3; ++a) read(range.first[a], ':'), read(range.last[a], a < 2 ? ',' : '\0');
  return range;
}

std::string format_volume(const WrittenVolume& volume) {
  const auto& n = volume.grid.dims;
  std::string fields;
  for (const WrittenField& field : volume.fields) fields += (fields.empty() ? "" : ", ") + field.name;
  return std::to_string(n[0]) + " x " + std::to_string(n[1]) + " x " + std::to_string(n[2]) + " voxels, " + fields;
}

}  // namespace

int run_convert(ConvertArguments arguments, const std::atomic<bool>& stop) {
  if (!arguments.crop.empty()) arguments.options.crop = range_of(arguments.crop);
  detail::refuse_web_address(arguments.out, "palpa convert");
  const std::string& in = arguments.request.files.front().string();
  arguments.read.checksums = Checksums::none;
  const bool to_store = is_store(arguments.out);
  if (!to_store && (arguments.options.shares_store || arguments.options.zarr != 0))
    throw LoadError("--part, --zarr: are of stores alone; name OUT.zarr");
  // Bare numbers are mapped then, so that each process reads its own part alone.
  arguments.read.preview = to_store && !arguments.request.layout.type.empty();
  VolumeFile file;
  std::unique_ptr<SlicedFile> sliced;
  {
    const Progress progress("reading " + in);
    const bool in_memory = arguments.options.resample_m != 0.0 || arguments.options.int16;
    if (!in_memory) sliced = open_sliced_file(arguments.request, arguments.read);
    if (!sliced) file = read_volume_file(arguments.request, arguments.read);
  }
  // Mapped numbers are sampled for their range, which a conversion does not need.
  std::vector<std::string> warnings = sliced ? sliced->volume.warnings : file.volume.warnings;
  std::erase_if(warnings, [](const std::string& warning) { return warning.starts_with("is looked at in one row"); });
  std::vector<std::string> lost;
  std::string grid;
  arguments.options.written = [&](const WrittenVolume& volume) { grid = format_volume(volume); };
  {
    Progress progress("writing " + arguments.out.filename().string());
    arguments.options.progress = [&](double share) {
      if (stop) throw LoadError("interrupted");
      progress.show(share);
    };
    try {
      lost =
          sliced ? convert(*sliced, arguments.out, arguments.options) : convert(file.volume, arguments.out, arguments.options);
    } catch (const LoadError& error) {
      const std::string problem = error.what();
      const bool has_place = problem.starts_with(arguments.out.string() + ": ") || problem.starts_with(in + ": ");
      throw LoadError(has_place ? problem : in + ": " + problem);
    }
  }
  warnings.insert(warnings.end(), lost.begin(), lost.end());
  for (std::string& warning : warnings) warning = in + ": " + warning;
  print_warnings(warnings);
  if (!to_store) return tell(wrote_words(arguments.out, grid)), 0;
  if (arguments.options.shares_store) {
    const WorkPart& part = arguments.options.part;
    tell("Wrote part " + std::to_string(part.number) + " of " + std::to_string(part.of) + " of " + arguments.out.string() +
         ": " + grid + "; after the last part: palpa prepare " + arguments.out.string() + "\n");
    return 0;
  }
  tell("Wrote " + arguments.out.string() + ": " + grid + "\n");
  PrepareArguments prepare{.store = arguments.out};
  prepare.options.read = arguments.read;
  return run_prepare(std::move(prepare), stop);
}

}  // namespace palpa::app
