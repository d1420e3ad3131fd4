// From the voxels of a file to those that the protocol hands over and Palpa keeps.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "palpa/file/protocol.h"

namespace palpa::protocol {

/// The number types that files have.
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

/// The first type that holds the numbers of a raw one exactly; float64 for integers of 64 bits.
VoxelType exact_type(RawType type) noexcept;

/// Voxels in a library's memory. Strides count numbers, not bytes.
struct RawVoxels {
  RawType type = RawType::uint8;
  std::array<std::int64_t, 3> dims{1, 1, 1};
  std::array<std::int64_t, 3> stride{1, 1, 1};
  std::int64_t component_stride = 1;
  int components = 1;
  bool swapped = false;  ///< in the other byte order than this machine's
};

/// The type with this name: "int16". Throws LoadError.
RawType type_named(std::string_view name);

/// The axes that the indices of an array are along, slowest first: "zyx" where the layout says nothing. Throws LoadError.
std::string axes_of(const ArrayLayout& layout);

/// An array whose indices have these lengths, slowest first; one of four has vector components, where the layout says or, of
/// length 3, where no other can be them. Throws LoadError where it does not fit the layout.
RawVoxels arranged(RawType type, const std::vector<std::int64_t>& lengths, const ArrayLayout& layout);

/// Where an array lies: its steps and origin, and in `header` whether they are in metres.
GridGeometry placed_by(const ArrayLayout& layout, Header& header);

/// How vector components get into the world: value = axes · (raw · scale + offset).
struct Turn {
  Mat3 axes = Mat3::identity();
  double scale = 1.0;   ///< [1]
  double offset = 0.0;  ///< the field's own unit

  /// Nothing to do.
  bool none() const noexcept { return axes == Mat3::identity(); }
};

/// Turn of vectors whose components are along the axes of the grid, not along those of its space.
Mat3 unit_axes(const GridGeometry& grid) noexcept;

/// Tells in `field` how voxels of `raw` will be kept: in their own type; the next one that holds them
/// exactly (int8 → int16, uint32 → float64); float64 with a warning (64-bit integers); or, for vectors that
/// are turned, a floating type, with scale and offset worked in.
void keep(const RawVoxels& raw, Turn& turn, FieldHeader& field, std::vector<std::string>& warnings);

/// True when the file's voxels, read as they are, already are what is kept.
bool kept_as_they_are(const RawVoxels& raw, const Turn& turn, const FieldHeader& field) noexcept;

/// Copies voxels that start at `first` to `to` as `keep` said.
void copy_voxels(const void* first, const RawVoxels& raw, const Turn& turn, const FieldHeader& field, std::byte* to);

}  // namespace palpa::protocol
