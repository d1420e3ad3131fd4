// palpa_reference_docs [--check] DOCS: the generated tables of the documentation, from the code's own tables.
//
// A table stands between two lines of a page:
//     <!-- generated: scene -->          the keys of scene files
//     <!-- generated: trace -->          the columns of a trace's files
//     <!-- generated: mode TYPE -->      the parameters of a mode
//     <!-- generated: limits -->         limits of files
//     <!-- end generated -->
// With --check nothing is written: exit 1 names every page that is not current.

#include <filesystem>
#include <fstream>
#include <iostream>
#include <set>
#include <sstream>
#include <stdexcept>

#include "palpa/base/limits.h"
#include "palpa/scene/load_scene.h"
#include "palpa/trace/trace.h"

namespace {

constexpr std::string_view begin_mark = "<!-- generated: ";
constexpr std::string_view end_of_mark = " -->\n";
constexpr std::string_view end_mark = "<!-- end generated -->";

std::string read(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error(path.string() + ": cannot be read");
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

std::string table(const std::string& what) {
  if (what == "scene") return palpa::scene_reference_markdown(palpa::standard_modes());
  if (what == "limits") return palpa::limits_reference_markdown();
  if (what == "trace") return palpa::trace_reference_markdown();
  if (what.starts_with("mode ")) {
    if (const palpa::Mode* mode = palpa::standard_modes().find(what.substr(5))) return palpa::mode_reference_markdown(*mode);
  }
  throw std::runtime_error("no table '" + what + "'; there are: scene, trace, limits, mode TYPE");
}

/// The page with new tables; `seen` collects the page's tables.
std::string made_anew(const std::string& page, std::set<std::string>& seen) {
  std::string out;
  std::size_t at = 0;
  for (;;) {
    const std::size_t begin = page.find(begin_mark, at);
    if (begin == std::string::npos) return out + page.substr(at);
    const std::size_t name = begin + begin_mark.size();
    const std::size_t name_end = page.find(end_of_mark, name);
    const std::size_t end = page.find(end_mark, name);
    if (name_end == std::string::npos || end == std::string::npos || end < name_end) {
      throw std::runtime_error("a generated table does not end; close it with " + std::string(end_mark));
    }
    const std::string what = page.substr(name, name_end - name);
    seen.insert(what);
    out += page.substr(at, name_end + end_of_mark.size() - at) + "\n" + table(what) + "\n";
    at = end;
  }
}

std::vector<std::filesystem::path> pages(const std::filesystem::path& docs) {
  std::set<std::filesystem::path> found;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(docs)) {
    if (entry.path().extension() == ".md") found.insert(entry.path());
  }
  return {found.begin(), found.end()};
}

int run(const std::filesystem::path& docs, bool check) {
  std::set<std::string> seen;
  int stale = 0;
  for (const std::filesystem::path& path : pages(docs)) {
    const std::string page = read(path);
    std::string anew;
    try {
      anew = made_anew(page, seen);
    } catch (const std::runtime_error& error) {
      throw std::runtime_error(path.string() + ": " + error.what());
    }
    if (anew == page) continue;
    if (check) {
      std::cerr << path.string() << ": a generated table is not current; run palpa_reference_docs " << docs.string() << "\n";
      ++stale;
    } else if (!(std::ofstream(path, std::ios::binary) << anew << std::flush)) {
      throw std::runtime_error(path.string() + ": cannot be written");
    }
  }
  std::set<std::string> wanted{"scene", "trace", "limits"};
  for (const palpa::Mode& mode : palpa::standard_modes().modes()) wanted.insert("mode " + std::string(mode.type()));
  for (const std::string& what : wanted) {
    if (seen.contains(what)) continue;
    std::cerr << docs.string() << ": no page has the table '" << what << "'\n";
    ++stale;
  }
  return stale == 0 ? 0 : 1;
}

}  // namespace

int main(int count, char** arguments) {
  const std::vector<std::string> given(arguments + 1, arguments + count);
  const bool check = !given.empty() && given.front() == "--check";
  if (given.size() != (check ? 2u : 1u)) {
    std::cerr << "usage: palpa_reference_docs [--check] DOCS\n";
    return 2;
  }
  try {
    return run(given.back(), check);
  } catch (const std::exception& error) {
    std::cerr << error.what() << "\n";
    return 2;
  }
}
