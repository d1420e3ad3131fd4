// Parts of a job, means of octaves, checksums of shards.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <random>

#include "palpa/base/load_error.h"
#include "palpa/file/octave_means.h"
#include "palpa/file/store_array.h"
#include "palpa/file/work_part.h"

namespace palpa {
namespace {

using detail::halve, detail::VoxelBlock, detail::VoxelIndex, detail::VoxelKind, detail::zero_block;

class Variable {
 public:
  Variable(const char* name, const char* value) : name_(name) { ::setenv(name, value, 1); }
  ~Variable() { ::unsetenv(name_); }

 private:
  const char* name_;
};

TEST(WorkPart, PartsAreAWholeWithoutGapsOrOverlap) {
  for (const std::int64_t count : {0, 1, 7, 64, 1000003}) {
    for (const int of : {1, 2, 3, 64, 1024}) {
      std::int64_t next = 0, largest = 0;
      for (int number = 1; number <= of; ++number) {
        const WorkPart part{number, of};
        EXPECT_EQ(part.first(count), next);
        next = part.end(count);
        largest = std::max(largest, next - part.first(count));
      }
      EXPECT_EQ(next, count);
      EXPECT_LE(largest, count / of + 1);
    }
  }
}

TEST(WorkPart, IsReadFromTextAndRefusedOtherwise) {
  EXPECT_EQ(work_part("3/64"), (WorkPart{3, 64}));
  EXPECT_EQ(work_part("1/1"), (WorkPart{1, 1}));
  for (const char* wrong : {"", "3", "/", "0/4", "5/4", "-1/4", "1/0", "a/4", "1/4x", "1/99999999999", " 1/4"})
    EXPECT_THROW(work_part(wrong), LoadError) << wrong;
}

TEST(WorkPart, ComesFromTheEnvironmentOfALauncher) {
  for (const char* name : {"OMPI_COMM_WORLD_RANK", "PMI_RANK", "SLURM_PROCID", "SLURM_ARRAY_TASK_ID"}) ::unsetenv(name);
  EXPECT_THROW(work_part("auto"), LoadError);
  {
    const Variable rank("OMPI_COMM_WORLD_RANK", "2"), size("OMPI_COMM_WORLD_SIZE", "8");
    EXPECT_EQ(work_part("auto"), (WorkPart{3, 8}));
  }
  {
    const Variable id("SLURM_ARRAY_TASK_ID", "5"), count("SLURM_ARRAY_TASK_COUNT", "4"), first("SLURM_ARRAY_TASK_MIN", "2");
    EXPECT_EQ(work_part("auto"), (WorkPart{4, 4}));
    const Variable task("SLURM_PROCID", "0"), tasks("SLURM_NTASKS", "1");  // each job of an array has one task
    EXPECT_EQ(work_part("auto"), (WorkPart{4, 4}));
  }
  const Variable rank("PMI_RANK", "8"), size("PMI_SIZE", "8");
  EXPECT_THROW(work_part("auto"), LoadError);
}

TEST(Crc32c, IsThatOfTheStandardsExample) {
  const char text[] = "123456789";
  EXPECT_EQ(detail::crc32c(std::as_bytes(std::span(text, 9))), 0xe3069283u);
}

template <class T>
VoxelBlock block_of(const VoxelKind& kind, const VoxelIndex& size, const std::vector<T>& numbers) {
  VoxelBlock block = zero_block(kind, size, size);
  std::memcpy(block.voxels.data(), numbers.data(), numbers.size() * sizeof(T));
  return block;
}
template <class T>
T number_of(const VoxelBlock& block, std::size_t n) {
  T number;
  std::memcpy(&number, block.voxels.data() + n * sizeof number, sizeof number);
  return number;
}

TEST(OctaveMeans, HalvesOfWholeNumbersGoUpAlsoBelowZero) {
  const VoxelKind kind{VoxelType::int16, 1};
  for (const auto& [low, high, mean] : {std::array{1, 2, 2}, {-1, -2, -1}, {0, -1, 0}, {-32768, -32767, -32767}}) {
    const VoxelBlock fine =
        block_of<std::int16_t>(kind, {2, 1, 1}, {static_cast<std::int16_t>(low), static_cast<std::int16_t>(high)});
    VoxelBlock coarse = zero_block(kind, {1, 1, 1}, {1, 1, 1});
    halve(kind, fine, coarse, {});
    EXPECT_EQ(number_of<std::int16_t>(coarse, 0), mean) << low << " " << high;
  }
}

TEST(OctaveMeans, AVoxelWithoutAValueMakesAHole) {
  const VoxelKind kind{VoxelType::float32, 3};
  constexpr float none = std::numeric_limits<float>::quiet_NaN();
  const VoxelBlock fine = block_of<float>(kind, {2, 1, 1}, {1, 2, none, 3, 4, 5});
  VoxelBlock coarse = zero_block(kind, {1, 1, 1}, {1, 1, 1});
  halve(kind, fine, coarse, {});
  EXPECT_EQ(number_of<float>(coarse, 0), 2.0f);
  EXPECT_EQ(number_of<float>(coarse, 1), 3.0f);
  EXPECT_TRUE(std::isnan(number_of<float>(coarse, 2)));
  const ChunkFacts facts = facts_of(kind, fine, {}, {2, 1, 1}, &coarse, {});
  EXPECT_EQ(facts.min, 1.0);
  EXPECT_EQ(facts.max, 5.0);
  EXPECT_EQ(facts.rms, 1.0);
}

TEST(OctaveMeans, LossesOfWholeNumbersAreExact) {
  std::mt19937 random(4);
  const VoxelKind kind{VoxelType::uint8, 1};
  const VoxelIndex size{149, 3, 5};
  VoxelBlock fine = zero_block(kind, size, size);
  for (std::byte& voxel : fine.voxels) voxel = static_cast<std::byte>(random());
  VoxelBlock coarse = zero_block(kind, {75, 2, 3}, {75, 2, 3});
  halve(kind, fine, coarse, {});
  double squares = 0.0;
  for (std::int64_t k = 0; k < size[2]; ++k)
    for (std::int64_t j = 0; j < size[1]; ++j)
      for (std::int64_t i = 0; i < size[0]; ++i) {
        const double lost = number_of<std::uint8_t>(fine, static_cast<std::size_t>((k * size[1] + j) * size[0] + i)) -
                            number_of<std::uint8_t>(coarse, static_cast<std::size_t>((k / 2 * 2 + j / 2) * 75 + i / 2));
        squares += lost * lost;
      }
  EXPECT_EQ(facts_of(kind, fine, {}, size, &coarse, {}).rms, std::sqrt(squares / static_cast<double>(fine.voxels.size())));
}

}  // namespace
}  // namespace palpa
