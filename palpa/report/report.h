// Reports: one HTML page on a trace, complete in itself.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "palpa/volume/read_volume.h"

namespace palpa {

struct ReportOptions {
  std::vector<std::filesystem::path> data_folders;  ///< looked for the scene's data before where the recording found them
  std::vector<std::filesystem::path> plugins;       ///< shared libraries that bring modes; trusted
  ReadOptions read;
  /// Folder that also gets the pictures as files: scene.png, moment.png, force.svg, modes.svg, position.svg, energy.svg,
  /// time.svg. Made where it is not there. Empty: none.
  std::filesystem::path pictures;
};

/// The trace as one HTML page, which needs neither network nor scripts: what was felt in words, pictures of
/// the scene with the path and of the moment in which most modes pushed, plots, tables, the scene's text.
/// Without the scene's data it has no pictures and says why; an incomplete trace is reported as far as it goes. The
/// same trace gives the same bytes on one machine. Throws LoadError on a folder that is no trace, and on a
/// file in it that cannot be read.
std::string report_html(const std::filesystem::path& trace, const ReportOptions& options = {});

/// Writes it, by default into the trace as report.html, replacing what was there; returns where it is. Throws
/// LoadError.
std::filesystem::path write_report(const std::filesystem::path& trace, const std::filesystem::path& out = {},
                                   const ReportOptions& options = {});

}  // namespace palpa
