// The promises that the folders make: which layer includes which, numbers that say their unit, pages whose
// links lead somewhere. And the checkers themselves: each must see a violation planted before it.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <map>
#include <regex>
#include <set>

#include "include_arrows.h"
#include "number_names.h"
#include "source_sizes.h"
#include "source_tokens.h"

namespace palpa::architecture {
namespace architecture_test {

namespace fs = std::filesystem;
using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;

fs::path repository() { return PALPA_SOURCE_FOLDER; }

std::string text_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  EXPECT_TRUE(file) << path;
  return {std::istreambuf_iterator<char>(file), {}};
}

/// The files under a folder of the repository with one of these endings, relative to the repository.
std::vector<std::string> files_under(const std::string& folder, const std::vector<std::string>& endings) {
  std::vector<std::string> files;
  for (const auto& entry : fs::recursive_directory_iterator(repository() / folder)) {
    for (const std::string& ending : endings) {
      if (entry.path().string().ends_with(ending)) files.push_back(fs::relative(entry.path(), repository()).string());
    }
  }
  std::sort(files.begin(), files.end());
  return files;
}

std::vector<std::string> names_of(const std::vector<UnitlessNumber>& numbers) {
  std::vector<std::string> names;
  for (const UnitlessNumber& number : numbers) names.push_back(number.name);
  return names;
}

constexpr const char* small_page = R"(# Design
a ◄ nowhere
## 3. Layers and folders
core ◄ field ◄ mode          words about ◄ arrows
core ◄ device
mode, device ◄ loop
field ◄ file ◄ reader
field ◄ vtk
## 4. Else
x ◄ y
)";

TEST(Arrows, AreReadFromTheSectionOnLayersAndFollowedToTheirEnd) {
  const Arrows arrows = arrows_of(small_page);
  EXPECT_THAT(arrows, SizeIs(8));
  EXPECT_THAT(arrows.at("core"), ElementsAre("core"));
  EXPECT_THAT(arrows.at("mode"), ElementsAre("core", "field", "mode"));
  EXPECT_THAT(arrows.at("loop"), ElementsAre("core", "device", "field", "loop", "mode"));
  EXPECT_THAT(arrows.at("file"), ElementsAre("core", "field", "file"));
}

TEST(Arrows, AnIncludeAgainstThemIsSeen) {
  const Arrows arrows = arrows_of(small_page);
  const auto wrong = [&](const char* path, const char* text) { return wrong_includes(arrows, path, text); };
  EXPECT_THAT(wrong("palpa/mode/a.h", "#include \"palpa/field/grid.h\"\n#include <vector>\n"), IsEmpty());
  EXPECT_THAT(wrong("palpa/field/a.h", "#pragma once\n #  include \"palpa/mode/mode.h\""),
              ElementsAre(HasSubstr("mode.h, against")));
  EXPECT_THAT(wrong("palpa/field/a.cpp", "#include <palpa/device/hand.h>"), SizeIs(1));
  EXPECT_THAT(wrong("palpa/field/a.cpp", "#include \"palpa/palpa.h\""), SizeIs(1));
  EXPECT_THAT(wrong("palpa/field/a.cpp", "#include \"palpa/version.h\""), IsEmpty());
  EXPECT_THAT(wrong("palpa/field/a.cpp", "#include \"grid.h\""), SizeIs(1));
  EXPECT_THAT(wrong("palpa/field/a.cpp", "#include \"../mode/mode.h\""), SizeIs(1));
  EXPECT_THAT(wrong("palpa/new/a.cpp", ""), SizeIs(1)) << "a layer that the page does not know";
  EXPECT_THAT(wrong("palpa/palpa.h", "#include \"palpa/loop/loop.h\""), IsEmpty());
}

TEST(Arrows, AnIncludeOfAForeignLibraryIsSeen) {
  const Arrows arrows = arrows_of(small_page);
  const auto wrong = [&](const char* path, const char* text) { return wrong_includes(arrows, path, text); };
  EXPECT_THAT(wrong("reader/vtk.cpp", "#include <vtkImageData.h>\n#include <itkImage.h>"), IsEmpty());
  EXPECT_THAT(wrong("palpa/file/a.cpp", "#include <vtkImageData.h>"), SizeIs(1));
  EXPECT_THAT(wrong("app/a.cpp", "#include <itkImage.h>"), SizeIs(1));
  EXPECT_THAT(wrong("explorer/a.h", "#include <QWidget>\n#include <vtkProp.h>"), IsEmpty());
  EXPECT_THAT(wrong("explorer/a.cpp", "#include <itkImage.h>"), SizeIs(1));
  EXPECT_THAT(wrong("palpa/vtk/a.h", "#include <vtkImageData.h>"), IsEmpty());
  EXPECT_THAT(wrong("palpa/vtk/a.h", "#include <itkImage.h>"), SizeIs(1));
  EXPECT_THAT(wrong("app/a.cpp", "#include <QWidget>"), SizeIs(1));
  EXPECT_THAT(wrong("palpa/mode/a.cpp", "#include <toml++/toml.h>"), IsEmpty());
  EXPECT_THAT(wrong("palpa/mode/a.h", "#include <toml++/toml.h>"), SizeIs(1)) << "a public header";
  EXPECT_THAT(wrong("palpa/mode/a.h", "#include <queue>\n#include <sys/types.h>"), IsEmpty());
  EXPECT_THAT(wrong("palpa/core/a.cpp", "#include <fmt/format.h>"), SizeIs(1)) << "core";
  EXPECT_THAT(wrong("reader/a.cpp", "#include \"palpa/file/protocol.h\""), IsEmpty());
  EXPECT_THAT(wrong("reader/a.cpp", "#include \"palpa/file/read_volume.h\""), SizeIs(1));
  EXPECT_THAT(wrong("reader/a.cpp", "#include \"palpa/mode/mode.h\""), SizeIs(1));
}

TEST(Arrows, HoldInTheSources) {
  const Arrows arrows = arrows_of(text_of(repository() / "docs/design.md"));
  ASSERT_THAT(arrows.at("study"), Contains("core")) << "the page's table was not understood";
  int files = 0;
  for (const char* folder : {"palpa", "reader", "app", "explorer", "python"}) {
    for (const std::string& file : files_under(folder, {".h", ".cpp"})) {
      EXPECT_THAT(wrong_includes(arrows, file, text_of(repository() / file)), IsEmpty());
      ++files;
    }
  }
  EXPECT_GT(files, 50) << "the sources were not found";
}

/// The headers that are installed, from palpa/ on: what palpa/CMakeLists.txt lists, and the one that is made.
std::vector<std::string> installed_headers(const std::string& cmake) {
  static const std::regex list(R"re(palpa_install_headers\(([^)]*)\))re"), header("[a-z_0-9/]+[.]h");
  std::vector<std::string> headers{"version.h"};
  for (std::sregex_iterator at(cmake.begin(), cmake.end(), list), end; at != end; ++at) {
    const std::string listed = (*at)[1];
    headers.insert(headers.end(), std::sregex_token_iterator(listed.begin(), listed.end(), header), {});
  }
  return headers;
}

TEST(InstalledHeaders, AreReadFromTheirList) {
  EXPECT_THAT(
      installed_headers("if(A)\n  palpa_install_headers(\n    a.h b/c_d.h\n    e/f3.h)\nendif()\npalpa_install_headers(g/h.h)"),
      ElementsAre("version.h", "a.h", "b/c_d.h", "e/f3.h", "g/h.h"));
}

TEST(InstalledHeaders, IncludeOneAnotherAloneAndAreOnThePageForTheirUsers) {
  static const std::regex include(R"re(#include [<"]palpa/([^>"]+)[>"])re");
  const std::vector<std::string> headers = installed_headers(text_of(repository() / "palpa/CMakeLists.txt"));
  ASSERT_THAT(headers, Contains("palpa.h"));
  EXPECT_LE(headers.size(), 30u);
  const std::string page = text_of(repository() / "docs/embedding.md");
  for (const std::string& header : headers) {
    EXPECT_THAT(page, HasSubstr('`' + header + '`')) << "docs/embedding.md";
    if (header == "version.h") continue;
    const std::string text = text_of(repository() / "palpa" / header);
    for (std::sregex_iterator at(text.begin(), text.end(), include), end; at != end; ++at)
      EXPECT_THAT(headers, Contains((*at)[1].str())) << header << " includes what is not installed";
  }
}

TEST(InstalledHeaders, OfTheComponentVtkIncludeNothingThatIsNot) {
  static const std::regex include(R"re(#include [<"]palpa/([^>"]+)[>"])re"), list(R"re(foreach\(header ([^)]*)\))re"),
      header("[a-z_0-9/]+[.]h");
  const std::string cmake = text_of(repository() / "palpa/CMakeLists.txt");
  std::smatch listed;
  ASSERT_TRUE(std::regex_search(cmake, listed, list));
  const std::string words = listed[1];
  const std::vector<std::string> own{std::sregex_token_iterator(words.begin(), words.end(), header), {}};
  std::vector<std::string> known = installed_headers(cmake);
  known.insert(known.end(), own.begin(), own.end());
  ASSERT_THAT(own, Contains("vtk/from_vtk.h"));
  const std::string page = text_of(repository() / "docs/embedding.md");
  for (const std::string& name : own) {
    EXPECT_THAT(page, HasSubstr('`' + name + '`')) << "docs/embedding.md";
    const std::string text = text_of(repository() / "palpa" / name);
    for (std::sregex_iterator at(text.begin(), text.end(), include), end; at != end; ++at)
      EXPECT_THAT(known, Contains((*at)[1].str())) << name << " includes what is not installed";
  }
}

TEST(Units, AreKnownByTheEndOfAName) {
  for (const char* name : {"position_m", "stiffness_n_per_m", "damping_ns_per_m", "per_s", "tick_us_p99", "force_max_n",
                           "error_bound_max_m", "ticks_per_s", "circulation_m2_per_s", "angle_deg", "newtons"}) {
    EXPECT_TRUE(ends_with_unit(name)) << name;
  }
  for (const char* name :
       {"position", "m", "s", "forcen", "stiffness_per", "drag_ns", "item_mass", "m_x", "strength_n_", "share"}) {
    EXPECT_FALSE(ends_with_unit(name)) << name;
  }
}

TEST(Units, ANumberWithoutOneIsSeen) {
  EXPECT_THAT(names_of(unitless_numbers("struct A { double length; double width_m; };")), ElementsAre("length"));
  EXPECT_THAT(names_of(unitless_numbers("struct A { double a = 0.0, b_m = 1, c{2}; std::optional<double> d; };")),
              ElementsAre("a", "c", "d"));
  EXPECT_THAT(names_of(unitless_numbers("namespace n { Vec3 place(const Vec3& from, double by_m); }")),
              ElementsAre("place", "from"));
  EXPECT_THAT(names_of(unitless_numbers("class A { double hidden; public: A(float given); private: double hidden_too; };")),
              ElementsAre("given"));
  EXPECT_THAT(names_of(unitless_numbers("class A { public: void f(B b = {}, double x = {}) { double local; } double y; };")),
              ElementsAre("x", "y"));
  EXPECT_THAT(names_of(unitless_numbers("template <class T> struct A { std::vector<T> t{1, 2}; std::span<const double> w; };")),
              ElementsAre("w"));
  EXPECT_EQ(unitless_numbers("\n\nstruct A {\n  double length;\n};").at(0).line, 4);
}

TEST(Units, ACommentCanSayOne) {
  EXPECT_THAT(unitless_numbers("struct A {\n  double share;  ///< [1] of all\n  Vec3 slope;  ///< [unit/m]\n};"), IsEmpty());
  EXPECT_THAT(unitless_numbers("struct A {\n  double value;  ///< in the field's own unit\n};"), IsEmpty());
  EXPECT_THAT(unitless_numbers("/// Share [1] of all.\ndouble share();"), IsEmpty());
  EXPECT_THAT(unitless_numbers("/// \\param f  [1] factor\nvoid stretch(double f);"), IsEmpty());
  EXPECT_THAT(unitless_numbers("/// Stretched by `f` [1].\nvoid stretch(double f);"), IsEmpty());

  EXPECT_THAT(unitless_numbers("struct A {\n  double share;  ///< of all\n};"), SizeIs(1)) << "no unit";
  EXPECT_THAT(unitless_numbers("struct A {\n  double share;  ///< [0, 1]\n};"), SizeIs(1)) << "a range is no unit";
  EXPECT_THAT(unitless_numbers("struct A {\n  double a;  ///< [1]\n  double b;\n};"), SizeIs(1)) << "the neighbour's";
  EXPECT_THAT(unitless_numbers("/// Stretched [1].\nvoid stretch(double f);"), SizeIs(1)) << "not the parameter's";
}

TEST(Units, WhatIsNotPublicIsLeftAlone) {
  EXPECT_THAT(unitless_numbers("namespace palpa::detail { double x(double y); }"), IsEmpty());
  EXPECT_THAT(unitless_numbers("namespace palpa { namespace detail { struct A { double b; }; } }"), IsEmpty());
  EXPECT_THAT(unitless_numbers("// double a;\n/* double b; */ #define C double c;\nconst char* d = \"double e;\";"), IsEmpty());
  EXPECT_THAT(unitless_numbers("virtual void number(const Info&, double&) {}\nusing F = std::function<void(double)>;"),
              IsEmpty());
}

TEST(Units, AreSaidInThePublicHeaders) {
  int headers = 0;
  for (const std::string& file : files_under("palpa", {".h"})) {
    if (file == "palpa/core/vec3.h") continue;  // vectors of any unit: whoever holds one says it
    for (const UnitlessNumber& number : unitless_numbers(text_of(repository() / file))) {
      ADD_FAILURE()
          << file << ':' << number.line << ": '" << number.name
          << "' does not say its unit; end the name with it, or say it in the comment: [1], [N], the field's own unit";
    }
    ++headers;
  }
  EXPECT_GT(headers, 25) << "the headers were not found";
}

std::vector<std::string> names_of(const std::vector<FunctionLength>& functions) {
  std::vector<std::string> names;
  for (const FunctionLength& function : functions) names.push_back(function.name);
  return names;
}

TEST(Sizes, FunctionsAreFoundWithTheirLines) {
  const char* source = R"(namespace n {
struct A {
  int a() const {
    return 1;
  }
  double b = f({1.0});
  enum class C { d, e };
 private:
  std::vector<int> g{1, 2};
};
template <class T>
A::A(int x)
    : x_(x) {
  const auto inner = [&](int y) { return y; };
  if (x > 0) { inner(1); }
}
constexpr int table[] = {f(1), 2};
}  // namespace n
)";
  const std::vector<FunctionLength> functions = functions_of(source);
  EXPECT_THAT(names_of(functions), ElementsAre("a", "A"));
  EXPECT_EQ(functions.at(0).line, 3);
  EXPECT_EQ(functions.at(0).lines, 3);
  EXPECT_EQ(functions.at(1).lines, 6);
}

TEST(Tick, HasShortFunctions) {
  int functions = 0;
  for (const std::string& file : files_under("palpa/tick", {".h", ".cpp"})) {
    for (const FunctionLength& function : functions_of(text_of(repository() / file))) {
      EXPECT_LE(function.lines, 60) << file << ':' << function.line << ": " << function.name;
      ++functions;
    }
  }
  EXPECT_GT(functions, 100) << "the sources were not found";
}

/// The words of a source that open a file, map one or give one a name: calls of the system and of C, streams, classes of Qt.
std::vector<std::string> words_that_open_files(const std::string& source) {
  static const std::set<std::string> always{
      "fopen",   "freopen",      "fdopen", "gzopen",    "openat",         "creat",        "mkstemp",   "mkostemp",
      "tmpfile", "memfd_create", "mmap",   "linkat",    "renameat",       "renameat2",    "ifstream",  "ofstream",
      "fstream", "filebuf",      "QFile",  "QSaveFile", "QTemporaryFile", "QImageWriter", "copy_file", "parse_file"};
  static const std::set<std::string> of_the_system{"open", "rename", "link",
                                                   "symlink"};  // as ::open; others have such names, too
  const std::vector<Token> tokens = lex(source).tokens;
  std::vector<std::string> found;
  for (std::size_t i = 0; i < tokens.size(); ++i) {
    const std::string& word = tokens[i].text;
    const bool global = i > 0 && tokens[i - 1].text == "::" &&
                        (i < 2 || !is_word(tokens[i - 2].text) || tokens[i - 2].text == "return" ||
                         tokens[i - 2].text == "fs" || tokens[i - 2].text == "filesystem");
    if (always.contains(word) || (global && of_the_system.contains(word))) found.push_back(word);
  }
  return found;
}

TEST(Files, WordsThatOpenThemAreSeen) {
  EXPECT_THAT(words_that_open_files("std::ifstream in(path); int d = ::open(p, O_RDONLY); fs::rename(a, b); QFile f(n);"),
              ElementsAre("ifstream", "open", "rename", "QFile"));
  EXPECT_THAT(words_that_open_files("return ::open(p);"), ElementsAre("open"));
  EXPECT_THAT(words_that_open_files(
                  "// fopen(\nvoid A::open() { link->open(); reader.open(x); backend::open(s); }\n#include <fstream>"),
              IsEmpty());
}

// docs/design.md §3: one way in, one way out.
TEST(Files, AreOpenedInOnePlace) {
  const std::map<std::string, std::string> others{
      {"palpa/trace/writer.cpp", "rows of a recording, which must be there when the process is killed"},
      {"palpa/file/shared_memory.cpp", "memory that is shared with palpa-read"},
      {"palpa/file/protocol_memory.cpp", "the same memory, mapped"},
      {"palpa/file/raw_file.cpp", "memory in large pages"},
      {"palpa/limits/free_memory.cpp", "what the system tells of its memory"},
      {"palpa/file/reader_process.cpp", "what the system tells of palpa-read"},
      {"reader/serve.cpp", "what the system tells of this process"},
      {"reader/cage.cpp", "whether the cage keeps a file closed"}};
  std::set<std::string> seen;
  for (const char* folder : {"palpa", "reader", "app", "explorer", "devices"}) {
    for (const std::string& file : files_under(folder, {".h", ".cpp"})) {
      if (file.starts_with("palpa/disk/")) continue;
      const std::vector<std::string> words = words_that_open_files(text_of(repository() / file));
      if (!words.empty()) seen.insert(file);
      if (others.contains(file)) continue;
      EXPECT_THAT(words, IsEmpty()) << file << ": use palpa/disk/input_file.h or new_file.h";
    }
  }
  for (const auto& [file, reason] : others) EXPECT_THAT(seen, Contains(file)) << "opens nothing any more: " << reason;
}

/// Words that write or read numbers as the program's locale says.
std::vector<std::string> words_that_obey_a_locale(const std::string& source) {
  static const std::set<std::string> words{"snprintf",     "sprintf",      "vsnprintf",     "vsprintf",     "asprintf",
                                           "strtod",       "strtof",       "strtold",       "atof",         "stod",
                                           "stof",         "stold",        "sscanf",        "fscanf",       "put_money",
                                           "setprecision", "stringstream", "ostringstream", "istringstream"};
  std::vector<std::string> found;
  for (const Token& token : lex(source).tokens) {
    if (words.contains(token.text)) found.push_back(token.text);
  }
  return found;
}

TEST(Numbers, WordsThatObeyALocaleAreSeen) {
  EXPECT_THAT(words_that_obey_a_locale("char t[9]; std::snprintf(t, 9, \"%g\", x); double y = std::stod(t); // strtod"),
              ElementsAre("snprintf", "stod"));
  EXPECT_THAT(words_that_obey_a_locale("std::from_chars(a, b, x); detail::text(\"%g\", x);"), IsEmpty());
}

// palpa/core/printed.h: no number that leaves the process, or is read, depends on the locale. palpa-read is a process of its
// own that never asks for one.
TEST(Numbers, AreWrittenAndReadWithoutTheLocale) {
  const std::map<std::string, std::string> others{
      {"palpa/core/printed.cpp", "where printf is held to the C locale"},
      {"palpa/file/reader_process.cpp", "whole numbers of the system, which have no separators"},
      {"palpa/view/offscreen.cpp", "words of a sentence"},
      {"palpa/device/open_device.cpp", "toml++ writes its numbers with to_chars"},
      {"app/reference.cpp", "words of the command line"},
      {"devices/inverse3.cpp", "Boost writes an address in the classic locale"},
      {"devices/inverse3_connection.cpp", "Boost writes an address in the classic locale"}};
  std::set<std::string> seen;
  for (const char* folder : {"palpa", "app", "explorer", "devices", "python"}) {
    for (const std::string& file : files_under(folder, {".h", ".cpp"})) {
      const std::vector<std::string> words = words_that_obey_a_locale(text_of(repository() / file));
      if (!words.empty()) seen.insert(file);
      if (others.contains(file)) continue;
      EXPECT_THAT(words, IsEmpty()) << file << ": use detail::text, to_chars or from_chars";
    }
  }
  for (const auto& [file, reason] : others) EXPECT_THAT(seen, Contains(file)) << "needs no exception any more: " << reason;
}

// What the program says is cleaned where it is printed.
TEST(Terminal, IsWrittenToInOnePlace) {
  static const std::set<std::string> words{"printf",  "fprintf", "vprintf", "puts", "fputs",
                                           "putchar", "fwrite",  "cout",    "cerr"};
  const std::set<std::string> writers{"app/terminal.cpp", "app/live_terminal.cpp"};
  int tokens_seen = 0;
  for (const std::string& file : files_under("app", {".h", ".cpp"})) {
    if (writers.contains(file)) continue;
    const std::vector<Token> tokens = lex(text_of(repository() / file)).tokens;
    for (std::size_t i = 0; i < tokens.size(); ++i, ++tokens_seen) {
      const bool of_fmt = i > 1 && tokens[i].text == "print" && tokens[i - 1].text == "::" && tokens[i - 2].text == "fmt";
      EXPECT_FALSE(of_fmt || words.contains(tokens[i].text))
          << file << ':' << tokens[i].line << ": " << tokens[i].text << "; use print or tell (app/terminal.h)";
    }
  }
  EXPECT_GT(tokens_seen, 5000) << "the sources were not found";
}

/// Targets of the links of a page that lead to a file, without the part behind '#'.
std::vector<std::string> linked_files(const std::string& markdown) {
  static const std::regex link(R"re(\]\(([^)#:\s]+)(#[^)]*)?\))re");
  return {std::sregex_token_iterator(markdown.begin(), markdown.end(), link, 1), {}};
}

TEST(Pages, LinksAreFound) {
  EXPECT_THAT(linked_files("see [a](docs/a.md) and [b](b.md#part), not [c](https://c.org) or [d](#here)"),
              ElementsAre("docs/a.md", "b.md"));
}

TEST(Pages, LinkToFilesThatAreThere) {
  std::vector<std::string> pages = files_under("docs", {".md"});
  for (const auto& entry : fs::directory_iterator(repository())) {
    if (entry.path().extension() == ".md") pages.push_back(entry.path().filename().string());
  }
  ASSERT_THAT(pages, Contains("README.md"));
  for (const std::string& page : pages) {
    for (const std::string& target : linked_files(text_of(repository() / page))) {
      EXPECT_TRUE(fs::exists(repository() / fs::path(page).parent_path() / target)) << page << " links to " << target;
    }
  }
}

/// The anchors of a page's headings, as GitHub makes them.
std::vector<std::string> anchors_of(const std::string& markdown) {
  std::vector<std::string> anchors;
  std::istringstream lines(markdown);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t begin = line.find_first_not_of('#');
    if (begin == 0 || begin == std::string::npos || line[begin] != ' ') continue;
    std::string anchor;
    for (const char c : line.substr(begin + 1)) {
      const auto letter = static_cast<unsigned char>(c);
      if (c == ' ') {
        anchor += '-';
      } else if (std::isalnum(letter) || c == '-' || c == '_' || letter >= 0x80) {
        anchor += static_cast<char>(std::tolower(letter));
      }
    }
    anchors.push_back(anchor);
  }
  return anchors;
}

TEST(Pages, AnchorsAreThoseOfTheirHeadings) {
  EXPECT_THAT(anchors_of("# VTK's own formats\n## 2. Words\ntext # no\n### `[time]`"),
              ElementsAre("vtks-own-formats", "2-words", "time"));
}

TEST(Pages, LinkToHeadingsThatAreThere) {
  static const std::regex link(R"re(\]\(([^)#:\s]*)#([^)\s]+)\))re");
  std::vector<std::string> pages = files_under("docs", {".md"});
  pages.insert(pages.end(), {"README.md", "CONTRIBUTING.md"});
  int links = 0;
  for (const std::string& page : pages) {
    const std::string text = text_of(repository() / page);
    for (std::sregex_iterator at(text.begin(), text.end(), link), end; at != end; ++at, ++links) {
      const fs::path target = (*at)[1].length() == 0 ? fs::path(page) : fs::path(page).parent_path() / (*at)[1].str();
      EXPECT_THAT(anchors_of(text_of(repository() / target)), Contains((*at)[2].str())) << page << ": " << at->str();
    }
  }
  EXPECT_GT(links, 10) << "no links to headings were found";
}

/// The tests that a page names as [`Suite.Name`](../tests/…) and that are not in the file it links to.
std::vector<std::string> missing_tests(const std::string& markdown,
                                       const std::function<std::string(const std::string&)>& text_of_link) {
  static const std::regex named(R"re(\[`(\w+)\.(\w+)`\]\(([^)\s]+)\))re");
  std::vector<std::string> missing;
  for (std::sregex_iterator at(markdown.begin(), markdown.end(), named), end; at != end; ++at) {
    const std::regex defined("TEST(_F|_P)?\\(" + (*at)[1].str() + ", *" + (*at)[2].str() + "\\)");
    if (!std::regex_search(text_of_link((*at)[3]), defined)) missing.push_back((*at)[1].str() + '.' + (*at)[2].str());
  }
  return missing;
}

TEST(Pages, ATestThatIsNotThereIsSeen) {
  const auto text = [](const std::string&) { return std::string("TEST(A, IsThere) {\nTEST_F(A, Too) {"); };
  EXPECT_THAT(missing_tests("[`A.IsThere`](a.cpp), [`A.Too`](a.cpp), [`A.IsNot`](a.cpp), [`A.Is`](a.cpp)", text),
              ElementsAre("A.IsNot", "A.Is"));
}

TEST(Pages, NameTestsThatAreThere) {
  const auto text_of_link = [](const std::string& link) { return text_of(repository() / "docs" / link); };
  EXPECT_THAT(missing_tests(text_of(repository() / "docs/path.md"), text_of_link), IsEmpty());
  const std::string theory = text_of(repository() / "docs/theory.md");
  EXPECT_THAT(missing_tests(theory, text_of_link), IsEmpty());
  // Every "Checked by" names one.
  static const std::regex checked("[*]Checked by[*] (.{0,3})");
  int statements = 0;
  for (std::sregex_iterator at(theory.begin(), theory.end(), checked), end; at != end; ++at, ++statements)
    EXPECT_EQ((*at)[1].str().substr(0, 2), "[`") << at->str();
  EXPECT_GT(statements, 20);
}

std::ptrdiff_t words_in(const std::string& text) {
  std::istringstream words(text);
  return std::distance(std::istream_iterator<std::string>(words), std::istream_iterator<std::string>());
}

/// The paragraphs and cells of tables in a page that are too long to be read, and the cells with too many links.
std::vector<std::string> too_long(const std::string& markdown) {
  constexpr std::ptrdiff_t most_of_a_paragraph = 250, most_of_a_cell = 100, most_links = 10;
  static const std::regex link(R"re(\]\()re");
  std::vector<std::string> found;
  std::istringstream lines(markdown);
  bool in_code = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("```")) in_code = !in_code;
    if (in_code) continue;
    const bool is_row = line.starts_with("|");
    std::istringstream parts(line);
    for (std::string part; std::getline(parts, part, is_row ? '|' : '\n');) {
      const auto links = std::distance(std::sregex_iterator(part.begin(), part.end(), link), std::sregex_iterator());
      if (words_in(part) > (is_row ? most_of_a_cell : most_of_a_paragraph) || (is_row && links > most_links))
        found.push_back(part.substr(0, 60));
    }
  }
  return found;
}

TEST(Pages, ALongCellAndALongParagraphAreSeen) {
  std::string words, links;
  for (int n = 0; n < 101; ++n) words += "word ";
  for (int n = 0; n < 11; ++n) links += "[a](b) ";
  EXPECT_THAT(too_long("| " + words + "| b |\n"), SizeIs(1));
  EXPECT_THAT(too_long("| a | " + links + "|\n"), SizeIs(1));
  EXPECT_THAT(too_long(words + links + "\n"), IsEmpty());
  EXPECT_THAT(too_long(words + words + words + "\n"), SizeIs(1));
  EXPECT_THAT(too_long("```\n" + words + words + words + "\n```\n"), IsEmpty());
}

TEST(Pages, HaveNoCellAndNoParagraphThatIsTooLong) {
  std::vector<std::string> pages = files_under("docs", {".md"});
  pages.insert(pages.end(), {"README.md", "CONTRIBUTING.md"});
  for (const std::string& page : pages) EXPECT_THAT(too_long(text_of(repository() / page)), IsEmpty()) << page;
}

TEST(Pages, GiveAReasonForEveryPackage) {
  const std::string reasons = text_of(repository() / "docs/dependencies.md");
  std::istringstream lines(text_of(repository() / "packages.txt"));
  int packages = 0;
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line[0] == '#' || line[0] == '[') continue;
    EXPECT_THAT(reasons, HasSubstr('`' + line + '`'));
    ++packages;
  }
  EXPECT_GT(packages, 10);
}

}  // namespace architecture_test
}  // namespace palpa::architecture
