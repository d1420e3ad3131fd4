#include "palpa/scene/keys.h"

#include <algorithm>
#include <array>
#include <limits>

#include "palpa/scene/wording.h"
#include "palpa/volume/analytic.h"

namespace palpa::detail {

namespace {

constexpr double unbounded = std::numeric_limits<double>::infinity();
/// 512³ samples of float32 are half a gigabyte.
constexpr double most_samples = 512;
constexpr double most_frames = 1000;

constexpr std::array<std::pair<std::string_view, double CouplingOptions::*>, 4> coupling_members{{
    {"stiffness_n_per_m", &CouplingOptions::stiffness_n_per_m},
    {"damping_ns_per_m", &CouplingOptions::damping_ns_per_m},
    {"max_force_n", &CouplingOptions::max_force_n},
    {"impact_ns_per_m", &CouplingOptions::impact_ns_per_m},
}};

Key coupling_key(std::string_view name, std::string_view sentence, Bounds bounds) {
  const CouplingOptions defaults;
  return {.name = std::string(name),
          .kind = KeyKind::number,
          .form = {},
          .fallback = toml_number(defaults.*coupling_member(name)),
          .sentence = std::string(sentence),
          .bounds = bounds};
}

std::string unit_of(std::string_view name) {
  constexpr std::array<std::pair<std::string_view, std::string_view>, 5> suffixes{
      {{"_ns_per_m", "N·s/m"}, {"_n_per_m", "N/m"}, {"_per_m", "unit/m"}, {"_n", "N"}, {"_m", "m"}}};
  for (const auto& [suffix, unit] : suffixes) {
    if (name.ends_with(suffix)) return " [" + std::string(unit) + "]";
  }
  return {};
}

std::vector<std::string> directions() {
  return {"anterior", "posterior", "left", "right", "superior", "inferior", "+x", "-x", "+y", "-y", "+z", "-z"};
}

std::vector<std::string> analytic_names() {
  std::vector<std::string> names;
  for (const auto& volumes : {analytic_volumes(), beating_volumes()}) {
    for (const AnalyticVolume& volume : volumes) names.emplace_back(volume.name);
  }
  return names;
}

/// Turns the parameters of a mode into keys.
class KeyCollector final : public ParameterVisitor {
 public:
  explicit KeyCollector(Keys& keys) : keys_(keys) {}
  void number(const ParameterInfo& info, double& value) override {
    if (info.kind == ParameterKind::level) {
      add(info, KeyKind::number, {}, "required");
    } else {
      add(info, KeyKind::number, {}, toml_number(value)).bounds = bounds(info);
    }
  }
  void optional_number(const ParameterInfo& info, std::optional<double>& value) override {
    add(info, KeyKind::number, {}, value ? toml_number(*value) : "").bounds = bounds(info);
  }
  void flag(const ParameterInfo& info, bool& value) override { add(info, KeyKind::flag, {}, value ? "true" : "false"); }
  void text(const ParameterInfo& info, std::string& value) override {
    add(info, KeyKind::text, {}, value.empty() ? "" : toml_string(value));
  }
  void choice(const ParameterInfo& info, int& value) override {
    Key& key = add(info, KeyKind::text, {}, toml_string(info.choices[static_cast<std::size_t>(value)]));
    key.choices.assign(info.choices.begin(), info.choices.end());
  }
  void field(const ParameterInfo& info, FieldRef&) override {
    add(info, KeyKind::text, "FIELD", info.required() ? "required" : "");
  }
  void vector(const ParameterInfo& info, Vec3& value) override {
    add(info, KeyKind::numbers, "[x, y, z]",
        "[" + toml_number(value.x) + ", " + toml_number(value.y) + ", " + toml_number(value.z) + "]")
        .count = 3;
  }
  void strength(const ParameterInfo& info, Strength& value) override {
    add(info, KeyKind::strength, {}, value.is_constant() ? toml_number(value.constant_n) : "a function").bounds = bounds(info);
  }
  void list(const ParameterInfo& info, ParameterList& list) override {
    Key& key = add(info, KeyKind::tables, {}, "");
    KeyCollector items(key.items);
    list.visit_default(items);
  }

 private:
  static Bounds bounds(const ParameterInfo& info) { return {info.range.low, info.range.high}; }
  Key& add(const ParameterInfo& info, KeyKind kind, std::string form, std::string fallback) {
    keys_.push_back({.name = std::string(info.name),
                     .kind = kind,
                     .form = std::move(form),
                     .fallback = std::move(fallback),
                     .sentence = std::string(info.sentence)});
    return keys_.back();
  }
  Keys& keys_;
};

}  // namespace

std::string sentence_of(const Bounds& bounds) {
  const std::string low = (bounds.above_low ? "above " : "at least ") + toml_number(bounds.low);
  if (bounds.high == unbounded) return low;
  if (bounds.low == bounds.high) return toml_number(bounds.low);
  if (bounds.above_low) return low + " and at most " + toml_number(bounds.high);
  return "between " + toml_number(bounds.low) + " and " + toml_number(bounds.high);
}

const Key* find(const Keys& keys, std::string_view name) noexcept {
  const auto found = std::ranges::find(keys, name, &Key::name);
  return found == keys.end() ? nullptr : &*found;
}

std::vector<std::string> names_of(const Keys& keys) {
  std::vector<std::string> names;
  for (const Key& key : keys) names.push_back(key.name);
  return names;
}

std::string form_of(const Key& key) {
  if (!key.form.empty()) return key.form;
  const std::string bounds = key.bounds ? ", " + sentence_of(*key.bounds) : "";
  switch (key.kind) {
    case KeyKind::number: return "number" + unit_of(key.name) + bounds;
    case KeyKind::whole_number: return "whole number" + bounds;
    case KeyKind::flag: return "true or false";
    case KeyKind::text: {
      if (key.choices.empty()) return "text";
      std::string form;
      for (const std::string& choice : key.choices) form += (form.empty() ? "" : " or ") + toml_string(choice);
      return form;
    }
    case KeyKind::texts: return "list of texts";
    case KeyKind::numbers: return "list of " + std::to_string(key.count) + " numbers";
    case KeyKind::text_or_texts: return "text, or list of texts";
    case KeyKind::text_or_number: return toml_string(key.choices.front()) + ", or number" + unit_of(key.name) + bounds;
    case KeyKind::text_or_position: return "text or [x, y, z]";
    case KeyKind::strength: return "STRENGTH" + unit_of(key.name) + bounds;
    case KeyKind::list: return "list";
    case KeyKind::table: return "table";
    case KeyKind::tables: return "tables";
  }
  return {};
}

const Keys& scene_keys() {
  static const Keys keys{
      {"palpa", KeyKind::whole_number, "1", "required", "format of the scene file", Bounds{1, 1}},
      {"title", KeyKind::text, {}, "", "what the scene is, in one line"},
      {"needs", KeyKind::texts, {}, "", "types of modes that plug-ins must bring"},
      {"coupling", KeyKind::table, "[coupling]", "", "the spring between hand and proxy"},
      {"law", KeyKind::table, "[law]", "", "the rule that finds the balance"},
      {"workspace", KeyKind::table, "[workspace]", "", "how the hand's reach lies in the world"},
      {"time", KeyKind::table, "[time]", "", "how the time goes of data that change with it"},
      {"volume", KeyKind::table, "[volume.NAME]", "", "the data, one table for each volume; NAME is a plain word"},
      {"mode", KeyKind::tables, "[[mode]]", "", "what is felt, one table for each mode; at least one"},
      {"view", KeyKind::table, "[[view.layer]]", "", "how it is drawn; ignored where nothing is drawn"},
  };
  return keys;
}

const Keys& coupling_keys() {
  static const Keys keys{
      coupling_key("stiffness_n_per_m", "stiffness of the spring that pulls the hand to the proxy (k of Eq. 1)",
                   {0, 1e5, true}),
      coupling_key("damping_ns_per_m", "damping of that spring (D of Eq. 1)", {0, 100}),
      coupling_key("max_force_n", "the guard lets out no longer force than this", {0, 100, true}),
      coupling_key("impact_ns_per_m",
                   "pulse of 20 ms as a hard level is hit, by the speed of the impact; added to what the data say; 0: none",
                   {0, 100}),
  };
  return keys;
}

double CouplingOptions::*coupling_member(std::string_view key) noexcept {
  const auto* found = std::ranges::find(coupling_members, key, [](const auto& member) { return member.first; });
  return found == coupling_members.end() ? nullptr : found->second;
}

const Keys& law_keys() {
  static const Keys keys{
      {"method", KeyKind::text, {}, "\"exact\"", "which law finds the balance", {}, law_methods()},
  };
  return keys;
}

const Keys& workspace_keys() {
  static const Keys keys{
      {"fit", KeyKind::text, "volume", "the first volume, unless `scale` is given",
       "the longest side of this volume's box becomes 0.15 m of hand, on every device"},
      {"scale", KeyKind::number, {}, "", "instead of `fit`: world metres per hand metre", Bounds{0, unbounded, true}},
      {"center", KeyKind::text_or_position, "volume or [x, y, z]", "the box of `fit`",
       "what the middle of the hand's reach touches: the middle of a volume's box, or a world position [m]"},
      {"towards_user",
       KeyKind::text,
       "direction",
       "\"anterior\" in a medical frame, else \"+z\"",
       "world direction that faces the user",
       {},
       directions()},
      {"up",
       KeyKind::text,
       "direction",
       "\"superior\" in a medical frame, else \"+y\"",
       "world direction that is up",
       {},
       directions()},
  };
  return keys;
}

const Keys& time_keys() {
  static const Keys keys{
      {"play",
       KeyKind::text,
       {},
       "\"hold\"",
       "the data stay at `start_s`, go on to their end, or begin again, each volume after its own length",
       {},
       {"hold", "once", "loop"}},
      {"speed", KeyKind::number, {}, "1", "seconds of data per second", Bounds{0, 1000, true}},
      {"start_s", KeyKind::number, {}, "0", "the moment of the data that is felt first [s]", Bounds{0, 1e9}},
  };
  return keys;
}

const Keys& file_keys() {
  static const Keys keys{
      {"length_unit",
       KeyKind::text,
       {},
       "the file's; else mm for medical formats, m for others",
       "unit of length of a file that says none",
       {},
       {"m", "cm", "mm", "um", "nm", "km", "angstrom"}},
      {"fields", KeyKind::table, "{NAME = {array = text, arrays = [x, y, z], unit = text}}", "all, under the file's names",
       "which arrays of the file are fields, and what they are called"},
      {"frame", KeyKind::whole_number, {}, "", "which frame of a file that holds several, counted from 0", Bounds{0, 1e6}},
      {"as", KeyKind::text, {}, "", "takes a file of three frames as one vector field", {}, {"vector"}},
      {"series", KeyKind::text, "UID", "the largest",
       "which series of a DICOM folder that holds several; `palpa info` lists them"},
      {"components_along",
       KeyKind::text,
       {},
       "\"file\"",
       "the axes that the components of vectors are along: those of the file's space, or those of its grid (FSL's directions)",
       {},
       {"file", "index"}},
      {"time",
       KeyKind::text_or_number,
       "\"latest\", or number [s]",
       "\"latest\"",
       "which moment of a case that holds several",
       Bounds{0, unbounded},
       {"latest"}},
      {"crop_m",
       KeyKind::numbers,
       "[x, y, z, x, y, z]",
       "all of it",
       "low and high corner, in the file's frame, of the part in which a curvilinear or unstructured grid is resampled",
       {},
       {},
       6},
      {"type",
       KeyKind::text,
       {},
       "",
       "of a file of bare numbers: what they are; `dims` says how many",
       {},
       {"int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64", "float32", "float64"}},
      {"byte_order", KeyKind::text, {}, "\"little\"", "of bare numbers", {}, {"little", "big"}},
      {"header_bytes", KeyKind::whole_number, {}, "0", "before the first of bare numbers", Bounds{0, 1e15}},
      {"dims",
       KeyKind::numbers,
       "[x, y, z]",
       "",
       "voxels along each axis, of bare numbers; of an array in HDF5 to be checked",
       {},
       {},
       3},
      {"axes",
       KeyKind::text,
       {},
       "\"zyx\"",
       "the axes that the indices of an array are along, slowest first",
       {},
       {"xyz", "xzy", "yxz", "yzx", "zxy", "zyx"}},
      {"components",
       KeyKind::text,
       {},
       "last, if it is of 3; of bare numbers none",
       "which index of an array is that of vector components",
       {},
       {"first", "last"}},
      {"spacing_m", KeyKind::numbers, "[x, y, z]", "1, 1, 1", "distances of an array's voxels along each axis", {}, {}, 3},
      {"origin_m", KeyKind::numbers, "[x, y, z]", "0, 0, 0", "where the first voxel of an array lies", {}, {}, 3},
  };
  return keys;
}

const Keys& volume_keys() {
  static const Keys keys = [] {
    Keys all{
        {"file", KeyKind::text_or_texts, "path, or [path, …]", "",
         "the file, several that belong together (PLOT3D), the folder of a case (OpenFOAM), or an array in a file "
         "(\"flow.h5:/velocity\"); a relative path is looked for beside the scene, then in each --data folder, "
         "then in $PALPA_DATA"},
        {"files", KeyKind::text, "pattern of paths", "",
         "instead of `file`: a time series, one file for each frame; `*` and `?` in the name stand for any characters, and "
         "numbers in it sort by value"},
        {"frame_period_s", KeyKind::number, "number [s], above 0", "that of `analytic`",
         "time from frame to frame of a series; with `file`, all the frames that it holds are one", Bounds{0, 1e9, true}},
        {"between_frames",
         KeyKind::text,
         {},
         "\"linear\"",
         "what lies between two frames: their blend, or the nearer one",
         {},
         {"linear", "nearest"}},
        {"analytic", KeyKind::text, {}, "", "instead of `file`: embedded data", {}, analytic_names()},
        {"sampled",
         KeyKind::whole_number,
         {},
         "",
         "with `analytic`: as a grid with this many samples along its longest side, "
         "instead of a formula",
         Bounds{2, most_samples}},
        {"frames",
         KeyKind::whole_number,
         {},
         "20",
         "with `sampled`, of embedded data that change with time: in how many moments of their cycle they are sampled",
         Bounds{1, most_frames}},
        {"pose", KeyKind::table, "{translate_m, rotate_axis_deg, scale}", "where the file puts it",
         "moves the volume in the world"},
        {"poses", KeyKind::tables, "[{time_s, translate_m, rotate_axis_deg, scale}, …]", "",
         "instead of `pose`: where the volume is at some moments; it moves steadily from one to the next"},
        {"filter",
         KeyKind::text,
         {},
         "smooth for whole numbers and rough scalars, cubic for smooth ones, trilinear for vectors",
         "what lies between the voxels: straight lines, a cubic spline that smooths (whole numbers lose their steps), or "
         "one that meets the voxels (not of whole numbers)",
         {},
         {"trilinear", "smooth", "cubic"}},
        {"sign",
         KeyKind::text,
         {},
         "",
         "the vectors are axes, whose sign means nothing, as the main direction of diffusion",
         {},
         {"none"}},
        {"labels", KeyKind::table, "{NAME = whole number}", "",
         "of a label map: more fields, each 1 where the voxels are this number and 0 elsewhere; its level 0.5 is a surface"},
        {"smoothing_m",
         KeyKind::number,
         {},
         "two sample spacings",
         "how far what vortex modes, gradient_force, q, lambda2 and coherence feel is smoothed first: standard deviation, in "
         "the world",
         Bounds{0, unbounded, true}},
    };
    all.insert(all.end(), file_keys().begin(), file_keys().end());
    return all;
  }();
  return keys;
}

const Keys& volume_field_keys() {
  static const Keys keys{
      {"array", KeyKind::text, {}, "NAME", "what the file calls the array"},
      {"arrays", KeyKind::texts, "[x, y, z]", "", "three scalar arrays of the file that are the components of one vector"},
      {"unit", KeyKind::text, {}, "the file's", "label of its unit; converts nothing"},
  };
  return keys;
}

const Keys& pose_keys() {
  static const Keys keys{
      {"translate_m",
       KeyKind::numbers,
       "[x, y, z]",
       "[0, 0, 0]",
       "where the volume's origin goes [m], after turn and scale",
       {},
       {},
       3},
      {"rotate_axis_deg",
       KeyKind::numbers,
       "[x, y, z, degrees]",
       "no turn",
       "axis, and right-handed angle about it",
       {},
       {},
       4},
      {"scale", KeyKind::number, {}, "1", "how much larger the volume becomes", Bounds{0, unbounded, true}},
  };
  return keys;
}

const Keys& poses_keys() {
  static const Keys keys = [] {
    Keys all{
        {"time_s", KeyKind::number, {}, "required", "moment of the data; the first is at 0, and they rise", Bounds{0, 1e9}}};
    all.insert(all.end(), pose_keys().begin(), pose_keys().end());
    return all;
  }();
  return keys;
}

const Keys& mode_keys() {
  static const Keys keys{
      {"name", KeyKind::text, "plain word", "required", "what the mode is called in events, tables and --set; unique"},
      {"type", KeyKind::text, "type of mode", "required", "one of those that `palpa modes` lists"},
      {"enabled", KeyKind::flag, {}, "true", "false: stays silent"},
      {"mask", KeyKind::tables, "[{of, points, outside}, …]", "",
       "factors between 0 and 1 on all strengths and drags of the mode, as functions of a field's value"},
  };
  return keys;
}

const Keys& function_keys() {
  static const Keys keys{
      {"of", KeyKind::text, "FIELD", "required", "scalar field whose value is looked up"},
      {"points", KeyKind::list, "[[value, result], …]", "required",
       "piecewise linear; values do not fall, two equal ones make a step"},
      {"outside", KeyKind::number, "number", "0", "result below the first and above the last value"},
  };
  return keys;
}

const Keys& view_keys() {
  static const Keys keys{{"layer", KeyKind::tables, "[[view.layer]]", "", "what is drawn"},
                         {"from",
                          KeyKind::numbers,
                          "[x, y, z]",
                          "chosen for what was felt",
                          "direction of the world from which pictures look",
                          {},
                          {},
                          3}};
  return keys;
}

const Keys& view_layer_keys() {
  static const Keys keys{
      {"show", KeyKind::text, {}, "required", "how it is drawn", {}, {"surface", "slices", "volume", "streamlines", "glyphs"}},
      {"field", KeyKind::text, "FIELD", "required", "what is drawn"},
      {"level", KeyKind::number, {}, "", "of a surface: the value it is drawn at"},
      {"name", KeyKind::text, {}, "the level's or the field's", "what the legend calls it"},
      {"parts",
       KeyKind::text,
       {},
       "\"large\"",
       "of a surface that is in several parts: those that are not small beside the largest, or all",
       {},
       {"large", "all"}},
      {"colors", KeyKind::table, "{points = [[value, \"#rrggbb\", opacity], …]}", "", "colour and opacity by value"},
  };
  return keys;
}

const Keys& view_colors_keys() {
  static const Keys keys{{"points", KeyKind::list, "[[value, \"#rrggbb\", opacity], …]", "required", "piecewise linear"}};
  return keys;
}

Keys parameter_keys(const Mode& mode) {
  Keys keys;
  KeyCollector collector(keys);
  Mode example = mode;
  example.visit(collector);
  return keys;
}

}  // namespace palpa::detail
