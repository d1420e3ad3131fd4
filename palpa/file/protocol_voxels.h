// Conversion of a file's voxels to those of the protocol and of Palpa.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "palpa/file/protocol.h"

namespace palpa::protocol {

/// Number types of files.
enum class RawType : std::uint8_t { int8, uint8, int16, uint16, int32, uint32, int64, uint64, float32, float64 };

std::size_t size_of(RawType type) noexcept;

/// Calls `use` with a value of the C++ type of `type`.
template <class Use>
void with_type(RawType type, Use use) {
  switch (type) {
    case RawType::int8: return use(std::int8_t{});
    case RawType::uint8: return use(std::uint8_t{});
    case RawType::int16: return use(std::int16_t{});
    case RawType::uint16: return use(std::uint16_t{});
    case RawType::int32: return use(std::int32_t{});
    case RawType::uint32: return use(std::uint32_t{});
    case RawType::int64: return use(std::int64_t{});
    case RawType::uint64: return use(std::uint64_t{});
    case RawType::float32: return use(float{});
    case RawType::float64: return use(double{});
  }
}

template <class Use>
void with_type(VoxelType type, Use use) {
  switch (type) {
    case VoxelType::uint8: return use(std::uint8_t{});
    case VoxelType::int16: return use(std::int16_t{});
    case VoxelType::uint16: return use(std::uint16_t{});
    case VoxelType::int32: return use(std::int32_t{});
    case VoxelType::float32: return use(float{});
    case VoxelType::float64: return use(double{});
  }
}

/// Smallest type that holds the numbers of a raw one exactly; float64 for integers of 64 bits.
VoxelType exact_type(RawType type) noexcept;

/// Voxels in a library's memory. Strides count numbers, not bytes.
struct RawVoxels {
  RawType type = RawType::uint8;
  std::array<std::int64_t, 3> dims{1, 1, 1};
  std::array<std::int64_t, 3> stride{1, 1, 1};
  std::int64_t component_stride = 1;
  int components = 1;
  bool swapped = false;  ///< byte order opposite to this machine's
};

/// Type by name: "int16". Throws LoadError.
RawType type_named(std::string_view name);

/// Axes of an array's indices, slowest first: "zyx" by default. Throws LoadError.
std::string axes_of(const ArrayLayout& layout);

/// Array of indices of these lengths, slowest first; with four, vector components are at the layout's index, or at the only
/// possible one of length 3. Throws LoadError if the layout does not fit.
RawVoxels arranged(RawType type, const std::vector<std::int64_t>& lengths, const ArrayLayout& layout);

/// Geometry of an array: its steps and origin; `header` receives whether they are in metres.
GridGeometry placed_by(const ArrayLayout& layout, Header& header);

/// Rotation of vector components to the world: value = axes · (raw · scale + offset).
struct VectorTurn {
  Mat3 axes = Mat3::identity();
  double scale = 1.0;   ///< [1]
  double offset = 0.0;  ///< the field's own unit

  /// Whether it is the identity.
  bool none() const noexcept { return axes == Mat3::identity(); }
};

/// Turn of vectors with components along the axes of the grid, not of its space.
Mat3 unit_axes(const GridGeometry& grid) noexcept;

/// Sets in `field` the type for voxels of `raw`: their own; the next exact one (int8 → int16, uint32 → float64); float64 with a
/// warning (64-bit integers); or, for rotated vectors, a floating type, with scale and offset applied.
void keep(const RawVoxels& raw, VectorTurn& turn, FieldHeader& field, std::vector<std::string>& warnings);

/// Whether the file's voxels need no conversion.
bool kept_as_they_are(const RawVoxels& raw, const VectorTurn& turn, const FieldHeader& field) noexcept;

/// Copies voxels from `first` to `to` as set by `keep`.
void copy_voxels(const void* first, const RawVoxels& raw, const VectorTurn& turn, const FieldHeader& field, std::byte* to);

}  // namespace palpa::protocol
