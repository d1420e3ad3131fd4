// trace.toml: what a trace says about itself.
#pragma once

#include <filesystem>
#include <string>

#include "palpa/trace/trace.h"

namespace palpa::detail {

/// The header as TOML, `complete` first.
std::string header_to_toml(const TraceHeader& header);

/// The header of the trace in `folder`; throws LoadError where there is none or it cannot be read.
TraceHeader read_header(const std::filesystem::path& folder);

}  // namespace palpa::detail
