// Numbers as people say them; `--json` has all their digits.
#pragma once

#include <string>
#include <string_view>

#include "app/info_facts.h"
#include "palpa/data/statistics.h"

namespace palpa::app {

/// "  label     text" and a line's end; nothing without text.
std::string line(std::string_view label, const std::string& text);
/// Path in shell syntax, quoted if needed.
std::string for_shell(const std::string& path);
/// Four digits, or as many as stand before the point, in groups of three: "16.43", "7 026 340".
std::string rounded_words(double value);
/// The same for one value among others over a span (in the same unit): a value that is only rounding beside the span is 0.
std::string rounded_words(double value, double span);
/// A length [m] in the unit in which people would say it: "245 mm".
std::string length_words(double metres);
/// A length in a volume [m]: in millimetres if that is a patient's, "0.5 file units" where no unit of length is known.
std::string length_words(const Facts& facts, double metres);
/// "3.33 m × 3.63 m × 1.14 m": the sides of a box [m], all in the unit of the longest; "3.33 × 3.63 × 1.14 file units" where no
/// unit of length is known.
std::string sides_words(const Facts& facts, const Vec3& sides_m);
/// ", taken as m": which unit was assumed for the file's lengths; empty where none was.
std::string assumed_words(const Facts& facts);
/// "(-5, 16, 7) mm": a position [m] in the unit that fits the data.
std::string in_one_unit(const Facts& facts, const Vec3& world_m);

/// A histogram with classes in one line of bars. Heights are square roots, so that rare values are visible beside frequent
/// ones.
std::string bars_of(const Histogram& histogram);

}  // namespace palpa::app
