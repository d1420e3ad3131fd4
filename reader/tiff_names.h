// Names of the slices of a stack.
#pragma once

#include <string>
#include <vector>

namespace palpa::reader {

/// Whether a name ends as that of a TIFF, in any case: .tif, .tiff.
bool is_tiff_name(const std::string& name) noexcept;

/// Whether most files of a folder have names of TIFF.
bool is_tiff_folder(const std::string& path);

/// Whether a name is before another: numbers by their value, so that "s2" is before "s10".
bool naturally_before(const std::string& a, const std::string& b) noexcept;

/// Names of the TIFF files in a folder, in natural order, without hidden ones.
std::vector<std::string> tiff_names_in(const std::string& folder);

/// Warnings about sorted names: missing numbers of a sequence, numbers that are there twice, several sequences.
std::vector<std::string> warnings_of_names(const std::vector<std::string>& names);

}  // namespace palpa::reader
