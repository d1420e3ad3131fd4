#include "palpa/scene/load_volumes.h"

#include <algorithm>
#include <cstdlib>
#include <new>
#include <optional>
#include <stdexcept>

#include "palpa/base/limits.h"
#include "palpa/base/web_address.h"
#include "palpa/base/wording.h"
#include "palpa/data/analytic.h"
#include "palpa/data/grid.h"
#include "palpa/data/labels.h"
#include "palpa/data/read_series.h"
#include "palpa/data/timed_field.h"

namespace palpa::detail::scene_file {

using detail::in_quotes;

// A volume that is yet to be opened.
struct VolumePlan : detail::VolumePart {
  std::string name;
  const toml::table* table = nullptr;
  Similarity placed;                                   // `pose`
  PoseTrack track;                                     // `poses`
  std::vector<std::pair<std::string, double>> labels;  // names of fields, and the number that each shows
  std::string source;
};

// Rules that hold between several keys of a request.
void check_request(const Section& section, const VolumeRequest& request) {
  for (const char* key : {"byte_order", "header_bytes"}) {
    if (request.layout.type.empty() && section.node(key)) {
      section.refuse(key, "is for a file of bare numbers; give 'type', too, or leave it out");
    }
  }
  for (const VolumeRequest::FieldRequest& field : request.fields) {
    const toml::node* arrays = (*section.subtable("fields"))[field.name]["arrays"].node();
    if (!arrays || (field.arrays.size() == 3 && field.array.empty())) continue;
    fail(place_of(*arrays), "'arrays' in field " + in_quotes(field.name) + " of " + section.where() +
                                (field.array.empty() ? " has " + std::to_string(field.arrays.size()) +
                                                           " names; it must be a list of 3, along x, y and z"
                                                     : " stands beside 'array'; give one of them"));
  }
}

namespace {

void check_series(const Section& section, const VolumePlan& plan) {
  const bool grids_of_formula =
      plan.sampled && std::ranges::find(beating_volumes(), plan.analytic, &AnalyticVolume::name) != beating_volumes().end();
  if (section.node("frames") && !grids_of_formula) {
    section.refuse("frames", "is for embedded data that change with time, with 'sampled'; leave it out");
  }
  if (section.node("files")) {
    if (!plan.frame_period_s) section.refuse("files", "is a time series; say the time from frame to frame, 'frame_period_s'");
    if (section.node("frame")) section.refuse("frame", "speaks of one file with several frames; leave it out with 'files'");
  } else if (section.node("file")) {
    if (section.node("frame") && plan.frame_period_s) {
      section.refuse("frame", "takes one frame, and 'frame_period_s' all of them; leave one out");
    }
  } else if (plan.frame_period_s && !grids_of_formula) {
    section.refuse("frame_period_s", "is for a time series, of files or sampled from embedded data; leave it out");
  }
  if (section.node("between_frames") && !plan.frame_period_s && !grids_of_formula) {
    section.refuse("between_frames", "is for a time series; give 'frame_period_s' too, or leave it out");
  }
}

Similarity similarity_of(const detail::PosePart& pose, const toml::table& table, const Section& volume) {
  const auto& [x, y, z, degrees] = pose.rotate_axis_deg;
  const Vec3 axis{x, y, z};
  if (axis == Vec3{}) {
    fail(place_of(*table.get("rotate_axis_deg")),
         "the axis in 'rotate_axis_deg' of " + volume.where() + " is zero; give [x, y, z, degrees]");
  }
  return {rotation_about(axis, degrees), pose.scale, pose.translate_m};
}

void place(const Section& volume, VolumePlan& plan) {
  if (const toml::table* pose = volume.subtable("pose")) plan.placed = similarity_of(plan.pose, *pose, volume);
  const toml::node* node = volume.node("poses");
  if (!node) return;
  if (volume.node("pose")) {
    fail(place_of(*node), "both 'pose' and 'poses' are given in " + volume.where() + "; use one of them");
  }
  const std::string poses = "'poses' of " + volume.where();
  const std::vector<const toml::table*> tables = tables_in(node);
  for (std::size_t i = 0; i < tables.size(); ++i) {
    plan.track.push_back({plan.poses[i].time_s, similarity_of(plan.poses[i].pose, *tables[i], volume)});
  }
  std::size_t wrong = 0;
  if (const char* problem = plan.track.empty() ? nullptr : problem_with(plan.track, &wrong))
    fail(place_of(*tables[wrong]), poses + ": " + problem);
  if (tables.size() < 2) {
    fail(place_of(*node), poses + " has " + (tables.empty() ? "none" : "one") + "; what moves has at least two: use 'pose'");
  }
}

Volume make(const VolumePlan& plan) {
  Volume volume = analytic_volume(plan.analytic)->make();
  if (!plan.sampled) return volume;
  const int longest = *plan.sampled;
  if (!timed(*volume.fields.front().field)) return sampled(volume, longest);
  volume = sampled(volume, longest, plan.frames, plan.between_frames);
  if (!plan.frame_period_s) return volume;
  for (VolumeField& f : volume.fields) {
    f.field = time_series(series_of(*f.field)->frames, *plan.frame_period_s, plan.between_frames);
  }
  return volume;
}

// Result of `act`; its exceptions become SceneErrors at `node` of the volume's table.
template <class Act>
auto at(const toml::node& node, const VolumePlan& plan, Act act) {
  try {
    return act();
  } catch (const MissingData&) {
    throw;
  } catch (const SceneError& error) {
    fail(place_of(node), error.what());
  } catch (const std::invalid_argument& error) {
    fail(place_of(node), "volume " + in_quotes(plan.name) + ": " + error.what());
  } catch (const std::bad_alloc&) {
    fail(place_of(node), "not enough memory for volume " + in_quotes(plan.name) + "; use smaller data");
  }
}

std::string warning_of(const VolumePlan& plan, const std::string& warning) {
  return detail::one_line(place_of(*plan.table) + ": volume " + in_quotes(plan.name) + ": " + warning);
}

// Scans of one patient on two days have positions that look alike and mean different places.
void warn_of_other_space(const VolumePlan& plan, const Volume& volume, const Scene& scene, std::vector<std::string>& warnings) {
  if (plan.table->contains("pose") || plan.table->contains("poses")) return;  // somebody has brought them together
  for (const SceneVolume& earlier : scene.volumes()) {
    const std::string& space = earlier.volume.frame_of_reference;
    if (space.empty() || volume.frame_of_reference.empty() || space == volume.frame_of_reference) continue;
    return warnings.push_back(
        warning_of(plan, "is in another frame of reference than volume " + in_quotes(earlier.name) +
                             ": they lie together only by chance; register one to the other, or give it a pose"));
  }
}

}  // namespace

VolumeLoader::VolumeLoader(const std::filesystem::path& folder, const VolumeReader& read_volume, const SceneOptions& options)
    : folder_(folder), read_volume_(read_volume), options_(options) {}

VolumeLoader::~VolumeLoader() = default;

void VolumeLoader::plan(const Section& scene) {
  const toml::table* volumes = scene.subtable("volume");
  std::vector<std::pair<const toml::key*, const toml::node*>> in_order;
  if (volumes) {
    for (const auto& [key, node] : *volumes) in_order.emplace_back(&key, &node);
  }
  // A table forgets the order of the file; the first volume is the one that a workspace fits.
  std::ranges::stable_sort(in_order,
                           [](const auto& a, const auto& b) { return a.first->source().begin < b.first->source().begin; });

  for (const auto& [key, node] : in_order) {
    const std::string name = check_plain("volume", *key);
    if (!node->is_table())
      fail(place_of(*node), "volume " + in_quotes(name) + " is " + kind_of(*node) + "; it must be a table");
    plans_.push_back(plan_volume(name, *node->as_table()));
    names_.push_back(name);
  }
  if (options_.given) check_given();
}

void VolumeLoader::check_given() const {
  std::vector<std::string> places;
  for (const VolumePlan& plan : plans_) {
    if (plan.analytic.empty() && plan.request.files.empty()) places.push_back(plan.name);
  }
  for (const auto& [name, volume] : *options_.given) {
    if (std::ranges::find(places, name) == places.end())
      fail("volume " + in_quotes(name), "the scene has no table [volume." + name +
                                            "] without 'file' and 'analytic', for the data of a program; " +
                                            suggestion(name, places));
  }
}

VolumePlan VolumeLoader::plan_volume(const std::string& name, const toml::table& table) const {
  VolumePlan plan;
  plan.name = name;
  plan.table = &table;
  const Section section = read(table, "volume " + in_quotes(name), static_cast<detail::VolumePart&>(plan));
  check_request(section, plan.request);
  if (const toml::table* labels = section.subtable("labels")) {
    for (const auto& [key, node] : *labels) {
      const std::string label = check_plain("label", key);
      if (!node.is_integer()) {
        fail(place_of(node), "label " + in_quotes(label) + " is " + kind_of(node) + "; it must be a whole number of the map");
      }
      plan.labels.emplace_back(label, static_cast<double>(node.as_integer()->get()));
    }
  }
  place(section, plan);
  const int sources = !plan.analytic.empty() + (section.node("file") != nullptr) + (section.node("files") != nullptr);
  const bool given = sources == 0 && options_.given;
  if (sources != 1 && !given) {
    fail(place_of(table), "volume " + in_quotes(name) + " has " + (sources == 0 ? "no data" : "two sources") +
                              "; give either 'file' or 'analytic'");
  }
  const bool formula = !plan.analytic.empty();
  for (const Key& key : detail::keys_of<VolumeRequest>()) {
    if (formula && section.node(key.name)) section.refuse(key.name, "speaks of a file; leave it out with 'analytic'");
    if (given && section.node(key.name)) section.refuse(key.name, "speaks of a file, and there is none; leave it out");
  }
  if (plan.sampled && !formula) section.refuse("sampled", "is for embedded data; leave it out with 'file'");
  check_series(section, plan);
  for (const char* key : {"filter", "sign"}) {
    if (formula && !plan.sampled && section.node(key)) {
      section.refuse(key, "speaks of voxels, and a formula has none; give 'sampled', too, or leave it out");
    }
  }
  if (!formula && !given) find_data(section, plan);
  for (const Key& key : detail::keys_of<detail::VolumePart>()) {
    if (const toml::node* node = section.node(key.name)) plan.source += key.name + " = " + text_of(*node) + "\n";
  }
  return plan;
}

void VolumeLoader::find_data(const Section& section, VolumePlan& plan) const {
  std::vector<std::filesystem::path>& files = plan.request.files;
  if (section.node("files")) {
    files = find_files(plan.series, section);
  } else if (section.text("file")) {
    files = {find_file(plan.file, section)};
  } else {
    for (const std::string& file : plan.files) files.push_back(find_file(file, section));
    if (files.empty()) section.refuse("file", "is an empty list; name a file");
  }
}

// Beside the scene, then in each data folder, then in $PALPA_DATA.
std::vector<std::filesystem::path> VolumeLoader::candidates_of(const std::filesystem::path& path) const {
  if (path.is_absolute()) return {path};
  std::vector<std::filesystem::path> candidates{folder_ / path};
  for (const std::filesystem::path& data : options_.data_folders) candidates.push_back(data / path);
  if (const char* data = std::getenv("PALPA_DATA"); data && *data) candidates.push_back(std::filesystem::path(data) / path);
  return candidates;
}

std::filesystem::path VolumeLoader::find_file(const std::string& file, const Section& section) const {
  if (file.empty() || file.find('\0') != std::string::npos) section.refuse("file", "is no path; give the path of a file");
  if (is_web_address(file)) {
    const std::string problem = detail::problem_with_web_address(file);
    if (!problem.empty()) section.refuse("file", problem);
    return file.substr(0, file.find_last_not_of('/') + 1);
  }
  if (options_.files && options_.files->contains(file)) return file;
  const std::filesystem::path path(file);
  std::vector<std::string> looked;
  for (const std::filesystem::path& candidate : candidates_of(path)) {
    std::error_code ignored;
    if (std::filesystem::exists(place_in_file(candidate).file, ignored)) return candidate;
    looked.push_back(candidate.string());
  }
  const std::string hint = path.is_absolute() ? "" : "; name the folder it is in with --data or $PALPA_DATA";
  fail(place_of(*section.node("file")),
       "no file " + in_quotes(file) + " for " + section.where() + "; looked for " + detail::joined(looked) + hint);
}

// The files of a series, in the order of their frames: those whose names match, in the first folder that has any.
std::vector<std::filesystem::path> VolumeLoader::find_files(const std::string& pattern, const Section& section) const {
  const toml::node& node = *section.node("files");
  if (is_web_address(pattern)) section.refuse("files", "is an address, and a series over HTTP is one store; give it by 'file'");
  const std::filesystem::path path(pattern);
  if (pattern.empty() || pattern.find('\0') != std::string::npos || !path.has_filename()) {
    section.refuse("files", "is no pattern of paths; give one like \"phase_*.vti\"");
  }
  std::vector<std::string> looked;
  for (const std::filesystem::path& candidate : candidates_of(path)) {
    const std::vector<std::filesystem::path> found = files_matching(candidate);
    if (found.size() == 1) {
      fail(place_of(node), "only " + in_quotes(found.front().string()) + " matches 'files' in " + section.where() +
                               "; a series has several frames: give one file as 'file'");
    }
    if (found.size() > limit::series_files.count()) section.refuse("files", "matches " + more_than(limit::series_files));
    if (!found.empty()) return found;
    looked.push_back(candidate.string());
  }
  fail(place_of(node), "no files match " + in_quotes(pattern) + " for " + section.where() + "; looked for " +
                           detail::joined(looked) +
                           (path.is_absolute() ? "" : "; name the folder they are in with --data or $PALPA_DATA"));
}

const Volume& VolumeLoader::given(const VolumePlan& plan) const {
  const auto found = options_.given->find(plan.name);
  if (found != options_.given->end()) return found->second;
  throw MissingData(place_of(*plan.table) + ": volume " + in_quotes(plan.name) + " has no data yet; give it a grid");
}

Volume VolumeLoader::data_of(const VolumePlan& plan) const {
  if (!plan.analytic.empty()) return make(plan);
  if (plan.request.files.empty()) return given(plan);
  return plan.frame_period_s ? read_series(plan.request, *plan.frame_period_s, plan.between_frames, read_volume_)
                             : read_volume_(plan.request);
}

std::vector<std::string> VolumeLoader::with_filter() const {
  std::vector<std::string> names;
  for (const VolumePlan& plan : plans_) {
    if (plan.filter) names.push_back(plan.name);
  }
  return names;
}

void VolumeLoader::open(Scene& scene, std::vector<std::string>& warnings) const {
  for (const VolumePlan& plan : plans_) open(plan, scene, warnings);
}

void VolumeLoader::open(const VolumePlan& plan, Scene& scene, std::vector<std::string>& warnings) const {
  Volume volume = at(*plan.table, plan, [&] { return data_of(plan); });
  for (const auto& [label, value] : plan.labels) {
    const toml::node& node = *plan.table->get("labels");
    if (std::ranges::find(volume.fields, label, &VolumeField::name) != volume.fields.end()) {
      fail(place_of(node),
           "volume " + in_quotes(plan.name) + " has a field " + in_quotes(label) + " already; give the label another name");
    }
    volume.fields.push_back(
        {label, "", at(node, plan, [&, v = value] { return label_field(*volume.fields.front().field, v); })});
  }
  if (const toml::node* sign = plan.table->get("sign")) volume = at(*sign, plan, [&] { return signless(volume); });
  if (const toml::node* node = plan.table->get("filter")) {
    volume = at(*node, plan, [&] { return filtered(volume, plan.filter); });
  }
  warn_of_other_space(plan, volume, scene, warnings);
  SceneVolume added{plan.name, std::move(volume), plan.placed, plan.track, plan.smoothing_m.value_or(0.0), plan.source};
  at(*plan.table, plan, [&] { return scene.add(std::move(added), plan.filter); });
  for (const std::string& warning : scene.volumes().back().volume.warnings) warnings.push_back(warning_of(plan, warning));
}

}  // namespace palpa::detail::scene_file
