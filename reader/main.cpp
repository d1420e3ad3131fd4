// palpa-read: parses one volume file for the program that started it (palpa/volume/read_volume.cpp). What
// can go wrong with a file of somebody else goes wrong here, where it costs one line.
#include <fcntl.h>
#include <malloc.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <atomic>
#include <cctype>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <future>
#include <new>
#include <stdexcept>
#include <string_view>

#include "dicom_files.h"
#include "messages.h"
#include "palpa/field/sha256.h"
#include "source.h"

namespace palpa::reader {
namespace {

constexpr std::uint64_t slack_bytes = 512'000'000;  ///< of address space, for what libraries need beside voxels

/// From here on the program may have `bytes` of address space more than it has now.
void limit_memory([[maybe_unused]] std::uint64_t bytes) {
#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)  // they map terabytes; there the caller watches
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

bool ends_with(std::string_view text, std::string_view end) {
  return text.size() >= end.size() && text.substr(text.size() - end.size()) == end;
}

/// The letters, digits and underscores at the start of `text`, after blanks and quotes.
std::string first_word(std::string_view text) {
  text.remove_prefix(std::min(text.find_first_not_of(" \t\"'"), text.size()));
  std::size_t end = 0;
  while (end < text.size() && (std::isalnum(static_cast<unsigned char>(text[end])) != 0 || text[end] == '_')) ++end;
  return std::string(text.substr(0, end));
}

/// The word that follows `key` at its first place in `text`; empty if it is not there.
std::string word_after(std::string_view text, std::string_view key) {
  const std::size_t at = text.find(key);
  return at == std::string_view::npos ? std::string() : first_word(text.substr(at + key.size()));
}

/// The data type of a NIfTI header, which vtkNIFTIReader looks up in a table that it runs off.
void check_nifti_type(const char* header, bool second_version) {
  std::uint32_t header_bytes = 0;
  std::uint16_t type = 0;
  std::memcpy(&header_bytes, header, sizeof header_bytes);
  std::memcpy(&type, header + (second_version ? 12 : 70), sizeof type);
  if (header_bytes != 348 && header_bytes != 540) type = static_cast<std::uint16_t>(type >> 8 | type << 8);
  static constexpr int known[] = {2, 4, 8, 16, 32, 64, 128, 256, 512, 768, 1024, 1280, 1792, 2304};
  if (std::find(std::begin(known), std::end(known), type) == std::end(known)) {
    throw LoadError("has NIfTI data type " + std::to_string(type) +
                    "; whole numbers to 64 bits, float32 and float64 can be read");
  }
}

/// Opens the file with the library that its first bytes ask for.
std::unique_ptr<Source> open_source(const protocol::Request& request) {
  if (is_openfoam_case(request.path)) return open_openfoam(request);
  if (std::filesystem::is_directory(request.path)) return open_dicom(request);
  char buffer[1024] = {};
  int got = 0;
  if (gzFile file = gzopen(request.path.c_str(), "rb")) {  // reads files that are not compressed as they are
    got = gzread(file, buffer, sizeof buffer);
    gzclose(file);
  } else {
    throw LoadError(std::string("cannot be opened: ") + std::strerror(errno) + "; check its permissions");
  }
  if (got <= 0) throw LoadError("cannot be read: its gzip compression is damaged; get the file again");
  const std::string_view start(buffer, static_cast<std::size_t>(got));
  const std::string_view name = request.path;
  if (start.size() >= 132 && start.substr(128, 4) == "DICM") return open_dicom(request);
  if (start.substr(0, 8) == "\x89HDF\r\n\x1a\n") return open_hdf5(request);
  if (ends_with(name, ".h5") || ends_with(name, ".hdf5") || ends_with(name, ".vtkhdf") || ends_with(name, ".hdf")) {
    throw LoadError("is no HDF5 file: it has not its signature; get the whole file, or convert an old HDF4 one (h4toh5)");
  }
  if (start.substr(0, 4) == "NRRD") return open_nrrd(request);
  if (ends_with(name, ".nrrd") || ends_with(name, ".nhdr")) {
    throw LoadError("is no NRRD file: it does not begin with 'NRRD'; give it its right name or export it again");
  }

  const bool nifti_1 = start.size() >= 348 && (start.substr(344, 3) == "n+1" || start.substr(344, 3) == "ni1");
  const bool nifti_2 = start.size() >= 540 && (start.substr(4, 3) == "n+2" || start.substr(4, 3) == "ni2");
  if (nifti_1 || nifti_2) {
    check_nifti_type(buffer, nifti_2);
    return open_nifti(request);
  }
  if (ends_with(name, ".nii") || ends_with(name, ".nii.gz")) {
    throw LoadError("is no NIfTI file: its header has no 'n+1' or 'n+2'; export it again");
  }

  if (start.substr(0, 14) == "# vtk DataFile") {
    std::string upper(start);
    for (char& c : upper) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
    const std::string kind = word_after(upper, "\nDATASET");
    if (kind == "STRUCTURED_POINTS" || kind == "RECTILINEAR_GRID" || kind == "STRUCTURED_GRID" || kind == "UNSTRUCTURED_GRID")
      return open_legacy_vtk(request);
    throw LoadError("holds " + (kind.empty() ? std::string("no DATASET that can be found") : kind) +
                    "; of legacy VTK files STRUCTURED_POINTS (image data) and RECTILINEAR_, STRUCTURED_ and UNSTRUCTURED_GRID "
                    "can be read");
  }
  if (const std::size_t at = start.find("<VTKFile"); at != std::string_view::npos) {
    const std::string kind = word_after(start.substr(at), " type=");
    return kind == "ImageData" ? open_vti(request) : open_vtk_xml(request, kind);
  }
  if (ends_with(name, ".vti")) throw LoadError("is no VTI file: it has no '<VTKFile'; export it again");

  const std::string first = first_word(start);
  if (ends_with(name, ".dx") || (first == "object" && start.find("class") != std::string_view::npos)) {
    throw LoadError(
        "is OpenDX, which is not read; its header says where the numbers are: write a NRRD header for them (data "
        "file, byte skip, sizes with the last index first, space directions), or convert it with numpy");
  }
  if (first == "ObjectType" || first == "NDims" || first == "DimSize" || first == "Comment" || ends_with(name, ".mha") ||
      ends_with(name, ".mhd")) {
    return open_metaimage(request);
  }
  if (is_dicom(request.path)) return open_dicom(request);
  if (is_plot3d(request.path)) return open_plot3d(request);
  throw LoadError("has no format that is known; DICOM, NRRD, MetaImage, NIfTI, VTK, PLOT3D, OpenFOAM and HDF5 can be read");
}

/// Shared memory from the caller, and its descriptor, for as long as this program runs.
std::byte* mapped(int descriptor, std::uint64_t bytes) {
  struct stat status {};
  if (::fstat(descriptor, &status) != 0 || static_cast<std::uint64_t>(status.st_size) < bytes) {
    throw LoadError("got too little memory from the program that asked for it; update palpa and palpa-read together");
  }
  void* memory = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
  if (memory == MAP_FAILED) throw std::bad_alloc();
  return static_cast<std::byte*>(memory);
}

/// A source's files, checked, with checksums where they are wanted: by a thread of its own that begins at once; whoever waits
/// for checksums helps.
class Checksums {
 public:
  Checksums(const Source& source, bool wanted) : source_(source), wanted_(wanted), files_(source.files.size()) {
    other_ = std::async(std::launch::async, [this] {
      work();
      source_.check_files();
    });
  }

  std::vector<SourceFile> finished() {
    work();
    other_.get();
    return std::move(files_);
  }

 private:
  void work() {
    for (std::size_t f = next_++; f < files_.size(); f = next_++) {
      const std::string& path = source_.files[f];
      files_[f] = {path, file_bytes(path), wanted_ ? sha256_of_file(path) : std::string()};
    }
  }

  const Source& source_;
  const bool wanted_;
  std::vector<SourceFile> files_;
  std::atomic<std::size_t> next_ = 0;
  std::future<void> other_;
};

/// Says that the voxels are there, and of which files: of many in several messages.
void send_done(int socket, const Source& source, const std::vector<SourceFile>& files) {
  protocol::Done done;
  std::size_t bytes = 0;
  for (const SourceFile& file : files) {
    if (bytes > protocol::max_packet_bytes / 2 || done.files.size() >= 500) {
      done.more = true;
      protocol::send(socket, done);
      done = {}, bytes = 0;
    }
    bytes += file.path.size() + file.sha256.size() + 32;
    done.files.push_back(file);
  }
  done.resampled = source.resampled;
  done.warnings = take_library_warnings();
  done.warnings.insert(done.warnings.end(), source.warnings.begin(), source.warnings.end());
  protocol::send(socket, done);
}

/// The planes of a rectilinear grid, behind the voxels of its field.
void put_planes(const protocol::FieldHeader& field, std::byte* voxels) {
  std::byte* to = voxels + (protocol::voxel_bytes(field).value_or(0) + 7) / 8 * 8;
  for (const std::vector<double>& planes : field.grid.planes) {
    if (!planes.empty()) std::memcpy(to, planes.data(), 8 * planes.size());
    to += 8 * planes.size();
  }
}

/// Refuses what was asked for in vain.
void check_request(const protocol::Request& request, const Source& source) {
  if (!request.partners.empty() && !source.takes.partners)
    throw LoadError("is a volume by itself, and " + std::to_string(request.partners.size() + 1) +
                    " files are named; give one (only a grid and its solution belong together)");
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

void serve(int socket) {
  bool garbled = false;
  auto first = protocol::receive(socket, garbled);
  if (!first || !std::holds_alternative<protocol::Request>(first->message)) {
    throw LoadError("was asked for in a way that palpa-read does not know; update palpa and palpa-read together");
  }
  const auto request = std::get<protocol::Request>(first->message);
  std::uint64_t bytes = file_bytes(request.path);
  for (const std::string& partner : request.partners) bytes += file_bytes(partner);
  // A header takes little. A legacy VTK file is read with it: numbers as text grow fourfold at most.
  limit_memory(std::min(request.max_bytes, 8 * bytes));

  const std::unique_ptr<Source> source = open_source(request);
  check_request(request, *source);
  if (!protocol::send(socket, source->header)) return;
  Checksums checks(*source, request.checksums);

  auto second = protocol::receive(socket, garbled);
  if (!second || !std::holds_alternative<protocol::Room>(second->message) || second->descriptor < 0) return;
  const auto& room = std::get<protocol::Room>(second->message);
  const auto offsets = protocol::place(source->header, room);
  if (!offsets) return;
  limit_memory(offsets->back() + source->header.working_bytes);
  std::byte* memory = mapped(second->descriptor, offsets->back());
  std::vector<std::byte*> to;
  for (std::size_t i = 0; i < room.fields.size(); ++i) to.push_back(memory + (*offsets)[i]);

  source->put = [&](std::byte* place, const std::byte* from, std::uint64_t count) {
    const ssize_t written = ::pwrite(second->descriptor, from, count, place - memory);
    const std::uint64_t done = written > 0 ? static_cast<std::uint64_t>(written) : 0;
    std::memcpy(place + done, from + done, count - done);  // what could not be written, through the mapping
  };
  source->read(room.fields, to);
  for (std::size_t i = 0; i < room.fields.size(); ++i) put_planes(source->header.fields[room.fields[i]], to[i]);
  send_done(socket, *source, checks.finished());
}

}  // namespace

std::int64_t chosen_frame(const protocol::Request& request, std::int64_t frames, std::vector<std::string>& warnings) {
  if (request.frame >= frames) {
    throw LoadError("has " + std::to_string(frames) + (frames == 1 ? " frame" : " frames") + ", not frame " +
                    std::to_string(request.frame) + "; they count from 0");
  }
  if (frames > 1 && request.frame < 0) {
    warnings.push_back("holds " + std::to_string(frames) +
                       " frames: the first is read (frame = N takes another, frame_period_s all of them, as a series)");
  }
  return std::max(request.frame, 0);
}

std::uint64_t file_bytes(const std::string& path) {
  struct stat status {};
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

}  // namespace palpa::reader

int main() {
  using namespace palpa;
  const int socket = protocol::socket_descriptor;
  struct stat status {};
  if (::fstat(socket, &status) != 0 || !S_ISSOCK(status.st_mode)) {
    std::fputs("palpa: palpa-read: is started by palpa to open a file; try 'palpa info FILE'\n", stderr);
    return 2;
  }
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  const rlimit none{0, 0};
  ::setrlimit(RLIMIT_CORE, &none);
  ::mallopt(M_ARENA_MAX, 2);  // each arena reserves address space
  reader::catch_library_messages();

  std::string sentence;
  try {
    reader::serve(socket);
  } catch (const std::bad_alloc&) {
    sentence = "needs more memory to be read than its header says; it is probably damaged";
  } catch (const std::length_error&) {
    sentence = "claims more than memory can hold; its header is damaged";
  } catch (const LoadError& error) {
    sentence = error.what();
  } catch (const std::exception& error) {
    sentence = std::string("cannot be read (") + error.what() + "); check that the file is whole";
  }
  if (!sentence.empty()) protocol::send(socket, protocol::Failure{sentence});
  ::_exit(sentence.empty() ? 0 : 1);  // without the libraries' farewells
}
