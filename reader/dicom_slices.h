// How the images of a DICOM series become a volume: which images belong together, in which order, where they lie, and in which
// numbers they are kept.
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

/// A number as messages have it.
inline std::string text_of(double number) { return detail::text("%.6g", number); }

/// What the header says of an image: a file's only one, or one of its frames.
struct Slice {
  int file = 0;   ///< its number among the files
  int frame = 0;  ///< in its file
  std::string series;
  std::string instance;                    ///< UID of the file's image
  std::string space;                       ///< UID of the frame of reference; empty: none is said
  std::array<std::int64_t, 2> size{1, 1};  ///< columns, rows
  RawType type = RawType::uint16;
  int bits = 16;                                 ///< [bits] that a number can fill
  int first_bit = 0;                             ///< of a number in its place; those below are not its own
  std::array<double, 2> spacing_mm{1, 1};        ///< from column to column, from row to row
  double thickness_mm = 0.0;                     ///< distance to the next slice if nothing else says it; 0: unknown
  bool spaced = false;                           ///< `spacing_mm` is said
  bool placed = false;                           ///< position and directions are the patient's (LPS)
  Vec3 position_mm;                              ///< centre of the first pixel
  Vec3 right{1, 0, 0}, down{0, 1, 0};            ///< [1] directions of rows and columns
  double slope = 1.0;                            ///< the value's own unit, per raw step
  double intercept = 0.0;                        ///< the value's own unit
  std::optional<std::array<double, 2>> padding;  ///< raw values from the first to the second are no measurement
  double number = 0.0;                           ///< of the file's image in its series
  std::vector<Trait> traits{};                   ///< by which it is told apart from others at its place
  std::vector<std::string> rest{};               ///< what else its functional groups say
  bool sparse = false;                           ///< images that are empty are left out of its file
  bool blank = false;                            ///< such an image, put in: all its raw numbers are 0

  bool negative() const noexcept { return type == RawType::int8 || type == RawType::int16 || type == RawType::int32; }
  std::uint64_t pixels() const noexcept { return static_cast<std::uint64_t>(size[0]) * static_cast<std::uint64_t>(size[1]); }
  /// The range of raw numbers that its bits can represent.
  double least() const noexcept { return negative() ? -std::ldexp(1.0, bits - 1) : 0.0; }
  double greatest() const noexcept { return std::ldexp(1.0, negative() ? bits - 1 : bits) - 1; }
};

/// Groups of slices that can be one volume: of one series, size, type, spacing and orientation, in the order of the first slice
/// of each.
std::vector<std::vector<Slice>> stacks_of(std::vector<Slice> slices);

/// A volume from slices of one stack.
struct Arranged {
  std::vector<std::vector<Slice>> frames;  ///< frames of equally many slices, which rise along their normal
  std::string differ;                      ///< what the frames differ in; empty: there is one
  GridGeometry grid;                       ///< [mm] of the volume that is handed over
  bool resampled = false;                  ///< its layers are not the slices but are interpolated between them
  std::vector<double> layer_at;            ///< [slices] place of each layer, if resampled
};

/// Sorts a stack into a volume. Slices need not be at right angles to the line along which they lie: a gantry tilt shears the
/// grid. Images at one place become frames (dicom_frames.h); unevenly spaced slices have to be resampled. Throws LoadError
/// where slices make no volume.
Arranged arranged(std::vector<Slice> stack, std::vector<std::string>& warnings);

/// The numbers in which slices are kept: kept = raw · factor + shift, value = kept · scale + offset.
struct Numbers {
  VoxelType type = VoxelType::int16;
  double scale = 1.0;   ///< the value's own unit, per kept step
  double offset = 0.0;  ///< the value's own unit
};
struct ToKept {
  double factor = 1.0;
  double shift = 0.0;
};

/// Raw numbers where all slices have one slope and intercept; else whole steps of a common slope, if they are exact; else
/// floating point. Also floating point where slices have padding, which is kept as NaN.
Numbers common_numbers(const std::vector<Slice>& stack);
ToKept to_kept(const Slice& slice, const Numbers& numbers) noexcept;

}  // namespace palpa::reader
