// Catches what the libraries print: their errors become LoadErrors, their warnings become warnings of the volume.
#pragma once

#include <string>
#include <vector>

namespace palpa::reader {

/// From here on nothing that VTK, MetaIO or GDCM print reaches the terminal. Call once, first.
void catch_library_messages();

/// True when VTK has reported an error since the last `take_library_error`: what it has read must not be used.
bool library_complained() noexcept;
/// The first error of a library since the last call, as half a sentence; empty if there was none.
std::string take_library_error();
/// The warnings since the last call.
std::vector<std::string> take_library_warnings();

}  // namespace palpa::reader
