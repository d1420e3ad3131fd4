#include "palpa/scene/scene_checks.h"

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "palpa/base/limits.h"
#include "palpa/base/wording.h"
#include "palpa/baseline/law.h"
#include "palpa/data/derived_fields.h"
#include "palpa/data/filter.h"
#include "palpa/data/thin_parts.h"
#include "palpa/scene/field_lookup.h"
#include "palpa/scene/keys.h"

namespace palpa::detail {

namespace {

std::string call_item(const std::string& list, std::size_t item, const std::string& name) {
  return list + " " + (name.empty() ? std::to_string(item + 1) : in_quotes(name));
}

/// Base of parameter checks of a mode or another part, lists included; tracks the part.
class CheckingVisitor : public ParameterVisitor {
 public:
  CheckingVisitor(const SceneMode& mode, std::size_t number, std::vector<Finding>& out) : out_(out), where_(called(mode)) {
    part_.section = "mode";
    part_.mode = number;
  }
  CheckingVisitor(const std::string& section, std::vector<Finding>& out) : out_(out) { part_.section = section; }
  void list(const ParameterInfo& info, ParameterList& list) override {
    const std::string outer = where_;
    part_.list = info.name;
    for (part_.item = 0; part_.item < list.size(); ++part_.item) {
      ItemName name;
      list.visit(part_.item, name);
      where_ = call_item(part_.list, part_.item, name.value) + " of " + outer;
      list.visit(part_.item, *this);
    }
    where_ = outer;
    part_.list.clear();
    part_.item = 0;
  }

 protected:
  void find(std::string_view key, std::string text) {
    Part part = part_;
    part.key = key;
    out_.push_back({std::move(part), std::move(text)});
  }
  std::string the(std::string_view key) const { return in_quotes(key) + (where_.empty() ? "" : " in " + where_); }
  const Part& part() const noexcept { return part_; }

 private:
  struct ItemName : ParameterVisitor {
    void text(const ParameterInfo& info, std::string& text) override {
      if (info.name == "name") value = text;
    }
    std::string value;
  };
  std::vector<Finding>& out_;
  Part part_;
  std::string where_;
};

class ParameterChecks final : public CheckingVisitor {
 public:
  using CheckingVisitor::CheckingVisitor;
  void number(const ParameterInfo& info, double& value) override {
    if (info.kind == ParameterKind::level) {
      if (!std::isfinite(value)) find(info.name, the(info.name) + " is not finite; a level is a value of the field");
    } else {
      in_range(info.name, info.range, value);
    }
  }
  void optional_number(const ParameterInfo& info, std::optional<double>& value) override {
    if (value) in_range(info.name, info.range, *value);
  }
  void numbers(const ParameterInfo& info, std::vector<double>& value) override {
    if (std::ranges::all_of(value, [](double number) { return std::isfinite(number); })) return;
    find(info.name, the(info.name) + " is not finite; give " + std::string(info.form));
  }
  void vectors(const ParameterInfo& info, std::vector<Vec3>& value) override {
    if (value.size() > limit::tool_feet.count()) return find(info.name, the(info.name) + " has " + more_than(limit::tool_feet));
    if (std::ranges::all_of(value, [](const Vec3& v) { return is_finite(v); })) return;
    find(info.name, the(info.name) + " is not finite; give [[x, y, z], …]");
  }
  void strength(const ParameterInfo& info, Strength& strength) override {
    if (strength.is_constant()) return in_range(info.name, info.range, strength.constant_n);
    function(info.name, info.range, strength.curve);
  }
  void text(const ParameterInfo& info, std::string& value) override {
    const std::string& list = part().list;
    if (info.name != "name" || value.empty() || list.empty()) return;
    if (const std::string problem = problem_with_name(list, value); !problem.empty()) find(info.name, problem);
    if (!names_.emplace(list, value).second) {
      find(info.name, name_is_taken(list, value));
    }
  }
  void function(std::string_view key, Range range, const TransferFunction& function) {
    if (function.points().empty()) return find(key, the(key) + " is a function without points; give at least one");
    for (const TransferFunction::Point& point : function.points()) in_range(key, range, point.result);
    in_range(key, range, function.outside());
  }

 private:
  void in_range(std::string_view key, Range range, double value) {
    const bool fits = range.contains(value) && std::isfinite(value);
    if (!fits) find(key, the(key) + " is " + toml_number(value) + "; it must be " + sentence_of(range));
  }
  std::set<std::pair<std::string, std::string>> names_;
};

class SceneChecks : public CheckingVisitor {
 public:
  SceneChecks(const Scene& scene, const SceneMode& mode, std::size_t number, std::vector<Finding>& out)
      : CheckingVisitor(mode, number, out), scene_(scene) {}

 protected:
  const Scene& scene_;
};

class FieldChecks final : public SceneChecks {
 public:
  using SceneChecks::SceneChecks;
  void field(const ParameterInfo& info, FieldRef& ref) override {
    if (info.kind == ParameterKind::optional_field && ref.name.empty()) return;
    const int components = info.kind == ParameterKind::scalar_field ? 1 : info.kind == ParameterKind::vector_field ? 3 : 0;
    resolve(info.name, ref, components);
  }
  void strength(const ParameterInfo& info, Strength& strength) override {
    if (!strength.is_constant()) resolve(info.name, strength.of, 1);
  }
  void resolve(std::string_view key, const FieldRef& ref, int components) {
    if (ref.name.empty()) return find(key, the(key) + " names no field; " + suggestion("", field_names(scene_.volumes())));
    const FoundField found = find_field(scene_.volumes(), ref.name);
    if (!found.field) return find(key, found.problem);
    const int has = found.components;
    if (components != 0 && has != components) {
      find(key,
           the(key) + " must be a " + kind(components) + " field; " + in_quotes(ref.name) + " is a " + kind(has) + " field");
    }
  }

 private:
  static std::string kind(int components) { return components == 1 ? "scalar" : "vector"; }
};

/// Compares the levels of a mode with the values of its parameter `field`.
class LevelChecks final : public SceneChecks {
 public:
  using SceneChecks::SceneChecks;
  void field(const ParameterInfo& info, FieldRef& ref) override {
    if (info.name == "field") ref_ = ref;
  }
  void number(const ParameterInfo& info, double& value) override {
    if (info.kind != ParameterKind::level || ref_.name.empty()) return;
    if (!extent_) extent_ = scene_.field(ref_).field->value_ranges().front();
    if (value >= extent_->min && value <= extent_->max) return;
    find(info.name, the(info.name) + " is " + toml_number(value) + ", outside the data of " + in_quotes(ref_.name) +
                        " and never met; they go from " + toml_number(extent_->min) + " to " + toml_number(extent_->max));
  }

 private:
  FieldRef ref_;
  std::optional<ValueRange> extent_;
};

/// Finds a texture of a field that has none.
class TextureChecks final : public SceneChecks {
 public:
  using SceneChecks::SceneChecks;
  void companion(FieldRef& of, Derivation felt) override {
    if (felt != Derivation::detail || of.name.empty() || has_detail(*scene_.field(of).field)) return;
    find("texture_ratio",
         the("texture_ratio") + " is not felt: nothing of " + in_quotes(of.name) +
             " is finer than its filter; of a scalar volume from voxels filter = \"smooth\" leaves such detail");
  }
};

/// Finds levels of a mode at which the smoothing filter loses much of the thin parts.
class ThinPartChecks final : public SceneChecks {
 public:
  ThinPartChecks(const Scene& scene, const SceneMode& mode, std::size_t number, const std::vector<std::string>& chose,
                 bool is_chosen, std::vector<Finding>& out)
      : SceneChecks(scene, mode, number, out), chose_(chose), is_chosen_(is_chosen) {}
  void field(const ParameterInfo& info, FieldRef& ref) override {
    if (info.name != "field" || ref.name.empty()) return;
    const bool is_chosen = std::ranges::find(chose_, parse_field_name(ref.name).volume()) != chose_.end();
    if (is_chosen != is_chosen_) return;
    const FieldPtr field = scene_.field(ref).field;
    const GridView* grid = grid_below(*field);
    if (grid && grid->filter == Filter::smooth && grid->voxels.components == 1) field_ = field;
  }
  void choice(const ParameterInfo& info, int& value) override {
    if (info.name == "solid") solid_ = info.choices[static_cast<std::size_t>(value)];
  }
  void number(const ParameterInfo& info, double& value) override {
    if (info.kind != ParameterKind::level || !field_) return;
    // [1] Shares lost, of thin parts and of the whole, from which a finding is reported. More: losses stay unknown; less: noise
    // is reported. Of what is thin for the most part, as a shell is, the share of the whole counts alone: each is a hole in a
    // wall.
    constexpr double much = 0.1, much_of_all = 0.01, mostly = 0.5;
    ThinParts worst;
    for (const auto& [side, left_out] : {std::pair{SolidSide::high, "low"}, std::pair{SolidSide::low, "high"}}) {
      if (solid_ == left_out) continue;
      const ThinParts parts = thin_parts(*field_, value, side);
      if (parts.lost_share() > worst.lost_share()) worst = parts;
    }
    const bool is_much = worst.lost_share() > much || worst.thin_share() > mostly;
    if (!is_much || !(worst.thin_share() * worst.lost_share() > much_of_all)) return;
    const auto percent = [](double share) { return toml_number(std::round(1000.0 * share) / 10.0) + " %"; };
    find(info.name, the(info.name) + ": the smooth filter loses " + toml_number(std::round(100.0 * worst.lost_share())) +
                        " % of the parts thinner than 2 voxels there, " + percent(worst.thin_share() * worst.lost_share()) +
                        " of the whole; filter = \"trilinear\" of the volume keeps them");
  }

 private:
  const std::vector<std::string>& chose_;
  bool is_chosen_;
  FieldPtr field_;
  std::string_view solid_ = "high";
};

template <class Part>
std::vector<Finding> part_findings(const std::string& section, Part& part) {
  std::vector<Finding> found;
  ParameterChecks checks(section, found);
  visit_parameters(part, checks);
  return found;
}

/// Length [m] of the longest side of the box about the feet, in the axes of the handle.
double size_m(const Tool& tool) {
  Vec3 low = tool.lever_m({}, 0), high = low;
  for (std::size_t foot = 1; foot < tool.feet(); ++foot) {
    const Vec3 lever = tool.lever_m({}, foot);
    low = {std::min(low.x, lever.x), std::min(low.y, lever.y), std::min(low.z, lever.z)};
    high = {std::max(high.x, lever.x), std::max(high.y, lever.y), std::max(high.z, lever.z)};
  }
  return largest_component(high - low);
}

/// Faults of a tool. \param at  its table; each finding gets its key. \param where  "[tool]"
std::vector<Finding> tool_findings(ToolOptions tool, const Part& at, const std::string& where) {
  const ToolOptions given = tool;
  std::vector<Finding> found = part_findings("tool", tool);
  const char* const problem = problem_with(given);
  if (found.empty() && problem) {
    // Each problem begins with its key.
    const std::string text = problem, key = text.substr(0, text.find(' '));
    found.push_back({{.section = {}, .list = {}, .key = key},
                     in_quotes(key) + " in " + where + " does not fit a tool of the shape " + in_quotes(name_of(given.shape)) +
                         "; " + text});
  }
  for (Finding& finding : found) {
    const std::string key = std::exchange(finding.part, at).key;
    finding.part.key = key;
  }
  return found;
}

/// \param at  table of the scene's tool
void warn_of_tool(const Scene& scene, const Part& at, std::vector<Finding>& found) {
  const Tool tool(scene.tool(), scene.coupling());
  if (tool.is_point()) return;
  const auto of_tool = [&](const char* key, std::string text) {
    Part part = at;
    part.key = key;
    found.push_back({std::move(part), std::move(text)});
  };
  // The least stiffness against turning at which no press along the longest lever has two balances (docs/theory.md 10.7).
  const double radius_m = tool.turning_radius_m(), reach_m = tool.reach_m();
  const double least_m = std::sqrt(2.0 * scene.coupling().max_force_n * reach_m / scene.coupling().stiffness_n_per_m);
  constexpr double rounding = 1e-9;
  if (radius_m < (1.0 - rounding) * least_m) {
    of_tool("turning_radius_m", "'turning_radius_m' is " + toml_number(radius_m) +
                                    ": the tool can tip over when it is pressed; from " +
                                    toml_number(std::ceil(1e4 * least_m) / 1e4) + " on it cannot");
  }
  double data_m = 0.0;
  for (const SceneVolume& volume : scene.volumes())
    data_m = std::max(data_m, largest_component(volume.volume.bounds_m().size_m()));
  const double long_m = scene.hand_to_world().scale * size_m(tool);
  if (data_m > 0.0 && long_m > data_m) {
    of_tool("", "the tool is longer than the data: " + toml_number(long_m) + " m against " + toml_number(data_m) +
                    " m of the world; a tool is in metres of the hand");
  }
}

}  // namespace

void refuse_first(const std::vector<Finding>& found) {
  if (!found.empty()) throw SceneProblem(found.front());
}

std::vector<Finding> range_findings(CouplingOptions coupling) { return part_findings("coupling", coupling); }
std::vector<Finding> range_findings(Workspace workspace) { return part_findings("workspace", workspace); }
std::vector<Finding> range_findings(TimeOptions time) { return part_findings("time", time); }
std::vector<Finding> range_findings(ToolOptions tool) {
  return tool_findings(std::move(tool), {.section = "tool", .list = {}, .key = {}}, "[tool]");
}

std::vector<Finding> hand_findings(const Scene& scene, const SceneHand& hand, std::size_t number) {
  const Part table{.section = "hand", .mode = number, .list = {}, .key = {}};
  const auto of_key = [&](const char* key, std::string text) {
    Part part = table;
    part.key = key;
    return std::vector<Finding>{{std::move(part), std::move(text)}};
  };
  if (std::string problem = problem_with_name("hand", hand.name); !problem.empty()) return of_key("name", std::move(problem));
  if (std::ranges::find(scene.hands(), hand.name, &SceneHand::name) != scene.hands().end())
    return of_key("name", name_is_taken("hand", hand.name));
  constexpr double most_m = 1.0;  // as of a tool. More: out of any person's reach; less: wide workspaces are refused
  if (!(is_finite(hand.at_m) &&
        largest_component({std::abs(hand.at_m.x), std::abs(hand.at_m.y), std::abs(hand.at_m.z)}) <= most_m))
    return of_key("at_m", "'at_m' in " + called(hand) + " is not within 1 m; it is in metres of the hand");
  Part tool = table;
  tool.list = "tool";
  return tool_findings(hand.tool, tool, "'tool' of " + called(hand));
}

std::vector<Finding> law_findings(const std::string& name) {
  const std::vector<std::string> laws(baseline::law_names.begin(), baseline::law_names.end());
  if (std::ranges::find(laws, name) != laws.end()) return {};
  return {{{.section = "law", .list = {}, .key = "method"}, "no law " + in_quotes(name) + "; " + suggestion(name, laws)}};
}

std::string called(const SceneMode& mode) { return "mode " + in_quotes(mode.name); }
std::string called(const SceneHand& hand) { return "hand " + in_quotes(hand.name); }
std::vector<std::string> names_of(const std::vector<SceneHand>& hands) {
  std::vector<std::string> names;
  for (const SceneHand& hand : hands) names.push_back(hand.name);
  return names;
}

std::string problem_with_volume_of(const std::string& field, const std::vector<std::string>& volumes) {
  const FieldName name = parse_field_name(field);
  if (!name.problem.empty()) return name.problem;
  const std::string volume = name.volume();
  if (std::ranges::find(volumes, volume) != volumes.end()) return {};
  return "no volume " + in_quotes(volume) + "; " + suggestion(volume, volumes);
}

std::vector<Finding> parameter_findings(const SceneMode& scene_mode, std::size_t number) {
  std::vector<Finding> found;
  ParameterChecks checks(scene_mode, number, found);
  look_through(scene_mode.mode, checks);
  for (const Mask& mask : scene_mode.masks) checks.function("mask", {0, 1}, mask.curve);
  if (const std::string name = problem_with_name("mode", scene_mode.name); !name.empty()) {
    found.push_back({{.section = "mode", .mode = number, .list = {}, .key = "name"}, name});
  }
  if (!found.empty()) return found;
  if (const std::string problem = scene_mode.mode.problem(); !problem.empty()) {
    found.push_back({{.section = "mode", .mode = number, .list = {}, .key = {}}, called(scene_mode) + ": " + problem});
  }
  return found;
}

std::vector<Finding> mode_findings(const Scene& scene, const SceneMode& scene_mode, std::size_t number) {
  std::vector<Finding> found;
  const SceneMode* const other = scene.find_mode(scene_mode.name);
  if (other && other != scene.modes().data() + number)
    found.push_back({{.section = "mode", .mode = number, .list = {}, .key = "name"}, name_is_taken("mode", scene_mode.name)});
  FieldChecks checks(scene, scene_mode, number, found);
  look_through(scene_mode.mode, checks);
  for (const Mask& mask : scene_mode.masks) checks.resolve("mask", mask.of, 1);
  return found;
}

std::vector<Finding> layer_findings(const Scene& scene, const std::vector<ViewLayer>& layers) {
  std::vector<Finding> found;
  for (std::size_t i = 0; i < layers.size(); ++i) {
    const ViewLayer::Show show = layers[i].show;
    const FoundField drawn = find_field(scene.volumes(), layers[i].field.name);
    const bool of_vectors = show == ViewLayer::Show::streamlines || show == ViewLayer::Show::glyphs;
    if (drawn.field && (show == ViewLayer::Show::slices || of_vectors == (drawn.components == 3))) continue;
    const char* const wrong = of_vectors ? " is a scalar field; streamlines and glyphs are drawn of a vector one"
                                         : " is a vector field; a surface or a volume is drawn of a scalar one, its magnitude";
    found.push_back({{.section = "view", .list = "layer", .item = i, .key = "field"},
                     drawn.field ? in_quotes(layers[i].field.name) + wrong : drawn.problem});
  }
  return found;
}

std::vector<Finding> warnings(const Scene& scene) {
  std::vector<Finding> found;
  const auto of_time = [&](const char* key, std::string text) {
    found.push_back({{.section = "time", .list = {}, .key = key}, std::move(text)});
  };
  bool any = false;
  for (const SceneVolume& volume : scene.volumes()) {
    for (const VolumeField& field : volume.volume.fields) any = any || timed(*field.field);
    if (scene.time().play == TimeOptions::Play::loop && !volume.poses.empty() &&
        volume.poses.front().pose != volume.poses.back().pose) {
      of_time("play", "volume " + in_quotes(volume.name) +
                          " jumps where its loop begins again; end its 'poses' with the first of them");
    }
  }
  if (scene.time() != TimeOptions{} && !any) {
    of_time("", "nothing in the scene changes with time; give a volume 'files' or 'poses', or leave [time] out");
  }
  if (scene.hands().empty()) warn_of_tool(scene, {.section = "tool", .list = {}, .key = {}}, found);
  for (std::size_t i = 0; i < scene.hands().size(); ++i)
    warn_of_tool(scene.of_hand(i), {.section = "hand", .mode = i, .list = "tool", .key = {}}, found);
  for (std::size_t i = 0; i < scene.modes().size(); ++i) {
    const SceneMode& mode = scene.modes()[i];
    LevelChecks levels(scene, mode, i, found);
    look_through(mode.mode, levels);
    TextureChecks texture(scene, mode, i, found);
    look_through(mode.mode, texture);
  }
  return found;
}

ThinPartFindings thin_part_findings(const Scene& scene, const std::vector<std::string>& chose) {
  ThinPartFindings found;
  for (std::size_t i = 0; i < scene.modes().size(); ++i) {
    ThinPartChecks by_default(scene, scene.modes()[i], i, chose, false, found.by_default);
    look_through(scene.modes()[i].mode, by_default);
    ThinPartChecks by_choice(scene, scene.modes()[i], i, chose, true, found.by_choice);
    look_through(scene.modes()[i].mode, by_choice);
  }
  return found;
}

}  // namespace palpa::detail
