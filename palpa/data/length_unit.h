// Units of length: the one table for files of every format, for scenes and for the command line.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

namespace palpa::detail {

struct LengthUnit {
  double metres = 1.0;  ///< [m] of one unit; > 0, finite
  std::string name;     ///< "mm" for "Millimetres"; the text itself where it has a factor ("1e-3 m")
};

/// The unit of length that a text names, in any case and usual spelling, with a factor before it or not: "mm", "Millimetres",
/// "μm", "1e-3 m". Nothing for a text that names none, and for one that names two of different size ("Mm": millimetre or
/// megametre). Allocates; does not throw but for want of memory; safe from any thread.
std::optional<LengthUnit> length_unit(std::string_view text);

/// Whether a text leaves the unit open: it is empty, or a word for that ("?", "unknown", "none"). Allocates; safe from any
/// thread.
bool leaves_length_unit_open(std::string_view text);

/// The names that messages, completion and the documentation propose.
inline constexpr std::array<std::string_view, 9> proposed_length_units{"m",  "cm",       "mm", "um", "nm",
                                                                       "km", "angstrom", "in", "ft"};

}  // namespace palpa::detail
