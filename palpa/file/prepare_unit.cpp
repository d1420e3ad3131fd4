#include "palpa/file/prepare_unit.h"

#include <algorithm>
#include <cstring>
#include <numeric>
#include <thread>

#include "palpa/base/input_file.h"
#include "palpa/base/load_error.h"

namespace palpa::detail {

void FactsBox::set(int octave, const VoxelIndex& first, const VoxelIndex& size) {
  if (octaves_.size() <= static_cast<std::size_t>(octave)) octaves_.resize(static_cast<std::size_t>(octave) + 1);
  octaves_[static_cast<std::size_t>(octave)] = {first, size,
                                                std::vector<ChunkFacts>(static_cast<std::size_t>(size[0] * size[1] * size[2]))};
}

ChunkFacts* FactsBox::at(int octave, const VoxelIndex& chunk) noexcept {
  if (static_cast<std::size_t>(octave) >= octaves_.size()) return nullptr;
  Part& part = octaves_[static_cast<std::size_t>(octave)];
  std::int64_t number = 0;
  for (const std::size_t a : {2, 1, 0}) {
    const std::int64_t inside = chunk[a] - part.first[a];
    if (inside < 0 || inside >= part.size[a]) return nullptr;
    number = number * part.size[a] + inside;
  }
  return &part.facts[static_cast<std::size_t>(number)];
}

PreparedFiles::PreparedFiles(const UnitPlan& plan, const std::filesystem::path& target)
    : plan_(plan), histograms_(target, plan.histogram_array()) {
  for (int n = 0; n <= plan.last; ++n) {
    if (n > plan.base)
      voxels_.emplace(std::piecewise_construct, std::tuple(n), std::forward_as_tuple(target, plan.voxel_array(n)));
    facts_.emplace(std::piecewise_construct, std::tuple(n), std::forward_as_tuple(target, plan.facts_array(n)));
  }
}

namespace {

/// Chunk of a unit's histogram.
std::vector<std::int64_t> place_of(const UnitPlan::Item& item) {
  return {item.frame, item.field, item.at[2], item.at[1], item.at[0], 0};
}

}  // namespace

void PreparedFiles::make() {
  for (auto& [octave, files] : voxels_) files.make();
  for (auto& [octave, files] : facts_) files.make();
  histograms_.make();
}

bool PreparedFiles::is_done(const UnitPlan::Item& item) const {
  const PlannedOctave& o = plan_.octaves[static_cast<std::size_t>(plan_.top)];
  std::vector<std::int64_t> at{item.frame, item.field};
  for (const std::size_t a : {2, 1, 0}) at.push_back(item.at[a] * (plan_.unit[a] >> plan_.top) / o.reach[a] / o.facts[a]);
  at.push_back(0);
  return facts_.at(plan_.top).has(at) && histograms_.has(place_of(item));
}

std::vector<std::int64_t> PreparedFiles::place(int frame, int channel, const VoxelIndex& at) const {
  std::vector<std::int64_t> result;
  if (plan_.image.has_time) result.push_back(frame);
  if (plan_.image.has_channels) result.push_back(channel);
  result.insert(result.end(), {at[2], at[1], at[0]});
  return result;
}

void PreparedFiles::write(int frame, const PackedChunk& chunk, FileBatch& batch) {
  voxels_.at(chunk.octave).write(place(frame, chunk.channel, chunk.at), chunk.bytes, batch);
  ++written_;
}

bool PreparedFiles::has_shards(int octave) const { return !voxels_.at(octave).plan().shard.empty(); }

void PreparedFiles::append(int frame, const PackedChunk& chunk) {
  ArrayFiles& files = voxels_.at(chunk.octave);
  const std::vector<std::int64_t>&shard = files.plan().shard, &size = files.plan().chunk;
  std::vector<std::int64_t> at = place(frame, chunk.channel, chunk.at), inside;
  for (std::size_t a = 0; a < at.size(); ++a) {
    const std::int64_t each = shard[a] / size[a];
    inside.push_back(at[a] % each);
    at[a] /= each;
  }
  const std::tuple key(chunk.octave, chunk.channel, at);
  auto found = shards_.find(key);
  if (found == shards_.end()) found = shards_.emplace(key, ShardFile(files, at)).first;
  found->second.append(inside, chunk.bytes);
  ++written_;
}

void PreparedFiles::finish_shards(FileBatch& batch) {
  for (auto& [key, shard] : shards_) shard.finish(batch);
  shards_.clear();
}

void PreparedFiles::write_facts(int octave, int frame, int field, const VoxelIndex& first, const VoxelIndex& end,
                                FactsBox& facts, FileBatch& batch) {
  const PlannedOctave& o = plan_.octaves[static_cast<std::size_t>(octave)];
  // The first one is written last: where it is there, all are.
  std::vector<VoxelIndex> order;
  for_each_index(first, end, [&](const VoxelIndex& at) { order.push_back(at); });
  std::reverse(order.begin(), order.end());
  for (const VoxelIndex& at : order) {
    if (at == first) batch.finish();
    std::vector<ChunkFacts> numbers(static_cast<std::size_t>(o.facts[0] * o.facts[1] * o.facts[2]));
    std::size_t next = 0;
    for_each_index({}, o.facts, [&](const VoxelIndex& inside) {
      const VoxelIndex chunk{at[0] * o.facts[0] + inside[0], at[1] * o.facts[1] + inside[1], at[2] * o.facts[2] + inside[2]};
      if (const ChunkFacts* found = facts.at(octave, chunk)) numbers[next] = *found;
      ++next;
    });
    const std::vector<std::int64_t> place{frame, field, at[2], at[1], at[0], 0};
    facts_.at(octave).write(place, packed_chunk(std::as_bytes(std::span(numbers)), sizeof(double)), batch);
  }
}

void PreparedFiles::write_histogram(const UnitPlan::Item& item, const DyadicHistogram& histogram, FileBatch& batch) {
  const DyadicHistogram::Numbers numbers = histogram.numbers();
  histograms_.write(place_of(item), std::as_bytes(std::span(numbers)), batch);
}

std::optional<DyadicHistogram> PreparedFiles::histogram(const UnitPlan::Item& item) const {
  const InputFile file(histograms_.file(place_of(item)));
  if (file.why_not() == NoInput::missing) return std::nullopt;
  DyadicHistogram::Numbers numbers{};
  DyadicHistogram found;
  if (!file.is_open() || file.bytes() != sizeof numbers || file.read(0, &numbers, sizeof numbers) != sizeof numbers ||
      !found.take(numbers))
    throw LoadError(file.path().string() + ": is no histogram that palpa wrote; remove it, and prepare the store again");
  return found;
}

std::vector<std::byte> narrowed(StoredAs stored, std::span<const std::byte> voxels) {
  std::vector<std::byte> narrow;
  if (stored == StoredAs::int8) {
    for (std::size_t n = 0; n < voxels.size(); n += 2) narrow.push_back(voxels[n]);  // its low byte
  } else if (stored == StoredAs::uint32) {
    narrow.resize(voxels.size() / 2);
    for (std::size_t n = 0; n < voxels.size() / sizeof(double); ++n) {
      double number = 0.0;
      std::memcpy(&number, voxels.data() + n * sizeof number, sizeof number);
      const bool fits = number >= 0.0 && number < 4294967296.0;  // unless the reader of the file has been taken over
      const std::uint32_t whole = fits ? static_cast<std::uint32_t>(number) : 0;
      std::memcpy(narrow.data() + n * sizeof whole, &whole, sizeof whole);
    }
  }
  return narrow;
}

void on_workers(int workers, std::int64_t count, const std::function<void(int, std::int64_t)>& act) {
  std::atomic<std::int64_t> next = 0;
  std::atomic<bool> failed = false;
  std::exception_ptr problem;
  std::mutex mutex;
  const auto work = [&](int worker) {
    try {
      for (std::int64_t n = next++; n < count && !failed; n = next++) act(worker, n);
    } catch (...) {
      const std::lock_guard lock(mutex);
      if (!problem) problem = std::current_exception();
      failed = true;
    }
  };
  {
    std::vector<std::jthread> others;
    for (int worker = 1; worker < workers; ++worker) others.emplace_back(work, worker);
    work(0);
  }
  if (problem) std::rethrow_exception(problem);
}

int reader_slots(const UnitPlan& plan) {
  constexpr std::int64_t bytes_ahead = std::int64_t{8} << 20;  // More: memory; less: the reader pauses
  std::int64_t largest = 1;
  for (const PlannedOctave& octave : plan.octaves)
    largest =
        std::max(largest, octave.chunk[0] * octave.chunk[1] * octave.chunk[2] * static_cast<std::int64_t>(plan.kind.bytes()));
  return static_cast<int>(std::clamp<std::int64_t>(bytes_ahead / largest, 2, 64));
}

}  // namespace palpa::detail
