// Scores of a renderer's forces.
#pragma once

#include <array>
#include <filesystem>
#include <map>
#include <span>
#include <string>

#include "bench/haptics/suite.h"

namespace palpa::haptics {

/// A figure of merit; 0 is perfect. Formulas: README.md.
struct Metric {
  const char* name;
  const char* of;  ///< the entry of a case's `scores` that selects it
  const char* heading;
  const char* format;
};
inline constexpr std::array metrics{
    Metric{"surface_p50_mm", "surface", "surface p50 mm", "%.3f"},
    Metric{"surface_p99_mm", "surface", "surface p99 mm", "%.3f"},
    Metric{"direction_p50_deg", "direction", "direction p50 °", "%.2f"},
    Metric{"direction_p99_deg", "direction", "direction p99 °", "%.2f"},
    Metric{"force_rms_n", "force", "force rms N", "%.3f"},
    Metric{"force_p99_n", "force", "force p99 N", "%.3f"},
    Metric{"force_share", "force", "force rms, % of truth's", "%.1f"},
    Metric{"lost_share", "lost", "lost %", "%.2f"},
    Metric{"false_rest_share", "rest", "false rest %", "%.0f"},
    Metric{"restless_share", "rest", "restless %", "%.0f"},
    Metric{"friction_p50_deg", "friction", "friction angle p50 °", "%.2f"},
    Metric{"friction_p99_deg", "friction", "friction angle p99 °", "%.2f"},
    Metric{"break_n", "break", "break N", "%.3f"},
    Metric{"drift_um", "drift", "drift µm/turn", "%.2f"},
    Metric{"energy_mj", "energy", "energy mJ/turn", "%.4f"},
    Metric{"ripple_mn", "ripple", "ripple mN", "%.2f"},
};

/// The figures of one case that its scores select, by name. Shares in percent. Infinite: the hand was not held.
using Scores = std::map<std::string, double>;
/// \param folder    of the case's truth, for a shape in a file
/// \param forces_n  [N] for each probe
/// Throws LoadError if the shape cannot be loaded.
Scores score(const MadeCase& one, std::span<const Vec3> forces_n, const std::filesystem::path& folder);

}  // namespace palpa::haptics
