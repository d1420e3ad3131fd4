// Shared parts of the tests of traces: a folder, texts, and plain ticks.
#pragma once

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "palpa/trace/trace.h"

namespace palpa::test {

namespace fs = std::filesystem;

inline std::string text_of(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::ostringstream text;
  text << stream.rdbuf();
  return text.str();
}
inline void set_text(const fs::path& file, const std::string& text) { std::ofstream(file, std::ios::binary) << text; }
inline std::string first_line(const fs::path& file) {
  const std::string text = text_of(file);
  return text.substr(0, text.find('\n'));
}

template <class Action>
std::string error_of(Action action) {
  try {
    action();
  } catch (const LoadError& error) {
    return error.what();
  }
  return "(no error)";
}

class Trace : public testing::Test {
 protected:
  void SetUp() override {
    std::string name = (fs::temp_directory_path() / "palpa-trace-XXXXXX").string();
    ASSERT_NE(::mkdtemp(name.data()), nullptr);
    root_ = name;
  }
  void TearDown() override { fs::remove_all(root_); }
  fs::path folder(const std::string& name = "trace") const { return root_ / name; }

  static constexpr const char* scene = "palpa = 1\n# \xc3\xa9 byte for byte\r\n\n";

 private:
  fs::path root_;
};

// A plain tick number `i` whose values differ from tick to tick.
inline TickFrame plain_frame(std::int64_t i) {
  TickFrame frame{.tick = i, .t_s = static_cast<double>(i) / 1000, .dt_s = 1e-3};
  frame.result.probe_m = {0.0, 0.001 * static_cast<double>(i), 1.0 / 3.0};
  frame.result.force_n = frame.command.force_n = {0.0, 0.5, 0.0};
  return frame;
}

inline void write_plain(TraceWriter& writer, std::int64_t from, std::int64_t to) {
  const ModeForce modes[] = {{.force_n = {0, 0, 1}, .primitives = 2}, {.split_shared = true}};
  for (std::int64_t i = from; i < to; ++i) writer.append(plain_frame(i), modes, {}, {}, {});
}

}  // namespace palpa::test
