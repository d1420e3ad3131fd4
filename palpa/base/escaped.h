// Texts of others within XML: pages, SVG, VTK's files.
#pragma once

#include <string>
#include <string_view>

namespace palpa::detail {

/// A text as it may stand in XML and HTML, between tags and in attributes between double quotes. What is no UTF-8 becomes '?',
/// what steers instead of being read (shown.h) becomes a space, but for line ends and tabs. Allocates; safe from any thread.
std::string escaped(std::string_view text);

}  // namespace palpa::detail
