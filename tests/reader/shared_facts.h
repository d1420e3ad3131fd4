// Facts of the shared data, found with other tools.
#pragma once

#include <fstream>
#include <nlohmann/json.hpp>

#include "files.h"

namespace palpa::test {

class SharedFacts : public ReaderTest {
 protected:
  void SetUp() override {
    ReaderTest::SetUp();
    if (IsSkipped()) return;
    const fs::path file = shared_file("facts.json");
    if (file.empty()) GTEST_SKIP() << "the shared data are not here: set PALPA_SHARED to their folder";
    facts_ = nlohmann::json::parse(std::ifstream(file));
  }
  nlohmann::json facts_;
};

}  // namespace palpa::test
