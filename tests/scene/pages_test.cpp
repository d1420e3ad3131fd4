// Scenes in the documentation, and the forces of mode pages.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include "tests/scene/scene_files.h"

namespace palpa {
namespace pages_test {

namespace fs = std::filesystem;
using test::parse;
using testing::IsEmpty;

std::vector<std::string> whole_scenes(const std::string& page) {
  std::vector<std::string> scenes;
  const std::string begin = "```toml\npalpa = 1", end = "\n```";
  for (std::size_t at = page.find(begin); at != std::string::npos; at = page.find(begin, at)) {
    at += begin.find('\n') + 1;
    const std::size_t stop = page.find(end, at);
    if (stop == std::string::npos) break;
    scenes.push_back(page.substr(at, stop + 1 - at));
    at = stop;
  }
  return scenes;
}

std::vector<std::string> scenes_in(const fs::path& page) {
  std::ifstream file(page, std::ios::binary);
  EXPECT_TRUE(file) << page;
  return whole_scenes({std::istreambuf_iterator<char>(file), {}});
}

const fs::path docs = fs::path(PALPA_SOURCE_FOLDER) / "docs";

TEST(Pages, WholeScenesAreFound) {
  EXPECT_THAT(whole_scenes("a\n```toml\nk = 1\n```\n```toml\npalpa = 1\nx = 2\n```\n```toml\npalpa = 1\n```\n"),
              testing::ElementsAre("palpa = 1\nx = 2\n", "palpa = 1\n"));
}

TEST(Pages, HaveScenesThatLoadWithoutAWarning) {
  int found = 0;
  for (const auto& entry : fs::recursive_directory_iterator(docs)) {
    if (entry.path().extension() != ".md") continue;
    for (const std::string& text : scenes_in(entry.path())) {
      ++found;
      try {
        EXPECT_THAT(parse(text).warnings, IsEmpty()) << entry.path();
      } catch (const LoadError& error) {
        ADD_FAILURE() << entry.path() << ": " << error.what();
      }
    }
  }
  EXPECT_GE(found, 2 + static_cast<int>(standard_modes().modes().size()));
}

TEST(Pages, EveryModeHasOneWithASceneOfIt) {
  for (const Mode& mode : standard_modes().modes()) {
    const fs::path page = docs / "modes" / (std::string(mode.type()) + ".md");
    const std::vector<std::string> scenes = scenes_in(page);
    ASSERT_FALSE(scenes.empty()) << page;
    const Scene scene = parse(scenes.front()).scene;
    ASSERT_EQ(scene.modes().size(), 1u) << page;
    EXPECT_EQ(scene.modes().front().mode.type(), mode.type());
  }
}

}  // namespace pages_test
}  // namespace palpa
