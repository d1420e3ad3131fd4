// Parts of a scene file: a list of keys for each part, as modes have (mode/parameters.h). Loading, writing, error lines, range
// checks, --set and the documentation use it: a new key is an entry in parts.cpp and the member that it fills.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "palpa/data/timed_field.h"
#include "palpa/data/volume.h"
#include "palpa/mode/mode.h"
#include "palpa/mode/parameters.h"
#include "palpa/scene/scene.h"

namespace palpa {

namespace detail {

/// Keys before the first table.
struct HeaderPart {
  int palpa = 1;  ///< format of the file
  std::string title;
  std::vector<std::string> needs;
  std::string only_hand;  ///< name of the single hand that is felt; empty: all
};

struct LawPart {
  std::string method = "exact";
};

struct PosePart {
  Vec3 translate_m;
  std::array<double, 4> rotate_axis_deg{0, 0, 1, 0};
  double scale = 1.0;  ///< [1]
};

struct TimedPosePart {
  double time_s = 0.0;
  PosePart pose;
};

/// [volume.NAME].
struct VolumePart {
  std::string file;                ///< a single file, or …
  std::vector<std::string> files;  ///< … several that belong together
  std::string series;              ///< pattern of the files of a time series
  std::optional<double> frame_period_s;
  BetweenFrames between_frames = BetweenFrames::linear;
  std::string analytic;
  std::optional<int> sampled;  ///< [1] samples
  int frames = 20;             ///< [1] of embedded data that change with time
  PosePart pose;
  std::vector<TimedPosePart> poses;
  std::optional<Filter> filter;
  std::string sign;
  std::optional<double> smoothing_m;
  VolumeRequest request;  ///< without its files
};

/// Keys of every mode.
struct ModePart {
  std::string name;
  std::string type;
  bool enabled = true;
  std::optional<SceneMode::Feet> feet{};
};

/// Function of a field, without its points.
struct FunctionPart {
  FieldRef of;
  double outside = 0.0;  ///< [N] or [1] as its results
};

/// Colours of a layer, without their points.
struct ColorsPart {};

/// Valid directions of [workspace].
std::vector<std::string> direction_words();

}  // namespace detail

/// "rod", … Allocates nothing; any thread.
const char* name_of(ToolOptions::Shape shape) noexcept;

/// Visits every key of a part, in the order of the documentation, as `Mode::visit` does. Each allocates.
void visit_part(detail::HeaderPart& part, ParameterVisitor& visitor);
void visit_part(CouplingOptions& part, ParameterVisitor& visitor);
void visit_part(detail::LawPart& part, ParameterVisitor& visitor);
void visit_part(Workspace& part, ParameterVisitor& visitor);
void visit_part(TimeOptions& part, ParameterVisitor& visitor);
void visit_part(ToolOptions& part, ParameterVisitor& visitor);
/// Without the tool.
void visit_part(SceneHand& part, ParameterVisitor& visitor);
void visit_part(detail::VolumePart& part, ParameterVisitor& visitor);
void visit_part(VolumeRequest& part, ParameterVisitor& visitor);
void visit_part(VolumeRequest::FieldRequest& part, ParameterVisitor& visitor);
void visit_part(detail::PosePart& part, ParameterVisitor& visitor);
void visit_part(detail::TimedPosePart& part, ParameterVisitor& visitor);
void visit_part(detail::ModePart& part, ParameterVisitor& visitor);
void visit_part(detail::FunctionPart& part, ParameterVisitor& visitor);
void visit_part(ViewOptions& part, ParameterVisitor& visitor);
void visit_part(ViewLayer& part, ParameterVisitor& visitor);
void visit_part(detail::ColorsPart& part, ParameterVisitor& visitor);

/// Visits the parameters of a copy of a mode. Allocates.
inline void look_through(Mode mode, ParameterVisitor& visitor) { mode.visit(visitor); }

}  // namespace palpa
