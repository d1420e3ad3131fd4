// A display of their own for tests of the window.
#pragma once

#include <string>

namespace palpa::explorer {

/// An X server without a screen, which lives as long as this process; and a home of its own. Returns why there is none; empty:
/// DISPLAY names it.
std::string start_display();

}  // namespace palpa::explorer
