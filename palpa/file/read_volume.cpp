#include "palpa/file/read_volume.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <memory>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "palpa/base/free_memory.h"
#include "palpa/base/input_file.h"
#include "palpa/base/limits.h"
#include "palpa/base/printed.h"
#include "palpa/base/sanitized.h"
#include "palpa/base/web_address.h"
#include "palpa/base/wording.h"
#include "palpa/data/length_unit.h"
#include "palpa/data/volume.h"
#include "palpa/file/components.h"
#include "palpa/file/derive_store.h"
#include "palpa/file/fetch_process.h"
#include "palpa/file/late_checksums.h"
#include "palpa/file/protocol.h"
#include "palpa/file/protocol_packed.h"
#include "palpa/file/raw_file.h"
#include "palpa/file/reader_process.h"
#include "palpa/file/shared_memory.h"
#include "palpa/file/sliced_file.h"
#include "palpa/file/store_protocol.h"
#include "palpa/file/store_reader.h"
#include "palpa/file/store_volume.h"

namespace palpa {
namespace {

using detail::free_memory_bytes;
using protocol::FieldHeader;
using protocol::Header;
using protocol::readable_bytes;

/// Resident memory of a reader beyond its header's request, for libraries. More: a damaged file can take more; less: valid
/// files are refused.
constexpr std::uint64_t reader_slack_bytes = 2'000'000'000;

constexpr std::size_t most_files = 1'000'000;  ///< of one volume; an endless list is cut there

/// Refuses invalid files before a reader is started.
void check_file(const std::filesystem::path& path) {
  if (is_web_address(path)) return;
  const detail::InputFile file(path);
  if (file.why_not() == detail::NoInput::folder) return;
  if (!file.is_open()) throw LoadError(file.problem() + "; give a volume file that can be read");
  if (file.bytes() == 0) throw LoadError("is empty; get the whole file");
}

/// Bytes of a file, or of all files in a folder; 0 for a store, whose files are too many to be counted.
std::uint64_t bytes_of(const std::filesystem::path& file) {
  std::error_code problem;
  if (protocol::is_store(file)) return 0;
  if (!std::filesystem::is_directory(file, problem)) return std::filesystem::file_size(file);
  std::uint64_t bytes = 0;
  for (std::filesystem::recursive_directory_iterator entry(file, problem), end; !problem && entry != end;
       entry.increment(problem)) {
    std::error_code gone;
    if (entry->is_regular_file(gone)) bytes += entry->file_size(gone);
  }
  return bytes;
}

/// Error for an unknown unit of length. \param who  its source
LoadError unknown_unit(const std::string& who, const std::string& unit) {
  const std::vector<std::string> names(detail::proposed_length_units.begin(), detail::proposed_length_units.end());
  return LoadError(who + " '" + unit + "', which is unknown; give it by length_unit, in a scene or by --set length_unit=mm (" +
                   detail::joined(names) + " and others are known)");
}

/// Unit of length of a request; none if absent. Throws LoadError.
std::optional<detail::LengthUnit> asked_unit(const VolumeRequest& request) {
  if (request.length_unit.empty()) return std::nullopt;
  std::optional<detail::LengthUnit> unit = detail::length_unit(request.length_unit);
  if (!unit) throw unknown_unit("is asked for with length_unit", request.length_unit);
  return unit;
}

/// Metres per unit of length of the file, noted in `volume`.
double metres_per_unit(const VolumeRequest& request, const Header& header, Volume& volume) {
  const auto take = [&](const detail::LengthUnit& unit) {
    volume.length_unit = unit.name;
    return unit.metres;
  };
  const std::optional<detail::LengthUnit> stated = detail::length_unit(header.length_unit);
  if (const auto asked = asked_unit(request)) {
    if (stated && std::abs(stated->metres - asked->metres) > 1e-9 * asked->metres) {
      volume.warnings.push_back("has the unit of length '" + header.length_unit + "', in place of which length_unit = '" +
                                request.length_unit + "' is taken");
    }
    return take(*asked);
  }
  if (stated) return take(*stated);
  if (!detail::leaves_length_unit_open(header.length_unit)) throw unknown_unit("has the unit of length", header.length_unit);
  const auto assumed = detail::length_unit(header.default_unit);
  if (!assumed) throw LoadError("cannot be read: palpa-read gave no unit of length; update both programs together");
  volume.length_unit_assumed = true;
  volume.warnings.push_back(std::string("says no unit of length: ") +
                            (assumed->metres == 1      ? "metres"
                             : assumed->metres == 1e-6 ? "micrometres"
                                                       : "millimetres") +
                            " are taken (length_unit takes another, in a scene or by --set)");
  return take(*assumed);
}

GridGeometry in_metres(const GridGeometry& grid, double metres_per_unit) {
  return {grid.dims, metres_per_unit * grid.index_to_world_m, metres_per_unit * grid.origin_m, grid.planes};
}

/// Request to the reader. Lengths of a VolumeRequest are in metres, those of the file in its unit, known if the request names
/// it; formats with keys of length are in metres themselves.
protocol::Request as_asked(const VolumeRequest& request, std::uint64_t limit, Checksums checksums) {
  const PlaceInFile place = place_in_file(request.files.front());
  protocol::Request ask{place.file.string(), request.as, request.frame, limit};
  for (std::size_t f = 1; f < request.files.size(); ++f) ask.partners.push_back(request.files[f].string());
  const std::optional<detail::LengthUnit> said = asked_unit(request);
  const double unit_m = said ? said->metres : 1.0;
  ask.series = request.series, ask.components_along = request.components_along;
  ask.inside = place.inside;
  ask.layout = request.layout;
  ask.layout.spacing_m = request.layout.spacing_m / unit_m;
  if (request.layout.origin_m) ask.layout.origin_m = *request.layout.origin_m / unit_m;
  ask.time_s = request.time_s;
  ask.checksums = checksums;
  if (request.crop) ask.crop = Box{request.crop->low_m / unit_m, request.crop->high_m / unit_m};
  return ask;
}

/// Planes of a rectilinear grid, stored after the voxels.
void take_planes(GridGeometry& grid, const std::byte* after_voxels) {
  const auto* numbers = reinterpret_cast<const double*>(after_voxels);
  for (std::size_t a = 0; a < 3; ++a) {
    if (grid.planes[a].empty()) continue;
    grid.planes[a].assign(numbers, numbers + grid.dims[a]);
    numbers += grid.dims[a];
  }
}

/// Field requested from the file: one array, by index, or three components of vectors.
struct Taken {
  std::vector<std::uint32_t> arrays;
  std::string name, unit;
};

/// Finds an array by its name. Throws LoadError.
std::uint32_t array_named(const std::string& name, const Header& header) {
  std::uint32_t f = 0;
  while (f < header.fields.size() && header.fields[f].name != name) ++f;
  if (f < header.fields.size()) return f;
  std::string known;
  for (const FieldHeader& field : header.fields) known += (known.empty() ? "'" : ", '") + field.name + "'";
  throw LoadError("has no array '" + name + "'; it has " + known);
}

std::vector<Taken> taken_fields(const VolumeRequest& request, const Header& header) {
  std::vector<Taken> taken;
  if (request.fields.empty()) {
    for (std::uint32_t f = 0; f < header.fields.size(); ++f)
      taken.push_back({{f}, header.fields[f].name, header.fields[f].unit});
    return taken;
  }
  for (const VolumeRequest::FieldRequest& wanted : request.fields) {
    // A file without names holds one array: any name means it.
    const bool any = !header.named && header.fields.size() == 1 && wanted.array.empty() && wanted.arrays.empty();
    std::vector<std::uint32_t> arrays;
    for (const std::string& name : wanted.arrays) arrays.push_back(array_named(name, header));
    if (any) {
      arrays.push_back(0);
    } else if (arrays.empty()) {
      arrays.push_back(array_named(wanted.array.empty() ? wanted.name : wanted.array, header));
    }
    if (const char* problem = detail::problem_with_components(header, arrays)) {
      throw LoadError("cannot make a vector of '" + wanted.arrays[0] + "', '" + wanted.arrays[1] + "' and '" +
                      wanted.arrays[2] + "': " + problem);
    }
    if (arrays.size() > 1 && request.components_along == "index") {
      throw LoadError("has vectors in three arrays, which are taken along the axes of its space; leave components_along out");
    }
    taken.push_back({arrays, wanted.name, wanted.unit.empty() ? header.fields[arrays.front()].unit : wanted.unit});
  }
  return taken;
}

/// Validates the reader's header before use.
void check(const Header& header) {
  if (header.frames < 1) throw LoadError("claims to have no frame; the header is damaged");
  if (header.fields.empty()) throw LoadError("has no field that can be felt; give a volume of numbers");
  for (const FieldHeader& field : header.fields) {
    if (!protocol::voxel_bytes(field)) {
      throw LoadError("claims more voxels than can be counted; the header is damaged");
    }
    if (!std::isfinite(field.scale) || !std::isfinite(field.offset) || field.scale == 0) {
      throw LoadError("rescales its values by a factor that is zero or not finite; correct its header");
    }
  }
}

/// Sentence of a reader's failure, untrusted and possibly none: it has parsed a file that may be malicious.
std::string sentence_of(const protocol::Failure& failure) {
  if (failure.sentence.find("; ") != std::string::npos) return failure.sentence;
  return "cannot be read: palpa-read says " + detail::in_quotes(failure.sentence) + "; the file is probably damaged";
}

template <class Expected>
Expected expect(protocol::Message message) {
  if (auto* failure = std::get_if<protocol::Failure>(&message)) throw LoadError(sentence_of(*failure));
  if (auto* expected = std::get_if<Expected>(&message)) return std::move(*expected);
  throw LoadError("cannot be read: palpa-read answered out of turn; update both programs together");
}

/// Data to read from a file, and their destination.
struct Plan {
  Header header;
  std::vector<Taken> taken;
  protocol::ReadRequest room;
  std::vector<std::uint64_t> offsets;  ///< of each field of `room` in memory; the last: total size
  double metres_per_file_unit = 1.0;
};

/// Checks a file's header against the request. Warnings and the unit go to `volume`.
Plan planned(Header header, const VolumeRequest& request, Volume& volume) {
  check(header);
  Plan plan{std::move(header), {}, {}, {}};
  volume.warnings = plan.header.warnings;
  plan.metres_per_file_unit = metres_per_unit(request, plan.header, volume);
  plan.taken = taken_fields(request, plan.header);
  for (const Taken& t : plan.taken) plan.room.fields.insert(plan.room.fields.end(), t.arrays.begin(), t.arrays.end());
  std::sort(plan.room.fields.begin(), plan.room.fields.end());
  plan.room.fields.erase(std::unique(plan.room.fields.begin(), plan.room.fields.end()), plan.room.fields.end());
  if (request.frame == VolumeRequest::all_frames) plan.room.frames = plan.header.frames;
  if (limit::frames.is_passed_by(plan.room.frames))
    throw LoadError("has " + std::to_string(plan.room.frames) + " frames, " + more_than(limit::frames));
  const auto placed = protocol::place(plan.header, plan.room);
  if (!placed) throw LoadError("claims more voxels than can be counted; the header is damaged");
  plan.offsets = *placed;
  return plan;
}

/// Positions of a field's arrays among those of the room.
std::vector<std::size_t> slots_of(const Plan& plan, const Taken& taken) {
  std::vector<std::size_t> slots;
  for (const std::uint32_t array : taken.arrays)
    slots.push_back(static_cast<std::size_t>(std::ranges::lower_bound(plan.room.fields, array) - plan.room.fields.begin()));
  return slots;
}

/// Refuses voxels that do not fit, before allocation.
void check_size(const Plan& plan, const ReadOptions& options, std::uint64_t limit) {
  const std::uint64_t free = free_memory_bytes(), bytes = plan.offsets.back();
  std::uint64_t with_work = 0;
  if (__builtin_add_overflow(bytes, plan.header.working_bytes, &with_work)) with_work = UINT64_MAX;
  const bool too_large = bytes > limit;
  if (!too_large && (options.max_bytes != 0 || with_work <= free)) return;
  const auto& n = plan.header.fields[plan.taken.front().arrays.front()].grid.dims;
  const std::string frames = plan.room.frames > 1 ? std::to_string(plan.room.frames) + " frames of " : "";
  throw LoadError(
      "claims " + frames + std::to_string(n[0]) + " × " + std::to_string(n[1]) + " × " + std::to_string(n[2]) +
      " voxels, which need " + readable_bytes(static_cast<double>(too_large ? bytes : with_work)) + " where " +
      readable_bytes(static_cast<double>(too_large ? limit : free)) + (options.max_bytes != 0 ? " are allowed" : " are free") +
      "; crop or downsample the volume (palpa convert --crop, --downsample)" +
      (plan.header.reads_rows ? ", or write it as a store, which may be larger than memory (palpa convert IN OUT.zarr)" : ""));
}

/// Refuses grids of invalid geometry.
void check_places(const Plan& plan) {
  for (const Taken& t : plan.taken) {
    GridGeometry even = in_metres(plan.header.fields[t.arrays.front()].grid, plan.metres_per_file_unit);
    even.planes = {};  // delivered with the voxels
    if (const char* problem = problem_with(even)) {
      throw LoadError("cannot be placed in the world (" + std::string(problem) + "); correct its header");
    }
  }
}

/// Frame of a field with delivered voxels. \param one_row_in  [rows] as of preview_grid_field; 0: for feeling
FieldPtr made_field(const Plan& plan, const Taken& taken, std::size_t frame, const std::shared_ptr<const std::byte>& voxels,
                    std::int64_t one_row_in) {
  const FieldHeader& field = plan.header.fields[taken.arrays.front()];
  std::vector<std::shared_ptr<const void>> arrays;
  for (const std::size_t slot : slots_of(plan, taken))
    arrays.emplace_back(voxels, voxels.get() + plan.offsets[frame * plan.room.fields.size() + slot]);
  GridGeometry grid = in_metres(field.grid, plan.metres_per_file_unit);
  take_planes(grid, static_cast<const std::byte*>(arrays.front().get()) + (protocol::voxel_bytes(field).value() + 7) / 8 * 8);
  try {
    if (arrays.size() > 1) return grid_field(grid, detail::joined_components(plan.header, taken.arrays, arrays));
    const Voxels of{field.type, field.components, arrays.front()};
    return one_row_in == 0 ? grid_field(grid, of, field.scale, field.offset)
                           : preview_grid_field(grid, of, field.scale, field.offset, one_row_in);
  } catch (const std::invalid_argument& problem) {
    const std::string what = problem.what();
    throw LoadError("cannot be felt: " + what + (what.find("; ") == std::string::npos ? "; correct the file" : ""));
  }
}

/// Formats the number of a field's voxels without a value.
std::string format_lost(double lost, double voxels, const std::string& format) {
  const double percent = 100.0 * lost / voxels;
  const std::string share = lost < 10'000.0 ? detail::text("%.0f", lost) + (lost == 1 ? " voxel is " : " voxels are ")
                                            : detail::text("%.*f %% of the voxels are ",
                                                           percent < 1.0    ? 2
                                                           : percent < 10.0 ? 1
                                                                            : 0,
                                                           percent);
  // DICOM's numbers are whole: only padding is without a value.
  return share +
         (format == "dicom"  ? "padding, where nothing was measured"
          : format == "hdf5" ? "without a value (not finite, or marked so by the file)"
                             : "not finite") +
         ": treated as outside";
}

/// Facts of a file's header beside its fields.
void take_facts(const Header& header, Volume& volume) {
  volume.format = header.format;
  volume.modality = header.modality;
  volume.scan = header.scan;
  volume.frame_of_reference = header.frame_of_reference;
  volume.medical_frame = header.medical_frame;
  volume.frames = header.frames;
}

/// Adds the fields of a plan with delivered voxels. \param one_row_in  [rows] as of made_field
void add_fields(Volume& volume, const Plan& plan, const std::shared_ptr<const std::byte>& voxels, const protocol::Done& done,
                std::int64_t one_row_in) {
  take_facts(plan.header, volume);
  volume.files = done.files;
  volume.warnings.insert(volume.warnings.end(), done.warnings.begin(), done.warnings.end());
  for (const Taken& t : plan.taken) {
    std::vector<FieldPtr> frames;
    double lost = 0.0, count = 0.0;
    for (std::size_t frame = 0; frame < static_cast<std::size_t>(plan.room.frames); ++frame) {
      frames.push_back(made_field(plan, t, frame, voxels, one_row_in));
      const GridView& grid = *grid_of(*frames.back());
      lost += std::round((1.0 - grid.valid_share) * static_cast<double>(grid.geometry.voxels()));
      count += static_cast<double>(grid.geometry.voxels());
    }
    const FieldPtr field = frames.size() > 1 ? time_series(std::move(frames), 1.0) : frames.front();
    volume.fields.push_back({t.name, t.unit, field});
    if (done.resampled.size() == plan.room.fields.size()) {
      volume.fields.back().resampling = detail::joined_resampling(done.resampled, slots_of(plan, t));
    }
    if (lost > 0 && !volume.fields.back().resampling) {
      volume.warnings.push_back((plan.taken.size() > 1 ? "field '" + t.name + "': " : "") +
                                format_lost(lost, count, plan.header.format));
    }
  }
}

/// Reads a file of bare numbers: mapped for display; else copied, unless it would fill more than half of the memory.
/// \param ends  ends checksums
void read_raw(const VolumeRequest& request, const protocol::Request& ask, const ReadOptions& options,
              const std::stop_source& ends, VolumeFile& result) {
  Volume& volume = result.volume;
  if (protocol::is_packed(ask.path) && std::filesystem::path(ask.path).extension() == ".gz")
    throw LoadError("is packed by gzip, and bare numbers are read as they lie; unpack it (gunzip)");
  const detail::RawFile file(ask);
  const Plan plan = planned(file.header, request, volume);
  check_places(plan);
  const bool large = options.max_bytes == 0 && plan.offsets.back() > free_memory_bytes() / 2;
  const bool in_place = file.kept_in_place() && (options.preview || large);
  if (!in_place) check_size(plan, options, ask.max_bytes);

  Checksum checksum;
  if (options.checksums != Checksums::none) checksum = detail::checksum_by_thread(ask.path, ends);
  const std::shared_ptr<const std::byte> voxels = in_place ? file.mapped() : file.copied();
  if (options.checksums == Checksums::now && checksum.text().empty())
    throw LoadError("was not read: it is gone, or this was cancelled; open it again");
  protocol::Done done{{{ask.path, bytes_of(ask.path), checksum}}, {}};
  if (in_place && !options.preview)
    done.warnings.push_back("is mapped, not copied, as it fills half of the free memory: leave the file alone");
  // A preview must not block on the disk: of large files it reads some rows only. More voxels: slower; fewer: a coarser range.
  constexpr std::int64_t most_voxels_of_many = 1 << 20;
  const std::int64_t count = plan.header.fields.front().grid.voxels();
  const std::int64_t one_row_in = !options.preview ? 0 : count > 16 * most_voxels_of_many ? count / most_voxels_of_many : 1;
  if (one_row_in > 1)
    done.warnings.push_back("is looked at in one row of voxels in " + std::to_string(one_row_in) + ": its range may be larger");
  add_fields(volume, plan, voxels, done, one_row_in);
  if (!file.is_whole()) throw LoadError("was cut short while it was read; get the whole file");
}

FileContents contents_of(const Header& header) {
  FileContents contents{header.format, header.series, header.labels, {}, header.alternatives};
  for (const FieldHeader& field : header.fields)
    contents.arrays.push_back({field.name, field.unit, field.components, field.grid.dims});
  return contents;
}

/// A whole series of Done. \param work_bytes, memory_bytes  of `ReaderProcess::receive`
protocol::Done whole_done(detail::ReaderProcess& reader, std::uint64_t work_bytes, std::uint64_t memory_bytes) {
  protocol::Done done;
  for (bool more = true; more;) {
    auto part = expect<protocol::Done>(reader.receive(work_bytes, memory_bytes));
    done.files.insert(done.files.end(), part.files.begin(), part.files.end());
    done.warnings.insert(done.warnings.end(), part.warnings.begin(), part.warnings.end());
    done.resampled = part.resampled;
    more = part.more && !part.files.empty() && done.files.size() < most_files;
  }
  return done;
}

/// Reads a file by palpa-read. \param ends  ends reading and checksums
void read_parsed(const VolumeRequest& request, const protocol::Request& ask, const ReadOptions& options,
                 const std::stop_source& ends, VolumeFile& result) {
  Volume& volume = result.volume;
  // Usual bound of the expansion of a compressed file. More: a damaged one can take more; less: valid ones are refused.
  constexpr std::uint64_t usual_ratio = 16;
  const std::unique_ptr<detail::ReaderProcess> fetch = detail::start_fetch(ask.path, options);
  std::optional<detail::UnpackedMemory> unpacked;
  const bool packed = protocol::is_packed(ask.path);
  if (packed || protocol::may_be_deflated(ask.path)) unpacked.emplace();
  std::uint64_t file_bytes = bytes_of(ask.path) * (packed ? usual_ratio : 1);
  for (const std::string& partner : ask.partners) check_file(partner), file_bytes += bytes_of(partner);
  auto reader = std::make_shared<detail::ReaderProcess>(detail::find_reader(options.reader),
                                                        detail::idle_limit_s(ask.path, options), ends.get_token());
  reader->send(ask, {fetch ? fetch->socket() : unpacked ? unpacked->file() : -1, -1});
  Header header = expect<Header>(reader->receive(file_bytes, reader_slack_bytes + 8 * file_bytes));
  result.contents = contents_of(header);
  if (options.found) options.found(result.contents);
  if (const auto& all = result.contents.alternatives; header.fields.empty() && !all.empty())
    throw LoadError("holds several arrays; name one, as FILE:" + all.front().name);
  const Plan plan = planned(std::move(header), request, volume);
  check_size(plan, options, ask.max_bytes);
  check_places(plan);
  const std::uint64_t bytes = plan.offsets.back(), working_bytes = plan.header.working_bytes;
  detail::SharedMemory memory(bytes);
  reader->send(plan.room, memory.files());
  const std::uint64_t work_bytes = file_bytes + bytes + working_bytes;
  const std::uint64_t memory_bytes = reader_slack_bytes + 8 * file_bytes + 2 * (bytes + working_bytes);
  protocol::Done done = whole_done(*reader, work_bytes, memory_bytes);
  if (options.checksums == Checksums::later) {
    const auto compute = [=, reader = std::move(reader)]() mutable {
      const auto ended_here = std::exchange(reader, nullptr);
      std::vector<std::string> texts;
      for (const SourceFile& file : whole_done(*ended_here, work_bytes, memory_bytes).files)
        texts.push_back(file.sha256.text());
      return texts;
    };
    const auto later = detail::checksums_by(compute, ends);
    for (std::size_t f = 0; f < done.files.size(); ++f) done.files[f].sha256 = {later, f};
  }
  reader.reset();
  if (fetch) done.files.push_back({ask.path, 0, {}});
  add_fields(volume, plan, memory.sealed_and_mapped(), done, options.preview ? 1 : 0);
}

/// `read_volume_file` of one file without the fields derived of a store; errors are sentences, without its name.
VolumeFile read_alone(const VolumeRequest& request, const ReadOptions& options) {
  const std::uint64_t limit = options.max_bytes != 0 ? options.max_bytes : free_memory_bytes() / 3 * 2;
  protocol::Request ask = as_asked(request, limit, options.checksums);
  ask.listing = options.found != nullptr;
  check_file(ask.path);
  VolumeFile result;
  if (std::optional<Volume> large = options.preview ? std::nullopt : detail::volume_in_octaves(request, options, limit)) {
    result.frames = large->frames;
    result.volume = std::move(*large);
    return result;
  }
  // Checksums may go on after the reading, and end with the data.
  std::stop_source ends;
  const std::stop_callback end_too(options.stop, [&] { ends.request_stop(); });
  (ask.layout.type.empty() ? read_parsed : read_raw)(request, ask, options, ends, result);
  result.volume.request = std::make_shared<const VolumeRequest>(request);
  result.frames = result.volume.frames;
  return result;
}

/// The part of a request for one derived field of a store; nullopt: it is not wanted.
std::optional<VolumeRequest> for_derived(const VolumeRequest& request, const std::string& name) {
  VolumeRequest part = request;
  part.files = {derived_store(request.files.front(), name)};
  std::erase_if(part.fields, [&](const VolumeRequest::FieldRequest& field) {
    return !field.arrays.empty() || (field.array.empty() ? field.name : field.array) != name;
  });
  return request.fields.empty() || !part.fields.empty() ? std::optional(part) : std::nullopt;
}

/// `read_volume_file` of one file; errors are sentences, without its name.
VolumeFile read_one(const VolumeRequest& request, const ReadOptions& options) {
  VolumeRequest own = request;
  std::vector<VolumeRequest> parts;
  for (const std::string& name : derived_names(request.files.front())) {
    const std::optional<VolumeRequest> part = for_derived(request, name);
    if (!part) continue;
    parts.push_back(*part);
    std::erase_if(own.fields, [&](const auto& field) {
      return std::ranges::any_of(part->fields, [&](const auto& derived) { return derived.name == field.name; });
    });
  }
  const bool has_own = request.fields.empty() || !own.fields.empty();
  VolumeFile result = has_own ? read_alone(own, options) : read_alone(parts.front(), options);
  for (std::size_t n = has_own ? 0 : 1; n < parts.size(); ++n) {
    const Volume made = read_alone(parts[n], options).volume;
    Volume& volume = result.volume;
    volume.fields.insert(volume.fields.end(), made.fields.begin(), made.fields.end());
    volume.files.insert(volume.files.end(), made.files.begin(), made.files.end());
    for (const std::string& warning : made.warnings) {
      if (std::ranges::find(volume.warnings, warning) == volume.warnings.end()) volume.warnings.push_back(warning);
    }
  }
  if (!parts.empty()) result.volume.request = std::make_shared<const VolumeRequest>(request);
  return result;
}

/// `open_sliced_file`; errors are sentences, without the file's name.
std::unique_ptr<SlicedFile> open_one_sliced(const VolumeRequest& request, const ReadOptions& options) {
  protocol::Request ask =
      as_asked(request, options.max_bytes != 0 ? options.max_bytes : free_memory_bytes() / 3 * 2, Checksums::none);
  check_file(ask.path);
  if (!ask.layout.type.empty() || !ask.partners.empty() || protocol::is_packed(ask.path) || protocol::is_store(ask.path) ||
      request.frame == VolumeRequest::all_frames)
    return nullptr;
  ask.rows = true;
  auto reader =
      std::make_unique<detail::ReaderProcess>(detail::find_reader(options.reader), options.idle_limit_s, options.stop);
  reader->send(ask, {-1, -1});
  const std::uint64_t file_bytes = bytes_of(ask.path);
  Header header = expect<Header>(reader->receive(file_bytes, reader_slack_bytes + 8 * file_bytes));
  StoreContents contents = protocol::contents_by_rows(header);
  if (contents.octaves.empty()) return nullptr;
  Volume volume;
  const Plan plan = planned(std::move(header), request, volume);
  check_places(plan);
  take_facts(plan.header, volume);
  volume.request = std::make_shared<const VolumeRequest>(request);
  std::vector<std::uint32_t> arrays;
  std::vector<SlicedFile::Field> fields;
  for (const Taken& taken : plan.taken) {
    if (taken.arrays.size() > 1) return nullptr;  // components of a vector, which are joined in memory
    const FieldHeader& of = plan.header.fields[taken.arrays.front()];
    arrays.push_back(taken.arrays.front());
    fields.push_back(
        {taken.name, taken.unit, in_metres(of.grid, plan.metres_per_file_unit), of.type, of.components, of.scale, of.offset});
  }
  // [bytes] Of chunks ahead. More: more memory; less: the disk pauses between requests.
  constexpr std::uint64_t ahead_bytes = 64'000'000;
  const auto slots = static_cast<int>(std::clamp<std::uint64_t>(ahead_bytes / protocol::slot_bytes(contents), 2, 64));
  auto file = std::make_unique<SlicedFile>(
      std::make_unique<StoreReader>(ask.path, options, slots, std::move(reader), std::move(contents)), std::move(arrays));
  file->volume = std::move(volume), file->fields = std::move(fields);
  return file;
}

/// Result of `act`, whose errors get the place of the request.
template <class Act>
auto with_place(const VolumeRequest& request, const Act& act) {
  if (request.files.empty()) throw LoadError("volume: no file is named; name one");
  // Sanitizes text of the file and of its reader, here for all of it.
  const std::string place = detail::one_line(request.files.front().string());
  try {
    return act();
  } catch (const LoadError& error) {
    constexpr std::size_t longest_bytes = 2000;  // More: unreadable; less: useful names are cut
    const std::string sentence = detail::shortened(detail::one_line(error.what()), longest_bytes);
    throw LoadError(sentence.starts_with(place + ": ") ? sentence : place + ": " + sentence);
  }
}

}  // namespace

std::unique_ptr<SlicedFile> open_sliced_file(const VolumeRequest& request, const ReadOptions& options) {
  return with_place(request, [&] {
    std::unique_ptr<SlicedFile> file = open_one_sliced(request, options);
    if (file)
      for (std::string& warning : file->volume.warnings) warning = detail::one_line(warning);
    return file;
  });
}

VolumeFile read_volume_file(const VolumeRequest& request, const ReadOptions& options) {
  return with_place(request, [&] {
    VolumeFile file = read_one(request, options);
    for (std::string& warning : file.volume.warnings) warning = detail::one_line(warning);
    return file;
  });
}

Volume read_volume(const VolumeRequest& request, const ReadOptions& options) {
  return read_volume_file(request, options).volume;
}

Volume read_volume(const std::filesystem::path& file, const ReadOptions& options) {
  VolumeRequest request;
  request.files = {file};
  return read_volume(request, options);
}

VolumeReader volume_reader(ReadOptions options) {
  return [options](const VolumeRequest& request) { return read_volume(request, options); };
}

}  // namespace palpa
