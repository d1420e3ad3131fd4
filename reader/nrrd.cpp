// NRRD by NrrdIO. itk::NrrdImageIO drops units, vector frames and data file names, and refuses grids without right angles.
#include <NrrdIO.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <iomanip>
#include <memory>
#include <optional>

#include "compression.h"
#include "data_file.h"
#include "library_words.h"
#include "palpa/base/input_file.h"
#include "palpa/data/length_unit.h"
#include "raw_rows.h"
#include "source.h"
#include "text_number.h"

namespace palpa::reader {
namespace {

struct NrrdDeleter {
  void operator()(Nrrd* nrrd) const { nrrdNuke(nrrd); }
};
struct StateDeleter {
  void operator()(NrrdIoState* state) const { nrrdIoStateNix(state); }
};

/// Innermost cause of a NrrdIO failure, in its last line: `[nrrd] function: cause`.
std::string cause() {
  char* text = biffGetDone(NRRD);
  std::string all = text != nullptr ? text : "";
  std::free(text);
  while (!all.empty() && all.back() == '\n') all.pop_back();
  all.erase(0, all.rfind('\n') + 1);  // npos + 1 is 0
  const std::size_t colon = all.find(": ");
  return known_words(colon == std::string::npos ? all : all.substr(colon + 2));
}

RawType raw_type(int type) {
  switch (type) {
    case nrrdTypeChar: return RawType::int8;
    case nrrdTypeUChar: return RawType::uint8;
    case nrrdTypeShort: return RawType::int16;
    case nrrdTypeUShort: return RawType::uint16;
    case nrrdTypeInt: return RawType::int32;
    case nrrdTypeUInt: return RawType::uint32;
    case nrrdTypeLLong: return RawType::int64;
    case nrrdTypeULLong: return RawType::uint64;
    case nrrdTypeFloat: return RawType::float32;
    case nrrdTypeDouble: return RawType::float64;
    default: throw LoadError("holds blocks of bytes, not numbers; volumes of numbers can be felt");
  }
}

constexpr std::size_t most_labels = 256;  // [1] with names. More: a damaged header costs time; fewer: large atlases lose names
constexpr std::size_t most_data_files =
    4096;  // as in the message. More: a damaged pattern names files for long; less: refuses series

struct Axes {
  std::vector<unsigned> space;
  std::optional<unsigned> vector;
  std::optional<unsigned> frames;
};

Vec3 direction(const Nrrd& nrrd, unsigned axis) {
  const double* d = nrrd.axis[axis].spaceDirection;
  return {d[0], nrrd.spaceDim > 1 ? d[1] : 0.0, nrrd.spaceDim > 2 ? d[2] : 0.0};
}

/// True if all numbers of a vector in the file's space are given.
bool exists(const Nrrd& nrrd, const double* vector) {
  return nrrd.spaceDim > 0 && std::all_of(vector, vector + nrrd.spaceDim, [](double d) { return std::isfinite(d); });
}

bool directed(const Nrrd& nrrd, unsigned axis) { return exists(nrrd, nrrd.axis[axis].spaceDirection); }

Axes sorted_axes(const Nrrd& nrrd, bool as_vector) {
  Axes axes;
  bool any_directed = false;
  for (unsigned a = 0; a < nrrd.dim; ++a) any_directed = any_directed || directed(nrrd, a);

  for (unsigned a = 0; a < nrrd.dim; ++a) {
    const int kind = nrrd.axis[a].kind;
    const bool spatial = any_directed ? directed(nrrd, a) && norm(direction(nrrd, a)) > 0
                                      : kind == nrrdKindUnknown || kind == nrrdKindDomain || kind == nrrdKindSpace;
    if (spatial) {
      axes.space.push_back(a);
      continue;
    }
    if (nrrd.axis[a].size == 1) continue;
    switch (kind) {
      case nrrdKindVector:
      case nrrdKindCovariantVector:
      case nrrdKindNormal:
      case nrrdKind3Vector:
      case nrrdKind3Gradient:
      case nrrdKind3Normal:
        if (nrrd.axis[a].size == 3 && !axes.vector) {
          axes.vector = a;
          continue;
        }
        break;
      case nrrdKindUnknown:
      case nrrdKindDomain:
      case nrrdKindTime:
      case nrrdKindList:
        if (!axes.frames) {
          axes.frames = a;
          continue;
        }
        break;
      default: break;
    }
    const char* name = airEnumStr(nrrdKind, kind);
    throw LoadError("has " + std::to_string(nrrd.axis[a].size) + " numbers per voxel (" + (name != nullptr ? name : "???") +
                    "); one, or a vector of three, can be felt");
  }
  // Four axes without kinds: the last counts frames, unless the first holds a vector: of size three, `as_vector` (the two swap
  // below).
  if (axes.space.size() == 4 && !axes.vector && !axes.frames) {
    const bool first = as_vector && nrrd.axis[axes.space.front()].size == 3;
    const auto extra = first ? axes.space.begin() : axes.space.end() - 1;
    axes.frames = *extra;
    axes.space.erase(extra);
  }
  if (as_vector && !axes.vector) {
    if (!axes.frames || nrrd.axis[*axes.frames].size != 3) {
      throw LoadError("has no three frames to take as one vector; leave out as = \"vector\"");
    }
    std::swap(axes.vector, axes.frames);
  }
  if (axes.space.empty() || axes.space.size() > 3) {
    throw LoadError("has " + std::to_string(axes.space.size()) + " axes in space; one to three can be felt");
  }
  return axes;
}

/// Spacing along an axis without a direction, from its spacing or its ends; 1 if the file has neither.
double plain_spacing(const NrrdAxisInfo& axis, int number, std::vector<std::string>& warnings) {
  if (std::isfinite(axis.spacing)) return axis.spacing;
  const double gaps = static_cast<double>(axis.center == nrrdCenterNode ? axis.size - 1 : axis.size);
  if (std::isfinite(axis.min) && std::isfinite(axis.max) && gaps > 0) return (axis.max - axis.min) / gaps;
  warnings.push_back("says no spacing along axis " + std::to_string(number) + ": 1 is taken");
  return 1.0;
}

/// World of the file's space → ours: mirrored axes have −1.
Vec3 signs_of(int space, protocol::Header& header) {
  switch (space) {
    case nrrdSpaceRightAnteriorSuperior:
    case nrrdSpaceRightAnteriorSuperiorTime: return header.medical_frame = true, Vec3{-1, -1, 1};
    case nrrdSpaceLeftAnteriorSuperior:
    case nrrdSpaceLeftAnteriorSuperiorTime: return header.medical_frame = true, Vec3{1, -1, 1};
    case nrrdSpaceLeftPosteriorSuperior:
    case nrrdSpaceLeftPosteriorSuperiorTime: return header.medical_frame = true, Vec3{1, 1, 1};
    case nrrdSpace3DLeftHanded:
    case nrrdSpace3DLeftHandedTime:
      header.warnings.push_back("the file's frame is left-handed: its x axis is negated");
      return {-1, 1, 1};
    default: return {1, 1, 1};
  }
}

Mat3 from_columns(const Vec3& a, const Vec3& b, const Vec3& c) { return transposed(Mat3{{a, b, c}}); }

std::string trimmed(const char* text) {
  std::string s = text != nullptr ? text : "";
  s.erase(0, s.find_first_not_of(" \t\r\""));
  s.erase(s.find_last_not_of(" \t\r\"") + 1);
  return s;
}

class NrrdSource : public Source {
 public:
  explicit NrrdSource(const protocol::Request& request) : path_(request.path) {
    check_named_files();
    nrrd_ = load(nullptr, true);
    header.format = "nrrd";
    takes.index_axes = true;
    header.default_unit = "mm";
    header.modality = modality();
    header.labels = segments();
    const Axes axes = sorted_axes(*nrrd_, request.as == "vector");

    raw_.type = raw_type(nrrd_->type);
    std::vector<std::int64_t> stride(nrrd_->dim, 1);
    for (unsigned a = 1; a < nrrd_->dim; ++a) {
      if (__builtin_mul_overflow(stride[a - 1], static_cast<std::int64_t>(nrrd_->axis[a - 1].size), &stride[a])) {
        throw LoadError("claims more voxels than can be counted; the header is damaged");
      }
    }
    for (std::size_t s = 0; s < 3; ++s) {
      const bool present = s < axes.space.size();
      raw_.dims[s] = present ? static_cast<std::int64_t>(nrrd_->axis[axes.space[s]].size) : 1;
      raw_.stride[s] = present ? stride[axes.space[s]] : raw_.stride[s - 1] * raw_.dims[s - 1];
    }
    if (axes.vector) raw_.components = 3, raw_.component_stride = stride[*axes.vector];
    if (axes.frames) {
      frame_stride_ = stride[*axes.frames];
      first_ = choose_frames(request, static_cast<std::int64_t>(nrrd_->axis[*axes.frames].size)) * frame_stride_;
    } else {
      choose_frames(request, 1);
    }

    protocol::FieldHeader field;
    field.name = axes.vector ? "vector" : "value";
    field.unit = trimmed(nrrd_->sampleUnits);
    const Vec3 signs = signs_of(nrrd_->space, header);
    const Mat3 flip{{{signs.x, 0, 0}, {0, signs.y, 0}, {0, 0, signs.z}}};
    find_geometry(axes, flip, field.grid);
    turn_.axes = request.components_along == "index" ? protocol::unit_axes(field.grid) : flip * measurement_frame();
    keep(raw_, turn_, field, header.warnings);
    header.fields.push_back(field);
    if (std::isfinite(nrrd_->oldMin) || std::isfinite(nrrd_->oldMax))
      header.warnings.push_back(
          "says that its numbers were made from others (old min, old max): they are felt as they are stored");

    all_bytes_ = size_of(raw_.type);
    for (unsigned a = 0; a < nrrd_->dim; ++a) {
      if (__builtin_mul_overflow(all_bytes_, nrrd_->axis[a].size, &all_bytes_)) all_bytes_ = INT64_MAX;
    }
    if (encoding_ == nrrdEncodingRaw && byte_skip_ >= 0 && line_skip_ == 0 && files.size() <= 2) {
      const std::uint64_t first = static_cast<std::uint64_t>(byte_skip_) + (files.size() == 1 ? header_bytes() : 0);
      note_left_over(file_bytes(files.back()), first + all_bytes_, "byte skip", header.warnings);
    }
    direct_ = !axes.frames && kept_as_they_are(raw_, turn_, field);
    find_rows();
    if (!direct_ && !header.reads_rows) header.working_bytes = all_bytes_;
  }

  void read_rows(std::uint32_t, std::int64_t slice, std::int64_t first, std::int64_t count, std::byte* to) override {
    rows_->read(turn_, header.fields[0], slice, first, count, to);
  }

  void read(const std::vector<std::uint32_t>&, const std::vector<std::byte*>& to) override {
    check_claims();
    if (header.reads_rows) return rows_->read_frames(turn_, header.fields[0], to, put);
    if (direct_) {
      const auto loaded = load(to[0], false);
      if (loaded->data != to[0]) throw LoadError("was changed while it was read; try again");
      loaded->data = nullptr;
    } else {
      const auto loaded = load(nullptr, false);
      for (std::size_t n = 0; n < to.size(); ++n) {
        const std::int64_t first = first_ + static_cast<std::int64_t>(n) * frame_stride_;
        copy_voxels(static_cast<const std::byte*>(loaded->data) + first * static_cast<std::int64_t>(size_of(raw_.type)), raw_,
                    turn_, header.fields[0], to[n]);
      }
    }
  }

 private:
  /// Rows can be read alone, and frames by several threads, from one file of raw numbers.
  void find_rows() {
    if (encoding_ != nrrdEncodingRaw || byte_skip_ < 0 || line_skip_ != 0 || files.size() > 2) return;
    const auto frame = static_cast<std::uint64_t>(first_) * size_of(raw_.type);
    RawVoxels stored = raw_;
    stored.swapped = swapped_;
    rows_.emplace(files.back(), frame + static_cast<std::uint64_t>(byte_skip_) + (files.size() == 1 ? header_bytes() : 0),
                  stored, frames_read);
    header.reads_rows = rows_->can_read();
  }

  using Loaded = std::unique_ptr<Nrrd, NrrdDeleter>;

  /// Loads the header alone, or also the voxels, into own memory or to `to`, which must have their size.
  Loaded load(std::byte* to, bool header_only) {
    const std::unique_ptr<NrrdIoState, StateDeleter> state(nrrdIoStateNew());
    state->skipData = header_only ? 1 : 0;
    Loaded nrrd(nrrdNew());
    if (to != nullptr) {
      std::vector<std::size_t> sizes;
      for (unsigned a = 0; a < nrrd_->dim; ++a) sizes.push_back(nrrd_->axis[a].size);
      nrrdWrap_nva(nrrd.get(), to, nrrd_->type, nrrd_->dim, sizes.data());
    }
    if (nrrdLoad(nrrd.get(), path_.c_str(), state.get()) != 0) {
      if (nrrd->data == to) nrrd->data = nullptr;
      if (header_only) list_files(*state);  // refuses files that the sandbox blocks, which NrrdIO does not distinguish
      throw LoadError("cannot be read as NRRD (" + cause() + "); check that the file is whole");
    }
    if (header_only) {
      list_files(*state);
      encoding_ = state->encoding;
      byte_skip_ = state->byteSkip;
      line_skip_ = state->lineSkip;
      swapped_ = state->endian != airEndianUnknown && state->endian != airMyEndian();
    }
    return nrrd;
  }

  /// Refuses headers that claim more voxels than the files can hold, because NrrdIO allocates and fills memory for all before
  /// reading.
  void check_claims() const {
    const bool attached = files.size() == 1;
    const std::uint64_t offset = attached ? header_bytes() : 0;
    std::uint64_t there = 0;
    const std::uint64_t parts = attached ? 1 : files.size() - 1;
    for (std::size_t f = attached ? 0 : 1; f < files.size(); ++f) {
      if (encoding_ == nrrdEncodingGzip) check_claim(files[f], offset, all_bytes_ / parts);
      there += file_bytes(files[f]);
    }
    if (encoding_ == nrrdEncodingGzip) return;
    std::uint64_t least = all_bytes_;
    if (encoding_ == nrrdEncodingAscii) {
      least = all_bytes_ / size_of(raw_.type);  // a number has at least one digit
      if (attached) check_words(offset);
    }
    check_skip(there);
    if (there < least) throw LoadError("is shorter than its header says; get the whole file, or correct its sizes");
  }

  /// Refuses words that are no numbers, of which the library reads the beginning: 1 of "1,5" and of "1d3".
  void check_words(std::uint64_t offset) const {
    detail::InputStream file(path_);
    file.seekg(static_cast<std::streamoff>(offset));
    constexpr int longest = 400;  // of a number; damaged files may lack blanks
    std::uint64_t left = all_bytes_ / size_of(raw_.type);
    for (std::string word; left > 0 && file >> std::setw(longest) >> word; --left) {
      if (!text_number(word))
        throw LoadError("has a word among its numbers that is none; correct it, or write them binary (encoding: raw)");
    }
  }

  /// Header size of a single file: its voxels follow an empty line.
  std::uint64_t header_bytes() const {
    detail::InputStream text(path_);
    for (std::string line; std::getline(text, line) && !line.empty() && line != "\r";) {
    }
    return static_cast<std::uint64_t>(std::max<std::streamoff>(text.tellg(), 0));
  }

  /// Refuses a byte skip that makes voxels of the header: counted from the end of the file, or within the header itself if that
  /// is named as the data file. \param there  bytes of the files with voxels
  void check_skip(std::uint64_t there) const {
    const bool attached = files.size() == 1;
    std::error_code none;
    const bool names_itself = std::ranges::any_of(files.begin() + 1, files.end(), [&](const std::string& file) {
      return std::filesystem::equivalent(file, path_, none);
    });
    if (!(attached && byte_skip_ < 0) && !names_itself) return;
    // Backwards −1 is the last offset at which all voxels fit, −2 a byte before it.
    const double first =
        byte_skip_ < 0 ? static_cast<double>(there) - static_cast<double>(all_bytes_) + static_cast<double>(byte_skip_) + 1.0
                       : static_cast<double>(byte_skip_);
    if (first < static_cast<double>(header_bytes()))
      throw LoadError("has voxels that would begin within its header; get the whole file, or correct its sizes and byte skip");
  }

  std::string beside(const std::string& name) const { return (std::filesystem::path(path_).parent_path() / name).string(); }

  /// Checks the data files in the header before NrrdIO, which opens them unchecked, together with the header. Files of a
  /// pattern are checked when their numbers are known (`list_files`).
  void check_named_files() const {
    detail::InputStream text(path_);
    const auto check = [&](const std::string& line, std::size_t from) {
      const std::string name = trimmed(line.substr(std::min(from, line.size())).c_str());
      if (!name.empty() && name != "-" && name.find('%') == std::string::npos) check_data_file(path_, beside(name));
    };
    std::string line;
    for (std::size_t names = 0; names <= most_data_files && std::getline(text, line) && !trimmed(line.c_str()).empty();) {
      const std::size_t colon = line.find(':');
      const std::string field = line.substr(0, std::min(colon, line.size()));
      if (names > 0) {
        check(line, 0), ++names;
      } else if (colon != std::string::npos && (field == "data file" || field == "datafile")) {
        if (trimmed(line.c_str() + colon + 1).starts_with("LIST")) {
          names = 1;
        } else {
          check(line, colon + 1);
        }
      }
    }
  }

  void list_files(const NrrdIoState& state) {
    files.push_back(path_);
    const auto add = [&](const std::string& name) {
      files.push_back(beside(name));
      check_data_file(path_, files.back());
    };
    if (state.dataFNFormat != nullptr) {
      // Formats like printf, but without it, because the format is from the file. NrrdIO has checked that it has a number.
      const std::string format = state.dataFNFormat;
      const std::size_t percent = format.find('%'), end = format.find('d', percent);
      if (end == std::string::npos) return;
      const bool zeros = format[percent + 1] == '0';
      const auto width = static_cast<std::size_t>(std::clamp(std::atoi(format.c_str() + percent + 1), 0, 64));
      const long step = state.dataFNStep;
      for (long n = state.dataFNMin; step > 0 ? n <= state.dataFNMax : step < 0 && n >= state.dataFNMax; n += step) {
        if (files.size() > most_data_files) throw LoadError("names more than 4096 data files; join them into fewer");
        std::string digits = std::to_string(n);
        if (digits.size() < width) digits.insert(0, width - digits.size(), zeros ? '0' : ' ');
        add(format.substr(0, percent) + digits + format.substr(end + 1));
      }
    } else if (state.dataFNArr != nullptr) {
      for (unsigned i = 0; i < state.dataFNArr->len; ++i) {
        const std::string name = state.dataFN[i] != nullptr ? state.dataFN[i] : "-";
        if (name == "-") throw LoadError("takes its voxels from the standard input; name a data file");
        add(name);
      }
    }
  }

  void find_geometry(const Axes& axes, const Mat3& flip, GridGeometry& grid) {
    const Nrrd& n = *nrrd_;
    Vec3 step[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    Vec3 origin;
    const bool oriented = directed(n, axes.space.front());
    if (oriented) {
      for (std::size_t s = 0; s < axes.space.size(); ++s) step[s] = direction(n, axes.space[s]);
      // A missing axis becomes one voxel across the others, as long as the first axis' step.
      if (axes.space.size() == 1) {
        const Vec3 u = normalized(step[0]);
        step[1] = norm(step[0]) * normalized(cross(u, std::abs(u.x) < 0.6 ? Vec3{1, 0, 0} : Vec3{0, 1, 0}));
      }
      if (axes.space.size() < 3) step[2] = norm(step[0]) * normalized(cross(step[0], step[1]));
    } else {
      for (std::size_t s = 0; s < axes.space.size(); ++s) {
        step[s] = plain_spacing(n.axis[axes.space[s]], static_cast<int>(s), header.warnings) * step[s];
      }
    }
    if (exists(n, n.spaceOrigin)) {
      origin = {n.spaceOrigin[0], n.spaceDim > 1 ? n.spaceOrigin[1] : 0.0, n.spaceDim > 2 ? n.spaceOrigin[2] : 0.0};
    } else if (!oriented) {
      double at[NRRD_DIM_MAX] = {};
      std::vector<unsigned> numbers = axes.space;
      if (nrrdOriginCalculate(&n, numbers.data(), static_cast<unsigned>(axes.space.size()), nrrdCenterCell, at) ==
          nrrdOriginStatusOkay) {
        origin = {at[0], axes.space.size() > 1 ? at[1] : 0.0, axes.space.size() > 2 ? at[2] : 0.0};
      }
    }
    grid.index_to_world_m = flip * from_columns(step[0], step[1], step[2]);
    grid.origin_m = flip * origin;

    for (std::size_t s = 0; s < axes.space.size(); ++s) {
      const std::string unit = trimmed(oriented && s < n.spaceDim ? n.spaceUnits[s] : n.axis[axes.space[s]].units);
      const auto here = palpa::detail::length_unit(unit), before = palpa::detail::length_unit(header.length_unit);
      const bool alike = unit == header.length_unit || (here && before && here->metres == before->metres);
      if (s > 0 && !alike) {
        throw LoadError("has axes in different units ('" + header.length_unit + "' and '" + unit + "'); convert them to one");
      }
      header.length_unit = unit;
    }
  }

  /// Modality as DICOM converters write it beside the voxels: "MR"; empty if it is no scanner modality.
  std::string modality() const {
    for (const char* key : {"modality", "Modality", "DICOM_0008_0060"}) {
      const std::unique_ptr<char, decltype(&std::free)> value(nrrdKeyValueGet(nrrd_.get(), key), &std::free);
      if (!value) continue;
      for (const char* known : {"CT", "MR", "PT", "NM", "US", "SEG"}) {
        if (trimmed(value.get()) == known) return known;
      }
    }
    return {};
  }

  std::string text_of(const std::string& key) const {
    const std::unique_ptr<char, decltype(&std::free)> value(nrrdKeyValueGet(nrrd_.get(), key.c_str()), &std::free);
    return trimmed(value.get());
  }

  /// Names of labels as 3D Slicer writes them into its segmentations; none where segments overlap, in layers that share values.
  std::vector<FilePart> segments() const {
    std::vector<FilePart> named;
    for (std::size_t number = 0; number < most_labels; ++number) {
      const std::string key = "Segment" + std::to_string(number) + "_";
      const std::string value = text_of(key + "LabelValue");
      char* end = nullptr;
      const long label = std::strtol(value.c_str(), &end, 10);
      if (value.empty() || *end != '\0') break;
      if (const std::string layer = text_of(key + "Layer"); !layer.empty() && layer != "0") return {};
      if (const std::string name = text_of(key + "Name"); !name.empty()) named.push_back({name, {}, label});
    }
    return named;
  }

  /// Axes along which vectors were measured, as columns in the file's space.
  Mat3 measurement_frame() const {
    const Nrrd& n = *nrrd_;
    if (n.spaceDim != 3 || !std::isfinite(n.measurementFrame[0][0])) return Mat3::identity();
    const auto column = [&](int i) {
      return Vec3{n.measurementFrame[i][0], n.measurementFrame[i][1], n.measurementFrame[i][2]};
    };
    const Mat3 frame = from_columns(column(0), column(1), column(2));
    if (!is_finite(frame)) throw LoadError("has a measurement frame that is not finite; correct it or leave it out");
    return frame;
  }

  std::string path_;
  Loaded nrrd_;
  const NrrdEncoding* encoding_ = nullptr;
  long byte_skip_ = 0;      ///< before the voxels; negative: from the end
  unsigned line_skip_ = 0;  ///< lines before these bytes
  RawVoxels raw_;
  VectorTurn turn_;
  bool swapped_ = false;  ///< in the file
  std::optional<RawRows> rows_;
  std::int64_t first_ = 0;         ///< index of the first value of the first frame to read
  std::int64_t frame_stride_ = 0;  ///< values from frame to frame
  std::uint64_t all_bytes_ = 0;
  bool direct_ = false;  ///< the library reads directly into the caller's memory
};

}  // namespace

std::unique_ptr<Source> open_nrrd(const protocol::Request& request) { return std::make_unique<NrrdSource>(request); }

}  // namespace palpa::reader
