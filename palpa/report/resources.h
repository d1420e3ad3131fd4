// Scripts and style of reports, embedded at build time: Palpa's own and of Debian packages.
#pragma once

#include <string_view>

namespace palpa::detail {

struct Resource {
  std::string_view name;    ///< of the file
  std::string_view text;    ///< content
  std::string_view sha256;  ///< of the text, hexadecimal
};

/// Resource by file name. Programming error (assert) if there is none.
const Resource& resource(std::string_view name);

}  // namespace palpa::detail
