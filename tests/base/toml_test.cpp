// Untrusted TOML: the check before the parser.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <stdlib.h>
#include <toml++/toml.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <random>

#include "palpa/base/limits.h"
#include "palpa/base/toml_problem.h"
#include "palpa/trace/trace.h"

namespace palpa {
namespace toml_test {

namespace fs = std::filesystem;
using detail::problem_with_toml;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

const auto most_parts = static_cast<int>(limit::key_parts.most);

std::string key_of(int parts) {
  std::string key = "c";
  for (int i = 1; i < parts; ++i) key += ".c";
  return key;
}

int depth_of(const toml::node& node) {
  int deepest = 0;
  if (const toml::table* table = node.as_table()) {
    for (const auto& [key, value] : *table) deepest = std::max(deepest, 1 + depth_of(value));
  }
  if (const toml::array* array = node.as_array()) {
    for (const toml::node& value : *array) deepest = std::max(deepest, depth_of(value));
  }
  return deepest;
}

// Every way to end a string, a comment or a list before a key: the parser itself decides the key's position.
TEST(TomlProblem, IsAKeyOfTooManyPartsWhateverStandsBeforeIt) {
  constexpr std::array<const char*, 22> values{"\"\"",
                                               "\"b\"",
                                               "\"\\\"\"",
                                               "\"\\\\\"",
                                               "\"#\"",
                                               "\"'''\"",
                                               "''",
                                               "'b'",
                                               "'\\'",
                                               "'\"'",
                                               "\"\"\"\"\"\"",
                                               "\"\"\"b\"\"\"\"",
                                               "\"\"\"b\"\"\"\"\"",
                                               "\"\"\"\\\"\"\"\"",
                                               "'''b''''",
                                               "'''b'''''",
                                               "\"\"\"\n#\\\n  \"\"\"",
                                               "'''\n\"'''",
                                               "[1, 2] # '\n",
                                               "{d = ']', e = \"}\"}",
                                               "1.5e3",
                                               "1979-05-27T07:32:00.999"};
  int met = 0;
  for (const char* value : values) {
    for (const std::string shape : {"a = V\nK = 1\n", "x = {a = V, K = 1}\n", "a = V # \"\n[K]\n", "a = [V, {K = 1}]\n",
                                    "\"a.b\" = V\n[[K]]\n", "a = V\r\nK = {}\r\n", "# '\na = V\n\"\".'.'.K = 1\n"}) {
      for (const int parts : {1, most_parts - 2, most_parts, most_parts + 1, 40}) {
        std::string text = shape;
        text.replace(text.find('V'), 1, value);
        text.replace(text.find('K'), 1, key_of(parts));
        int depth = 0;
        try {
          depth = depth_of(toml::parse(std::string_view(text)));
        } catch (const toml::parse_error&) {
          continue;  // a value that the shape does not take
        }
        ++met;
        const int own = parts + (shape.find("'.'") != std::string::npos ? 2 : 0);
        ASSERT_GE(depth, own) << text;
        EXPECT_EQ(problem_with_toml(text).has_value(), own > most_parts) << text;
      }
    }
  }
  EXPECT_GT(met, 500);
}

// For any text: if no problem is found, parsing ends, and tables nest no deeper than the keys of so many parts, each within the
// value of another, allow.
TEST(TomlProblem, IsFoundInTextsOfChance) {
  constexpr std::array<const char*, 24> pieces{"\"", "\"\"\"", "'", "'''", "\\", "#",  "\n",       "\r\n",
                                               "a",  "a = ",   "1", ".",   ",",  "[",  "]",        "[[",
                                               "]]", "{",      "}", "=",   " ",  "b.", "\xc2\x85", "\xe2\x80\xa8"};
  std::mt19937 random(7);
  int parsed = 0, refused = 0;
  for (int n = 0; n < 50'000; ++n) {
    std::string text;
    for (auto left = random() % 14; left > 0; --left) text += pieces[random() % pieces.size()];
    text += (random() % 2 ? "\n" : ", ") + key_of(300) + " = 1" + (random() % 2 ? "}" : "") + "\n";
    if (problem_with_toml(text)) {
      ++refused;
      continue;
    }
    ++parsed;
    try {
      ASSERT_LE(depth_of(toml::parse(std::string_view(text))), 3 * most_parts) << text.substr(0, 60);
    } catch (const toml::parse_error&) {
    }
  }
  EXPECT_GT(parsed, 1000);
  EXPECT_GT(refused, 1000);
}

TEST(TomlProblem, IsTooManyHeadingsWhichTheParserLooksThroughForEach) {
  const auto text = [](std::size_t count, const std::string& before, const std::string& behind) {
    std::string all;
    for (std::size_t i = 0; i < count; ++i) all += before + std::to_string(i) + behind;
    return all;
  };
  const std::size_t most = limit::headings.count();
  for (const auto& [before, behind] : {std::pair{"[a", "]\n"}, {" [[ a", "]]\n"}, {"a", ".b = 1\n"}, {"x", " = {a.b = 1}\n"}}) {
    EXPECT_FALSE(problem_with_toml(text(most, before, behind))) << before;
    const auto problem = problem_with_toml(text(most + 1, before, behind));
    ASSERT_TRUE(problem) << before;
    EXPECT_EQ(problem->line, most + 1);
    EXPECT_EQ(problem->sentence, more_than(limit::headings));
  }
  // Lists of lists and of tables, a line each, are no headings.
  EXPECT_FALSE(problem_with_toml("a = [\n" + text(3 * most, "[", ", 1.5],\n") + "]\n"));
  EXPECT_FALSE(problem_with_toml("a = [\n" + text(3 * most, "{b = ", "},\n") + "]\n"));
}

TEST(TomlProblem, IsAskedForBeforeEveryTextIsParsed) {
  int parsers = 0;
  for (const char* folder : {"palpa", "app", "explorer", "devices", "reader"}) {
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(PALPA_SOURCE_FOLDER) / folder)) {
      if (entry.path().extension() != ".cpp" && entry.path().extension() != ".h") continue;
      std::ifstream file(entry.path());
      const std::string source{std::istreambuf_iterator<char>(file), {}};
      EXPECT_EQ(source.find("toml::parse_file"), std::string::npos) << entry.path();
      if (source.find("toml::parse(") == std::string::npos) continue;
      ++parsers;
      EXPECT_NE(source.find("problem_with_toml("), std::string::npos) << entry.path();
    }
  }
  EXPECT_GE(parsers, 4);
}

class TraceOfAStranger : public testing::Test {
 protected:
  TraceOfAStranger() {
    std::string name = (fs::temp_directory_path() / "palpa-stranger-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
  }
  ~TraceOfAStranger() override { fs::remove_all(folder_); }
  void write(const std::string& name, const std::string& text) const { std::ofstream(folder_ / name) << text; }
  std::string error() const {
    try {
      const TraceReader trace(folder_);
    } catch (const LoadError& error) {
      return error.what();
    }
    return "no error";
  }
  fs::path folder_;
};

TEST_F(TraceOfAStranger, HasNoKeyOfManyParts) {
  write("scene.toml", "palpa = 1\n");
  write("trace.toml", "x = {a = \"\"\"b\"\"\"\", " + key_of(200'000) + " = 1}\n");
  EXPECT_EQ(error(), (folder_ / "trace.toml").string() + ":1:53: a key of " + more_than(limit::key_parts));
}

TEST_F(TraceOfAStranger, HasShortTexts) {
  write("scene.toml", std::string(limit::scene_bytes.count() + 1, '#'));
  write("trace.toml", "format = 1\ndt_s = 0.001\n");
  EXPECT_THAT(error(), AllOf(StartsWith((folder_ / "scene.toml").string() + ": "), HasSubstr("longer than 4 MiB; ")));
  write("scene.toml", "palpa = 1\n");
  EXPECT_EQ(error(), "no error");
  write("trace.toml", std::string(limit::trace_toml_bytes.count() + 1, '#'));
  EXPECT_THAT(error(), AllOf(StartsWith((folder_ / "trace.toml").string() + ": "), HasSubstr("longer than 4 MiB; ")));
}

}  // namespace toml_test
}  // namespace palpa
