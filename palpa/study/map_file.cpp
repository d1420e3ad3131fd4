#include "palpa/study/map_file.h"

#include <algorithm>
#include <charconv>
#include <cstring>
#include <system_error>

#include "palpa/base/input_file.h"
#include "palpa/base/printed.h"
#include "palpa/data/sha256.h"
#include "palpa/file/write_volume.h"
#include "palpa/study/recording.h"
#include "palpa/version.h"

namespace palpa {
namespace {

namespace fs = std::filesystem;

constexpr std::string_view magic = "palpa: a map of forces that is not whole yet (1)\n";

/// Numbers of a point, in the file's order.
using Kept = std::array<double, 9>;
Kept kept(const MapPoint& p) {
  return {p.first_contact_n.x, p.first_contact_n.y, p.first_contact_n.z,   p.steady_n.x,           p.steady_n.y,
          p.steady_n.z,        p.proxy_distance_m,  1.0 * p.broken_levels, p.unsettled ? 0.0 : 1.0};
}
MapPoint point_of(const Kept& n) { return {{n[0], n[1], n[2]}, {n[3], n[4], n[5]}, n[6], static_cast<int>(n[7]), n[8] == 0.0}; }

std::string header(const std::string& identity) { return std::string(magic) + identity + '\0'; }

}  // namespace

std::string identity_of_map(const Scene& scene, const std::vector<fs::path>& plugins, const MapLattice& lattice) {
  std::string text = std::string("palpa ") + version + "\n" + to_toml(scene) + "\n";
  for (const SourceFile& file : detail::data_files(scene)) text += "data " + file.sha256.text() + "\n";
  for (const fs::path& plugin : plugins) text += "plugin " + detail::sha256_of_file(plugin.string()) + "\n";
  const auto& [i, j, k] = lattice.points;
  text += detail::text("%d x %d x %d places from %.17g %.17g %.17g m, %.17g m apart\n", i, j, k, lattice.low_m.x,
                       lattice.low_m.y, lattice.low_m.z, lattice.spacing_m);
  return text;
}

fs::path kept_map_file(const fs::path& map) { return fs::path(map) += ".part"; }

fs::path map_part_file(const fs::path& map, int part) { return fs::path(map) += ".part-" + std::to_string(part); }

std::vector<fs::path> map_part_files(const fs::path& map) {
  const std::string begin = map.filename().string() + ".part-";
  std::vector<std::pair<int, fs::path>> found;
  std::error_code error;
  for (fs::directory_iterator entry(map.has_parent_path() ? map.parent_path() : fs::path("."), error), end;
       !error && entry != end; entry.increment(error)) {
    const std::string name = entry->path().filename().string();
    if (!name.starts_with(begin)) continue;
    int part = 0;
    const auto [rest, problem] = std::from_chars(name.data() + begin.size(), name.data() + name.size(), part);
    if (problem == std::errc{} && rest == name.data() + name.size() && part > 0)
      found.emplace_back(part, map_part_file(map, part));
  }
  std::sort(found.begin(), found.end());
  std::vector<fs::path> files;
  for (auto& [part, file] : found) files.push_back(std::move(file));
  return files;
}

void keep_map(const ForceMap& map, const std::string& identity, const fs::path& file) {
  std::string bytes = header(identity);
  bytes.append(reinterpret_cast<const char*>(map.done.data()), map.done.size());
  for (int way = 0; way < map.lattice.ways(); ++way) {
    if (map.done[static_cast<std::size_t>(way)] == 0) continue;
    const int i = way % map.lattice.points[0], j = way / map.lattice.points[0];
    for (int k = 0; k < map.lattice.points[2]; ++k) {
      const Kept numbers = kept(map.points[map.lattice.number(i, j, k)]);
      bytes.append(reinterpret_cast<const char*>(numbers.data()), sizeof numbers);
    }
  }
  detail::write_whole(file, bytes, detail::Existing::replaced);
}

KeptMap take_kept_map(ForceMap& map, const std::string& identity, const fs::path& path) {
  const detail::InputFile file(path);
  if (file.why_not() == detail::NoInput::missing) return KeptMap::none;
  constexpr const char* right = "name the map otherwise, or move this away";
  file.expect_open(right);
  std::string begin(magic.size(), '\0');
  if (file.read(0, begin.data(), begin.size()) != begin.size() || begin != magic)
    throw LoadError(path.string() + ": exists already and is not a partial map; " + right);
  const std::string expected = header(identity);
  const std::size_t way_bytes = sizeof(Kept) * static_cast<std::size_t>(map.lattice.points[2]);
  const std::uint64_t most = expected.size() + map.done.size() + map.done.size() * way_bytes;
  if (file.bytes() > most || file.bytes() < expected.size() + map.done.size()) return KeptMap::another;
  std::string bytes(static_cast<std::size_t>(file.bytes()), '\0');
  if (file.read(0, bytes.data(), bytes.size()) != bytes.size() || !bytes.starts_with(expected)) return KeptMap::another;
  const char* next = bytes.data() + expected.size();
  const std::vector<std::uint8_t> done(next, next + map.done.size());
  next += done.size();
  const auto ways = static_cast<std::size_t>(std::count(done.begin(), done.end(), 1));
  if (std::any_of(done.begin(), done.end(), [](std::uint8_t flag) { return flag > 1; }) ||
      static_cast<std::size_t>(bytes.data() + bytes.size() - next) != ways * way_bytes)
    return KeptMap::another;
  for (int way = 0; way < map.lattice.ways(); ++way) {
    if (done[static_cast<std::size_t>(way)] == 0) continue;
    const int i = way % map.lattice.points[0], j = way / map.lattice.points[0];
    for (int k = 0; k < map.lattice.points[2]; ++k) {
      Kept numbers;
      std::memcpy(numbers.data(), next, sizeof numbers);
      next += sizeof numbers;
      map.points[map.lattice.number(i, j, k)] = point_of(numbers);
    }
  }
  for (std::size_t way = 0; way < done.size(); ++way) map.done[way] |= done[way];
  return KeptMap::taken;
}

void write_map(const ForceMap& map, const Similarity& hand_to_world, const fs::path& file, detail::Existing existing) {
  WrittenVolume volume;
  const MapLattice& lattice = map.lattice;
  for (std::size_t a = 0; a < 3; ++a) volume.grid.dims[a] = lattice.points[a];
  volume.grid.index_to_world_m = (hand_to_world.scale * lattice.spacing_m) * hand_to_world.rotation;
  volume.grid.origin_m = hand_to_world.to_world(lattice.low_m);
  const std::size_t slice = static_cast<std::size_t>(lattice.points[0]) * static_cast<std::size_t>(lattice.points[1]);
  const auto add = [&](const char* name, const char* unit, VoxelType type, int components, const auto& put) {
    volume.fields.push_back({name, unit, type, components, [&map, slice, put](std::int64_t k, double* to) {
                               const MapPoint* const first = map.points.data() + static_cast<std::size_t>(k) * slice;
                               for (const MapPoint* point = first; point != first + slice; ++point) to = put(*point, to);
                             }});
  };
  const auto force = [&hand_to_world](Vec3 MapPoint::* member) {
    return [&hand_to_world, member](const MapPoint& point, double* to) {
      const Vec3 world_n = hand_to_world.turned_to_world(point.*member);
      to[0] = world_n.x, to[1] = world_n.y, to[2] = world_n.z;
      return to + 3;
    };
  };
  add("first_contact_n", "N", VoxelType::float32, 3, force(&MapPoint::first_contact_n));
  add("steady_n", "N", VoxelType::float32, 3, force(&MapPoint::steady_n));
  add("proxy_distance_m", "m", VoxelType::float32, 1,
      [](const MapPoint& point, double* to) { return *to = point.proxy_distance_m, to + 1; });
  add("broken_levels", "", VoxelType::uint8, 1,
      [](const MapPoint& point, double* to) { return *to = std::min(point.broken_levels, 255), to + 1; });
  add("settled", "", VoxelType::uint8, 1, [](const MapPoint& point, double* to) { return *to = !point.unsettled, to + 1; });
  write_volume(volume, file, existing);
}

}  // namespace palpa
