#include "serve.h"

#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <future>
#include <new>
#include <string_view>

#include "compression.h"
#include "messages.h"
#include "palpa/base/limits.h"
#include "palpa/data/sha256.h"
#include "palpa/data/volume.h"
#include "palpa/file/protocol_memory.h"
#include "palpa/file/protocol_packed.h"
#include "palpa/file/store_protocol.h"
#include "program.h"
#include "row_serve.h"
#include "sandbox.h"

namespace palpa::reader {
namespace {

/// Address space for libraries, beside the voxels. More: a damaged file can take more; less: sound files are refused.
constexpr std::uint64_t slack_bytes = 512'000'000;

/// Limits further address space to `bytes`.
void limit_memory([[maybe_unused]] std::uint64_t bytes) {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // sanitizers map terabytes; the caller's own limit remains
  std::uint64_t pages = 0;
  std::ifstream("/proc/self/statm") >> pages;
  const std::uint64_t now = pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
  rlimit limit{};
  ::getrlimit(RLIMIT_AS, &limit);
  const std::uint64_t wanted = now + slack_bytes + std::min<std::uint64_t>(bytes, std::uint64_t{1} << 60);
  limit.rlim_cur = std::min<rlim_t>(wanted, limit.rlim_max);
  ::setrlimit(RLIMIT_AS, &limit);
#endif
}

/// Checks a source's files and, if requested, computes checksums, in threads that start at once; the thread in `finished`
/// helps.
class FileChecks {
 public:
  /// \param request  with which the source was opened
  FileChecks(const Source& source, const protocol::Request& request)
      : source_(source),
        request_(request),
        files_(source.files.size()),
        checked_(std::async(std::launch::async, [this] { source_.check_files(); })),
        computed_(std::async(std::launch::async, [this] { work(); })) {}

  /// The files without checksums, once they are checked.
  std::vector<SourceFile> checked() {
    checked_.get();
    std::vector<SourceFile> files;
    for (const std::string& file : source_.files) files.push_back({path_of(file), file_bytes(path_of(file)), {}});
    return files;
  }

  std::vector<SourceFile> finished() {
    work();
    computed_.get();
    if (checked_.valid()) checked_.get();
    return std::move(files_);
  }

 private:
  void work() {
    for (std::size_t f = next_++; f < files_.size(); f = next_++) {
      const std::string& path = path_of(source_.files[f]);
      files_[f] = {path, file_bytes(path), request_.checksums == Checksums::none ? "" : detail::sha256_of_file(path)};
    }
  }
  const std::string& path_of(const std::string& file) const {
    return !request_.packed.empty() && file == request_.path ? request_.packed : file;
  }

  const Source& source_;
  const protocol::Request& request_;
  std::vector<SourceFile> files_;
  std::atomic<std::size_t> next_ = 0;
  std::future<void> checked_, computed_;
};

/// Reports complete voxels and their files to the caller; a long list is sent in several messages.
void send_done(int socket, const Source& source, const std::vector<SourceFile>& files) {
  protocol::Done done;
  std::size_t bytes = 0;
  for (const SourceFile& file : files) {
    if (bytes > protocol::max_packet_bytes / 2 || done.files.size() >= 500) {
      done.more = true;
      protocol::send(socket, done);
      done = {}, bytes = 0;
    }
    bytes += file.path.size() + file.sha256.text().size() + 32;
    done.files.push_back(file);
  }
  done.resampled = source.resampled;
  done.warnings = take_library_warnings();
  done.warnings.insert(done.warnings.end(), source.warnings.begin(), source.warnings.end());
  protocol::send(socket, done);
}

/// Writes the planes of a rectilinear grid behind the voxels of its field.
void put_planes(const protocol::FieldHeader& field, std::byte* voxels) {
  std::byte* to = voxels + (protocol::voxel_bytes(field).value_or(0) + 7) / 8 * 8;
  for (const std::vector<double>& planes : field.grid.planes) {
    if (!planes.empty()) std::memcpy(to, planes.data(), 8 * planes.size());
    to += 8 * planes.size();
  }
}

/// Throws LoadError if the request has options that do not apply to this file.
void check_request(const protocol::Request& request, const Source& source) {
  if (!request.partners.empty() && !source.takes.partners)
    throw LoadError("is a volume by itself, and " + std::to_string(request.partners.size() + 1) +
                    " files are named; give one (only a grid and its solution, and blocks of one grid in VTK's XML files, "
                    "belong together)");
  if (request.time_s && !source.takes.time) throw LoadError("has no moments to choose from; leave 'time' out");
  if (request.crop && !source.takes.crop)
    throw LoadError("is not resampled when read, so no part of it is; leave 'crop_m' out");
  if (!request.inside.empty() && !source.takes.inside)
    throw LoadError("has no arrays by path; give the file alone and name its arrays in 'fields'");
  if (request.layout != ArrayLayout{} && !source.takes.layout)
    throw LoadError("says its own shape; leave dims, axes, components, spacing_m and origin_m out");
  if (request.components_along == "index" && !source.takes.index_axes)
    throw LoadError("has no vectors along the axes of one grid; leave components_along out");
  if (!request.series.empty() && !source.takes.series)
    throw LoadError("is no DICOM file, so it holds no series; leave 'series' out");
}

/// Decompresses a file that is compressed as a whole into a memory file.
void unpack_request(protocol::Request& request, int memory) {
  if (memory < 0 || !protocol::is_packed(request.path)) {
    request.memory = memory;
    return;
  }
  unpack_whole(request.path, memory, request.max_bytes);
  request.packed = request.path;
  request.path = unpacked_folder + std::to_string(memory);
}

/// [bytes] Memory for a file that is read with its header. A header needs little, but a legacy VTK file is read as a whole, and
/// numbers as text grow up to fourfold in memory.
std::uint64_t header_bytes(const protocol::Request& request, std::uint64_t bytes) {
  return std::min(request.max_bytes, 8 * bytes);
}

/// \param unpacks  true if it reads compressed files itself
void answer(int socket, Open open, bool unpacks) {
  int for_unpacked = -1;
  protocol::Request request = receive_request(socket, true, &for_unpacked);
  close_cage();
  if (!unpacks) unpack_request(request, for_unpacked);
  // The files of a store are many, and its header needs none of them.
  std::uint64_t bytes = protocol::is_store(request.path) ? 0 : file_bytes(request.path);
  for (const std::string& partner : request.partners) bytes += file_bytes(partner);
  limit_memory(header_bytes(request, bytes));

  const std::unique_ptr<Source> source = open(request);
  if (request.store) return source->serve_chunks(socket);
  check_request(request, *source);
  if (!protocol::send(socket, source->header)) return;
  if (request.rows) return serve_rows(socket, *source);
  FileChecks checks(*source, request);

  bool garbled = false;
  auto second = protocol::receive(socket, garbled);
  if (!second || !std::holds_alternative<protocol::ReadRequest>(second->message) || second->descriptor < 0) return;
  const auto& room = std::get<protocol::ReadRequest>(second->message);
  const auto offsets = protocol::place(source->header, room);
  if (!offsets || room.frames != source->frames_read) return;
  limit_memory(offsets->back() + source->header.working_bytes);
  {
    const protocol::Memory memory = protocol::mapped({second->descriptor, second->second_descriptor}, offsets->back(), true);
    std::vector<std::byte*> to;
    for (std::size_t n = 0; n + 1 < offsets->size(); ++n) to.push_back(memory.all.get() + (*offsets)[n]);
    source->put = [&](std::byte* place, const std::byte* from, std::uint64_t bytes_put) {
      memory.write(place, from, bytes_put);
    };
    source->read(room.fields, to);
    for (std::size_t n = 0; n < to.size(); ++n) put_planes(source->header.fields[room.fields[n % room.fields.size()]], to[n]);
  }  // the caller can seal only what is not mapped
  if (request.checksums == Checksums::later) send_done(socket, *source, checks.checked());
  send_done(socket, *source, checks.finished());
}

}  // namespace

void allow_memory(std::uint64_t bytes) { limit_memory(bytes); }

void allow_memory(const protocol::Request& request, std::uint64_t bytes) { limit_memory(header_bytes(request, bytes)); }

void Source::read_rows(std::uint32_t, std::int64_t, std::int64_t, std::int64_t, std::byte*) {
  throw LoadError("is read as a whole alone; update both programs together");
}

void Source::serve_chunks(int) {
  throw LoadError("is no OME-Zarr, whose chunks are read one by one; name the folder of one, or make one by palpa convert");
}

std::int64_t Source::choose_frames(const protocol::Request& request, std::int64_t frames) {
  header.frames = static_cast<std::int32_t>(std::min<std::int64_t>(frames, INT32_MAX));
  if (request.frame == VolumeRequest::all_frames) {
    if (limit::frames.is_passed_by(static_cast<double>(frames)))
      throw LoadError("has " + std::to_string(frames) + " frames, " + more_than(limit::frames));
    frames_read = frames;
    return 0;
  }
  if (request.frame >= frames) {
    throw LoadError("has " + std::to_string(frames) + (frames == 1 ? " frame" : " frames") + ", not frame " +
                    std::to_string(request.frame) + "; they count from 0");
  }
  if (frames > 1 && request.frame < 0) {
    header.warnings.push_back("holds " + std::to_string(frames) +
                              " frames: the first is read (frame = N takes another, frame_period_s all of them, as a series)");
  }
  return std::max(request.frame, 0);
}

std::uint64_t file_bytes(const std::string& path) {
  struct stat status{};
  if (::stat(path.c_str(), &status) != 0) return 0;
  if (!S_ISDIR(status.st_mode)) return static_cast<std::uint64_t>(std::max<off_t>(status.st_size, 0));
  std::uint64_t bytes = 0;
  std::error_code problem;
  for (std::filesystem::recursive_directory_iterator entry(path, problem), end; !problem && entry != end;
       entry.increment(problem)) {
    std::error_code gone;
    if (entry->is_regular_file(gone)) bytes += entry->file_size(gone);
  }
  return bytes;
}

void note_left_over(std::uint64_t there, std::uint64_t needed, const char* key, std::vector<std::string>& warnings) {
  if (there <= needed) return;
  warnings.push_back("holds " + std::to_string(there - needed) + (there - needed == 1 ? " byte" : " bytes") +
                     " more than its voxels need, which are taken to stand behind these; if not, correct " + key);
}

int serve(const char* format, std::initializer_list<Format> formats) {
  return run_program([&](int socket) {
    catch_library_messages();
    for (const Format& known : formats) {
      if (format != nullptr && known.name == format) return answer(socket, known.open, known.name == "nifti");
    }
    throw LoadError("was handed to a program that does not know its format; update palpa-read and those beside it together");
  });
}

}  // namespace palpa::reader
