// Shared data of tests: real scans, flows and recorded hands, which a user's machine does not have.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>

namespace palpa::test {

/// Folder of the shared data, whether it exists or not.
inline std::filesystem::path shared_data_folder() {
  const char* shared = std::getenv("PALPA_SHARED");
  return std::filesystem::path(shared ? shared : "") / "data";
}

/// Path in that folder. Notes the running case in the file $PALPA_TESTS_DATA_CASES: only such cases can differ where the data
/// are hidden, and `./test --without-data` runs no others.
inline std::filesystem::path shared_data(const std::filesystem::path& file = {}) {
  const char* cases = std::getenv("PALPA_TESTS_DATA_CASES");
  if (const testing::TestInfo* test = testing::UnitTest::GetInstance()->current_test_info(); cases && test)
    std::ofstream(cases, std::ios::app) << std::string(test->test_suite_name()) + '.' + test->name() + '\n';
  return file.empty() ? shared_data_folder() : shared_data_folder() / file;
}

}  // namespace palpa::test
