#include "tests/fuzz/parsers.h"

#include <toml++/toml.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "palpa/base/load_error.h"
#include "palpa/base/sanitized.h"
#include "palpa/base/toml_problem.h"
#include "palpa/device/hand.h"
#include "palpa/file/store_protocol.h"
#include "palpa/trace/csv.h"
#include "palpa/trace/trace.h"

namespace palpa::fuzz {
namespace {

using namespace protocol;

std::string content(const fs::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}
fs::path written(const fs::path& file, std::string_view bytes) {
  std::ofstream(file, std::ios::binary) << bytes;
  return file;
}

/// The promise broken by the action, which may refuse with a message.
template <class Action>
std::string unless_refused(Action action) {
  try {
    return action();
  } catch (const LoadError& error) {
    return broken_by_refusal(error.what());
  }
}

// ---- packets ----

std::string broken_by_header(const Header& header) {
  ReadRequest room;
  for (std::uint32_t n = 0; n < header.fields.size(); ++n) {
    room.fields.push_back(n);
    const auto voxels = voxel_bytes(header.fields[n]);
    if (voxels && *voxels > (std::uint64_t{1} << 62)) return "the size of voxels does not overflow";
    unsigned __int128 exact = static_cast<unsigned>(std::max(header.fields[n].components, 0));
    for (const std::int64_t dim : header.fields[n].grid.dims)
      exact = std::min<unsigned __int128>(exact * static_cast<std::uint64_t>(dim), std::uint64_t{1} << 63);
    if (voxels && *voxels < exact) return "voxels have a byte at least";
  }
  if (const auto places = place(header, room)) {
    for (std::size_t n = 1; n < places->size(); ++n) {
      if ((*places)[n] < (*places)[n - 1] + *voxel_bytes(header.fields[n - 1])) return "places of fields do not overlap";
    }
  }
  return {};
}

/// Sizes of a valid store are small, and its last chunk has a place.
std::string broken_by_contents(const StoreContents& contents) {
  if (problem_with(contents) != nullptr) return {};
  const std::uint64_t most_bytes = slot_bytes(contents);
  if (most_bytes > most_chunk_bytes + (std::uint64_t{1} << 24)) return "a slot is no larger than a chunk";
  for (std::size_t n = 0; n < contents.octaves.size(); ++n) {
    const StoreOctave& octave = contents.octaves[n];
    StoreChunk last{.octave = static_cast<std::int32_t>(n), .frame = contents.frames - 1};
    for (std::size_t a = 0; a < 3; ++a) last.at[a] = (octave.grid.dims[a] - 1) / octave.chunk[a];
    if (!has_place(contents, last) || content_bytes(contents, last) > most_bytes) return "a chunk has a place in a slot";
    ++last.at[0];
    if (has_place(contents, last)) return "there is no chunk beyond the last";
  }
  return {};
}

std::vector<std::string> seeds_of_packets() {
  FieldHeader field;
  field.name = "value", field.unit = "HU";
  field.grid.dims = {4, 5, 6};
  FieldHeader planes = field;
  planes.components = 3;
  for (std::vector<double>& axis : planes.grid.planes) axis = {0.0};
  Header header;
  header.format = "nrrd", header.default_unit = "mm", header.warnings = {"a warning"};
  header.scan.emplace_back(), header.fields = {field, planes};
  Request request{.path = "a folder/a.nrrd", .as = "vector", .frame = 2, .max_bytes = 1000};
  request.partners = {"b"}, request.time_s = 0.5, request.crop = Box{{0, 0, 0}, {1, 1, 1}};
  StoreContents contents{.format = "OME-Zarr 0.4, Zarr v2", .length_unit = "um", .warnings = {"a warning"}};
  contents.fields = {{.name = "value", .file_type = "uint8"}};
  contents.octaves = {{.chunk = {32, 32, 32}, .shard = {64, 64, 64}, .codec = "blosc (lz4)", .facts = {4, 4, 4}}};
  contents.octaves.front().grid.dims = {300, 200, 100};
  const std::vector<Message> messages{header,
                                      request,
                                      Done{{{"a file", 100, "00"}}, {"late"}, {{}}, true},
                                      Failure{"is not liked; bring another"},
                                      ReadRequest{{0, 2}, 3},
                                      contents,
                                      StoreRoom{4, 65536},
                                      ChunkRequest{{.octave = 1}, 2},
                                      ChunkAnswer{{.octave = 1}, 2, ChunkState::damaged, 99, "'0/1': is cut"},
                                      FetchRequest{3, "0/1/2/3", 64, 1 << 20, true, 1 << 26},
                                      FetchAnswer{3, FetchState::failed, 64, 1 << 27, true, "its server answers 403"}};
  std::vector<std::string> seeds;
  for (const Message& message : messages) seeds.push_back(bytes_of(message));
  return seeds;
}

// ---- TOML ----

/// Accepted text can be parsed, or the parser itself refuses it; refused text has a position and a message.
std::string broken_by_toml(std::string_view text, const fs::path&) {
  if (const auto problem = detail::problem_with_toml(text)) {
    const auto lines = static_cast<std::size_t>(std::count(text.begin(), text.end(), '\n')) + 1;
    if (problem->line < 1 || problem->line > lines || problem->column < 1 || problem->column > text.size() + 1)
      return "a problem of a text has a place in it";
    return broken_by_refusal("a:" + std::to_string(problem->line) + ": " + problem->sentence);
  }
  try {
    const toml::table parsed = toml::parse(text);
    // The parser recurses for tables within tables.
    std::size_t deepest = 0;
    const auto look = [&](const auto& self, const toml::node& node, std::size_t depth) -> void {
      deepest = std::max(deepest, depth);
      if (const toml::table* table = node.as_table()) {
        for (const auto& [key, value] : *table) self(self, value, depth + 1);
      }
      if (const toml::array* array = node.as_array()) {
        for (const toml::node& value : *array) self(self, value, depth + 1);
      }
    };
    look(look, parsed, 0);
    if (deepest > 10'000) return "tables let through are not nested without bound: " + std::to_string(deepest);
  } catch (const toml::parse_error&) {
  }
  return {};
}

std::vector<std::string> seeds_of_toml() {
  return {
      "palpa = 1\ntitle = \"a \\\"head\\\"\"\n[coupling]\nstiffness_n_per_m = 8e2\n[[mode]]\nname = 'skin'\n[[mode.level]]\n"
      "value = -300 # HU\n",
      "a.b.\"c d\".'e' = [1, 2.5, {x = true, y = 1979-05-27T07:32:00Z}]\n",
      "t = \"\"\"\nseveral\\\n  lines \"\" \"\"\"\nl = '''raw ''\n'''\nn = {a = \"\"\"b\"\"\"\", c.c.c = 1}\n",
      "x = [[[[0x1f, 0o7, 0b1], inf], -nan], 1_000]\r\n"};
}

// ---- CSV ----

/// Lines and cells are those of the text for any content, and a written cell is read back.
std::string broken_by_csv(std::string_view bytes, const fs::path& folder) {
  return unless_refused([&]() -> std::string {
    detail::LineFile file(written(folder / "a.csv", bytes));
    std::string_view line;
    std::vector<std::string_view> cells, again;
    std::size_t at = 0;
    while (file.next(line)) {
      const std::size_t end = bytes.find('\n', at);
      std::string_view whole = bytes.substr(at, end - at);
      if (whole.ends_with('\r')) whole.remove_suffix(1);
      if (end == std::string_view::npos || line != whole) return "lines of a file are its lines";
      at = end + 1;
      detail::split(line, cells);
      std::string joined;
      for (const std::string_view cell : cells) joined += "," + std::string(cell);
      if (joined.substr(1) != line) return "cells joined are the line that was split";
      for (const std::string_view cell : cells) {
        double number = 0.0, back = 0.0;
        std::string text;
        if (detail::take_number(cell, number)) {
          detail::put_number(text, number);
          const bool same = std::bit_cast<std::uint64_t>(number) == std::bit_cast<std::uint64_t>(back) || std::isnan(number);
          if (!detail::take_number(text, back) ||
              (!same && std::bit_cast<std::uint64_t>(number) != std::bit_cast<std::uint64_t>(back)))
            return "a number that was written is read back the same";
        }
        text.clear();
        detail::put_text(text, cell);
        detail::split(text, again);
        if (again.size() != 1) return "a text that was written is one cell";
      }
    }
    if (bytes.find('\n', at) != std::string_view::npos) return "all lines of a file are read";
    return {};
  });
}

std::vector<std::string> seeds_of_csv() {
  return {
      "tick,t_s,kind,subject,value\n5,0.005,onset,skin,-300\n5,0.005,fault,\"with,comma\",\"strength is negative, "
      "\"\"so\"\"\"\n",
      "a,b\r\n1e-310,nan\r\n-inf,18446744073709551615\r\nhalf a li"};
}

// ---- hands ----

std::string broken_by_target(const Target& target) {
  const double duration_s = target.duration_s();
  if (!std::isfinite(duration_s) || duration_s < 0.0) return "a recorded hand has a length";
  for (const std::string& warning : target.warnings()) {
    if (warning != detail::sanitized(warning)) return "a warning is one line in words";
  }
  constexpr double beyond_m = 2100.0;  // the longest admitted distance, between ends of a box, with rounding
  for (int n = -2; n <= 34; ++n) {
    const Target::Point point = target.at(duration_s * n / 32.0);
    if (point.valid && !(largest_component(point.position_m) < beyond_m)) return "a valid position is where a hand can be";
    if (!is_finite(target.at(1e300 * n).position_m) && point.valid) return "a position is finite at every time";
  }
  return {};
}

/// A recorded hand has a position at every time, for any form.
std::string broken_by_hand(std::string_view bytes, const fs::path& folder) {
  const fs::path file = written(folder / "hand.csv", bytes);
  const RecordingOptions with_rate{.hand_rate_hz = 200.0, .center = false};
  for (const RecordingOptions& options : {RecordingOptions{}, with_rate}) {
    if (std::string broken = unless_refused([&] { return broken_by_target(*recorded_target(file, options)); }); !broken.empty())
      return broken;
  }
  return {};
}

std::vector<std::string> seeds_of_hands() {
  return {
      "t_s,x_m,y_m,z_m,buttons\n0,0,0.01,0.09,0\n0.005,+0.001,0.01,0.088,1\n0.2,0.002,0.01,nan,0\n0.21,0.003,1e-400,0.08,0\n",
      "Time,Cursor Position X,Cursor Position Y,Cursor Position Z\n0,0,0,0\n0.001,0.01,0.02,0.03\n0.002,0.01,0.02,0.03\n",
      "x,y,z\n0,0.01,0.09\n0.0005, 0.01 ,0.08\r\n\n1e3,0,0\n",
      "tick,t_s,probe_x_m,probe_y_m,probe_z_m,probe_valid,buttons\n0,0,0,0,0,1,0\n1,0.001,0.1,0,0,0,4294967295\n"};
}

// ---- traces ----

constexpr std::array trace_files{"trace.toml",   "ticks.csv",      "modes.csv",  "events.csv",
                                 "balances.csv", "primitives.csv", "timing.csv", "scene.toml"};

constexpr std::int64_t sound_ticks = 5;

void record(const fs::path& folder) {
  TraceHeader header;
  header.arguments = {"palpa", "run"}, header.sets = {{"coupling.damping_ns_per_m", "0.3"}}, header.notes = {"a note"};
  header.device_name = "touch", header.data_files = {{"a.nrrd", 12, "00"}}, header.seeds = {7}, header.primitives = true;
  TraceWriter writer(folder, header, "palpa = 1\n", {"skin", "with,comma"});
  const PlacedPrimitive plane{
      .primitive = {.kind = PrimitiveKind::plane, .id = {0, 3}, .direction = {0, 0, 1}, .strength_n = 0.8},
      .captured = {.field = 0, .value = -300},
      .force_n = {0, 0, 0.5},
      .state = PrimitiveState::stick};
  const SubStep step{.time_step_s = 1e-3, .stiffness_n_per_m = 500, .move_fraction = 1, .first_primitive = 0, .primitives = 1};
  const ModeForce modes[] = {{.force_n = {0, 0, 1}, .primitives = 2}, {.split_shared = true}};
  for (std::int64_t n = 0; n < sound_ticks; ++n) {
    TickFrame frame{.tick = n, .t_s = 1e-3 * static_cast<double>(n), .dt_s = 1e-3};
    frame.result.probe_m = {0.0, 0.001 * static_cast<double>(n), 1.0 / 3.0};
    writer.append(frame, modes, {&step, 1}, {&plane, 1}, {});
  }
  writer.append_event(4, 0.004, "warning", "session", "two, \"words\"");
  writer.finish();
}

/// The first byte selects the trace's file of the other bytes. Read values are the text's numbers, or the trace is refused; it
/// equals itself.
std::string broken_by_trace(std::string_view bytes, const fs::path& folder) {
  if (bytes.empty()) return {};
  const fs::path sound = folder / "sound", damaged = folder / "damaged";
  if (!fs::exists(sound)) record(sound);
  if (!fs::exists(damaged)) fs::copy(sound, damaged);
  const char* file = trace_files[static_cast<unsigned char>(bytes.front()) % trace_files.size()];
  written(damaged / file, bytes.substr(1));
  std::string broken = unless_refused([&]() -> std::string {
    const TraceReader trace(damaged);
    if (!(trace.header().dt_s > 0.0)) return "a trace has a time step";
    if (!std::isfinite(trace.header().hand_to_world.scale)) return "a trace has a map from hand to world";
    const std::vector<TraceTick> ticks = trace.ticks();
    trace.has_energy();
    return ticks.size() <= std::max<std::size_t>(sound_ticks, bytes.size()) ? std::string() : "a tick is a row";
  });
  const auto compared = [&](const fs::path& a, const fs::path& b) {
    return unless_refused([&]() -> std::string {
      const TraceDifference difference = compare_traces(a, b);
      if (difference.where != detail::sanitized(difference.where)) return "where traces differ is said in one line";
      // Values may be missing, but none may differ from itself.
      if (a == b && difference.where.find(" against ") != std::string::npos)
        return "a trace is the same as itself: " + difference.where;
      return {};
    });
  };
  if (broken.empty()) broken = compared(damaged, sound);
  if (broken.empty()) broken = compared(sound, damaged);
  if (broken.empty()) broken = compared(damaged, damaged);
  fs::copy_file(sound / file, damaged / file, fs::copy_options::overwrite_existing);
  return broken;
}

std::vector<std::string> seeds_of_traces() {
  std::string name = (fs::temp_directory_path() / "palpa-seeds-XXXXXX").string();
  const fs::path folder = ::mkdtemp(name.data());
  record(folder / "trace");
  std::vector<std::string> seeds;
  for (std::size_t n = 0; n < trace_files.size(); ++n)
    seeds.push_back(static_cast<char>(n) + content(folder / "trace" / trace_files[n]));
  fs::remove_all(folder);
  return seeds;
}

}  // namespace

std::string bytes_of(const Message& message) {
  const std::vector<std::byte> packet = packed(message);
  return {reinterpret_cast<const char*>(packet.data()), packet.size()};
}

std::string broken_by_packet(std::string_view bytes, const fs::path&) {
  const auto message = unpacked(reinterpret_cast<const std::byte*>(bytes.data()), bytes.size());
  if (!message) return {};
  const std::vector<std::byte> packet = packed(*message);
  const auto again = unpacked(packet.data(), packet.size());
  if (!again || packed(*again) != packet) return "a message that was unpacked is packed and unpacked to the same";
  if (const auto* contents = std::get_if<StoreContents>(&*message)) return broken_by_contents(*contents);
  const Header* header = std::get_if<Header>(&*message);
  return header ? broken_by_header(*header) : std::string();
}

std::string broken_by_refusal(std::string_view text) {
  constexpr std::size_t longest = 3000;  // [1] bytes
  const auto with = [&](const char* promise) { return std::string(promise) + ": " + detail::sanitized(text.substr(0, 300)); };
  if (text != detail::sanitized(text)) return with("a refusal steers nothing");
  if (text.find("; ") == std::string_view::npos) return with("a refusal says what would be right");
  if (text.size() > longest) return with("a refusal can be read");
  return {};
}

std::vector<Parser> parsers() {
  return {{"packet", broken_by_packet, seeds_of_packets},
          {"toml", broken_by_toml, seeds_of_toml},
          {"csv", broken_by_csv, seeds_of_csv},
          {"hand", broken_by_hand, seeds_of_hands},
          {"trace", broken_by_trace, seeds_of_traces}};
}

}  // namespace palpa::fuzz
