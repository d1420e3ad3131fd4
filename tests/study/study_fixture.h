// Folder of one test, and shared parts of the tests of runs.
#pragma once

#include <gtest/gtest.h>
#include <stdlib.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>

#include "palpa/study/run.h"

namespace palpa {

inline constexpr const char* phantom_scene = R"(palpa = 1
title = "phantom"
[coupling]
stiffness_n_per_m = 800
damping_ns_per_m = 0.5
max_force_n = 3.3
[workspace]
fit = "head"
[volume.head]
analytic = "head_phantom"
[[mode]]
name = "skin"
type = "surface_and_friction"
field = "head"
friction_n = 0.1
[[mode.level]]
name = "skin"
value = -300
strength_n = 0.8
[[mode.level]]
name = "bone"
value = 300
strength_n = 4.0
[[mode]]
name = "syrup"
type = "viscosity"
field = "head"
drag_ns_per_m = 0.5
)";

/// A folder with the phantom's scene, and runs of it.
class StudyFolder {
 public:
  StudyFolder() {
    std::string name = (std::filesystem::temp_directory_path() / "palpa-study-test-XXXXXX").string();
    folder = ::mkdtemp(name.data());
    write("scene.toml", phantom_scene);
  }
  ~StudyFolder() { std::filesystem::remove_all(folder); }
  StudyFolder(const StudyFolder&) = delete;
  StudyFolder& operator=(const StudyFolder&) = delete;

  void write(const std::string& name, const std::string& text) const { std::ofstream(folder / name, std::ios::binary) << text; }
  std::string read(const std::filesystem::path& file) const {
    std::ostringstream text;
    text << std::ifstream(file, std::ios::binary).rdbuf();
    return text.str();
  }
  std::map<std::string, std::string> reproducible_files(const std::filesystem::path& trace) const {
    std::map<std::string, std::string> files;
    for (const auto& entry : std::filesystem::directory_iterator(trace)) {
      const std::string name = entry.path().filename();
      if (name != "timing.csv" && name.ends_with(".csv")) files[name] = read(entry.path());
    }
    return files;
  }
  RunOptions options(const std::string& trace, double duration_s = 1.0) const {
    RunOptions o;
    o.scene = folder / "scene.toml";
    o.hand = "sim:stroke";
    o.duration_s = duration_s;
    if (!trace.empty()) o.out = folder / trace;
    o.arguments = {"run", "scene.toml"};
    return o;
  }

  std::filesystem::path folder;
};

class StudyTest : public testing::Test, protected StudyFolder {};

}  // namespace palpa
