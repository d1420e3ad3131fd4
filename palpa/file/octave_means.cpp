#include "palpa/file/octave_means.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <type_traits>

#include "palpa/file/row_crc.h"

namespace palpa::detail {
namespace {

template <class Act>
void with_type(VoxelType type, const Act& act) {
  switch (type) {
    case VoxelType::uint8: return act(std::uint8_t{});
    case VoxelType::int16: return act(std::int16_t{});
    case VoxelType::uint16: return act(std::uint16_t{});
    case VoxelType::int32: return act(std::int32_t{});
    case VoxelType::float32: return act(float{});
    case VoxelType::float64: return act(double{});
  }
}

/// Number in which eight of a type are summed: exact for whole numbers.
template <class T>
using Sum =
    std::conditional_t<std::is_floating_point_v<T>, double, std::conditional_t<sizeof(T) == 4, std::int64_t, std::int32_t>>;

/// \param halvings  [1] the sum is of 2^halvings numbers
template <class T>
T mean(Sum<T> sum, int halvings) noexcept {
  if constexpr (std::is_floating_point_v<T>) {
    const double mean = sum * (1.0 / static_cast<double>(1 << halvings));
    return std::isfinite(mean) ? static_cast<T>(mean) : std::numeric_limits<T>::quiet_NaN();  // one NaN of many
  } else {
    return static_cast<T>((sum + ((Sum<T>{1} << halvings) >> 1)) >> halvings);  // towards −∞, so a half goes up
  }
}

/// Offset of a voxel, in voxels.
std::int64_t place(const VoxelIndex& size, std::int64_t i, std::int64_t j, std::int64_t k) noexcept {
  return (k * size[1] + j) * size[0] + i;
}

/// Row of means of a scalar: of up to four rows.
template <class T>
void halve_row(const T* const (&rows)[4], int count, std::int64_t valid, T* to) noexcept {
  const int across = count == 4 ? 2 : count == 2 ? 1 : 0;
  const std::int64_t pairs = valid / 2;
  const T* const r0 = rows[0];
  const T* const r1 = rows[1];
  const T* const r2 = rows[2];
  const T* const r3 = rows[3];
  if (count == 4) {
    for (std::int64_t i = 0; i < pairs; ++i) {
      const Sum<T> one = Sum<T>(r0[2 * i]) + r0[2 * i + 1], two = Sum<T>(r1[2 * i]) + r1[2 * i + 1];
      const Sum<T> three = Sum<T>(r2[2 * i]) + r2[2 * i + 1], four = Sum<T>(r3[2 * i]) + r3[2 * i + 1];
      to[i] = mean<T>((one + two) + (three + four), 3);
    }
  } else {
    for (std::int64_t i = 0; i < pairs; ++i) {
      Sum<T> sum = Sum<T>(r0[2 * i]) + r0[2 * i + 1];
      if (count == 2) sum += Sum<T>(r1[2 * i]) + r1[2 * i + 1];
      to[i] = mean<T>(sum, across + 1);
    }
  }
  if (valid % 2 == 1) {
    Sum<T> sum = 0;
    for (int n = 0; n < count; ++n) sum += Sum<T>(rows[n][valid - 1]);
    to[pairs] = mean<T>(sum, across);
  }
}

template <class T>
void halve_vectors(int components, const T* const (&rows)[4], int count, std::int64_t valid, T* to) noexcept {
  const int across = count == 4 ? 2 : count == 2 ? 1 : 0;
  for (std::int64_t i = 0; 2 * i < valid; ++i)
    for (int c = 0; c < components; ++c) {
      const bool two = 2 * i + 1 < valid;
      Sum<T> sum = 0;
      for (int n = 0; n < count; ++n) {
        const T* const first = rows[n] + 2 * i * components + c;
        sum += two ? Sum<T>(first[0]) + first[components] : Sum<T>(first[0]);
      }
      to[i * components + c] = mean<T>(sum, across + (two ? 1 : 0));
    }
}

template <class T>
void halve_as(int components, const VoxelBlock& fine, VoxelBlock& coarse, const VoxelIndex& at) noexcept {
  const T* const from = reinterpret_cast<const T*>(fine.voxels.data());
  T* const to = reinterpret_cast<T*>(coarse.voxels.data());
  for (std::int64_t k = 0; k < fine.valid[2]; k += 2)
    for (std::int64_t j = 0; j < fine.valid[1]; j += 2) {
      const T* rows[4] = {};
      int count = 0;
      for (std::int64_t dk = k; dk < std::min(k + 2, fine.valid[2]); ++dk)
        for (std::int64_t dj = j; dj < std::min(j + 2, fine.valid[1]); ++dj)
          rows[count++] = from + place(fine.size, 0, dj, dk) * components;
      T* const row = to + place(coarse.size, at[0], at[1] + j / 2, at[2] + k / 2) * components;
      components == 1 ? halve_row<T>(rows, count, fine.valid[0], row)
                      : halve_vectors<T>(components, rows, count, fine.valid[0], row);
    }
}

/// Range and loss of a row, and its count of numbers with a loss.
template <class T>
struct RowFacts {
  T min = std::numeric_limits<T>::max(), max = std::numeric_limits<T>::lowest();
  double squares = 0.0;
  std::int64_t finite = 0;

  void add_range(const T* row, std::int64_t numbers) noexcept {
    if constexpr (std::is_floating_point_v<T>) {
      for (std::int64_t n = 0; n < numbers; ++n) {
        if (!std::isfinite(row[n])) continue;
        min = std::min(min, row[n]), max = std::max(max, row[n]), ++finite;
      }
    } else {
      T low = min, high = max;
      for (std::int64_t n = 0; n < numbers; ++n) low = std::min(low, row[n]), high = std::max(high, row[n]);
      min = low, max = high, finite += numbers;
    }
  }

  /// \return  [1] numbers that lose something finite
  std::int64_t add_loss(int components, const T* row, const T* means, std::int64_t voxels) noexcept {
    if constexpr (sizeof(T) < 4) {
      std::uint64_t sum = 0;
      if (components == 1) {
        // In pieces that a compiler takes several voxels of at once; sums of a piece fit 32 bits where numbers have 8.
        constexpr std::int64_t piece = 64;
        T upper[piece];
        for (std::int64_t first = 0; first < voxels; first += piece) {
          const std::int64_t count = std::min(piece, voxels - first);
          for (std::int64_t m = 0; m < (count + 1) / 2; ++m) upper[2 * m] = upper[2 * m + 1] = means[first / 2 + m];
          std::conditional_t<sizeof(T) == 1, std::uint32_t, std::uint64_t> part = 0;
          for (std::int64_t i = 0; i < count; ++i) {
            const auto lost = static_cast<std::uint32_t>(std::abs(std::int32_t{row[first + i]} - std::int32_t{upper[i]}));
            part += decltype(part){lost} * lost;
          }
          sum += part;
        }
      } else {
        for (std::int64_t i = 0; i < voxels; ++i)
          for (int c = 0; c < components; ++c) {
            const std::int64_t lost = std::int64_t{row[i * components + c]} - std::int64_t{means[i / 2 * components + c]};
            sum += static_cast<std::uint64_t>(lost * lost);
          }
      }
      squares += static_cast<double>(sum);
      return voxels * components;
    } else {
      std::int64_t counted = 0;
      for (std::int64_t i = 0; i < voxels; ++i)
        for (int c = 0; c < components; ++c) {
          const double lost = static_cast<double>(row[i * components + c]) - static_cast<double>(means[i / 2 * components + c]);
          if (!std::isfinite(lost)) continue;
          squares += lost * lost, ++counted;
        }
      return counted;
    }
  }
};

template <class T>
ChunkFacts facts_as(int components, const VoxelBlock& block, const VoxelIndex& low, const VoxelIndex& count,
                    const VoxelBlock* coarse, const VoxelIndex& at) noexcept {
  const T* const voxels = reinterpret_cast<const T*>(block.voxels.data());
  const T* const means = coarse ? reinterpret_cast<const T*>(coarse->voxels.data()) : nullptr;
  RowFacts<T> facts;
  std::int64_t with_loss = 0;
  RowCrc crc;
  for (std::int64_t k = low[2]; k < low[2] + count[2]; ++k)
    for (std::int64_t j = low[1]; j < low[1] + count[1]; ++j) {
      const T* const row = voxels + place(block.size, low[0], j, k) * components;
      const std::int64_t numbers = count[0] * components;
      facts.add_range(row, numbers);
      crc.add(row, static_cast<std::size_t>(numbers) * sizeof(T));
      if (!means) continue;
      const T* const mean_row = means + place(coarse->size, at[0] + low[0] / 2, at[1] + j / 2, at[2] + k / 2) * components;
      with_loss += facts.add_loss(components, row, mean_row, count[0]);
    }
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  return {.min = facts.finite > 0 ? static_cast<double>(facts.min) : none,
          .max = facts.finite > 0 ? static_cast<double>(facts.max) : none,
          .rms = with_loss > 0 ? std::sqrt(facts.squares / static_cast<double>(with_loss)) : 0.0,
          .crc32 = static_cast<double>(crc.value())};
}

}  // namespace

VoxelBlock zero_block(const VoxelKind& kind, const VoxelIndex& size, const VoxelIndex& valid) {
  return {size, valid, std::vector<std::byte>(static_cast<std::size_t>(size[0] * size[1] * size[2]) * kind.bytes())};
}

void halve(const VoxelKind& kind, const VoxelBlock& fine, VoxelBlock& coarse, const VoxelIndex& at) noexcept {
  with_type(kind.type, [&](auto number) { halve_as<decltype(number)>(kind.components, fine, coarse, at); });
  if (!kind.is_rounded) return;
  double* const means = reinterpret_cast<double*>(coarse.voxels.data());
  for (std::int64_t k = 0; 2 * k < fine.valid[2]; ++k)
    for (std::int64_t j = 0; 2 * j < fine.valid[1]; ++j) {
      double* const row = means + place(coarse.size, at[0], at[1] + j, at[2] + k) * kind.components;
      for (std::int64_t n = 0; n < (fine.valid[0] + 1) / 2 * kind.components; ++n) row[n] = std::floor(row[n] + 0.5);
    }
}

ChunkFacts facts_of(const VoxelKind& kind, const VoxelBlock& block, const VoxelIndex& low, const VoxelIndex& size,
                    const VoxelBlock* coarse, const VoxelIndex& at) {
  ChunkFacts facts;
  VoxelIndex count{};
  for (std::size_t a = 0; a < 3; ++a) count[a] = std::clamp<std::int64_t>(block.valid[a] - low[a], 0, size[a]);
  with_type(kind.type,
            [&](auto number) { facts = facts_as<decltype(number)>(kind.components, block, low, count, coarse, at); });
  return facts;
}

void copy_voxels(std::size_t voxel_bytes, const std::byte* from, const VoxelIndex& from_size, const VoxelIndex& from_low,
                 std::byte* to, const VoxelIndex& to_size, const VoxelIndex& to_low, const VoxelIndex& count) noexcept {
  if (count[0] <= 0) return;
  const std::size_t row = static_cast<std::size_t>(count[0]) * voxel_bytes;
  for (std::int64_t k = 0; k < count[2]; ++k)
    for (std::int64_t j = 0; j < count[1]; ++j) {
      std::memcpy(
          to + static_cast<std::size_t>(place(to_size, to_low[0], to_low[1] + j, to_low[2] + k)) * voxel_bytes,
          from + static_cast<std::size_t>(place(from_size, from_low[0], from_low[1] + j, from_low[2] + k)) * voxel_bytes, row);
    }
}

}  // namespace palpa::detail
