// A private display for tests of the window.
#pragma once

#include <string>

namespace palpa::explorer {

/// An X server without a screen, which ends with this process; and a home folder of its own. Returns the error; empty: DISPLAY
/// names it.
std::string start_display();

}  // namespace palpa::explorer
