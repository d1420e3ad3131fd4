// What the pages of reports are made of.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "palpa/base/new_file.h"
#include "palpa/report/plots.h"
#include "palpa/report/recorded.h"
#include "palpa/report/report.h"
#include "palpa/scene/load_scene.h"

namespace palpa::detail {

/// [1] Rows of each plot. More: a larger page; fewer: zoomed plots are coarse.
inline constexpr std::size_t most_plot_rows = 3000;

/// A page that palpa made, or an empty one, may be replaced without asking. Throws LoadError where something else is there.
Existing what_becomes_of(const std::filesystem::path& file, const ReportOptions& options);

/// A picture of the report as a file of its own, where that is asked for. Throws LoadError.
void keep(const ReportOptions& options, const std::string& name, const std::string& bytes);

/// A figure with a text for those who do not see it. \param caption  a text
std::string figure(const std::string& content, const std::string& caption);

/// \param words  a text
std::string notice(const std::string& words);

/// The plots, each as a place for plots.js and as an SVG for where there is no script, and for paper.
/// \param has_moments  a click on a plot looks at that moment
std::string plots_markup(const std::vector<TimePlot>& plots, bool has_moments, const ReportOptions& options);

/// The licences of what stands in the page.
std::string software_markup();

/// The scene as it was felt, if its data are there; else `why_not`.
std::optional<LoadedScene> scene_of(const std::filesystem::path& trace, const Recorded& recorded, const ReportOptions& options,
                                    std::string& why_not);

}  // namespace palpa::detail
