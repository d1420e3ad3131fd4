// Volume from the images of a DICOM series: grouping, order, positions and number type.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "dicom_traits.h"
#include "palpa/base/printed.h"
#include "source.h"

namespace palpa::reader {

inline std::string text_of(double number) { return detail::text("%.6g", number); }

/// Header of an image: a file's only image, or one of its frames.
struct Slice {
  int file = 0;   ///< index of the file
  int frame = 0;  ///< index within the file
  std::string series;
  std::string instance;                    ///< UID of the file's image
  std::string space;                       ///< UID of the frame of reference; empty: none
  std::array<std::int64_t, 2> size{1, 1};  ///< columns, rows
  RawType type = RawType::uint16;
  int bits = 16;                                 ///< [bits] stored
  int first_bit = 0;                             ///< lowest stored bit; lower bits do not belong to the number
  std::array<double, 2> spacing_mm{1, 1};        ///< from column to column, from row to row
  double thickness_mm = 0.0;                     ///< distance to the next slice if the file has no other; 0: unknown
  bool spaced = false;                           ///< `spacing_mm` is in the file
  bool placed = false;                           ///< position and directions are the patient's (LPS)
  Vec3 position_mm;                              ///< centre of the first pixel
  Vec3 right{1, 0, 0}, down{0, 1, 0};            ///< [1] directions of rows and columns
  double slope = 1.0;                            ///< the value's own unit, per raw step
  double intercept = 0.0;                        ///< the value's own unit
  std::optional<std::array<double, 2>> padding;  ///< raw values from the first to the second are no measurement
  double number = 0.0;                           ///< of the file's image in its series
  std::vector<Trait> traits{};                   ///< differences from other images at its position
  std::vector<std::string> rest{};               ///< other elements of its functional groups
  bool sparse = false;                           ///< the file omits empty images
  bool blank = false;                            ///< inserted for an omitted image: all raw numbers are 0

  bool negative() const noexcept { return type == RawType::int8 || type == RawType::int16 || type == RawType::int32; }
  std::uint64_t pixels() const noexcept { return static_cast<std::uint64_t>(size[0]) * static_cast<std::uint64_t>(size[1]); }
  /// Range of raw numbers in its bits.
  double least() const noexcept { return negative() ? -std::ldexp(1.0, bits - 1) : 0.0; }
  double greatest() const noexcept { return std::ldexp(1.0, negative() ? bits - 1 : bits) - 1; }
};

/// Groups of slices that can form one volume: of one series, size, type, spacing and orientation, ordered by their first
/// slices.
std::vector<std::vector<Slice>> stacks_of(std::vector<Slice> slices);

/// Volume from slices of one stack.
struct Arranged {
  std::vector<std::vector<Slice>> frames;  ///< with equal numbers of slices, in order along their normal
  std::string differ;                      ///< difference between the frames; empty: one frame
  GridGeometry grid;                       ///< [mm] of the resulting volume
  bool resampled = false;                  ///< layers are interpolated between slices
  std::vector<double> layer_at;            ///< [slices] position of each layer, if resampled
};

/// Sorts a stack into a volume. The line of positions may be oblique to the slices: a gantry tilt shears the grid. Images at
/// one position become frames (dicom_frames.h); unevenly spaced slices are resampled. Throws LoadError if they form no volume.
Arranged arranged(std::vector<Slice> stack, std::vector<std::string>& warnings);

/// Number type of the stored slices: kept = raw · factor + shift, value = kept · scale + offset.
struct Numbers {
  VoxelType type = VoxelType::int16;
  double scale = 1.0;   ///< the value's own unit, per kept step
  double offset = 0.0;  ///< the value's own unit
};
struct ToKept {
  double factor = 1.0;
  double shift = 0.0;
};

/// Raw numbers for slices of one slope and intercept; else whole steps of a common slope, if exact; else, and for padding
/// (NaN), floating point.
Numbers common_numbers(const std::vector<Slice>& stack);
ToKept to_kept(const Slice& slice, const Numbers& numbers) noexcept;

}  // namespace palpa::reader
