// Shared parts of the loading tests: a ball's scene, its texts, and the check of refused texts.
#pragma once

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

#include "tests/scene/scene_files.h"

namespace palpa::test::ball_scene {

/// A whole scene: line 1 is the format, the mode's table starts at line 4.
inline constexpr const char* ball = R"(palpa = 1
[volume.ball]
analytic = "sphere"
[[mode]]
name = "skin"
type = "surface_and_friction"
field = "ball"
[[mode.level]]
name = "outside"
value = 0
strength_n = 0.8
)";

inline std::string with(const std::string& more) { return ball + more; }

class Folder {
 public:
  Folder() {
    std::string name = (std::filesystem::temp_directory_path() / "palpa-scene-XXXXXX").string();
    path = mkdtemp(name.data());
  }
  ~Folder() { std::filesystem::remove_all(path); }
  std::filesystem::path file(const std::string& name, const std::string& text = "x") const {
    std::filesystem::create_directories((path / name).parent_path());
    std::ofstream(path / name) << text;
    return path / name;
  }
  std::filesystem::path path;
};

struct Wrong {
  const char* what;
  std::string text;
  const char* error;
};

/// Each refusal is one line that begins with its place.
inline void expect_refused(const std::vector<Wrong>& scenes) {
  for (const Wrong& wrong : scenes) {
    const std::string error = error_of(wrong.text);
    EXPECT_THAT(error, testing::StartsWith(wrong.error)) << wrong.what << ":\n" << wrong.text.substr(0, 2000);
    EXPECT_EQ(error.find('\n'), std::string::npos) << wrong.what;
    EXPECT_THAT(error, testing::HasSubstr(";")) << wrong.what;
  }
}

inline std::string header(const std::string& more) { return "palpa = 1\n" + more + std::string(ball).substr(10); }
inline std::string volume(const std::string& body) {
  return "palpa = 1\n[volume.v]\n" + body + "\n[[mode]]\nname = \"m\"\ntype = \"viscosity\"\nstrength_n = 1\n";
}
inline std::string mode(const std::string& body) {
  return "palpa = 1\n[volume.ball]\nanalytic = \"sphere\"\n[[mode]]\n" + body + "\n";
}
inline std::string layer(const std::string& body) { return with("[[view.layer]]\n" + body + "\n"); }

inline SceneOptions set(const std::string& path, const std::string& value) {
  SceneOptions options;
  options.sets = {{path, value}};
  return options;
}

}  // namespace palpa::test::ball_scene
