// Lines of a first scene: each key with its reason, numbers with few digits.
#pragma once

#include <initializer_list>
#include <string>

#include "palpa/solver/vec3.h"

namespace palpa::detail {

/// `key = value` and its reason, in a column of its own.
std::string reasoned(const std::string& what, const std::string& why);

/// \param digits  [1] significant, at most
std::string with_digits(double value, int digits);
/// \param share  [1]
std::string percent(double share);
/// "182 x 230 x 151 mm", in the unit that gives the longest side one to three digits.
std::string size_words(std::initializer_list<double> lengths_m);
std::string size_words(const Vec3& size_m);

}  // namespace palpa::detail
