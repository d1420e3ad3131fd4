// Reports: one HTML page on a trace, complete in itself.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "palpa/file/read_volume.h"

namespace palpa {

/// Where a report finds its data, and what else is written beside it.
struct ReportOptions {
  std::vector<std::filesystem::path> data_folders;  ///< looked for the scene's data before where the recording found them
  std::vector<std::filesystem::path> plugins;       ///< shared libraries that bring modes; trusted
  ReadOptions read;
  /// Another trace of the same hand: the page compares what the two felt instead of telling of one. Empty: none.
  std::filesystem::path beside;
  /// Folder that also gets the pictures as files: scene.png, moment.png, force.svg, modes.svg, distance.svg, energy.svg,
  /// time.svg, spectrum.svg; of two traces force.svg, difference.svg, direction.svg, where.svg, spectrum.svg. Made where it is
  /// not there. Empty: none.
  std::filesystem::path pictures;
  bool full_paths = false;  ///< whole paths of data, hand, plug-ins and trace in the page; else their last names
  bool replace = false;     ///< what has the name of the report or of a picture already gives way, not only an earlier report
  std::function<void(double)> progress;  ///< is told the share that is done [1]; empty: nobody is
};

/// The trace as one HTML page, which needs no network: what was felt in words; a view of the scene with the path, events and
/// primitives that can be turned, at a moment that is chosen; plots that zoom and share that moment; how rough the signal is
/// and where it steps; tables; the scene's text. Without scripts, and on paper, pictures stand in for view and plots. Without
/// the scene's data the view has only what was recorded, and the page says why; an incomplete trace is reported as far as it
/// goes. The same trace gives the same bytes on one machine. Throws LoadError on a folder that is no trace, on a file in it
/// that cannot be read, and on a trace beside it whose hand is another.
std::string report_html(const std::filesystem::path& trace, const ReportOptions& options = {});

/// Writes it, by default into the trace as report.html, of two traces into the first as beside.html, replacing an earlier
/// report and nothing else; returns where it is. Never writes through a link. Throws LoadError, also where something else has
/// that name.
std::filesystem::path write_report(const std::filesystem::path& trace, const std::filesystem::path& out = {},
                                   const ReportOptions& options = {});

}  // namespace palpa
