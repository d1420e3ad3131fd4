#include "palpa/file/store_survey.h"

#include <zlib.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstring>
#include <functional>
#include <limits>
#include <map>
#include <random>
#include <set>
#include <utility>

#include "palpa/file/store_chunks.h"

namespace palpa {
namespace {

// More of any: slower; less: a coarser picture.
constexpr std::size_t most_chunks = 4096, chunks_for_values = 64;

using Clock = std::chrono::steady_clock;
using Counts = std::array<std::int64_t, 3>;

/// Random different places among those of a grid in all frames and fields; all of them if they are no more than `most`.
std::vector<StoreChunk> places_among(const StoreContents& contents, const Counts& along, bool facts, std::size_t most) {
  const auto fields = static_cast<std::uint64_t>(contents.fields.size());
  const std::uint64_t sides[] = {static_cast<std::uint64_t>(along[0]), static_cast<std::uint64_t>(along[1]),
                                 static_cast<std::uint64_t>(along[2]), fields, static_cast<std::uint64_t>(contents.frames)};
  double all = 1.0;
  for (const std::uint64_t side : sides) all *= static_cast<double>(side);
  const auto place_of = [&](auto number_below) {
    StoreChunk chunk{.facts = facts};
    for (std::size_t a = 0; a < 3; ++a) chunk.at[a] = static_cast<std::int64_t>(number_below(sides[a]));
    chunk.field = static_cast<std::int32_t>(number_below(fields));
    chunk.frame = static_cast<std::int32_t>(number_below(sides[4]));
    return chunk;
  };
  std::mt19937_64 random(2);  // equal stores, equal results
  std::vector<StoreChunk> places;
  if (all <= static_cast<double>(most)) {
    for (std::uint64_t n = 0; n < static_cast<std::uint64_t>(all); ++n) {
      std::uint64_t rest = n;
      places.push_back(place_of([&](std::uint64_t side) {
        const std::uint64_t number = rest % side;
        rest /= side;
        return number;
      }));
    }
    std::shuffle(places.begin(), places.end(), random);
    return places;
  }
  std::set<StoreChunk> taken;
  for (std::size_t tries = 0; places.size() < most && tries < 4 * most; ++tries) {
    const StoreChunk chunk = place_of([&](std::uint64_t side) { return random() % side; });
    if (taken.insert(chunk).second) places.push_back(chunk);
  }
  return places;
}

void widen(StoreSurvey::Values& values, double min, double max) {
  values.min = std::min(values.min, min), values.max = std::max(values.max, max);
}

void take_values(const StoreContents& contents, const StoreChunk& chunk, std::span<const std::byte> content,
                 std::vector<StoreSurvey::Values>& values) {
  const StoreOctave& octave = contents.octaves.front();
  const StoreField& field = contents.fields[static_cast<std::size_t>(chunk.field)];
  const std::vector<double> numbers = numbers_in(field, content);
  StoreSurvey::Values& of = values[static_cast<std::size_t>(chunk.field)];
  std::size_t at = 0;
  for (std::int64_t k = 0; k < octave.chunk[2]; ++k) {
    for (std::int64_t j = 0; j < octave.chunk[1]; ++j) {
      for (std::int64_t i = 0; i < octave.chunk[0]; ++i, at += static_cast<std::size_t>(field.components)) {
        const Counts voxel{chunk.at[0] * octave.chunk[0] + i, chunk.at[1] * octave.chunk[1] + j,
                           chunk.at[2] * octave.chunk[2] + k};
        if (voxel[0] >= octave.grid.dims[0] || voxel[1] >= octave.grid.dims[1] || voxel[2] >= octave.grid.dims[2]) continue;
        for (std::size_t c = 0; c < static_cast<std::size_t>(field.components); ++c) {
          if (std::isfinite(numbers[at + c])) widen(of, numbers[at + c], numbers[at + c]);
        }
      }
    }
  }
}

/// Whether a chunk of octave 0 that is absent has other values than the fill value in the next octave. None: unknown.
std::optional<bool> differs_in_next(StoreReader& reader, const StoreChunk& chunk) {
  const StoreContents& contents = reader.contents();
  const StoreOctave &octave = contents.octaves[0], &next = contents.octaves[1];
  const double fill = contents.fields[static_cast<std::size_t>(chunk.field)].fill;
  VoxelBox box;
  for (std::size_t a = 0; a < 3; ++a) {
    // Voxels of the next octave that are of this chunk alone.
    const std::int64_t first = chunk.at[a] * octave.chunk[a], end = std::min(first + octave.chunk[a], octave.grid.dims[a]);
    box.first[a] = (first + 1) / 2;
    box.count[a] = std::min(end / 2, next.grid.dims[a]) - box.first[a];
    if (box.count[a] < 1) return std::nullopt;
  }
  const auto voxels = voxels_in(reader, {.octave = 1, .frame = chunk.frame, .field = chunk.field}, box);
  if (!voxels) return std::nullopt;
  return std::ranges::any_of(*voxels, [&](double value) { return value != fill && !(std::isnan(value) && std::isnan(fill)); });
}

bool is_fill(const ChunkFacts& facts, double fill) {
  return (facts.min == fill && facts.max == fill) || (std::isnan(fill) && std::isnan(facts.min));
}

/// Number of a chunk in a random order of all, the same for equal stores.
std::uint64_t shuffled(const StoreChunk& chunk) {
  std::uint64_t hash = 0;
  for (const auto number : {std::int64_t{chunk.frame}, std::int64_t{chunk.field}, chunk.at[0], chunk.at[1], chunk.at[2]}) {
    hash = (hash ^ static_cast<std::uint64_t>(number)) + 0x9e3779b97f4a7c15U;  // the steps of splitmix64
    hash = (hash ^ (hash >> 30)) * 0xbf58476d1ce4e5b9U;
    hash = (hash ^ (hash >> 27)) * 0x94d049bb133111ebU;
    hash ^= hash >> 31;
  }
  return hash;
}

/// Search of all chunks of octave 0 of a prepared store: their facts, and whether the store has them, in blocks as they come.
class FactsSearch {
 public:
  using Facts = std::map<StoreChunk, ChunkFacts>;

  FactsSearch(StoreReader& reader, StoreSurvey& found) : reader_(reader), found_(found) {}

  /// Facts of random chunks that have values.
  Facts search(const std::function<bool()>& go_on) {
    const Counts along = chunks_along(octave_);
    Counts blocks{};
    for (std::size_t a = 0; a < 3; ++a) blocks[a] = (along[a] + octave_.facts[a] - 1) / octave_.facts[a];
    std::vector<StoreChunk> wanted;
    for (StoreChunk block : places_among(reader_.contents(), blocks, true, most_blocks)) {
      wanted.push_back(block);
      block.facts = false, block.presence = true;
      wanted.push_back(block);
    }
    read_chunks(
        reader_, wanted, [&](const StoreRead& read, std::span<const std::byte> content) { take(read, content); }, go_on);
    if (static_cast<double>(count_) == found_.chunks) {
      for (StoreSurvey::Values& values : found_.values) values.about = false;
    }
    Facts facts;
    for (const auto& [order, chunk] : picked_) facts.insert(chunk);
    return facts;
  }

 private:
  static constexpr std::size_t most_blocks = 1'000'000;  // More: memory; fewer: parts of larger stores are not looked at
  struct Block {
    std::vector<ChunkFacts> facts;
    std::vector<std::byte> present;
  };

  void take(const StoreRead& read, std::span<const std::byte> content) {
    if (read.state == ChunkState::damaged && ++found_.damaged == 1) found_.damage = read.sentence;
    if (read.state != ChunkState::present) return;
    StoreChunk at = read.chunk;
    at.facts = at.presence = false;
    Block& block = blocks_[at];
    if (read.chunk.presence) {
      block.present.assign(content.begin(), content.end());
    } else {
      block.facts.resize(content.size() / sizeof(ChunkFacts));
      std::memcpy(block.facts.data(), content.data(), block.facts.size() * sizeof(ChunkFacts));
    }
    if (block.facts.empty() || block.present.size() != block.facts.size()) return;
    for (std::size_t n = 0; n < block.facts.size(); ++n) take(at, n, block);
    blocks_.erase(at);
  }

  void take(const StoreChunk& block_at, std::size_t n, const Block& block) {
    StoreChunk chunk = block_at;
    auto rest = static_cast<std::int64_t>(n);
    for (std::size_t a = 0; a < 3; ++a) {
      chunk.at[a] = block_at.at[a] * octave_.facts[a] + rest % octave_.facts[a];
      rest /= octave_.facts[a];
      if (chunk.at[a] * octave_.chunk[a] >= octave_.grid.dims[a]) return;
    }
    const auto field = static_cast<std::size_t>(chunk.field);
    const ChunkFacts& facts = block.facts[n];
    const bool has_values = !is_fill(facts, reader_.contents().fields[field].fill);
    const bool is_absent = block.present[n] == std::byte{0};
    ++count_, ++found_.looked_for;
    if (facts.min <= facts.max) widen(found_.values[field], facts.min, facts.max);
    found_.absent += is_absent, found_.lost += is_absent && has_values;
    if (!has_values || is_absent) return;
    picked_.emplace(shuffled(chunk), std::pair(chunk, facts));
    if (picked_.size() > most_chunks) picked_.erase(std::prev(picked_.end()));
  }

  StoreReader& reader_;
  StoreSurvey& found_;
  const StoreOctave& octave_ = reader_.contents().octaves.front();
  std::map<StoreChunk, Block> blocks_;  ///< of which half has come
  std::map<std::uint64_t, std::pair<StoreChunk, ChunkFacts>> picked_;
  std::int64_t count_ = 0;
};

/// Whether the facts of a chunk are of other voxels. False of a chunk with voxels beyond the octave, which have any value.
bool has_changed(const StoreOctave& octave, const StoreChunk& chunk, const ChunkFacts& facts,
                 std::span<const std::byte> content) {
  for (std::size_t a = 0; a < 3; ++a) {
    if ((chunk.at[a] + 1) * octave.chunk[a] > octave.grid.dims[a]) return false;
  }
  const auto sum = ::crc32_z(0, reinterpret_cast<const Bytef*>(content.data()), content.size());
  return static_cast<double>(sum) != facts.crc32;
}

void count_lost(StoreReader& reader, const std::vector<StoreChunk>& absent, const std::function<bool()>& go_on,
                StoreSurvey& found) {
  const StoreContents& contents = reader.contents();
  found.absent = static_cast<std::int64_t>(absent.size());
  for (const StoreChunk& chunk : absent) {
    const auto field = static_cast<std::size_t>(chunk.field);
    const double fill = contents.fields[field].fill;
    if (std::isfinite(fill)) widen(found.values[field], fill, fill);
    if (contents.octaves.size() > 1 && go_on() && differs_in_next(reader, chunk).value_or(false)) ++found.lost;
  }
}

/// Looks at chunks; returns those that are absent.
std::vector<StoreChunk> look_at(StoreReader& reader, const std::vector<StoreChunk>& places, const FactsSearch::Facts& facts,
                                const std::function<bool()>& go_on, StoreSurvey& found) {
  const StoreContents& contents = reader.contents();
  std::vector<StoreChunk> absent;
  std::size_t looked_for_values = 0;
  double stored_bytes = 0.0, whole_bytes = 0.0;
  const auto look = [&](const StoreRead& read, std::span<const std::byte> content) {
    ++found.looked_at;
    if (read.state == ChunkState::absent) absent.push_back(read.chunk);
    if (read.state == ChunkState::damaged && ++found.damaged == 1) found.damage = read.sentence;
    if (read.state != ChunkState::present) return;
    stored_bytes += static_cast<double>(read.bytes), whole_bytes += static_cast<double>(content.size());
    if (facts.empty() && looked_for_values++ < chunks_for_values) take_values(contents, read.chunk, content, found.values);
    const auto known = facts.find(read.chunk);
    if (known == facts.end() || !has_changed(contents.octaves.front(), read.chunk, known->second, content)) return;
    if (++found.damaged == 1) found.damage = "a chunk has changed since palpa prepare";
  };
  read_chunks(reader, places, look, go_on);
  found.stored_share = whole_bytes > 0.0 ? stored_bytes / whole_bytes : 0.0;
  return absent;
}

std::function<bool()> within(double longest_s) {
  const Clock::time_point latest =
      Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(longest_s));
  return [latest] { return Clock::now() < latest; };
}

}  // namespace

StoreSurvey survey(StoreReader& reader, double longest_s, double longest_facts_s, bool facts_suffice) {
  const StoreContents& contents = reader.contents();
  StoreSurvey found;
  constexpr double infinity = std::numeric_limits<double>::infinity();
  found.values.assign(contents.fields.size(), {infinity, -infinity, true});
  const Counts along = chunks_along(contents.octaves.front());
  found.chunks = static_cast<double>(contents.fields.size()) * contents.frames;
  for (const std::int64_t n : along) found.chunks *= static_cast<double>(n);
  found.can_tell_lost = contents.prepared || contents.octaves.size() > 1;

  FactsSearch::Facts facts;
  if (contents.prepared) facts = FactsSearch(reader, found).search(within(longest_facts_s));
  const std::function<bool()> go_on = within(longest_s);
  if (found.looked_for > 0) {
    if (facts_suffice) return found;
    std::vector<StoreChunk> places;
    for (const auto& [chunk, of] : facts) places.push_back(chunk);
    std::ranges::sort(places, {}, shuffled);
    look_at(reader, places, facts, go_on, found);
    return found;
  }
  const std::vector<StoreChunk> absent =
      look_at(reader, places_among(contents, along, false, most_chunks), facts, go_on, found);
  found.looked_for = found.looked_at;
  count_lost(reader, absent, go_on, found);
  return found;
}

double waste_of_chunks(const StoreOctave& octave) noexcept {
  constexpr std::int64_t window = 128, step = 32;
  double waste = 1.0;
  for (std::size_t a = 0; a < 3; ++a) {
    const std::int64_t whole = octave.grid.dims[a], chunk = octave.chunk[a], side = std::min(window, whole);
    double read = 0.0;
    int places = 0;
    // Places repeat after a chunk; of long axes a few hundred are enough.
    for (std::int64_t first = 0; first + side <= whole && places < 512; first += step, ++places)
      read += static_cast<double>(std::min((first + side - 1) / chunk * chunk + chunk, whole) - first / chunk * chunk);
    waste *= places == 0 ? 1.0 : read / places / static_cast<double>(side);
  }
  return waste;
}

}  // namespace palpa
