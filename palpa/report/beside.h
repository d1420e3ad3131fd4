// The page that compares two traces of the same hand.
#pragma once

#include <filesystem>
#include <string>

#include "palpa/report/report.h"

namespace palpa::detail {

/// What the hand felt in `first` and in `options.beside`: in words, with a verdict whether a hand would tell; both forces and
/// their difference over time; where on the hand's way they differ; both spectra; how rough each is. Throws LoadError on a
/// folder that is no trace, and where the two hands are not the same, with the moment from which on they differ.
std::string beside_html(const std::filesystem::path& first, const ReportOptions& options);

}  // namespace palpa::detail
