// Units of length: the only table for files of every format, for scenes and for the command line.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>

namespace palpa::detail {

struct LengthUnit {
  double metres = 1.0;  ///< [m] of one unit; > 0, finite
  std::string name;     ///< "mm" for "Millimetres"; the text itself if it has a factor ("1e-3 m")
};

/// Parses a unit of length, in any case and usual spelling, with an optional factor: "mm", "Millimetres", "μm", "1e-3 m". None
/// for other texts and for ambiguous ones ("Mm": millimetre or megametre). Allocates; throws std::bad_alloc only; any thread.
std::optional<LengthUnit> length_unit(std::string_view text);

/// Whether a text leaves the unit open: empty, or "?", "unknown", "none". Allocates; any thread.
bool leaves_length_unit_open(std::string_view text);

/// Names proposed by messages, completion and the documentation.
inline constexpr std::array<std::string_view, 9> proposed_length_units{"m",  "cm",       "mm", "um", "nm",
                                                                       "km", "angstrom", "in", "ft"};

}  // namespace palpa::detail
