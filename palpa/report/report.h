// Reports: a self-contained HTML page on a trace.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "palpa/file/read_volume.h"

namespace palpa {

/// Data sources and additional output of a report.
struct ReportOptions {
  std::vector<std::filesystem::path> data_folders;  ///< searched for the scene's data before the recorded paths
  std::vector<std::filesystem::path> plugins;       ///< shared libraries with modes; trusted
  ReadOptions read;
  /// Second trace of the same hand: the page compares both. Empty: none.
  std::filesystem::path beside;
  /// Folder for the pictures as files: scene.png, moment.png, force.svg, torque.svg (of a tool), modes.svg, distance.svg,
  /// energy.svg, time.svg, spectrum.svg; of two traces force.svg, difference.svg, direction.svg, where.svg, spectrum.svg.
  /// Created if missing. Empty: none.
  std::filesystem::path pictures;
  bool full_paths = false;               ///< whole paths of data, hand, plug-ins and trace in the page; else base names
  bool replace = false;                  ///< replace any existing report or picture file, not only an earlier report
  std::function<void(double)> progress;  ///< called with the finished share [1]; may be empty
};

/// HTML page on a trace, without network access: summary in sentences; interactive view of the scene with path, events and
/// primitives at a chosen moment; zoomable plots linked to that moment; roughness and steps of the signal; tables; the scene's
/// text. Without scripts, and on paper, pictures replace view and plots. Without the scene's data the view shows only recorded
/// content, with the reason; an incomplete trace is reported as far as it goes. Equal traces give equal bytes on one machine.
/// Of a folder with a trace of each hand: a page that links the hands' own pages and summarizes them.
/// Throws LoadError on a folder that is no trace, on an unreadable file, and on a second trace with a different hand.
std::string report_html(const std::filesystem::path& trace, const ReportOptions& options = {});

/// Writes the page and returns its path: by default report.html in the trace, for two traces beside.html in the first. Replaces
/// an earlier report only; never writes through a link. Of a folder with a trace of each hand: writes a page into each trace,
/// and report.html into the folder; `out`, `beside` and `pictures` are for one trace. Throws LoadError, also if the name is
/// taken by another file.
std::filesystem::path write_report(const std::filesystem::path& trace, const std::filesystem::path& out = {},
                                   const ReportOptions& options = {});

}  // namespace palpa
