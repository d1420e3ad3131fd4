// Building blocks of report pages.
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

/// Reports and empty files may be replaced without `replace`. Throws LoadError on any other file.
Existing what_becomes_of(const std::filesystem::path& file, const ReportOptions& options);

/// Writes a picture of the report as a file of its own, if requested. Throws LoadError.
void keep(const ReportOptions& options, const std::string& name, const std::string& bytes);

/// Figure with a text alternative. \param caption  a text
std::string figure(const std::string& content, const std::string& caption);

/// \param words  a text
std::string notice(const std::string& words);

/// Plots, each as a container for plots.js and as an SVG, for paper and pages without scripts.
/// \param has_moments  a click on a plot selects that moment
std::string plots_markup(const std::vector<TimePlot>& plots, bool has_moments, const ReportOptions& options);

/// Licences of the embedded software.
std::string software_markup();

/// The recorded scene, if its data can be loaded; else the reason in `why_not`.
std::optional<LoadedScene> scene_of(const std::filesystem::path& trace, const Recorded& recorded, const ReportOptions& options,
                                    std::string& why_not);

}  // namespace palpa::detail
