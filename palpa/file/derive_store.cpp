#include "palpa/file/derive_store.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "palpa/base/load_error.h"
#include "palpa/base/web_address.h"
#include "palpa/base/wording.h"
#include "palpa/data/smooth_grid.h"
#include "palpa/file/fetch_process.h"
#include "palpa/file/protocol_voxels.h"
#include "palpa/file/store_protocol.h"
#include "palpa/file/store_voxels.h"
#include "palpa/file/store_writer.h"

namespace palpa {
namespace {

namespace fs = std::filesystem;
using Index = std::array<std::int64_t, 3>;

constexpr std::array writable{Derivation::curl, Derivation::divergence, Derivation::gradient_magnitude, Derivation::q,
                              Derivation::lambda2};
// [voxels] Rows derived at once, counted from the first row. More: more memory; fewer: more voxels are read and smoothed twice.
constexpr std::int64_t rows_at_once = 64;
constexpr std::uint64_t cache_bytes = 256'000'000;
constexpr int slots = 64;

/// Voxels around one that its derived value depends on: the support of the Gaussian that `derived` smooths with, of two least
/// distances of planes and cut off at four deviations, and a neighbour for the difference.
Index halo_of(Derivation derivation, const GridGeometry& grid) {
  const bool smooths = derivation == Derivation::q || derivation == Derivation::lambda2;
  const Mat3 steps = transposed(grid.index_to_world_m);
  const double lengths_m[] = {norm(steps.row[0]), norm(steps.row[1]), norm(steps.row[2])};
  const double least_m = *std::min_element(std::begin(lengths_m), std::end(lengths_m));
  Index halo{};
  for (std::size_t a = 0; a < 3; ++a)
    halo[a] = 1 + (smooths ? static_cast<std::int64_t>(std::ceil(8.0 * least_m / lengths_m[a] + 1e-9)) : 0);
  return halo;
}

/// Derived values of one field of a store, by boxes.
class DerivedRows {
 public:
  DerivedRows(Derivation derivation, std::int32_t field, std::unique_ptr<StoreReader> reader)
      : derivation_(derivation),
        of_(reader->contents().fields[static_cast<std::size_t>(field)]),
        grid_(reader->contents().octaves.front().grid),
        halo_(halo_of(derivation, grid_)),
        voxels_(std::make_shared<detail::StoreCache>("the store", std::move(reader), detail::StoreCache::Open{}, cache_bytes),
                field, 0) {}

  const GridGeometry& grid() const noexcept { return grid_; }

  void read(const SliceRows& range, std::byte* to) {
    const std::int64_t end = range.first_row + range.rows;
    for (std::int64_t j = range.first_row; j < end; j = (j / rows_at_once + 1) * rows_at_once) {
      SliceRows block = range;
      block.first_row = j, block.rows = std::min((j / rows_at_once + 1) * rows_at_once, end) - j;
      derive(block, range, reinterpret_cast<float*>(to));
    }
  }

 private:
  /// Writes a block's values to their places in those of `whole`.
  void derive(const SliceRows& block, const SliceRows& whole, float* to) {
    const Index first{0, block.first_row, block.first_slice},
        last{grid_.dims[0], first[1] + block.rows, first[2] + block.slices};
    Index low{}, high{};
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = std::max<std::int64_t>(first[a] - halo_[a], 0);
      high[a] = std::min(last[a] + halo_[a], grid_.dims[a]);
    }
    GridGeometry box = grid_;
    box.dims = {high[0] - low[0], high[1] - low[1], high[2] - low[2]};
    box.origin_m = grid_.to_world({0.0, static_cast<double>(low[1]), static_cast<double>(low[2])});
    const auto room =
        std::make_shared<std::vector<std::byte>>(static_cast<std::size_t>(box.voxels() * of_.components) * size_of(of_.type));
    if (!voxels_.read(0, low, box.dims, room->data()))
      throw LoadError("octave 0 of the store has a lost or damaged chunk at voxel " + std::to_string(first[0]) + ", " +
                      std::to_string(first[1]) + ", " + std::to_string(first[2]) +
                      " or near it; palpa prepare --check names it");
    const FieldPtr field = grid_field(box, {of_.type, of_.components, {room, room->data()}});
    const FieldPtr made = derived(derivation_, field);
    const GridView& view = *smooth_grid_of(*made);
    const auto* const values = static_cast<const float*>(view.voxels.data.get());
    const std::int64_t row = box.dims[0] * view.voxels.components;
    for (std::int64_t k = first[2]; k < last[2]; ++k)
      for (std::int64_t j = first[1]; j < last[1]; ++j) {
        const float* const from = values + ((k - low[2]) * box.dims[1] + j - low[1]) * row;
        float* const out = to + ((k - whole.first_slice) * whole.rows + j - whole.first_row) * row;
        for (std::int64_t n = 0; n < row; ++n) out[n] = static_cast<float>(from[n] * view.scale + view.offset);
      }
  }

  Derivation derivation_;
  StoreField of_;
  GridGeometry grid_;
  Index halo_;
  detail::StoreVoxels voxels_;
};

std::int32_t field_named(const StoreContents& contents, const DerivedArray& array) {
  std::vector<std::string> names;
  for (const StoreField& field : contents.fields) names.push_back(field.name);
  const auto found = std::ranges::find(names, array.of);
  if (found == names.end())
    throw LoadError("has no field " + detail::in_quotes(array.of) + "; " + detail::suggestion(array.of, names));
  const auto number = static_cast<std::size_t>(found - names.begin());
  if (contents.fields[number].components != components_taken(array.derivation))
    throw LoadError("has field " + detail::in_quotes(array.of) + " of " +
                    (contents.fields[number].components == 1 ? "single values" : "vectors") + ", and " +
                    name_of(array.derivation) + " is made from " +
                    (components_taken(array.derivation) == 1 ? "single values" : "vectors") + "; name another field");
  if (contents.frames > 1)
    throw LoadError("has " + std::to_string(contents.frames) +
                    " frames, and fields are derived of one; write it as a store of one frame (palpa convert)");
  return static_cast<std::int32_t>(number);
}

void write_derived(const fs::path& store, const DerivedArray& array, const PrepareOptions& options) {
  auto reader = std::make_unique<StoreReader>(store, options.read, slots);
  const std::int32_t number = field_named(reader->contents(), array);
  const StoreField& of = reader->contents().fields[static_cast<std::size_t>(number)];
  WrittenVolume volume;
  volume.length_unit = reader->contents().length_unit;
  WrittenField field{.name = name_of(array), .unit = unit_of(array.derivation, of.unit), .type = VoxelType::float32};
  field.components = components_given(array.derivation);
  DerivedRows rows(array.derivation, number, std::move(reader));
  volume.grid = rows.grid();
  field.rows = [&](const SliceRows& range, std::byte* to) {
    if (options.stop && *options.stop) throw LoadError("interrupted");
    rows.read(range, to);
  };
  field.rows_at_once = rows_at_once;
  volume.fields.push_back(std::move(field));
  write_store(volume, derived_store(store, name_of(array)),
              {.part = options.part, .shares_store = true, .keeps_rows = true, .progress = options.progress});
}

}  // namespace

DerivedArray derived_array(const std::string& text) {
  const std::size_t equals = text.find('=');
  const auto derivation = derivation_named(std::string_view(text).substr(0, equals));
  const bool is_writable = derivation && std::ranges::find(writable, *derivation) != writable.end();
  if (!is_writable || equals == std::string::npos || equals + 1 == text.size())
    throw LoadError("--derive " + detail::one_line(text) +
                    ": is no derived field that can be written; give curl, divergence, gradient_magnitude, q or lambda2 and a "
                    "field, as in q=velocity");
  return {*derivation, text.substr(equals + 1)};
}

fs::path derived_store(const fs::path& store, const std::string& name) { return store / "palpa" / "derived" / name; }

std::vector<std::string> derived_names(const fs::path& store) {
  std::vector<std::string> names;
  std::error_code problem;
  if (is_web_address(store) || !protocol::is_store(store)) return names;
  for (fs::directory_iterator entry(store / "palpa" / "derived", problem), end; !problem && entry != end;
       entry.increment(problem)) {
    if (fs::is_regular_file(entry->path() / ".zattrs", problem) || fs::is_regular_file(entry->path() / "zarr.json", problem))
      names.push_back(entry->path().filename().string());
    problem.clear();
  }
  std::ranges::sort(names);
  return names;
}

PreparedStore derive_store(const fs::path& store, const DerivedArray& array, const PrepareOptions& options) {
  detail::refuse_web_address(store, "palpa prepare");
  const fs::path made = derived_store(store, name_of(array));
  try {
    if (!options.into.empty()) throw LoadError("--into: derived fields lie within their store; leave it out");
    std::error_code none;
    if (!fs::exists(made / "palpa", none)) write_derived(store, array, options);  // its preparation begins with all rows
  } catch (const LoadError& error) {
    const std::string problem = error.what();
    throw LoadError(problem.starts_with(store.string()) ? problem : store.string() + ": " + problem);
  } catch (const std::invalid_argument& error) {
    throw LoadError(store.string() + ": " + error.what());
  }
  if (options.is_one_part) return {};
  return prepare_store(made, options);
}

}  // namespace palpa
