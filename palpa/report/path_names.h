// Paths in a page that leaves the machine: base names, because folders have names of people and houses in them.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "palpa/report/recorded.h"

namespace palpa::detail {

/// Takes the folders out of texts, or leaves texts as they are. Allocates; any thread.
class PathNames {
 public:
  /// \param trace  folder of the trace
  /// \param full   whole paths stay
  PathNames(const Recorded& recorded, const std::filesystem::path& trace, bool full);

  /// The last name of a path. "scan.h5:/mag/u" keeps the array behind the file.
  std::string of_path(std::string_view path) const;
  /// An argument of a command line or a setting KEY=VALUE, with the last names of its paths.
  std::string of_argument(std::string_view argument) const;
  /// A value of a scene, without its quotes: a path as its last name.
  std::string of_value(std::string_view value) const;
  /// A sentence or a scene's text: known folders, whole strings that name a file, and what looks like a path are shortened.
  std::string in_text(std::string_view text) const;

 private:
  bool is_known_file(std::string_view name) const;
  bool full_;
  std::vector<std::string> folders_;  ///< of known files, the longest first
  std::vector<std::string> files_;    ///< base names of known files
};

}  // namespace palpa::detail
