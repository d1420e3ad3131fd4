#include "palpa/file/unit_walk.h"

#include <algorithm>
#include <cstring>

#include "palpa/base/load_error.h"

namespace palpa::detail {
namespace {

// [s] Between looks at an interrupt. Longer: Ctrl-C takes effect later; shorter: more work.
constexpr double look_s = 0.2;

VoxelIndex product(const VoxelIndex& a, const VoxelIndex& b) { return {a[0] * b[0], a[1] * b[1], a[2] * b[2]}; }

template <class T>
void fill_with(double value, std::vector<std::byte>& voxels) {
  const T number = static_cast<T>(value);
  T* const to = reinterpret_cast<T*>(voxels.data());
  std::fill_n(to, voxels.size() / sizeof(T), number);
}

}  // namespace

std::vector<std::byte> filled_chunk(const StoreField& field, const VoxelIndex& chunk) {
  std::vector<std::byte> voxels(static_cast<std::size_t>(chunk[0] * chunk[1] * chunk[2] * field.components) *
                                size_of(field.type));
  switch (field.type) {
    case VoxelType::uint8: fill_with<std::uint8_t>(field.fill, voxels); break;
    case VoxelType::int16: fill_with<std::int16_t>(field.fill, voxels); break;
    case VoxelType::uint16: fill_with<std::uint16_t>(field.fill, voxels); break;
    case VoxelType::int32: fill_with<std::int32_t>(field.fill, voxels); break;
    case VoxelType::float32: fill_with<float>(field.fill, voxels); break;
    case VoxelType::float64: fill_with<double>(field.fill, voxels); break;
  }
  return voxels;
}

ChunkStream::ChunkStream(StoreReader& reader, std::function<bool()> goes_on) : reader_(reader), goes_on_(std::move(goes_on)) {
  for (int slot = 0; slot < reader.slots(); ++slot) free_.push_back(slot);
}

void ChunkStream::follow(std::vector<StoreChunk> order) {
  order_.erase(order_.begin(), order_.begin() + static_cast<std::ptrdiff_t>(taken_));
  requested_ -= taken_, taken_ = 0;
  order_.insert(order_.end(), order.begin(), order.end());
  request_ahead();
}

void ChunkStream::request_ahead() {
  while (!free_.empty() && requested_ < order_.size()) {
    reader_.request(order_[requested_++], free_.back());
    free_.pop_back();
  }
}

void ChunkStream::take(const std::function<void(const StoreRead&, std::span<const std::byte>)>& act) {
  request_ahead();
  const StoreChunk wanted = order_.at(taken_);
  auto found = arrived_.find(wanted);
  while (found == arrived_.end()) {
    if (!goes_on_()) throw LoadError("interrupted");
    if (const std::optional<StoreRead> read = reader_.next(look_s)) arrived_.emplace(read->chunk, *read);
    found = arrived_.find(wanted);
  }
  const StoreRead& read = found->second;
  act(read, read.state == ChunkState::present ? reader_.content(read.slot) : std::span<const std::byte>());
  free_.push_back(read.slot);
  arrived_.erase(found);
  ++taken_;
  request_ahead();
}

UnitWalk::UnitWalk(const UnitPlan& plan, const StoreContents& contents, ChunkStream& chunks, WalkSink sink, int octave_in_store)
    : plan_(plan), contents_(contents), chunks_(chunks), sink_(std::move(sink)), shift_(octave_in_store) {}

void UnitWalk::set_item(int frame, int field, int from_octave) {
  frame_ = frame, field_ = field, from_ = from_octave;
  kind_ = {plan_.kind.type, plan_.components[static_cast<std::size_t>(field)], plan_.kind.is_rounded};
}

VoxelIndex UnitWalk::children(int octave) const noexcept {
  VoxelIndex count{};
  for (std::size_t a = 0; a < 3; ++a) {
    count[a] = 2 * plan_.octaves[static_cast<std::size_t>(octave)].block[a] /
               plan_.octaves[static_cast<std::size_t>(octave - 1)].block[a];
  }
  return count;
}

void UnitWalk::add_chunks(int octave, const VoxelIndex& at, std::vector<StoreChunk>& order) const {
  const PlannedOctave& o = plan_.octaves[static_cast<std::size_t>(octave)];
  VoxelIndex first{}, end{};
  for (std::size_t a = 0; a < 3; ++a) {
    first[a] = at[a] * o.block[a] / o.reach[a];
    end[a] = std::min((at[a] + 1) * o.block[a] / o.reach[a], o.chunks[a]);
  }
  for_each_index(first, end, [&](const VoxelIndex& chunk) {
    order.push_back({.octave = octave - shift_, .frame = frame_, .field = field_, .at = chunk});
  });
}

void UnitWalk::add_chunks_below(int octave, const VoxelIndex& at, std::vector<StoreChunk>& order) const {
  if (octave == from_) return add_chunks(octave, at, order);
  const VoxelIndex count = children(octave), first = product(at, count);
  for_each_index({}, count, [&](const VoxelIndex& child) {
    const VoxelIndex child_at{first[0] + child[0], first[1] + child[1], first[2] + child[2]};
    const VoxelIndex valid = plan_.valid_in_block(octave - 1, child_at);
    if (valid[0] > 0 && valid[1] > 0 && valid[2] > 0) add_chunks_below(octave - 1, child_at, order);
  });
}

VoxelBlock UnitWalk::made(int octave, const VoxelIndex& at) {
  std::vector<StoreChunk> order;
  add_chunks_below(octave, at, order);
  chunks_.follow(std::move(order));
  ready_ = nullptr;
  return block_of(octave, at);
}

VoxelBlock UnitWalk::made_of(int octave, const VoxelIndex& at, int ready_octave, std::map<VoxelIndex, VoxelBlock>& ready) {
  ready_octave_ = ready_octave, ready_ = &ready;
  return block_of(octave, at);
}

VoxelBlock UnitWalk::block_of(int octave, const VoxelIndex& at) {
  if (ready_ && octave == ready_octave_) return std::move(ready_->at(at));
  if (octave == from_) return gathered(octave, at);
  const PlannedOctave& o = plan_.octaves[static_cast<std::size_t>(octave)];
  VoxelBlock block = zero_block(kind_, o.block, plan_.valid_in_block(octave, at));
  const VoxelIndex count = children(octave), first = product(at, count);
  for_each_index({}, count, [&](const VoxelIndex& child) {
    const VoxelIndex child_at{first[0] + child[0], first[1] + child[1], first[2] + child[2]};
    const VoxelIndex valid = plan_.valid_in_block(octave - 1, child_at);
    if (valid[0] <= 0 || valid[1] <= 0 || valid[2] <= 0) return;
    const VoxelBlock fine = block_of(octave - 1, child_at);
    const VoxelIndex to{child[0] * fine.size[0] / 2, child[1] * fine.size[1] / 2, child[2] * fine.size[2] / 2};
    halve(kind_, fine, block, to);
    emit_facts_over(octave - 1, child_at, fine, &block, to);
  });
  emit_voxels(octave, at, block);
  return block;
}

VoxelBlock UnitWalk::gathered(int octave, const VoxelIndex& at) {
  const PlannedOctave& o = plan_.octaves[static_cast<std::size_t>(octave)];
  VoxelBlock block = zero_block(kind_, o.block, plan_.valid_in_block(octave, at));
  std::vector<StoreChunk> order;
  add_chunks(octave, at, order);
  std::vector<std::byte> filled;
  for (const StoreChunk& chunk : order) {
    chunks_.take([&](const StoreRead& read, std::span<const std::byte> content) {
      const std::size_t bytes = static_cast<std::size_t>(o.chunk[0] * o.chunk[1] * o.chunk[2]) * kind_.bytes();
      if (read.state == ChunkState::damaged) sink_.damaged(read);
      if (read.state != ChunkState::present) {
        if (filled.empty()) filled = filled_chunk(contents_.fields[static_cast<std::size_t>(field_)], o.chunk);
        content = filled;
      } else if (content.size() < bytes) {
        throw LoadError("the reader gave a chunk that is too short; install palpa anew");
      }
      VoxelIndex to{}, voxels{};
      for (std::size_t a = 0; a < 3; ++a) {
        to[a] = chunk.at[a] * o.reach[a] - at[a] * o.block[a];
        voxels[a] = std::min(o.chunk[a], block.valid[a] - to[a]);
      }
      copy_voxels(kind_.bytes(), content.data(), o.chunk, {}, block.voxels.data(), block.size, to, voxels);
    });
  }
  return block;
}

void UnitWalk::emit_facts(int octave, const VoxelIndex& at, const VoxelBlock& block) {
  if (octave == plan_.last) return emit_facts_over(octave, at, block, nullptr, {});
  VoxelIndex half{}, valid{};
  for (std::size_t a = 0; a < 3; ++a) half[a] = (block.size[a] + 1) / 2, valid[a] = (block.valid[a] + 1) / 2;
  VoxelBlock coarse = zero_block(kind_, half, valid);
  halve(kind_, block, coarse, {});
  emit_facts_over(octave, at, block, &coarse, {});
}

void UnitWalk::emit_facts_over(int octave, const VoxelIndex& at, const VoxelBlock& block, const VoxelBlock* coarse,
                               const VoxelIndex& coarse_at) {
  const PlannedOctave& o = plan_.octaves[static_cast<std::size_t>(octave)];
  std::vector<StoreChunk> chunks;
  add_chunks(octave, at, chunks);
  for (const StoreChunk& chunk : chunks) {
    VoxelIndex low{};
    for (std::size_t a = 0; a < 3; ++a) low[a] = chunk.at[a] * o.reach[a] - at[a] * o.block[a];
    sink_.facts(octave, chunk.at, facts_of(kind_, block, low, o.reach, coarse, coarse_at));
    if (octave == 0) sink_.finest(kind_, block, low, o.reach);
  }
}

void UnitWalk::emit_voxels(int octave, const VoxelIndex& at, const VoxelBlock& block) {
  const PlannedOctave& o = plan_.octaves[static_cast<std::size_t>(octave)];
  std::vector<StoreChunk> chunks;
  add_chunks(octave, at, chunks);
  for (const StoreChunk& chunk : chunks) {
    VoxelIndex low{}, valid{};
    for (std::size_t a = 0; a < 3; ++a) {
      low[a] = chunk.at[a] * o.reach[a] - at[a] * o.block[a];
      valid[a] = std::clamp<std::int64_t>(block.valid[a] - low[a], 0, o.chunk[a]);
    }
    if (block.size == o.chunk) {
      sink_.voxels(octave, chunk.at, block);
      continue;
    }
    VoxelBlock part = zero_block(kind_, o.chunk, valid);
    copy_voxels(kind_.bytes(), block.voxels.data(), block.size, low, part.voxels.data(), part.size, {}, valid);
    sink_.voxels(octave, chunk.at, part);
  }
}

void UnitWalk::read_facts(int octave, const VoxelIndex& first, const VoxelIndex& end) {
  ready_ = nullptr;
  for_each_index(first, end, [&](const VoxelIndex& at) {
    std::vector<StoreChunk> order;
    add_chunks(octave, at, order);
    chunks_.follow(std::move(order));
    emit_facts(octave, at, gathered(octave, at));
  });
}

}  // namespace palpa::detail
