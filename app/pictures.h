// Drawing functions of a shared library, loaded at the first use, because loading VTK takes longer than most commands.
#pragma once

#include <filesystem>
#include <string>

#include "palpa/base/new_file.h"
#include "palpa/data/field.h"
#include "palpa/data/statistics.h"
#include "palpa/data/volume.h"
#include "palpa/report/report.h"
#include "palpa/study/check.h"
#include "palpa/study/map.h"

namespace palpa::app {

struct Pictures {
  const char* version;  ///< of its program

  /// `write_report`.
  std::filesystem::path (*report)(const std::filesystem::path& trace, const std::filesystem::path& out,
                                  const ReportOptions& options);
  /// `volume_picture` of a field, as a PNG file.
  void (*volume)(const Volume& volume, std::size_t field, const Statistics& values, const std::string& what,
                 const std::filesystem::path& file, detail::Existing existing);
  /// `map_picture`, as a PNG file.
  void (*map)(const Scene& scene, const ForceMap& map, const std::filesystem::path& file, detail::Existing existing);
  /// Map of a check, as a PNG file.
  void (*check)(const CheckReport& report, const std::filesystem::path& file, detail::Existing existing);
};

/// Loads the library at the first call. Returns nullptr in a build without pictures. Throws LoadError if loading fails.
const Pictures* pictures();

/// Like `pictures`, but throws LoadError if there are none; messages begin with `place`.
const Pictures& pictures_for(const std::string& place);

}  // namespace palpa::app
