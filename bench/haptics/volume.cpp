#include "bench/haptics/volume.h"

#include <cstdio>
#include <cstring>
#include <sstream>

#include "palpa/base/input_file.h"
#include "palpa/base/load_error.h"
#include "palpa/base/new_file.h"

namespace palpa::haptics {

namespace {

template <class Number>
std::string bytes_of(const std::vector<float>& samples) {
  std::string bytes(samples.size() * sizeof(Number), '\0');
  for (std::size_t i = 0; i < samples.size(); ++i) {
    const Number number = static_cast<Number>(samples[i]);
    std::memcpy(bytes.data() + i * sizeof(Number), &number, sizeof(Number));
  }
  return bytes;
}

template <class Number>
void from_bytes(const std::string& bytes, std::size_t first, std::vector<float>& samples) {
  for (std::size_t i = 0; i < samples.size(); ++i) {
    Number number;
    std::memcpy(&number, bytes.data() + first + i * sizeof(Number), sizeof(Number));
    samples[i] = static_cast<float>(number);
  }
}

struct Type {
  const char* name;
  const char* in_nrrd;
  std::size_t bytes;
  std::string (*write)(const std::vector<float>&);
  void (*read)(const std::string&, std::size_t, std::vector<float>&);
};
constexpr Type types[] = {{"uint8", "uint8", 1, bytes_of<std::uint8_t>, from_bytes<std::uint8_t>},
                          {"uint16", "uint16", 2, bytes_of<std::uint16_t>, from_bytes<std::uint16_t>},
                          {"int16", "int16", 2, bytes_of<std::int16_t>, from_bytes<std::int16_t>},
                          {"float32", "float", 4, bytes_of<float>, from_bytes<float>}};

/// The cell around a point: eight samples with their weights.
struct Cell {
  std::array<int, 3> low{};
  std::array<double, 3> share{};  // [1] of the way to the next sample
  bool inside = false;
};
Cell cell_of(const SampledGrid& grid, const Vec3& x_m) {
  const Vec3 from = x_m - grid.origin_m;
  const std::array<double, 3> at{from.x / grid.spacing_m.x, from.y / grid.spacing_m.y, from.z / grid.spacing_m.z};
  Cell cell;
  for (std::size_t a = 0; a < 3; ++a) {
    if (!(at[a] >= 0.0 && at[a] <= grid.size[a] - 1)) return cell;
    cell.low[a] = std::min(static_cast<int>(at[a]), grid.size[a] - 2);
    cell.share[a] = at[a] - cell.low[a];
  }
  cell.inside = true;
  return cell;
}

/// Weighted mean of `of` over the cell's eight samples.
template <class Of>
auto blended(const Cell& cell, Of of) {
  decltype(of(0, 0, 0)) sum{};
  for (int corner = 0; corner < 8; ++corner) {
    double weight = 1.0;
    std::array<int, 3> index{};
    for (std::size_t a = 0; a < 3; ++a) {
      const int upper = corner >> a & 1;
      index[a] = cell.low[a] + upper;
      weight *= upper ? cell.share[a] : 1.0 - cell.share[a];
    }
    sum += weight * of(index[0], index[1], index[2]);
  }
  return sum;
}

}  // namespace

SampledGrid cube(int samples, double edge_m) {
  const double spacing_m = edge_m / samples, first_m = -0.5 * (samples - 1) * spacing_m;
  return {{samples, samples, samples}, {spacing_m, spacing_m, spacing_m}, {first_m, first_m, first_m}};
}

bool SampledVolume::holds(const Vec3& x_m) const { return cell_of(grid, x_m).inside; }

double SampledVolume::value(const Vec3& x_m) const {
  const Cell cell = cell_of(grid, x_m);
  if (!cell.inside) return 0.0;
  return blended(cell, [&](int i, int j, int k) {
    return static_cast<double>(samples[(static_cast<std::size_t>(k) * grid.size[1] + j) * grid.size[0] + i]);
  });
}

Vec3 SampledVolume::slope_per_m(const Vec3& x_m) const {
  const Cell cell = cell_of(grid, x_m);
  if (!cell.inside) return {};
  const auto at = [&](int i, int j, int k) {
    return static_cast<double>(samples[(static_cast<std::size_t>(k) * grid.size[1] + j) * grid.size[0] + i]);
  };
  return blended(cell, [&](int i, int j, int k) {
    const auto low = [](int n) { return std::max(n - 1, 0); };
    const auto high = [](int n, int size) { return std::min(n + 1, size - 1); };
    const int i0 = low(i), i1 = high(i, grid.size[0]), j0 = low(j), j1 = high(j, grid.size[1]), k0 = low(k),
              k1 = high(k, grid.size[2]);
    return Vec3{(at(i1, j, k) - at(i0, j, k)) / ((i1 - i0) * grid.spacing_m.x),
                (at(i, j1, k) - at(i, j0, k)) / ((j1 - j0) * grid.spacing_m.y),
                (at(i, j, k1) - at(i, j, k0)) / ((k1 - k0) * grid.spacing_m.z)};
  });
}

std::size_t write_nrrd(const SampledVolume& volume, const std::filesystem::path& file) {
  const Type* type = nullptr;
  for (const Type& known : types) type = volume.type == known.name ? &known : type;
  const bool vectors = volume.components == 3;
  const SampledGrid& grid = volume.grid;
  char size[64], directions[160], origin[120];
  std::snprintf(size, sizeof size, "%s%d %d %d", vectors ? "3 " : "", grid.size[0], grid.size[1], grid.size[2]);
  std::snprintf(directions, sizeof directions, "%s(%.9g,0,0) (0,%.9g,0) (0,0,%.9g)", vectors ? "none " : "",
                1e3 * grid.spacing_m.x, 1e3 * grid.spacing_m.y, 1e3 * grid.spacing_m.z);
  std::snprintf(origin, sizeof origin, "(%.9g,%.9g,%.9g)", 1e3 * grid.origin_m.x, 1e3 * grid.origin_m.y, 1e3 * grid.origin_m.z);
  std::string header = std::string("NRRD0004\n# of the benchmark of volume haptics; lengths in mm\ntype: ") + type->in_nrrd +
                       "\ndimension: " + (vectors ? "4" : "3") + "\nspace dimension: 3\nsizes: " + size +
                       "\nspace directions: " + directions + "\nspace origin: " + origin +
                       "\nspace units: \"mm\" \"mm\" \"mm\"\nkinds: " + (vectors ? "vector " : "") +
                       "domain domain domain\nendian: little\nencoding: raw\n\n";
  const std::size_t first = header.size();
  detail::write_whole(file, header + type->write(volume.samples), detail::Existing::replaced);
  return first;
}

SampledVolume read_nrrd(const std::filesystem::path& file) {
  const detail::InputFile input(file);
  input.expect_open("make the benchmark's data anew");
  std::string bytes(input.bytes(), '\0');
  input.read(0, bytes.data(), bytes.size());
  const std::size_t end = bytes.find("\n\n");
  SampledVolume volume;
  const Type* type = nullptr;
  std::istringstream lines(bytes.substr(0, end));
  for (std::string line; std::getline(lines, line);) {
    for (const Type& known : types) {
      if (line == std::string("type: ") + known.in_nrrd) type = &known;
    }
    auto& size = volume.grid.size;
    std::sscanf(line.c_str(), "sizes: %d %d %d", &size[0], &size[1], &size[2]);
    Vec3 mm;
    if (std::sscanf(line.c_str(), "space directions: (%lf,0,0) (0,%lf,0) (0,0,%lf)", &mm.x, &mm.y, &mm.z) == 3)
      volume.grid.spacing_m = 1e-3 * mm;
    if (std::sscanf(line.c_str(), "space origin: (%lf,%lf,%lf)", &mm.x, &mm.y, &mm.z) == 3) volume.grid.origin_m = 1e-3 * mm;
  }
  if (end == std::string::npos || !type || bytes.size() != end + 2 + volume.grid.samples() * type->bytes)
    throw LoadError(file.string() + ": is no whole volume of scalars; make the benchmark's data anew");
  volume.type = type->name;
  volume.samples.resize(volume.grid.samples());
  type->read(bytes, end + 2, volume.samples);
  return volume;
}

double Noise::next() {
  double sum = 0.0;
  for (int i = 0; i < 12; ++i) {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    sum += static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
  }
  return sum - 6.0;
}

}  // namespace palpa::haptics
