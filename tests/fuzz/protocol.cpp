// The protocol of palpa-read: invalid packets and hostile readers; and Palpa's other parsers.
#include "palpa/file/protocol.h"

#include <sys/wait.h>

#include <array>
#include <cstdlib>
#include <fstream>
#include <iterator>

#include "palpa/base/load_error.h"
#include "palpa/file/read_volume.h"
#include "palpa/file/sliced_file.h"
#include "palpa/file/store_reader.h"
#include "tests/fuzz/campaigns.h"
#include "tests/fuzz/hostile_acts.h"
#include "tests/fuzz/parsers.h"
#include "tests/fuzz/scenes.h"
#include "tests/reader/damage.h"

namespace palpa::fuzz {
namespace {

using namespace protocol;

FieldHeader any_field(Choices& choices) {
  FieldHeader field;
  field.name = "f" + std::to_string(choices.below(3));
  field.type = static_cast<VoxelType>(choices.below(6));
  field.components = choices.one_in(3) ? 3 : 1;
  for (std::int64_t& dim : field.grid.dims) dim = 2 + static_cast<std::int64_t>(choices.below(4));
  constexpr std::array<std::int64_t, 6> odd_dims{0, -1, INT64_MAX, INT64_MIN, std::int64_t{1} << 32, 3'000'000};
  if (choices.one_in(8)) field.grid.dims[choices.below(3)] = choices.one_of(odd_dims);
  if (choices.one_in(8)) field.components = static_cast<std::int32_t>(choices.below(7)) - 2;
  if (choices.one_in(8)) field.grid.origin_m.x = odd_number(choices, 1.0);
  if (choices.one_in(8)) field.grid.index_to_world_m.row[choices.below(3)].y = odd_number(choices, 1.0);
  if (choices.one_in(8)) field.scale = odd_number(choices, 1.0);
  if (choices.one_in(8)) field.offset = odd_number(choices, 1.0);
  return field;
}

Header any_header(Choices& choices) {
  Header header;
  header.format = "nrrd", header.default_unit = "mm";
  if (choices.one_in(8)) header.frames = static_cast<std::int32_t>(choices.below(1 << 16)) - 5;
  if (choices.one_in(8)) header.working_bytes = UINT64_MAX >> choices.below(64);
  if (choices.one_in(8)) header.length_unit = choices.bytes(5);
  header.reads_rows = choices.one_in(2);
  for (std::uint64_t n = choices.one_in(8) ? choices.below(5) : 1; n > 0; --n) header.fields.push_back(any_field(choices));
  for (std::uint64_t n = choices.below(3); n > 0; --n) header.warnings.push_back(choices.bytes(choices.below(20)));
  for (auto* parts : {&header.series, &header.labels, &header.alternatives})
    for (std::uint64_t n = choices.below(3); n > 0; --n)
      parts->push_back({choices.bytes(choices.below(20)), choices.bytes(choices.below(20)), static_cast<std::int64_t>(n)});
  return header;
}

StoreContents any_contents(Choices& choices) {
  StoreContents contents;
  contents.format = "OME-Zarr", contents.length_unit = choices.bytes(choices.below(4));
  contents.warnings.assign(choices.below(3), choices.bytes(choices.below(20)));
  for (std::uint64_t n = 1 + choices.below(2); n > 0; --n) {
    StoreField field{.name = "f", .type = static_cast<VoxelType>(choices.below(6)), .components = choices.one_in(3) ? 3 : 1};
    if (choices.one_in(8)) field.components = static_cast<std::int32_t>(choices.below(7)) - 2;
    contents.fields.push_back(field);
  }
  constexpr std::array<std::int64_t, 6> odd_sides{0, -1, INT64_MAX, INT64_MIN, std::int64_t{1} << 32, 3'000'000};
  for (std::uint64_t n = 1 + choices.below(2); n > 0; --n) {
    StoreOctave octave{.chunk = {4, 4, 4}, .shard = {8, 8, 8}, .codec = "raw"};
    octave.grid.dims = {16, 16, 1 + static_cast<std::int64_t>(choices.below(20))};
    if (choices.one_in(4)) octave.facts = {2, 2, 2};
    for (auto* sides : {&octave.grid.dims, &octave.chunk, &octave.shard, &octave.facts})
      if (choices.one_in(16)) (*sides)[choices.below(3)] = choices.one_of(odd_sides);
    if (choices.one_in(16)) octave.grid.origin_m.x = odd_number(choices, 1.0);
    if (choices.one_in(16)) octave.grid.index_to_world_m.row[choices.below(3)].y = odd_number(choices, 1.0);
    contents.octaves.push_back(octave);
  }
  if (choices.one_in(8)) contents.frames = static_cast<std::int32_t>(choices.below(1 << 20)) - 5;
  if (choices.one_in(8)) contents.period_s = odd_number(choices, 1.0);
  return contents;
}

StoreChunk any_chunk(Choices& choices) {
  StoreChunk chunk;
  if (choices.one_in(4)) chunk.octave = static_cast<std::int32_t>(choices.below(4)) - 1;
  if (choices.one_in(8)) chunk.frame = static_cast<std::int32_t>(choices.below(4)) - 1;
  if (choices.one_in(8)) chunk.field = static_cast<std::int32_t>(choices.below(4)) - 1;
  if (choices.one_in(4)) chunk.facts = true;
  if (choices.one_in(4)) chunk.presence = true;
  for (std::int64_t& at : chunk.at) at = static_cast<std::int64_t>(choices.below(3)) - (choices.one_in(16) ? 1 : 0);
  return chunk;
}

ChunkAnswer any_answer(Choices& choices) {
  ChunkAnswer answer{.chunk = any_chunk(choices),
                     .slot = static_cast<std::int32_t>(choices.below(5)) - (choices.one_in(8) ? 1 : 0)};
  answer.state = static_cast<ChunkState>(choices.below(3));
  answer.bytes = UINT64_MAX >> choices.below(64), answer.sentence = choices.bytes(choices.below(30));
  return answer;
}

Message any_message(Choices& choices) {
  switch (choices.below(11)) {
    case 5: return any_contents(choices);
    case 6: return StoreRoom{static_cast<std::int32_t>(choices.below(9)) - 2, UINT64_MAX >> choices.below(64)};
    case 7: return ChunkRequest{any_chunk(choices), static_cast<std::int32_t>(choices.below(9)) - 2};
    case 8: return any_answer(choices);
    case 9: return FetchRequest{.name = choices.bytes(choices.below(30)), .bytes = UINT64_MAX >> choices.below(64)};
    case 10:
      return FetchAnswer{.state = static_cast<FetchState>(choices.below(5)), .sentence = choices.bytes(choices.below(30))};
    case 0: return any_header(choices);
    case 1: return Done{{{"a file", choices.below(100), "00"}}, {choices.bytes(choices.below(10))}, {}, choices.one_in(3)};
    case 2: return Failure{choices.bytes(choices.below(60))};
    case 3: return ReadRequest{{0, static_cast<std::uint32_t>(choices.below(9))}};
    default: return Request{.path = choices.bytes(choices.below(30)), .max_bytes = choices.below(1000)};
  }
}

std::string damaged(Choices& choices, std::string bytes) {
  test::Damage damage([&](std::size_t n) { return static_cast<std::size_t>(choices.below(n)); });
  for (std::uint64_t n = choices.below(3); n > 0; --n) bytes = damage.damaged(std::move(bytes));
  bytes.resize(std::min(bytes.size(), max_packet_bytes));
  return bytes;
}

Tried unpacked_packets(Choices& choices, const fs::path& folder) {
  return {.broken = broken_by_packet(damaged(choices, bytes_of(any_message(choices))), folder)};
}

std::size_t open_descriptors() {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator("/proc/self/fd"), fs::directory_iterator()));
}

Attempt begin(const Parser& parser) {
  return [parser, seeds = parser.seeds()](Choices& choices, const fs::path& folder) {
    return Tried{.broken = parser.broken_by(damaged(choices, choices.one_of(seeds)), folder)};
  };
}

/// For any reader the caller gets a volume or a one-line error, in time, and leaks nothing.
Tried hostile_reader(Choices& choices, const fs::path& folder) {
  std::ofstream(folder / "a.nrrd") << "any bytes";
  {
    std::ofstream acts(folder / "acts", std::ios::binary);
    const auto now_and_then = [&](Act::Kind kind) {
      if (choices.one_in(10)) put_act(acts, {kind});
    };
    const auto packet = [&](const Message& message) {
      put_act(acts, {Act::send, choices.one_in(4) ? damaged(choices, bytes_of(message)) : bytes_of(message)});
    };
    put_act(acts, {Act::receive});
    for (std::uint64_t n = 1 + choices.below(2); n > 0; --n)
      packet(choices.one_in(8) ? any_message(choices) : Message(any_header(choices)));
    put_act(acts, {Act::receive});
    for (const Act::Kind kind : {Act::shrink, Act::crash, Act::hang, Act::spin, Act::close}) now_and_then(kind);
    put_act(acts, {Act::fill, choices.bytes(choices.below(9))});
    packet(choices.one_in(8) ? any_message(choices) : Message(Done{{{"a file", 1, "00"}}, {}, {}, choices.one_in(8)}));
    for (const Act::Kind kind : {Act::crash, Act::hang}) now_and_then(kind);
  }
  ::setenv("PALPA_HOSTILE", (folder / "acts").c_str(), 1);
  ReadOptions options;
  options.reader = PALPA_HOSTILE_READER;
  options.idle_limit_s = 0.3;
  options.max_bytes = 100'000'000;
  const std::size_t descriptors = open_descriptors();
  Tried result;
  try {
    read_volume(folder / "a.nrrd", options);
  } catch (const LoadError& error) {
    result.broken = broken_by_refusal(error.what());
    result.refused = 1;
  }
  if (open_descriptors() != descriptors) result.broken = "no descriptor is left";
  if (::waitpid(-1, nullptr, WNOHANG) != -1) result.broken = "no child is left";
  return result;
}

/// For any reader of a store the caller gets chunks or a one-line error, in time, and leaks nothing.
Tried hostile_store(Choices& choices, const fs::path& folder) {
  fs::create_directories(folder / "a.zarr");
  std::ofstream(folder / "a.zarr" / ".zgroup") << "{}";
  {
    std::ofstream acts(folder / "acts", std::ios::binary);
    const auto packet = [&](const Message& message) {
      put_act(acts, {Act::send, choices.one_in(4) ? damaged(choices, bytes_of(message)) : bytes_of(message)});
    };
    put_act(acts, {Act::receive});
    packet(choices.one_in(8) ? any_message(choices) : Message(any_contents(choices)));
    put_act(acts, {Act::receive});
    for (int n = 0; n < 4; ++n) {
      put_act(acts, {Act::receive});
      for (const Act::Kind kind : {Act::shrink, Act::crash, Act::hang, Act::spin, Act::close})
        if (choices.one_in(20)) put_act(acts, {kind});
      ChunkAnswer answer{.slot = n, .state = static_cast<ChunkState>(choices.below(3))};
      packet(choices.one_in(8) ? any_message(choices) : choices.one_in(4) ? Message(any_answer(choices)) : Message(answer));
    }
    if (choices.one_in(3)) put_act(acts, {Act::hang});
  }
  ::setenv("PALPA_HOSTILE", (folder / "acts").c_str(), 1);
  ReadOptions options;
  options.reader = PALPA_HOSTILE_READER;
  options.idle_limit_s = 0.3;
  options.max_bytes = 400'000'000;
  const std::size_t descriptors = open_descriptors();
  Tried result;
  try {
    StoreReader store(folder / "a.zarr", options, 4);
    for (int slot = 0; slot < 4; ++slot) store.request({}, slot);
    for (int n = 0; n < 4; ++n) {
      if (const auto read = store.next(1.0); read && (read->slot < 0 || read->slot > 3 || store.content(read->slot).empty()))
        result.broken = "a chunk is in a slot";
    }
  } catch (const LoadError& error) {
    result.broken = broken_by_refusal(error.what());
    result.refused = 1;
  }
  if (open_descriptors() != descriptors) result.broken = "no descriptor is left";
  if (::waitpid(-1, nullptr, WNOHANG) != -1) result.broken = "no child is left";
  return result;
}

/// For any reader of rows the caller gets rows or a one-line error, in time, and leaks nothing.
Tried hostile_rows(Choices& choices, const fs::path& folder) {
  std::ofstream(folder / "a.nrrd") << "any bytes";
  {
    std::ofstream acts(folder / "acts", std::ios::binary);
    const auto packet = [&](const Message& message) {
      put_act(acts, {Act::send, choices.one_in(8) ? damaged(choices, bytes_of(message)) : bytes_of(message)});
    };
    put_act(acts, {Act::receive});
    packet(choices.one_in(8) ? any_message(choices) : Message(any_header(choices)));
    put_act(acts, {Act::receive});
    for (std::int32_t n = 0; n < 5; ++n) {
      put_act(acts, {Act::receive});
      for (const Act::Kind kind : {Act::shrink, Act::crash, Act::hang, Act::spin, Act::close})
        if (choices.one_in(20)) put_act(acts, {kind});
      ChunkAnswer answer{.chunk = {.at = {0, 0, n}}, .slot = 63 - n};  // the last free slot is taken first
      if (choices.one_in(8)) answer.state = static_cast<ChunkState>(choices.below(3));
      packet(choices.one_in(8) ? any_message(choices) : choices.one_in(4) ? Message(any_answer(choices)) : Message(answer));
    }
    if (choices.one_in(3)) put_act(acts, {Act::hang});
  }
  ::setenv("PALPA_HOSTILE", (folder / "acts").c_str(), 1);
  ReadOptions options;
  options.reader = PALPA_HOSTILE_READER;
  options.idle_limit_s = 0.3;
  options.max_bytes = 100'000'000;
  const std::size_t descriptors = open_descriptors();
  Tried result;
  try {
    VolumeRequest request;
    request.files = {folder / "a.nrrd"};
    if (const auto file = open_sliced_file(request, options)) {
      const SlicedFile::Field& field = file->fields.front();
      const auto& n = field.grid.dims;
      std::vector<std::byte> rows(static_cast<std::size_t>(n[0] * n[2] * field.components) * size_of(field.type));
      file->read(0, {0, n[2], n[1] - 1, 1}, rows.data());
    }
  } catch (const LoadError& error) {
    result.broken = broken_by_refusal(error.what());
    result.refused = 1;
  }
  if (open_descriptors() != descriptors) result.broken = "no descriptor is left";
  if (::waitpid(-1, nullptr, WNOHANG) != -1) result.broken = "no child is left";
  return result;
}

}  // namespace

void add_protocol(std::vector<Campaign>& to) {
  to.push_back({.name = "packet", .of = "packets", .long_tries = 10'000'000, .begin = [](const fs::path&) {
                  return Attempt(unpacked_packets);
                }});
  to.push_back({.name = "reader",
                .of = "readers",
                .long_tries = 20'000,
                .begin =
                    [](const fs::path&) {
                      return Attempt([](Choices& choices, const fs::path& folder) {
                        if (choices.one_in(3)) return hostile_rows(choices, folder);
                        return choices.one_in(2) ? hostile_store(choices, folder) : hostile_reader(choices, folder);
                      });
                    },
                .patience_s = 120.0});  // a reader may compute for seconds, which a busy machine makes a minute
  for (const Parser& parser : parsers()) {
    if (parser.name == "packet") continue;  // which has its own campaign, of messages with any content
    to.push_back({.name = "parser " + parser.name, .of = "texts", .long_tries = 1'000'000, .begin = [parser](const fs::path&) {
                    return begin(parser);
                  }});
  }
}

}  // namespace palpa::fuzz
