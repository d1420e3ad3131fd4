#include "app/info_store.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "app/info_numbers.h"
#include "palpa/base/web_address.h"
#include "palpa/base/wording.h"
#include "palpa/file/protocol.h"
#include "palpa/file/store_protocol.h"
#include "palpa/file/store_volume.h"

namespace palpa::app {
namespace {

using Json = nlohmann::ordered_json;

constexpr double longest_survey_s = 0.4;  // More: slower; less: fewer chunks are looked at
constexpr double longest_facts_s = 60.0;  // More: info of very large stores takes longer; less: not all lost chunks are found
constexpr int slots = 16;                 // [1] More: more memory; fewer: slow disks are used less
constexpr int slots_of_web = 64;          // [1] as where it is felt: a network is slow alone, not at once
constexpr double hand_m = 0.15;           // of the longest side, where a store is felt
constexpr double much_waste = 2.0;        // [1] More: slow stores are not reported; less: usual ones are

std::string sides(const std::array<std::int64_t, 3>& n) { return fmt::format("{} × {} × {}", n[0], n[1], n[2]); }

std::string bytes_words(double bytes) { return protocol::readable_bytes(bytes); }

const char* making_words(OctaveMaking making) {
  switch (making) {
    case OctaveMaking::means: return "means of 2 × 2 × 2 voxels";
    case OctaveMaking::decimation: return "every second voxel";
    case OctaveMaking::neither: return "neither means of 2 × 2 × 2 voxels nor every second voxel";
    case OctaveMaking::undecided: return "means or every second voxel, which the looked-at voxels leave open";
    case OctaveMaking::none: break;
  }
  return "";
}

std::string making_key(OctaveMaking making) {
  static constexpr const char* keys[] = {"none", "means", "decimation", "neither", "undecided"};
  return keys[static_cast<std::size_t>(making)];
}

std::string octave_words(const StoreFacts& facts) {
  const std::size_t count = facts.places.octaves.size();
  const std::string coarsest = sides(facts.places.octaves.back().grid.dims);
  if (count == 1) return "1; palpa prepare makes coarser ones, as feeling a store needs them";
  return fmt::format("{}, down to {} voxels: {}", count, coarsest, making_words(facts.places.making));
}

std::string lost_words(const StoreFacts& facts) {
  if (facts.contents.prepared && is_web_address(facts.name)) return "not looked for: by HTTP each chunk would be a request";
  const StoreSurvey& survey = facts.survey;
  const std::string of =
      static_cast<double>(survey.looked_for) == survey.chunks
          ? fmt::format("all {} chunks", rounded_words(survey.chunks))
          : fmt::format("{} chunks that were looked at, of {}", survey.looked_for, rounded_words(survey.chunks));
  if (survey.absent == 0) return "none of " + of;
  if (!survey.can_tell_lost)
    return fmt::format("{} of {} are absent; whether they were lost, a store of one octave does not say", survey.absent, of);
  if (survey.lost == 0) return fmt::format("none of {}: {} are absent, and have the fill value", of, survey.absent);
  return fmt::format("{} of {}: absent, where {} has values; get them again", survey.lost, of,
                     facts.contents.prepared ? "palpa prepare found values or the next octave" : "the next octave");
}

std::string chunk_words(const StoreFacts& facts) {
  const StoreOctave& octave = facts.contents.octaves.front();
  std::string words = fmt::format("{} voxels, {}", sides(octave.chunk), octave.codec);
  if (octave.shard != octave.chunk) words += fmt::format(", in shards of {}", sides(octave.shard));
  return words;
}

/// Lines that all stores have.
std::string common_words(const StoreFacts& facts) {
  const StoreSurvey& survey = facts.survey;
  std::string stored;
  if (survey.stored_share > 0.0) {
    const double present =
        1.0 - static_cast<double>(survey.absent) / static_cast<double>(std::max<std::int64_t>(survey.looked_for, 1));
    stored = fmt::format(", about {} in the store",
                         bytes_words(facts.whole_bytes() * facts.contents.frames * survey.stored_share * present));
  }
  const double waste = waste_of_chunks(facts.contents.octaves.front());
  std::string words =
      line("store", facts.contents.format + stored) + line("octaves", octave_words(facts)) + line("chunks", chunk_words(facts));
  if (waste > much_waste) {
    words += line("", fmt::format("a window of 128 × 128 × 128 voxels reads {:.2g} times too much; palpa convert {} NEW.zarr "
                                  "writes chunks of 32 × 32 × 32",
                                  waste, for_shell(facts.name)));
  }
  words += line("lost", lost_words(facts));
  if (survey.damaged > 0)
    words += line("damaged",
                  fmt::format("{} of {} chunks that were looked at: {}", survey.damaged, survey.looked_at, survey.damage));
  return words + line("prepared", facts.contents.prepared ? "yes: ranges and checksums of all chunks are known"
                                                          : "no; palpa prepare " + for_shell(facts.name) + " does it");
}

std::string end_words(const StoreSurvey::Values& values, double value) {
  if (values.min > values.max) return "unknown";
  return (values.about ? "about " : "") + rounded_words(value, values.max - values.min);
}

std::string field_words(const StoreFacts& facts) {
  std::size_t width = 5;
  for (const StoreField& field : facts.contents.fields) width = std::max(width, field.name.size());
  std::string words = fmt::format("\n  {:<{}}  {:<8}  {:<9}  {:<26}  max\n", "field", width, "unit", "stored as", "min");
  bool is_about = false;
  for (std::size_t f = 0; f < facts.contents.fields.size(); ++f) {
    const StoreField& field = facts.contents.fields[f];
    const StoreSurvey::Values& values = facts.survey.values[f];
    is_about = is_about || values.about;
    words += fmt::format("  {:<{}}  {:<8}  {:<9}  {:<26}  {}\n", field.name, width, field.unit.empty() ? "–" : field.unit,
                         field.file_type + (field.components == 3 ? "×3" : ""), end_words(values, values.min),
                         end_words(values, values.max));
  }
  if (is_about) words += "  of a sample of chunks: the range may be larger\n";
  std::string bars;
  for (const StoreField& field : facts.contents.fields) {
    const Histogram& h = field.histogram;
    if (h.counts.empty() || h.total() == 0) continue;
    const auto value = [&](double raw) { return rounded_words(raw, h.high - h.low); };
    bars += line(field.name, fmt::format("{}median {}, 99 % up to {}", field.components == 3 ? "length: " : "",
                                         value(h.percentile(0.5)), value(h.percentile(0.99))));
    bars += line("", fmt::format("{} ▕{}▏ {}", value(h.low), bars_of(h), value(h.high)));
  }
  return words + (bars.empty() ? "" : "\n" + bars);
}

Json json_number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

/// [m] Distances of voxels along i, j, k.
std::array<double, 3> spacings_m(const GridGeometry& grid) {
  const Mat3 columns = transposed(grid.index_to_world_m);
  return {norm(columns.row[0]), norm(columns.row[1]), norm(columns.row[2])};
}

/// Whether a grid lies along the axes of the world.
bool is_along_axes(const GridGeometry& grid) {
  const Mat3& m = grid.index_to_world_m;
  return std::abs(m.row[0].y) + std::abs(m.row[0].z) + std::abs(m.row[1].x) + std::abs(m.row[1].z) + std::abs(m.row[2].x) +
             std::abs(m.row[2].y) ==
         0.0;
}

/// [m] Of the hand a voxel, where the longest side of a grid is as long as a first scene makes it.
double voxel_of_hand_m(const GridGeometry& grid) {
  const std::array<double, 3> spacing_m = spacings_m(grid);
  double longest_m = 0.0;
  for (std::size_t a = 0; a < 3; ++a) longest_m = std::max(longest_m, spacing_m[a] * static_cast<double>(grid.dims[a]));
  return hand_m * std::ranges::min(spacing_m) / longest_m;
}

Json store_json(const StoreFacts& facts) {
  const StoreContents& contents = facts.contents;
  Json octaves = Json::array(), fields = Json::array();
  for (const StoreOctave& octave : facts.places.octaves) {
    const Mat3& steps = octave.grid.index_to_world_m;
    Json rows = Json::array();
    for (const Vec3& row : steps.row) rows.push_back({row.x, row.y, row.z});
    octaves.push_back({{"dims", octave.grid.dims},
                       {"spacing_m", spacings_m(octave.grid)},
                       {"index_to_world_m", rows},
                       {"origin_m", {octave.grid.origin_m.x, octave.grid.origin_m.y, octave.grid.origin_m.z}},
                       {"chunk", octave.chunk},
                       {"shard", octave.shard},
                       {"codec", octave.codec}});
  }
  for (std::size_t f = 0; f < contents.fields.size(); ++f) {
    const StoreSurvey::Values& values = facts.survey.values[f];
    fields.push_back({{"name", contents.fields[f].name},
                      {"unit", contents.fields[f].unit},
                      {"components", contents.fields[f].components},
                      {"type", contents.fields[f].file_type},
                      {"fill", json_number(contents.fields[f].fill)},
                      {"min", json_number(values.min)},
                      {"max", json_number(values.max)},
                      {"of_sample", values.about}});
    const Histogram& h = contents.fields[f].histogram;
    if (!h.counts.empty()) fields.back()["histogram"] = {{"low", h.low}, {"high", h.high}, {"counts", h.counts}};
  }
  const StoreSurvey& survey = facts.survey;
  return {{"format", contents.format},
          {"length_unit", contents.length_unit},
          {"length_unit_assumed", contents.length_unit_assumed},
          {"frames", contents.frames},
          {"period_s", contents.period_s},
          {"prepared", contents.prepared},
          {"fields", std::move(fields)},
          {"octaves", std::move(octaves)},
          {"octaves_made_by", making_key(facts.places.making)},
          {"chunk_waste", waste_of_chunks(contents.octaves.front())},
          {"chunks", survey.chunks},
          {"chunks_looked_for", survey.looked_for},
          {"chunks_looked_at", survey.looked_at},
          {"chunks_absent", survey.absent},
          {"chunks_lost", survey.lost},
          {"chunks_damaged", survey.damaged}};
}

}  // namespace

double StoreFacts::whole_bytes() const noexcept {
  double voxel_bytes = 0.0, voxels = 1.0;
  for (const StoreField& field : contents.fields) voxel_bytes += static_cast<double>(size_of(field.type)) * field.components;
  for (const std::int64_t n : contents.octaves.front().grid.dims) voxels *= static_cast<double>(n);
  return voxels * voxel_bytes;
}

std::optional<StoreFacts> store_facts_of(const Asked& asked, const ReadOptions& read) {
  const std::filesystem::path& path = asked.request.files.front();
  if (asked.is_series || asked.request.files.size() > 1 || !protocol::is_store(path)) return std::nullopt;
  std::optional<StoreReader> reader;
  try {
    reader.emplace(path, read, is_web_address(path) ? slots_of_web : slots);
  } catch (const LoadError&) {
    if (is_web_address(path)) throw;
    return std::nullopt;  // Reading it as a whole succeeds, as with one large chunk, or says why it fails.
  }
  StoreFacts facts{asked.name, reader->contents(), {}, {}, detail::most_whole_bytes(asked.request)};
  facts.places = octave_places(*reader);
  facts.survey = survey(*reader, longest_survey_s, longest_facts_s);
  const int octaves = detail::felt_octaves(reader->contents(), facts.places);
  if (facts.is_large() && octaves > 1) {
    const double voxel_hand_m = voxel_of_hand_m(reader->contents().octaves.front().grid);
    facts.expected = expected_octaves(reader->contents(), octaves, voxel_hand_m, measured_chunk_s(*reader));
  }
  return facts;
}

ReadOptions options_for_whole(const Asked& asked, ReadOptions read) {
  if (read.max_bytes == 0 && protocol::is_store(asked.request.files.front()))
    read.max_bytes = static_cast<std::uint64_t>(detail::most_whole_bytes(asked.request));
  return read;
}

InfoTable store_table(const StoreFacts& facts) {
  const StoreContents& contents = facts.contents;
  const GridGeometry& grid = contents.octaves.front().grid;
  const std::array<double, 3> spacing_m = spacings_m(grid);
  std::vector<std::string> spacings, sizes;
  for (std::size_t a = 0; a < 3; ++a) {
    spacings.push_back(length_words(spacing_m[a]));
    sizes.push_back(length_words(spacing_m[a] * static_cast<double>(grid.dims[a])));
  }
  InfoTable table{facts.name + "\n", {}};
  table.words += line("grid", fmt::format("{} voxels of {} × {} × {}{}", sides(grid.dims), spacings[0], spacings[1],
                                          spacings[2], is_along_axes(grid) ? "" : ", turned or sheared in the world"));
  table.words += line(
      "size", fmt::format("{} × {} × {}{}, {} as a whole", sizes[0], sizes[1], sizes[2],
                          contents.length_unit_assumed ? " (micrometres are assumed)" : "", bytes_words(facts.whole_bytes())));
  if (contents.frames > 1) table.words += line("frames", fmt::format("{}", contents.frames));
  table.words += common_words(facts);
  if (facts.expected) table.words += line("felt live", words_of(*facts.expected));
  table.words += field_words(facts);
  table.json["format"] = "zarr";
  table.json["store"] = store_json(facts);
  if (facts.expected) table.json["store"]["felt_live"] = Json::parse(to_json(*facts.expected));
  std::vector<std::string> warnings = contents.warnings;
  warnings.insert(warnings.end(), facts.places.warnings.begin(), facts.places.warnings.end());
  table.json["warnings"] = warnings;
  return table;
}

void add_store(InfoTable& table, const StoreFacts& facts) {
  table.words += "\n" + common_words(facts);
  table.json["store"] = store_json(facts);
  for (const std::string& warning : facts.places.warnings) table.json["warnings"].push_back(warning);
}

}  // namespace palpa::app
