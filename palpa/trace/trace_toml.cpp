#include "palpa/trace/trace_toml.h"

#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <utility>

#include "palpa/base/input_file.h"
#include "palpa/base/limits.h"
#include "palpa/base/toml_problem.h"
#include "palpa/base/wording.h"
#include "palpa/data/volume.h"
#include "palpa/trace/csv.h"

namespace palpa::detail {

namespace {

// File names may have bytes of invalid UTF-8.
std::string toml_text(std::string_view text) { return toml_string(text, "?"); }

// TOML number, with the point or exponent that makes it a float.
std::string number(double value) {
  std::string out;
  put_number(out, value);
  if (std::isfinite(value) && out.find_first_of(".e") == std::string::npos) out += ".0";
  return out;
}

std::string list(const std::vector<std::string>& values) {
  std::string out = "[";
  for (std::size_t i = 0; i < values.size(); ++i) out += (i ? ", " : "") + values[i];
  return out + "]";
}

std::string quoted_list(const std::vector<std::string>& texts) {
  std::vector<std::string> values;
  for (const std::string& text : texts) values.push_back(toml_text(text));
  return list(values);
}

std::vector<std::string> texts_of(const toml::node_view<const toml::node>& node) {
  std::vector<std::string> texts;
  if (const toml::array* values = node.as_array()) {
    for (const toml::node& value : *values) texts.push_back(value.value_or(std::string()));
  }
  return texts;
}

/// Integer in the range of `Whole`; else `otherwise`. Not value_or: it casts a float of any size to an integer.
template <typename Whole>
Whole whole_or(const toml::node_view<const toml::node>& node, Whole otherwise) {
  const auto* const integer = node.as_integer();
  return integer && std::in_range<Whole>(integer->get()) ? static_cast<Whole>(integer->get()) : otherwise;
}

// Similarity of a 4×4 matrix; rotation and scale to rounding.
Similarity similarity_of(const toml::node_view<const toml::node>& node) {
  Similarity map;
  double m[3][4];
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 4; ++j) m[i][j] = node[i][j].value_or(i == j ? 1.0 : 0.0);
    map.rotation.row[i] = {m[i][0], m[i][1], m[i][2]};
  }
  map.translation_m = {m[0][3], m[1][3], m[2][3]};
  // Normalised to about 1: the cube of a scale may overflow.
  double largest = 0.0;
  for (const Vec3& row : map.rotation.row) largest = std::max(largest, largest_component(row));
  for (Vec3& row : map.rotation.row) row = row / largest;
  const double scale = std::cbrt(determinant(map.rotation));
  for (Vec3& row : map.rotation.row) row = row / scale;
  map.scale = scale * largest;
  return map;
}

}  // namespace

std::string header_to_toml(const TraceHeader& header) {
  std::vector<std::string> sets;
  for (const auto& [path, value] : header.sets) sets.push_back(path + "=" + value);
  std::vector<std::string> seeds;
  for (const std::uint64_t seed : header.seeds) seeds.push_back(std::to_string(seed));

  std::string out;
  const auto put = [&](const char* key, const std::string& value) { out += std::string(key) + " = " + value + "\n"; };
  put("complete", header.complete ? "true" : "false");
  put("format", std::to_string(header.format));
  put("palpa_version", toml_text(header.palpa_version));
  put("arguments", quoted_list(header.arguments));
  if (!header.hand.empty()) put("hand", toml_text(header.hand));
  put("sets", quoted_list(sets));
  put("plugins", quoted_list(header.plugins));
  put("primitives", header.primitives ? "true" : "false");
  put("dt_s", number(header.dt_s));
  put("seeds", list(seeds));
  put("notes", quoted_list(header.notes));
  const Similarity& map = header.hand_to_world;
  const Mat3 turn = map.scale * map.rotation;
  const double shift[] = {map.translation_m.x, map.translation_m.y, map.translation_m.z};
  out += "hand_to_world = [\n";
  for (int i = 0; i < 3; ++i) {
    out += "  " + list({number(turn.row[i].x), number(turn.row[i].y), number(turn.row[i].z), number(shift[i])}) + ",\n";
  }
  out += "  [0.0, 0.0, 0.0, 1.0],\n]\n\n[device]\n";
  put("name", toml_text(header.device_name));
  put("max_force_n", number(header.device_max_force_n));
  put("max_stiffness_n_per_m", number(header.device_max_stiffness_n_per_m));
  put("workspace_radius_m", number(header.device_workspace_radius_m));
  put("encoder_step_m", number(header.device_encoder_step_m));
  if (header.has_tool) {
    put("max_torque_nm", number(header.device_max_torque_nm));
    put("max_turn_damping_nms_per_rad", number(header.device_max_turn_damping_nms_per_rad));
  }
  if (header.motors) {
    put("motors", "true");
    put("continuous_force_n", number(header.device_continuous_force_n));
    put("max_damping_ns_per_m", number(header.device_max_damping_ns_per_m));
    put("damping_ns_per_m", number(header.device_damping_ns_per_m));
    put("dead_man_buttons", std::to_string(header.dead_man_buttons));
  }
  for (const SourceFile& file : header.data_files) {
    out += "\n[[data_file]]\n";
    put("path", toml_text(file.path));
    put("bytes", std::to_string(file.bytes));
    put("sha256", toml_text(file.sha256.is_known() ? file.sha256.text() : std::string()));
  }
  return out;
}

namespace {

/// The table of a trace's header file. Throws LoadError.
toml::table parse_header(const std::filesystem::path& folder, const std::filesystem::path& file) {
  const InputFile opened(file);
  if (opened.why_not() == NoInput::missing) {
    throw LoadError(folder.string() + ": is no trace (it holds no trace.toml); name a folder that `palpa run --out` made");
  }
  const std::string text = read_whole(opened, limit::trace_toml_bytes, limit::trace_toml_bytes.remedy);
  if (const auto problem = problem_with_toml(text)) {
    throw LoadError(file.string() + ":" + std::to_string(problem->line) + ":" + std::to_string(problem->column) + ": " +
                    problem->sentence);
  }
  try {
    return toml::parse(std::string_view(text), file.string());
  } catch (const toml::parse_error& error) {
    const toml::source_position at = error.source().begin;
    throw LoadError(file.string() + ":" + std::to_string(at.line) + ":" + std::to_string(at.column) + ": " +
                    one_line(error.description()) + "; a trace.toml is written by palpa and not edited");
  }
}

void read_device(const toml::node_view<const toml::node>& device, TraceHeader& header) {
  const TraceHeader usual;
  header.device_name = device["name"].value_or(std::string());
  header.device_max_force_n = device["max_force_n"].value_or(usual.device_max_force_n);
  header.device_max_stiffness_n_per_m = device["max_stiffness_n_per_m"].value_or(usual.device_max_stiffness_n_per_m);
  header.device_workspace_radius_m = device["workspace_radius_m"].value_or(usual.device_workspace_radius_m);
  header.device_encoder_step_m = device["encoder_step_m"].value_or(usual.device_encoder_step_m);
  header.motors = device["motors"].value_or(false);
  header.device_continuous_force_n = device["continuous_force_n"].value_or(usual.device_continuous_force_n);
  header.device_max_damping_ns_per_m = device["max_damping_ns_per_m"].value_or(usual.device_max_damping_ns_per_m);
  header.device_damping_ns_per_m = device["damping_ns_per_m"].value_or(0.0);
  header.device_max_torque_nm = device["max_torque_nm"].value_or(0.0);
  header.device_max_turn_damping_nms_per_rad =
      device["max_turn_damping_nms_per_rad"].value_or(usual.device_max_turn_damping_nms_per_rad);
  header.dead_man_buttons = whole_or(device["dead_man_buttons"], std::uint32_t{0});
}

}  // namespace

TraceHeader read_header(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "trace.toml";
  const toml::table parsed = parse_header(folder, file);
  const toml::node& whole = parsed;
  const toml::node_view<const toml::node> root{whole};
  TraceHeader header;
  header.complete = root["complete"].value_or(false);
  header.format = whole_or(root["format"], 0);
  if (header.format != 1) {
    throw LoadError(file.string() + ": has format " + std::to_string(header.format) + "; this palpa reads format 1");
  }
  header.palpa_version = root["palpa_version"].value_or(std::string());
  header.arguments = texts_of(root["arguments"]);
  header.hand = root["hand"].value_or(std::string());
  for (const std::string& set : texts_of(root["sets"])) {
    const std::size_t equals = set.find('=');
    if (equals == std::string::npos)
      throw LoadError(file.string() + ": set " + in_quotes(set) + " has no '='; a set is PATH=VALUE");
    header.sets.emplace_back(set.substr(0, equals), set.substr(equals + 1));
  }
  header.plugins = texts_of(root["plugins"]);
  header.notes = texts_of(root["notes"]);
  header.primitives = root["primitives"].value_or(false);
  header.dt_s = root["dt_s"].value_or(0.0);
  if (!(header.dt_s > 0.0 && header.dt_s <= 1.0)) {
    throw LoadError(file.string() + ": dt_s is missing or not usable; it lies above 0 and is at most 1");
  }
  header.hand_to_world = similarity_of(root["hand_to_world"]);
  if (!is_usable(header.hand_to_world)) {
    throw LoadError(file.string() +
                    ": hand_to_world is no rotation, move and scale; a trace.toml is written by palpa and not edited");
  }
  read_device(root["device"], header);
  if (const toml::array* seeds = root["seeds"].as_array()) {
    for (const toml::node& seed : *seeds)
      header.seeds.push_back(static_cast<std::uint64_t>(whole_or(toml::node_view{seed}, std::int64_t{0})));
  }
  if (const toml::array* files = root["data_file"].as_array()) {
    for (const toml::node& entry : *files) {
      const toml::node_view<const toml::node> data{entry};
      header.data_files.push_back({.path = data["path"].value_or(std::string()),
                                   .bytes = static_cast<std::uint64_t>(whole_or(data["bytes"], std::int64_t{0})),
                                   .sha256 = data["sha256"].value_or(std::string())});
    }
  }
  return header;
}

}  // namespace palpa::detail
