// Escaping of untrusted text for XML: pages, SVG, VTK's files.
#pragma once

#include <string>
#include <string_view>

namespace palpa::detail {

/// Escapes a text for XML and HTML, between tags and in attributes within double quotes. Invalid UTF-8 becomes '?', a control
/// character (sanitized.h) other than line ends and tabs a space. Allocates; any thread.
std::string escaped(std::string_view text);

}  // namespace palpa::detail
