// Finite stand-ins for numbers that are not finite in legacy VTK text files, which the library does not read.
#pragma once

#include <vtkDataSet.h>

#include <optional>
#include <string>

namespace palpa::reader {

/// Text of a file with stand-ins for "nan", "inf" and "infinity", in any case and with a sign, "1.#INF" and the like; none if
/// the file has no such number, holds binary numbers, or is too long for the library. Changes only lines of numbers. Throws
/// LoadError.
std::optional<std::string> with_stand_ins(const std::string& path);

/// Restores the numbers that are not finite in arrays and coordinates read from such a text.
void put_back_not_finite(vtkDataSet& data);

}  // namespace palpa::reader
