// Named data sets: volumes, facts of their scans, and requests for them: the interface between scenes and readers of files.
#pragma once

#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "palpa/data/field.h"
#include "palpa/data/grid.h"
#include "palpa/data/timed_field.h"

namespace palpa {

enum class ScanFactKind : std::uint8_t {
  body_part,  ///< "head"
  protocol,   ///< known words of the protocol's name: "head routine"
  image,      ///< shown quantity other than the signal itself: "phase map", "ADC map"
  angiogram,  ///< "yes"
  contrast,   ///< "yes": with a contrast agent
  scanner,    ///< maker and model
  kernel,     ///< of the reconstruction
  sequence,   ///< of MR, in words
  slice_thickness_mm,
  tube_voltage_kv,
  tube_current_ma,
  field_strength_t,
  repetition_time_ms,
  echo_time_ms,
  inversion_time_ms,
  flip_angle_deg,
  b_value_s_per_mm2,
  velocity_range_cm_per_s,  ///< fastest measurable velocity (VENC)
};
inline constexpr std::size_t scan_fact_kinds = 18;
/// Fact of a scan's acquisition, from its file; none is about a person.
struct ScanFact {
  ScanFactKind kind = ScanFactKind::body_part;
  std::string words;    ///< of textual kinds; else empty
  double number = 0.0;  ///< in the kind's own unit, the suffix of its name; finite
  friend bool operator==(const ScanFact&, const ScanFact&) = default;
};

std::string_view name_of(ScanFactKind kind) noexcept;
constexpr bool is_number(ScanFactKind kind) noexcept { return kind >= ScanFactKind::slice_thickness_mm; }

/// Difference of a resampled field from the file's own interpolant: at random places of the data, as shares of the range.
struct ResamplingError {
  double p50 = 0.0;      ///< [1] half of the places have smaller errors
  double p99 = 0.0;      ///< [1]
  double max = 0.0;      ///< [1] of the examined places
  double covered = 1.0;  ///< [1] share of the places where the field has data
  friend bool operator==(const ResamplingError&, const ResamplingError&) = default;
};

/// Resampling of a curvilinear or unstructured grid to an affine one.
struct Resampling {
  std::array<std::int64_t, 3> dims{};    ///< points of the file's grid along its own indices; n, 1, 1 without indices
  std::vector<ValueRange> value_ranges;  ///< of each component, at those points
  ResamplingError by_cell;               ///< at places uniform over cells: boundary layers count most
  ResamplingError by_volume;             ///< at places uniform over space, as for a hand
  friend bool operator==(const Resampling&, const Resampling&) = default;
};

/// A named field of a volume.
struct VolumeField {
  std::string name;  ///< plain word; in scenes `volume.field`
  std::string unit;  ///< a label ("HU", "cm/s"), empty if unknown; converts nothing
  FieldPtr field;
  std::optional<Resampling> resampling{};  ///< none: the field is the file's own interpolant
};

/// Checksums that a reading computes.
enum class Checksums : std::uint8_t {
  none,
  now,    ///< before the reading ends
  later,  ///< in another thread, while the data are already in use
};

/// Checksums of a volume's files, computed by another thread, which ends with this object. Any thread.
class LateChecksums {
 public:
  virtual ~LateChecksums() = default;
  /// `text` does not block.
  virtual bool are_known() const = 0;
  /// In hexadecimal; empty if a file could not be read. Blocks until all are computed. \param file  number in the volume
  virtual std::string text(std::size_t file) const = 0;
};

/// SHA-256 of a file, a value. Any thread.
class Checksum {
 public:
  /// Unknown: `text` is empty.
  Checksum() = default;
  template <std::convertible_to<std::string> Text>
  Checksum(Text&& hexadecimal) : text_(std::forward<Text>(hexadecimal)) {}  // NOLINT: a text is its own checksum
  Checksum(std::shared_ptr<const LateChecksums> later, std::size_t file) : later_(std::move(later)), file_(file) {}

  /// `text` does not block.
  bool is_known() const { return !later_ || later_->are_known(); }
  /// In hexadecimal; empty: unknown. Blocks until it is computed.
  std::string text() const { return later_ ? later_->text(file_) : text_; }
  /// Equal texts. Blocks, except for copies.
  friend bool operator==(const Checksum& a, const Checksum& b) {
    const bool are_copies = a.later_ && a.later_ == b.later_ && a.file_ == b.file_;
    return are_copies || a.text() == b.text();
  }

 private:
  std::string text_;
  std::shared_ptr<const LateChecksums> later_;
  std::size_t file_ = 0;
};

/// Source file of a volume.
struct SourceFile {
  std::string path;
  std::uint64_t bytes = 0;
  Checksum sha256;
};

struct VolumeRequest;

/// Named data set: one or more fields on a grid, or a formula. A value; the voxels are shared.
struct Volume {
  std::vector<VolumeField> fields;
  bool medical_frame = false;         ///< the world is LPS: x to the patient's left, y to the back, z to the head
  std::string format;                 ///< "dicom", "nrrd", "vti", "plot3d", …; "formula" or "grid" of embedded data
  std::string modality;               ///< "CT", "MR", … from the file; empty if unknown
  std::vector<ScanFact> scan;         ///< from the file; each kind at most once
  std::string frame_of_reference;     ///< DICOM's UID of the space of positions; empty if unknown
  std::string length_unit;            ///< of the file, before conversion to metres: "mm"; empty for embedded data
  bool length_unit_assumed = false;   ///< the unit is the format's, given by neither file nor request
  std::vector<SourceFile> files;      ///< empty for embedded data
  int frames = 1;                     ///< in its file; the fields are one of them, or all of them as a time series
  std::vector<std::string> warnings;  ///< half sentences, for the reader of a summary
  std::shared_ptr<const VolumeRequest> request{};  ///< source request; null for embedded data

  /// [m] of the first field.
  Box bounds_m() const noexcept { return fields.front().field->bounds_m(); }
};

/// The volume moved by a pose. Throws as for a field.
Volume posed(const Volume& volume, const Similarity& pose);
/// The volume moved along a track. Throws as for a field.
Volume moving(const Volume& volume, const PoseTrack& track);
/// Every field as a grid. Throws as for a field.
Volume sampled(const Volume& volume, int longest);
/// Every field as a series of grids. Throws as for a field.
Volume sampled(const Volume& volume, int longest, int frames, BetweenFrames between_frames = BetweenFrames::linear);
/// Every field with another filter; throws as for a field, and a sentence names the field. Without a filter: each trilinear
/// grid gets its default, all else stays. `Scene::add` does so, so that data from files, embedded data and data of a program
/// are felt alike; `read_volume` and `grid_field` themselves give trilinear fields.
Volume filtered(Volume volume, std::optional<Filter> filter = {});

/// The volume with signless vector fields. Throws as above, and without vector fields.
Volume signless(Volume volume);

/// Properties of an array that its file leaves open.
struct ArrayLayout {
  std::string type;                    ///< "int16": of a file of bare numbers; empty: given by the file
  std::string byte_order;              ///< "big"; "little" or empty: little
  std::int64_t header_bytes = 0;       ///< before the first voxel
  std::string axes;                    ///< "zyx": grid axis of each index, slowest first; empty: "zyx"
  std::string components;              ///< index of vector components: "first" or "last"; empty: last if it is of 3
  std::array<std::int64_t, 3> dims{};  ///< voxels along x, y, z; 0: not given
  Vec3 spacing_m;                      ///< [m] 0: not given
  std::optional<Vec3> origin_m;        ///< [m]
  friend bool operator==(const ArrayLayout&, const ArrayLayout&) = default;
};

/// A scene's `[volume.NAME]`.
struct VolumeRequest {
  std::vector<std::filesystem::path> files;  ///< resolved: they exist
  std::string length_unit;                   ///< "m", "mm", … or empty: the file's own, else the default
  struct FieldRequest {
    std::string name;                   ///< field name in the scene
    std::string array;                  ///< array name in the file; empty: `name`
    std::string unit;                   ///< label; empty: the file's
    std::vector<std::string> arrays{};  ///< three scalar arrays instead of `array`: the components of a vector along x, y and z
    friend bool operator==(const FieldRequest&, const FieldRequest&) = default;
  };
  std::vector<FieldRequest> fields;  ///< empty: all, under the file's names
  std::string as;                    ///< "vector" if a file of three frames is one vector; else empty
  static constexpr int all_frames = -2;
  int frame = -1;                   ///< of a file with several; -1: not given; `all_frames`: as time series, a second apart
  std::string series;               ///< of a DICOM folder with several, its UID; empty: the largest
  std::string components_along;     ///< "index": vectors are along the grid's axes; "file" or empty: by the format
  std::optional<double> time_s;     ///< [s] of a case with several moments; none: the latest
  std::optional<Box> crop;          ///< [m] region for resampling of a curvilinear or unstructured grid
  std::optional<double> memory_mb;  ///< [MB] a store whose octave 0 takes more is felt through windows; none: 512
  /// [mm] in the file's frame: octaves with wider voxels of a volume that is felt through windows are no data; none: all are.
  std::optional<double> coarsest_mm;
  ArrayLayout layout;  ///< of an array in an HDF5 file, or of a file of bare numbers
};

/// File with a path inside it: "flow.h5:/velocity" is the array /velocity of flow.h5.
struct PlaceInFile {
  std::filesystem::path file;
  std::string inside;  ///< begins with '/'; empty: the whole file
};
/// Splits a path at the last ":/" unless a file or folder of that whole name exists.
PlaceInFile place_in_file(const std::filesystem::path& path);

/// Reader of a scene's files: injected, so that scenes need no reader. Throws LoadError.
using VolumeReader = std::function<Volume(const VolumeRequest&)>;

}  // namespace palpa
