// Numbers that are not finite in legacy VTK files of text, which the library does not read: others stand in for them meanwhile.
#pragma once

#include <vtkDataSet.h>

#include <optional>
#include <string>

namespace palpa::reader {

/// A file as text in which "nan", "inf" and "infinity", in any case and with a sign, and "1.#INF" and the like are stand-ins;
/// none where it has none of them, holds binary numbers, or is too long for the library. Only lines of nothing but numbers are
/// changed. Throws LoadError.
std::optional<std::string> with_stand_ins(const std::string& path);

/// Puts the numbers that are not finite back into the arrays and coordinates that were read from such a text.
void put_back_not_finite(vtkDataSet& data);

}  // namespace palpa::reader
