// Report that compares two traces of one hand.
#pragma once

#include <filesystem>
#include <string>

#include "palpa/report/report.h"

namespace palpa::detail {

/// HTML page on `first` and `options.beside`: summary sentences with a verdict whether the difference is perceptible; both
/// forces and their difference over time; positions with differences; both spectra; roughness of each. Throws LoadError on a
/// folder that is no trace, and if the hands differ, with the time of the first difference.
std::string beside_html(const std::filesystem::path& first, const ReportOptions& options);

}  // namespace palpa::detail
