// Capture of library output: errors become LoadErrors, warnings become warnings of the volume.
#pragma once

#include <string>
#include <vector>

namespace palpa::reader {

/// Captures all output of VTK, MetaIO and GDCM. Call once, first.
void catch_library_messages();

/// True if VTK has reported an error since the last `take_library_error`: its data must not be used.
bool library_complained() noexcept;
/// First library error since the last call, as half a sentence; empty if none.
std::string take_library_error();
/// Warnings since the last call.
std::vector<std::string> take_library_warnings();

}  // namespace palpa::reader
