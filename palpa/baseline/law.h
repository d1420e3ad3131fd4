// Laws by name: the exact one, and those of earlier systems to compare with.
#pragma once

#include <array>
#include <memory>
#include <string_view>

#include "palpa/solver/law.h"

namespace palpa::baseline {

/// Names of all laws, the exact one first: the values of `[law] method`.
inline constexpr std::array<std::string_view, 5> law_names{"exact", "paper-2005", "ikits-2003", "ikits-2003-sequential",
                                                           "no-proxy"};

/// Makes the law of a name; nullptr where there is none. Allocates.
std::unique_ptr<Law> law(std::string_view name);

}  // namespace palpa::baseline
