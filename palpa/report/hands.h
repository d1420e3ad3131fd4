// Page on the traces of several hands.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "palpa/report/report.h"

namespace palpa::detail {

/// Page that links the report of each hand and summarizes them side by side. Throws LoadError as `report_html`.
/// \param traces  in `folder`, of one run; at least one
std::string hands_html(const std::filesystem::path& folder, const std::vector<std::filesystem::path>& traces,
                       const ReportOptions& options);

/// Throws LoadError for options that are for one trace.
void check_options_of_hands(const std::filesystem::path& folder, const std::vector<std::filesystem::path>& traces,
                            const std::filesystem::path& out, const ReportOptions& options);

}  // namespace palpa::detail
