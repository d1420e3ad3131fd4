#include "store.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <mutex>

#include "interruptible.h"
#include "palpa/data/grid_base.h"
#include "palpa/file/derive_store.h"
#include "palpa/file/prepare_store.h"
#include "palpa/file/unit_walk.h"

namespace palpa::python {
namespace {

namespace fs = std::filesystem;
using detail::VoxelIndex;

constexpr int slots = 16;  // chunks ahead. More: memory; fewer: the reader pauses

/// Open store for Python. Any thread: calls take turns.
class PythonStore {
 public:
  explicit PythonStore(const fs::path& path) : path_(path), reader_(path, {}, slots), chunks_(reader_, [] { return true; }) {}

  py::dict contents() const {
    const StoreContents& c = reader_.contents();
    py::list fields, octaves;
    for (const StoreField& field : c.fields) {
      fields.append(py::dict(py::arg("name") = field.name, py::arg("unit") = field.unit, py::arg("dtype") = name_of(field.type),
                             py::arg("file_type") = field.file_type, py::arg("components") = field.components,
                             py::arg("fill") = field.fill));
    }
    for (const StoreOctave& octave : c.octaves) {
      const Mat3 columns = transposed(octave.grid.index_to_world_m);
      const Vec3& o = octave.grid.origin_m;
      octaves.append(py::dict(
          py::arg("dims") = py::tuple(py::cast(octave.grid.dims)), py::arg("chunk") = py::tuple(py::cast(octave.chunk)),
          py::arg("shard") = py::tuple(py::cast(octave.shard)), py::arg("codec") = octave.codec,
          py::arg("spacing_m") = py::make_tuple(norm(columns.row[0]), norm(columns.row[1]), norm(columns.row[2])),
          py::arg("origin_m") = py::make_tuple(o.x, o.y, o.z)));
    }
    return py::dict(py::arg("format") = c.format, py::arg("length_unit") = c.length_unit, py::arg("fields") = fields,
                    py::arg("octaves") = octaves, py::arg("frames") = c.frames, py::arg("period_s") = c.period_s,
                    py::arg("prepared") = c.prepared, py::arg("warnings") = c.warnings);
  }

  /// Voxels from the first to before the end, indexed [k, j, i], of a vector [k, j, i, component].
  py::array read(int octave, const VoxelIndex& first, const VoxelIndex& end, int frame, int field) {
    const StoreContents& c = reader_.contents();
    if (octave < 0 || octave >= static_cast<int>(c.octaves.size()))
      throw py::index_error("no octave " + std::to_string(octave) + "; they go from 0 to " +
                            std::to_string(c.octaves.size() - 1));
    if (frame < 0 || frame >= c.frames)
      throw py::index_error("no frame " + std::to_string(frame) + "; they go from 0 to " + std::to_string(c.frames - 1));
    if (field < 0 || field >= static_cast<int>(c.fields.size()))
      throw py::index_error("no field " + std::to_string(field) + "; they go from 0 to " + std::to_string(c.fields.size() - 1));
    const StoreOctave& of = c.octaves[static_cast<std::size_t>(octave)];
    VoxelIndex size{};
    for (std::size_t a = 0; a < 3; ++a) {
      size[a] = end[a] - first[a];
      if (first[a] < 0 || size[a] < 1 || end[a] > of.grid.dims[a]) {
        throw py::index_error("no voxels " + std::to_string(first[a]) + " to " + std::to_string(end[a]) + " along " + "ijk"[a] +
                              " of octave " + std::to_string(octave) + "; it has " + std::to_string(of.grid.dims[a]));
      }
    }
    const StoreField& kind = c.fields[static_cast<std::size_t>(field)];
    std::vector<py::ssize_t> shape{size[2], size[1], size[0]};
    if (kind.components > 1) shape.push_back(kind.components);
    py::array array(py::dtype(name_of(kind.type)), shape);
    auto* const to = static_cast<std::byte*>(array.mutable_data());
    {
      const py::gil_scoped_release release;
      copy(octave, frame, field, first, end, to);
    }
    return array;
  }

 private:
  void copy(int octave, int frame, int field, const VoxelIndex& first, const VoxelIndex& end, std::byte* to) {
    const std::lock_guard lock(mutex_);
    const StoreOctave& of = reader_.contents().octaves[static_cast<std::size_t>(octave)];
    const StoreField& kind = reader_.contents().fields[static_cast<std::size_t>(field)];
    const std::size_t bytes = size_of(kind.type) * static_cast<std::size_t>(kind.components);
    VoxelIndex size{}, from{}, behind{};
    for (std::size_t a = 0; a < 3; ++a)
      size[a] = end[a] - first[a], from[a] = first[a] / of.chunk[a], behind[a] = (end[a] + of.chunk[a] - 1) / of.chunk[a];
    std::vector<StoreChunk> order;
    detail::for_each_index(from, behind, [&](const VoxelIndex& at) {
      order.push_back({.octave = octave, .frame = frame, .field = field, .at = at});
    });
    std::string damaged;
    chunks_.follow(order);
    for (const StoreChunk& chunk : order) {
      chunks_.take([&](const StoreRead& read, std::span<const std::byte> content) {
        if (read.state == ChunkState::damaged && damaged.empty()) damaged = path_.string() + ": " + read.sentence;
        std::vector<std::byte> fill;
        if (read.state != ChunkState::present) {
          fill = detail::filled_chunk(kind, of.chunk);
          content = fill;
        }
        VoxelIndex low{}, at{}, count{};
        for (std::size_t a = 0; a < 3; ++a) {
          const std::int64_t begin = chunk.at[a] * of.chunk[a];
          const std::int64_t one = std::max(begin, first[a]), other = std::min(begin + of.chunk[a], end[a]);
          low[a] = one - begin, at[a] = one - first[a], count[a] = other - one;
        }
        detail::copy_voxels(bytes, content.data(), of.chunk, low, to, size, at, count);
      });
    }
    if (!damaged.empty()) throw LoadError(damaged);
  }

  fs::path path_;
  std::mutex mutex_;
  StoreReader reader_;
  detail::ChunkStream chunks_;
};

py::dict prepare(const fs::path& store, const py::object& part, const py::object& into, int threads, bool check,
                 const std::string& derive) {
  PrepareOptions options;
  if (!part.is_none()) {
    const auto [number, of] = part.cast<std::pair<int, int>>();
    options.part = work_part(std::to_string(number) + "/" + std::to_string(of));
    options.is_one_part = true;
  }
  if (!into.is_none()) options.into = into.cast<fs::path>();
  options.threads = threads;
  const PreparedStore made = interruptible([&](const std::atomic<bool>& stop, std::stop_token token) {
    options.stop = &stop;
    options.read.stop = std::move(token);
    if (derive.empty()) return check ? check_prepared_store(store, options) : prepare_store(store, options);
    const DerivedArray array = derived_array(derive);
    return check ? check_prepared_store(derived_store(store, name_of(array)), options) : derive_store(store, array, options);
  });
  return py::dict(py::arg("units") = made.units, py::arg("units_done_before") = made.units_before,
                  py::arg("units_missing") = made.units_missing, py::arg("first_octave") = made.first_octave,
                  py::arg("last_octave") = made.last_octave, py::arg("chunks_written") = made.chunks_written,
                  py::arg("voxels") = made.voxels, py::arg("seconds") = made.seconds, py::arg("finished") = made.is_finished,
                  py::arg("wrong") = made.wrong, py::arg("wrong_chunks") = made.wrong_chunks);
}

}  // namespace

void bind_store(py::module_& module) {
  module.def("prepare_store", &prepare);
  py::class_<PythonStore>(module, "StoreOfChunks")
      .def(py::init<const fs::path&>())
      .def("contents", &PythonStore::contents)
      .def("read", &PythonStore::read);
}

}  // namespace palpa::python
