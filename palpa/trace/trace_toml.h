// trace.toml: header of a trace.
#pragma once

#include <filesystem>
#include <string>

#include "palpa/trace/trace.h"

namespace palpa::detail {

/// Header as TOML, `complete` first.
std::string header_to_toml(const TraceHeader& header);

/// Header of the trace in `folder`; throws LoadError if missing or unreadable.
TraceHeader read_header(const std::filesystem::path& folder);

}  // namespace palpa::detail
