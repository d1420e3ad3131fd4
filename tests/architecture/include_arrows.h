// Which layer may include which: read from the page that says so, checked against the sources.
#pragma once

#include <map>
#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace palpa::architecture {

/// For each layer the layers that it may include, itself among them.
using Arrows = std::map<std::string, std::set<std::string>>;

/// The arrows of a design page: the lines with `◄` of its section on layers, such as
///     core ◄ field ◄ mode     words
///     tick, device ◄ loop     words
/// A layer may include what stands left of it in any line, and what that may include.
Arrows arrows_of(std::string_view design_page);

/// What is wrong with the includes of one source file, one sentence each. `path` is relative to the
/// repository: palpa/LAYER/FILE, reader/FILE, app/FILE or explorer/FILE.
std::vector<std::string> wrong_includes(const Arrows& arrows, std::string_view path, std::string_view text);

}  // namespace palpa::architecture
