#include "palpa/study/map.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "app/commands.h"
#include "app/output_names.h"
#include "app/pictures.h"
#include "app/terminal.h"
#include "palpa/base/free_memory.h"
#include "palpa/base/printed.h"
#include "palpa/mode/plugin.h"
#include "palpa/study/map_file.h"

namespace palpa::app {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int slice_points = 256, grid_points = 64;

/// \param parts  [1] of the map
MapLattice lattice_of(const MapArguments& arguments, int parts) {
  const int points = arguments.points > 0 ? arguments.points : arguments.grid ? grid_points : slice_points;
  try {
    if (arguments.grid) return map_grid(1e-3 * arguments.size_mm, points, parts);
    return map_slice(arguments.slice[0] - 'x', 1e-3 * arguments.at_mm, 1e-3 * arguments.size_mm, points, parts);
  } catch (const LoadError& error) {
    throw LoadError(std::string("map: ") + error.what());
  }
}

/// Refuses a map whose points do not fit into memory together. Throws LoadError.
void check_memory(const MapLattice& lattice) {
  const double needed = static_cast<double>(lattice.count()) * sizeof(MapPoint);
  const auto free = static_cast<double>(detail::free_memory_bytes());
  if (needed > free)
    throw LoadError(detail::text("map: %.0f points need %.1f GB as a whole, and %.1f GB are free; give fewer --points",
                                 static_cast<double>(lattice.count()), 1e-9 * needed, 1e-9 * free));
}

Json summary_of(const ForceMap& map, const MapWork& work) {
  double largest_n = 0.0;
  std::int64_t felt = 0, broken = 0, unsettled = 0;
  for (const MapPoint& point : map.points) {
    largest_n = std::max(largest_n, norm(point.steady_n));
    felt += norm(point.steady_n) > contact_force_n;
    broken += point.broken_levels > 0;
    unsettled += point.unsettled;
  }
  const double seconds = std::max(work.seconds, 1e-9);
  return {{"points", map.lattice.count()},
          {"points_felt_now", work.points},
          {"ticks", work.ticks},
          {"seconds", work.seconds},
          {"threads", work.threads},
          {"points_per_s", static_cast<double>(work.points) / seconds},
          {"probes_per_s", static_cast<double>(work.ticks) / seconds},
          {"points_with_force", felt},
          {"points_behind_a_broken_level", broken},
          {"points_not_settled", unsettled},
          {"force_max_n", largest_n}};
}

std::string format_summary(const Json& summary) {
  const auto count = [&](const char* key) { return detail::grouped(detail::text("%.0f", summary[key].get<double>())); };
  std::string words = detail::text("%s points, %s with a force, up to %.3g N", count("points").c_str(),
                                   count("points_with_force").c_str(), summary["force_max_n"].get<double>());
  if (summary["points_not_settled"].get<std::int64_t>() > 0) words += "; not converged at " + count("points_not_settled");
  const int threads = summary["threads"].get<int>();
  words += detail::text("\n%s of them computed in %.2f s on %d %s: %s points and %s probe positions per second\n",
                        count("points_felt_now").c_str(), summary["seconds"].get<double>(), threads,
                        threads == 1 ? "core" : "cores", count("points_per_s").c_str(), count("probes_per_s").c_str());
  return words;
}

/// Adds what earlier runs and other parts kept.
void take_kept(ForceMap& map, const std::string& identity, const fs::path& kept, const std::vector<fs::path>& parts) {
  std::vector<fs::path> files = parts;
  files.push_back(kept);
  for (const fs::path& file : files) {
    const KeptMap found = take_kept_map(map, identity, file);
    if (found == KeptMap::another)
      print_warnings({file.string() + ": belongs to another map or is damaged; its places are computed from the start"});
    if (found == KeptMap::taken) tell("going on with the map in " + file.string() + "\n");
  }
}

/// \param keep  called where a file cannot be written, as on a full disk: the computed map is not lost
void write_files(const Scene& scene, const ForceMap& map, const MapArguments& arguments, const Pictures* pictures,
                 const std::function<void()>& keep) {
  try {
    write_map(map, scene.hand_to_world(), arguments.out, arguments.existing);
    if (pictures) pictures->map(scene, map, arguments.picture, arguments.existing);
  } catch (const LoadError&) {
    keep();
    throw;
  }
}

bool is_felt(const ForceMap& map, const WorkPart& part) {
  return std::ranges::all_of(ways_of(map.lattice, part), [&](int way) { return map.done[static_cast<std::size_t>(way)] == 1; });
}

}  // namespace

int run_map(const MapArguments& arguments, const std::atomic<bool>& stop) {
  const std::vector<fs::path> parts = arguments.is_part ? std::vector<fs::path>() : map_part_files(arguments.out);
  const MapLattice lattice =
      lattice_of(arguments, arguments.is_part ? arguments.part.of : std::max(1, static_cast<int>(parts.size())));
  if (!arguments.is_part) check_memory(lattice);
  check_output(arguments.out, ".vti", arguments.existing);
  const Pictures* pictures = nullptr;
  if (!arguments.picture.empty()) {
    check_output(arguments.picture, ".png", arguments.existing);
    pictures = &pictures_for(arguments.picture.string());
  }
  ReadOptions read = arguments.read;
  read.checksums = Checksums::now;
  LoadedScene loaded;
  {
    const Progress progress("loading " + arguments.scene.filename().string());
    loaded = load_scene(arguments.scene, volume_reader(read), modes_with(arguments.plugins), arguments.scene_options);
  }
  print_warnings(loaded.warnings);

  ForceMap map(lattice);
  const std::string identity = identity_of_map(loaded.scene, arguments.plugins, lattice);
  const fs::path kept = arguments.is_part ? map_part_file(arguments.out, arguments.part.number) : kept_map_file(arguments.out);
  take_kept(map, identity, kept, parts);

  MapWork work;
  {
    Progress progress("feeling " + arguments.scene.filename().string());
    work = feel_map(loaded.scene, map,
                    {.threads = arguments.threads,
                     .stop = &stop,
                     .part = arguments.part,
                     .progress = [&](double share) { progress.show(share); },
                     .keep = [&](const ForceMap& so_far) { keep_map(so_far, identity, kept); }});
  }
  if (arguments.is_part && is_felt(map, arguments.part)) {
    keep_map(map, identity, kept);
    tell("part " + std::to_string(arguments.part.number) + " of " + std::to_string(arguments.part.of) + " is in " +
         kept.string() + "; the same command without --part joins all parts\n");
    return 0;
  }
  if (!map.is_whole()) {
    keep_map(map, identity, kept);
    tell("the partial map is kept in " + kept.string() + "; the same command resumes it\n");
    return 0;
  }
  write_files(loaded.scene, map, arguments, pictures, [&] { keep_map(map, identity, kept); });
  std::error_code none;
  fs::remove(kept, none);
  for (const fs::path& part : parts) fs::remove(part, none);

  const Json summary = summary_of(map, work);
  print(arguments.json ? summary.dump(2) + "\n" : format_summary(summary));
  return 0;
}

}  // namespace palpa::app
