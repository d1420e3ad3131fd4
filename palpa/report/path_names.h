// Shortens paths in a page to base names: folders may contain names of people and houses.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "palpa/report/recorded.h"

namespace palpa::detail {

/// Removes folders from texts, or leaves texts unchanged. Allocates; any thread.
class PathNames {
 public:
  /// \param trace  folder of the trace
  /// \param full   keep whole paths
  PathNames(const Recorded& recorded, const std::filesystem::path& trace, bool full);

  /// Base name of a path. "scan.h5:/mag/u" keeps the array's name.
  std::string of_path(std::string_view path) const;
  /// Argument of a command line or setting KEY=VALUE, with base names.
  std::string of_argument(std::string_view argument) const;
  /// Value of a scene, without quotes; a path becomes its base name.
  std::string of_value(std::string_view value) const;
  /// Sentence or scene text: shortens known folders, strings that name a file, and anything that resembles a path.
  std::string in_text(std::string_view text) const;

 private:
  bool is_known_file(std::string_view name) const;
  bool full_;
  std::vector<std::string> folders_;  ///< of known files, longest first
  std::vector<std::string> files_;    ///< base names of known files
};

}  // namespace palpa::detail
