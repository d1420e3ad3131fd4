#include "palpa/file/convert.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "palpa/data/volume.h"
#include "palpa/file/fetch_process.h"
#include "palpa/file/protocol_voxels.h"
#include "palpa/file/sliced_file.h"
#include "palpa/file/store_writer.h"
#include "palpa/file/write_volume.h"

namespace palpa {
namespace {

/// Field on its grid during conversion: positions of its voxels, and the values of a slice.
struct Step {
  GridGeometry grid;
  std::function<void(std::int64_t k, double* values)> slice;
  bool computed = false;  ///< values differ from all voxels
};

/// Field to convert: voxels in memory, or rows of a file.
struct Converted {
  SlicedFile::Field of;
  const VolumeField* field = nullptr;  ///< in memory
  const std::byte* voxels = nullptr;   ///< in memory
  std::function<void(const SliceRows&, std::byte*)> rows{};
  std::int64_t rows_at_once = 1;  ///< [voxels] along j
};

/// Field in memory; without voxels, if it has none of its own.
Converted in_memory(const VolumeField& field) {
  const GridView* view = grid_of(*field.field);
  if (!view) return {{field.name, field.unit}, &field};
  const Voxels& voxels = view->voxels;
  return {{field.name, field.unit, view->geometry, voxels.type, voxels.components, view->scale, view->offset},
          &field,
          static_cast<const std::byte*>(voxels.data.get())};
}

Step of_voxels(const Converted& from) {
  const auto slice = [from, room = std::vector<std::byte>()](std::int64_t k, double* values) mutable {
    const SlicedFile::Field& of = from.of;
    const std::int64_t count = of.grid.dims[0] * of.grid.dims[1] * of.components;
    const std::size_t bytes = static_cast<std::size_t>(count) * size_of(of.type);
    const std::byte* first = from.voxels + static_cast<std::size_t>(k) * bytes;
    if (from.rows) {
      room.resize(bytes);
      from.rows({k, 1, 0, of.grid.dims[1]}, room.data());
      first = room.data();
    }
    protocol::with_type(of.type, [&](auto number) {
      const auto* const voxels = reinterpret_cast<const decltype(number)*>(first);
      for (std::int64_t n = 0; n < count; ++n) values[n] = static_cast<double>(voxels[n]) * of.scale + of.offset;
    });
  };
  return {from.of.grid, slice, false};
}

Step cropped(const Step& whole, const VoxelRange& part, int components) {
  Step step{whole.grid, {}, whole.computed};
  for (std::size_t a = 0; a < 3; ++a) {
    if (part.first[a] < 0 || part.last[a] < part.first[a] || part.last[a] >= whole.grid.dims[a]) {
      throw LoadError("has no voxels " + std::to_string(part.first[a]) + " to " + std::to_string(part.last[a]) + " along " +
                      "ijk"[a] + "; they go from 0 to " + std::to_string(whole.grid.dims[a] - 1));
    }
    step.grid.dims[a] = part.last[a] - part.first[a] + 1;
  }
  step.grid.origin_m = whole.grid.to_world(
      {static_cast<double>(part.first[0]), static_cast<double>(part.first[1]), static_cast<double>(part.first[2])});
  step.slice = [whole, part, dims = step.grid.dims, components, all = std::vector<double>()](std::int64_t k,
                                                                                             double* values) mutable {
    all.resize(static_cast<std::size_t>(whole.grid.dims[0] * whole.grid.dims[1] * components));
    whole.slice(part.first[2] + k, all.data());
    for (std::int64_t j = 0; j < dims[1]; ++j) {
      const double* from = all.data() + ((part.first[1] + j) * whole.grid.dims[0] + part.first[0]) * components;
      values = std::copy_n(from, dims[0] * components, values);
    }
  };
  return step;
}

Step downsampled(const Step& fine, int factor, int components) {
  Step step{fine.grid, {}, true};
  std::array<std::int64_t, 3> block{};
  Vec3 shift;
  double* shifts[] = {&shift.x, &shift.y, &shift.z};
  double factors[3];
  for (std::size_t a = 0; a < 3; ++a) {
    block[a] = std::min<std::int64_t>(factor, fine.grid.dims[a]);
    step.grid.dims[a] = fine.grid.dims[a] / block[a];
    factors[a] = static_cast<double>(block[a]);
    *shifts[a] = 0.5 * (factors[a] - 1.0);
  }
  for (Vec3& row : step.grid.index_to_world_m.row) row = {row.x * factors[0], row.y * factors[1], row.z * factors[2]};
  step.grid.origin_m = fine.grid.to_world({shift.x, shift.y, shift.z});
  step.slice = [fine, block, dims = step.grid.dims, components, all = std::vector<double>()](std::int64_t k,
                                                                                             double* values) mutable {
    const std::int64_t count = dims[0] * dims[1] * components, width = fine.grid.dims[0];
    std::vector<double> found(static_cast<std::size_t>(count), 0.0);
    all.resize(static_cast<std::size_t>(width * fine.grid.dims[1] * components));
    std::fill_n(values, count, 0.0);
    for (std::int64_t s = 0; s < block[2]; ++s) {
      fine.slice(k * block[2] + s, all.data());
      for (std::int64_t j = 0; j < dims[1] * block[1]; ++j)
        for (std::int64_t i = 0; i < dims[0] * block[0]; ++i)
          for (int c = 0; c < components; ++c) {
            const double value = all[static_cast<std::size_t>((j * width + i) * components + c)];
            const std::int64_t to = (j / block[1] * dims[0] + i / block[0]) * components + c;
            if (std::isfinite(value)) values[to] += value, found[static_cast<std::size_t>(to)] += 1.0;
          }
    }
    for (std::int64_t n = 0; n < count; ++n) values[n] /= found[static_cast<std::size_t>(n)];  // of none: NaN
  };
  return step;
}

/// Resamples the current grid along the world's axes, which needs a field.
Step resampled(const Field& field, double spacing_m) {
  if (!(spacing_m > 0.0) || !std::isfinite(spacing_m))
    throw LoadError("cannot be resampled to cubes of that size; give metres above 0");
  const Box box = field.bounds_m();
  const Vec3 size_m = box.size_m();
  const double sides_m[] = {size_m.x, size_m.y, size_m.z};
  Step step{{}, {}, true};
  for (std::size_t a = 0; a < 3; ++a) {
    const double steps = std::floor(sides_m[a] / spacing_m + 1e-9);
    if (!(steps < 1e9)) throw LoadError("would have more than a billion voxels along one axis; take larger ones");
    step.grid.dims[a] = static_cast<std::int64_t>(steps) + 1;
  }
  step.grid.index_to_world_m = spacing_m * Mat3::identity();
  // The remainder beyond whole cubes is cut at both ends alike.
  step.grid.origin_m =
      box.centre_m() - 0.5 * spacing_m *
                           Vec3{static_cast<double>(step.grid.dims[0] - 1), static_cast<double>(step.grid.dims[1] - 1),
                                static_cast<double>(step.grid.dims[2] - 1)};
  step.slice = [&field, grid = step.grid, box](std::int64_t k, double* values) {
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    for (std::int64_t j = 0; j < grid.dims[1]; ++j)
      for (std::int64_t i = 0; i < grid.dims[0]; ++i) {
        const Vec3 at_m =
            detail::within(box, grid.to_world({static_cast<double>(i), static_cast<double>(j), static_cast<double>(k)}));
        if (field.components() == 1) {
          const ScalarSample s = field.scalar(at_m);
          *values++ = s.inside ? s.value : none;
        } else {
          const VectorSample s = field.vector(at_m);
          for (const double part : {s.value.x, s.value.y, s.value.z}) *values++ = s.inside ? part : none;
        }
      }
  };
  return step;
}

/// Type that keeps a field's values exactly.
VoxelType kept_type(const SlicedFile::Field& view, bool computed) {
  const VoxelType raw = view.type;
  const bool fractions = raw == VoxelType::float32 || raw == VoxelType::float64;
  if (!computed && view.scale == 1.0 && view.offset == 0.0) return raw;
  if (!computed && !fractions && view.scale == std::nearbyint(view.scale) && view.offset == std::nearbyint(view.offset)) {
    // Raw numbers of up to 16 bits, times a whole number: in 32 bits, if they fit.
    const double largest = (raw == VoxelType::int32 ? 2147483648.0 : 65536.0) * std::abs(view.scale) + std::abs(view.offset);
    if (largest < 2147483648.0) return VoxelType::int32;
  }
  return raw == VoxelType::float64 || raw == VoxelType::int32 ? VoxelType::float64 : VoxelType::float32;
}

/// Values as whole numbers of 16 bits; refuses a range or resolution beyond them.
Step as_int16(const Step& before, const VolumeField& field, int components) {
  for (const ValueRange& extent : field.field->value_ranges()) {
    if (extent.min < -32768.0 || extent.max > 32767.0) {
      throw LoadError("field '" + field.name + "' goes beyond 16 bits (-32768 to 32767); leave out --int16");
    }
  }
  double widest = 0.0;
  for (const ValueRange& extent : field.field->value_ranges()) widest = std::max(widest, extent.max - extent.min);
  if (widest < 256.0) {
    throw LoadError("field '" + field.name + "' would keep fewer than 256 values as whole numbers; leave out --int16");
  }
  Step step = before;
  step.slice = [before, count = before.grid.dims[0] * before.grid.dims[1] * components, name = field.name](std::int64_t k,
                                                                                                           double* values) {
    before.slice(k, values);
    for (std::int64_t n = 0; n < count; ++n) {
      if (!std::isfinite(values[n])) {
        throw LoadError("field '" + name +
                        "' has voxels without a value, which whole numbers cannot represent; leave out --int16");
      }
      values[n] = std::nearbyint(values[n]);
    }
  };
  return step;
}

WrittenField written(const Converted& from, const ConvertOptions& options, GridGeometry& grid, std::vector<FieldPtr>& kept) {
  if (!from.voxels && !from.rows)
    throw LoadError("field '" + from.of.name + "' has no voxels of its own to write; give a file of a grid");
  const bool on_new_grid = options.resample_m != 0.0 && !options.crop && options.downsample == 1;
  if (from.of.grid.is_rectilinear() && !on_new_grid) {
    throw LoadError(
        "field '" + from.of.name +
        "' lies on planes at uneven distances, which no format here stores; resample it (--resample-m M) without --crop");
  }
  const int components = from.of.components;
  Step step = of_voxels(from);
  if (options.crop) step = cropped(step, *options.crop, components);
  if (options.downsample > 1) step = downsampled(step, options.downsample, components);
  if (options.resample_m != 0.0) {
    FieldPtr source = from.field->field;
    if (options.crop || options.downsample > 1) {
      const auto count = static_cast<std::size_t>(step.grid.dims[0] * step.grid.dims[1] * components);
      const auto voxels = std::make_shared<std::vector<float>>();
      voxels->reserve(count * static_cast<std::size_t>(step.grid.dims[2]));
      std::vector<double> slice(count);
      for (std::int64_t k = 0; k < step.grid.dims[2]; ++k) {
        step.slice(k, slice.data());
        voxels->insert(voxels->end(), slice.begin(), slice.end());
      }
      source = grid_field(step.grid, {VoxelType::float32, components, {voxels, voxels->data()}});
    }
    kept.push_back(source);
    step = resampled(*source, options.resample_m);
  }
  VoxelType type = kept_type(from.of, step.computed);
  if (options.int16) step = as_int16(step, *from.field, components), type = VoxelType::int16;
  grid = step.grid;
  const bool as_it_is = !options.crop && !step.computed && !options.int16 && type == from.of.type && from.of.scale == 1.0 &&
                        from.of.offset == 0.0;
  WrittenField result{from.of.name, from.of.unit, type, components, step.slice};
  if (as_it_is) result.voxels = from.voxels, result.rows = from.rows, result.rows_at_once = from.rows_at_once;
  return result;
}

/// \param volume  facts of the volume; its fields are not looked at
std::vector<std::string> convert(const Volume& volume, const std::vector<Converted>& fields, const std::filesystem::path& out,
                                 const ConvertOptions& options) {
  detail::refuse_web_address(out, "palpa convert");
  if (options.downsample < 1)
    throw LoadError("downsample: " + std::to_string(options.downsample) + " voxels cannot become one; give 2 or more");
  WrittenVolume result;
  std::vector<std::string> lost;
  std::vector<FieldPtr> kept;
  std::string names;
  for (const Converted& field : fields) {
    names += (names.empty() ? "'" : ", '") + field.of.name + "'";
    if (!options.field.empty() && field.of.name != options.field) continue;
    GridGeometry grid;
    WrittenField next = written(field, options, grid, kept);
    if (result.fields.empty()) result.grid = grid;
    if (grid != result.grid) {
      lost.push_back("field '" + field.of.name + "' lies on another grid and is left out: convert it by itself (--field)");
      continue;
    }
    result.fields.push_back(std::move(next));
  }
  if (result.fields.empty()) throw LoadError("has no field '" + options.field + "'; it has " + names);
  const bool to_nifti = is_nifti(out);
  if (result.fields.size() > 1 && (to_nifti || out.extension() == ".nrrd" || out.extension() == ".nhdr")) {
    throw LoadError("has several fields (" + names + "), and " + (to_nifti ? "NIfTI" : "NRRD") +
                    " holds one; choose one with --field, or write .vti");
  }
  result.medical_frame = volume.medical_frame;
  result.length_unit = volume.medical_frame || volume.length_unit == "mm" ? "mm" : "m";
  if (to_nifti && !volume.medical_frame)
    lost.push_back("NIfTI has medical frames only: x, y and z are written as left, back and head of a patient");
  if (to_nifti && !result.fields.front().unit.empty())
    lost.push_back("NIfTI has no units: field '" + result.fields.front().name + "' is in " + result.fields.front().unit);
  if (is_store(out) && volume.medical_frame)
    lost.push_back("OME-Zarr has no medical frame: x to the patient's left, y to the back and z to the head are x, y and z");
  if (out.extension() == ".vti") {
    if (volume.medical_frame)
      lost.push_back("VTI has no medical frame: x to the patient's left, y to the back and z to the head are x, y and z");
    for (const WrittenField& field : result.fields) {
      if (!field.unit.empty()) lost.push_back("VTI has no units: field '" + field.name + "' is in " + field.unit);
    }
  }
  if (volume.frames > 1)
    lost.push_back("one of " + std::to_string(volume.frames) + " frames is written (frame = N takes another)");
  if (is_store(out)) {
    if (!volume.length_unit.empty()) result.length_unit = volume.length_unit;
    write_store(result, out,
                {.part = options.part,
                 .shares_store = options.shares_store,
                 .existing = options.existing,
                 .zarr = options.zarr,
                 .progress = options.progress});
  } else {
    write_volume(result, out, options.existing, options.progress);
  }
  if (options.written) options.written(result);
  return lost;
}

}  // namespace

std::vector<std::string> convert(const Volume& volume, const std::filesystem::path& out, const ConvertOptions& options) {
  std::vector<Converted> fields;
  for (const VolumeField& field : volume.fields) fields.push_back(in_memory(field));
  return convert(volume, fields, out, options);
}

std::vector<std::string> convert(SlicedFile& file, const std::filesystem::path& out, const ConvertOptions& options) {
  if (options.resample_m != 0.0 || options.int16)
    throw LoadError("cannot be resampled or rounded slice by slice; convert it in memory");
  std::vector<Converted> fields;
  for (std::size_t f = 0; f < file.fields.size(); ++f) {
    const auto rows = [&file, f](const SliceRows& range, std::byte* to) { file.read(f, range, to); };
    fields.push_back({file.fields[f], nullptr, nullptr, rows, file.rows_at_once()});
  }
  return convert(file.volume, fields, out, options);
}

}  // namespace palpa
