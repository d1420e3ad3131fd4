// The shipped scenes by name, for tests of all of them.
#pragma once

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include "tests/shared_data.h"

namespace palpa::test {

/// Names of all scenes, without ending, sorted.
inline std::vector<std::string> shipped_scenes() {
  std::vector<std::string> names;
  for (const auto& file : std::filesystem::directory_iterator(PALPA_SCENES_FOLDER)) {
    if (file.path().extension() == ".toml") names.push_back(file.path().stem());
  }
  std::ranges::sort(names);
  return names;
}

inline std::filesystem::path scene_file(const std::string& name) {
  return std::filesystem::path(PALPA_SCENES_FOLDER) / (name + ".toml");
}

/// Names of the scenes with a tool, without ending, sorted: "tools/peg", …
inline std::vector<std::string> tool_scenes() {
  std::vector<std::string> names;
  for (const auto& file : std::filesystem::directory_iterator(std::filesystem::path(PALPA_SCENES_FOLDER) / "tools")) {
    const std::string name = file.path().stem().string();
    const bool of_two_hands = name.starts_with("two_");  // felt by tests/study/hands_test.cpp
    if (file.path().extension() == ".toml" && !of_two_hands) names.push_back("tools/" + name);
  }
  std::ranges::sort(names);
  return names;
}

/// An environment variable's value, followed by a part of a path.
inline std::filesystem::path from_environment(const char* variable, const char* part) {
  const char* value = std::getenv(variable);
  return std::filesystem::path(value ? value : "") / part;
}
inline std::filesystem::path reader() { return from_environment("PALPA_BIN", "palpa-read"); }

/// The reason why this scene, or a test of real data that is no scene, cannot run here; empty: it can.
inline std::string missing_for(const std::string& name) {
  std::ifstream text(scene_file(name));
  const std::string keys{std::istreambuf_iterator<char>(text), {}};
  if (text.is_open() && keys.find("\nfile = ") == std::string::npos) return {};
  if (!std::filesystem::is_directory(shared_data())) return "no real data: " + shared_data().string() + " is not there";
  if (!std::filesystem::exists(reader())) return "this build has no palpa-read, so no real data";
  return {};
}

}  // namespace palpa::test
