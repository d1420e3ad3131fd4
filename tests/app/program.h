// The built program as a process: arguments, exit code and two streams.
#pragma once

#include <gtest/gtest.h>
#include <sys/types.h>

#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace palpa {

struct Ended {
  int code = -1;  ///< exit code; 128 + signal after a signal
  std::string out;
  std::string err;
};

using Environment = std::map<std::string, std::string>;

/// One folder per test, in which the program runs.
class ProgramTest : public testing::Test {
 protected:
  ProgramTest();
  ~ProgramTest() override;

  /// Runs `palpa` to its end.
  Ended palpa(const std::vector<std::string>& arguments, const Environment& environment = {}) const;
  pid_t start(const std::vector<std::string>& arguments, const Environment& environment = {}) const;
  /// Waits for its end; its streams are in the folder until the next start.
  Ended wait(pid_t process) const;
  void wait_for_words(const std::string& piece) const;
  /// Waits until a recording has ticks on disk.
  void wait_for_ticks(const std::filesystem::path& trace) const;
  /// Expects exit code 2 and one line with all `pieces`.
  void expect_refusal(const std::vector<std::string>& arguments, const std::vector<std::string>& pieces) const;

  void write(const std::string& name, const std::string& text) const;
  std::string read(const std::filesystem::path& file) const;
  /// Writes the embedded head's scene under this name, with one piece of its text exchanged.
  void write_scene(const std::string& name, const std::string& from = {}, const std::string& to = {}) const;

  std::filesystem::path folder;
};

}  // namespace palpa
