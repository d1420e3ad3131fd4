// Laws by name: the exact law, and those of earlier systems for comparison.
#pragma once

#include <array>
#include <memory>
#include <string_view>

#include "palpa/solver/law.h"

namespace palpa::baseline {

/// Names of all laws, the exact law first: the values of `[law] method`.
inline constexpr std::array<std::string_view, 5> law_names{"exact", "paper-2005", "ikits-2003", "ikits-2003-sequential",
                                                           "no-proxy"};

/// Makes the law of a name; nullptr for an unknown name. Allocates.
std::unique_ptr<Law> law(std::string_view name);

}  // namespace palpa::baseline
