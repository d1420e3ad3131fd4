// A named data set, and what is done to all of its fields.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "palpa/grid/filter.h"
#include "palpa/grid/sampled.h"
#include "palpa/time/moving.h"
#include "palpa/time/time_series.h"
#include "palpa/volume/scan_facts.h"

namespace palpa {

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
  std::array<std::int64_t, 3> dims{};  ///< points of the file's grid along its own indices; n, 1, 1 where it has none
  std::vector<Extent> extents;         ///< of each component, at those points
  ResamplingError by_cell;             ///< at places that hit every cell as often: boundary layers count most
  ResamplingError by_volume;           ///< at places that hit every part of space as often, as a hand does
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

}  // namespace palpa
