// Scripts and style of a report, which the build puts into the library: files of ours and of Debian's packages.
#pragma once

#include <string_view>

namespace palpa::detail {

struct Resource {
  std::string_view name;    ///< the file's own
  std::string_view text;    ///< all of it
  std::string_view sha256;  ///< of the text, hexadecimal
};

/// The file called `name`. Programming error (assert) if the build put none of that name in.
const Resource& resource(std::string_view name);

}  // namespace palpa::detail
