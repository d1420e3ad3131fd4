// Named data sets: what a volume is, how its scan was made, and how one is asked for: the seam between scenes and whatever
// opens files.
#pragma once

#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "palpa/data/field.h"
#include "palpa/data/grid.h"
#include "palpa/data/timed_field.h"

namespace palpa {

enum class ScanFactKind : std::uint8_t {
  body_part,  ///< "head"
  protocol,   ///< the known words of the protocol's name: "head routine"
  image,      ///< what is shown where that is not the signal itself: "phase map", "ADC map"
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
  velocity_range_cm_per_s,  ///< fastest velocity that is measured (VENC)
};
inline constexpr std::size_t scan_fact_kinds = 18;
/// One fact of how a scan was made, as its file says it; none of them is about a person.
struct ScanFact {
  ScanFactKind kind = ScanFactKind::body_part;
  std::string words;    ///< of kinds that are said in words; else empty
  double number = 0.0;  ///< in the kind's own unit, which its name ends with; finite
  friend bool operator==(const ScanFact&, const ScanFact&) = default;
};

/// The kind's name: "body_part", …
std::string_view name_of(ScanFactKind kind) noexcept;
/// Whether facts of this kind are numbers.
constexpr bool is_number(ScanFactKind kind) noexcept { return kind >= ScanFactKind::slice_thickness_mm; }

/// How much a field differs from the file's own interpolant, where its grid was made anew: at random places of the data, as
/// shares of the range.
struct ResamplingError {
  double p50 = 0.0;      ///< [1] half of the places are wrong by less
  double p99 = 0.0;      ///< [1]
  double max = 0.0;      ///< [1] of the places looked at
  double covered = 1.0;  ///< [1] share of the places where the field has data at all
  friend bool operator==(const ResamplingError&, const ResamplingError&) = default;
};

/// What was put onto an affine grid, because its own is curvilinear or unstructured.
struct Resampling {
  std::array<std::int64_t, 3> dims{};    ///< points of the file's grid along its own indices; n, 1, 1 where it has none
  std::vector<ValueRange> value_ranges;  ///< of each component, at those points
  ResamplingError by_cell;               ///< at places that hit every cell as often: boundary layers count most
  ResamplingError by_volume;             ///< at places that hit every part of space as often, as a hand does
  friend bool operator==(const Resampling&, const Resampling&) = default;
};

/// One field of a volume.
struct VolumeField {
  std::string name;  ///< plain word; how scenes name it: `volume.field`
  std::string unit;  ///< a label ("HU", "cm/s"), empty if unknown; converts nothing
  FieldPtr field;
  std::optional<Resampling> resampling{};  ///< none: the field is the file's own interpolant
};

/// A file that a volume was read from.
struct SourceFile {
  std::string path;
  std::uint64_t bytes = 0;
  std::string sha256;  ///< hexadecimal
};

struct VolumeRequest;

/// A named data set: one or more fields on one grid, or one formula. A value; the voxels are shared.
struct Volume {
  std::vector<VolumeField> fields;
  bool medical_frame = false;         ///< the world is LPS: x to the patient's left, y to the back, z to the head
  std::string format;                 ///< "dicom", "nrrd", "vti", "plot3d", …; "formula" or "grid" of embedded data
  std::string modality;               ///< "CT", "MR", … as the file says it; empty if it does not
  std::vector<ScanFact> scan;         ///< how it was made, as the file says it; each kind at most once
  std::string frame_of_reference;     ///< DICOM's UID of the space that positions are in; empty if the file does not say it
  std::string length_unit;            ///< of the file, before its lengths became metres: "mm"; empty for embedded data
  bool length_unit_assumed = false;   ///< neither the file nor the request says it: it is that of the format
  std::vector<SourceFile> files;      ///< empty for embedded data
  int frames = 1;                     ///< that its file holds; the fields are one of them, or all of them as a time series
  std::vector<std::string> warnings;  ///< half sentences, for the reader of a summary
  std::shared_ptr<const VolumeRequest> request{};  ///< what it was read by; null for embedded data

  /// Box of the first field [m].
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
/// Every field through another filter; throws as for a field, and a sentence names the field. Without a filter: each trilinear
/// grid gets its default, and all else stays. That is what `Scene::add` does, so that data from files, embedded data and data
/// of a program are felt alike; `read_volume` and `grid_field` themselves give trilinear fields.
Volume filtered(Volume volume, std::optional<Filter> filter = {});

/// The volume with its vector fields without sign. Throws as above, and where there is no vector field.
Volume signless(Volume volume);

/// What an array of a file does not say about itself.
struct ArrayLayout {
  std::string type;                    ///< "int16": of a file of bare numbers; empty: the file says it
  std::string byte_order;              ///< "big"; "little" or empty: little
  std::int64_t header_bytes = 0;       ///< before the first voxel
  std::string axes;                    ///< "zyx": which of the grid's axes each index is, slowest first; empty: that
  std::string components;              ///< where vector components are: "first" or "last" index; empty: last if it is of 3
  std::array<std::int64_t, 3> dims{};  ///< voxels along x, y, z; 0: not said
  Vec3 spacing_m;                      ///< [m] 0: not said
  std::optional<Vec3> origin_m;        ///< [m]
  friend bool operator==(const ArrayLayout&, const ArrayLayout&) = default;
};

/// What a scene's `[volume.NAME]` says about the file besides its path.
struct VolumeRequest {
  std::vector<std::filesystem::path> files;  ///< resolved: they exist
  std::string length_unit;                   ///< "m", "mm", … or empty: the file's own, else the default
  struct FieldRequest {
    std::string name;                   ///< how the scene names the field
    std::string array;                  ///< the file's name of the array; empty: the same
    std::string unit;                   ///< label; empty: the file's
    std::vector<std::string> arrays{};  ///< instead of `array` three scalar ones: the components of a vector along x, y and z
    friend bool operator==(const FieldRequest&, const FieldRequest&) = default;
  };
  std::vector<FieldRequest> fields;  ///< empty: all, under the file's names
  std::string as;                    ///< "vector" where a file of three frames is one vector; else empty
  static constexpr int all_frames = -2;
  int frame = -1;                ///< of a file with several; -1: not said; `all_frames`: as time series, a second apart
  std::string series;            ///< of a DICOM folder with several, its UID; empty: the largest
  std::string components_along;  ///< "index": vectors are along the grid's axes; "file" or empty: as the format says
  std::optional<double> time_s;  ///< [s] of a case with several moments; none: the latest
  std::optional<Box> crop;       ///< [m] the part that a curvilinear or unstructured grid is resampled in
  ArrayLayout layout;            ///< of an array in an HDF5 file, or of a file of bare numbers
};

/// A file, and what is meant inside it: "flow.h5:/velocity" is the array /velocity of flow.h5.
struct PlaceInFile {
  std::filesystem::path file;
  std::string inside;  ///< begins with '/'; empty: all of it
};
/// Splits a path at the last ":/" unless there is a file or folder of that whole name.
PlaceInFile place_in_file(const std::filesystem::path& path);

/// How a scene's files are opened: injected, so that scenes need no reader. Throws LoadError.
using VolumeReader = std::function<Volume(const VolumeRequest&)>;

}  // namespace palpa
