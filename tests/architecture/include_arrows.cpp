#include "include_arrows.h"

#include <regex>
#include <sstream>
#include <stdexcept>

namespace palpa::architecture {
namespace {

constexpr std::string_view arrow = "◄";

std::vector<std::string> words_of(const std::string& text) {
  static const std::regex word("[a-z]+");
  return {std::sregex_token_iterator(text.begin(), text.end(), word), {}};
}

/// Layer of a path; empty for files above the layers (palpa/palpa.h, palpa/version.cpp).
std::string layer_of(std::string_view path) {
  const bool library = path.starts_with("palpa/");
  if (library) path.remove_prefix(6);
  const auto slash = path.find('/');
  return slash == path.npos ? std::string() : std::string(path.substr(0, slash));
}

bool is_header(std::string_view path) { return path.ends_with(".h"); }

}  // namespace

Arrows arrows_of(std::string_view design_page) {
  Arrows arrows;
  std::istringstream lines{std::string(design_page)};
  std::string section;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("## ")) section = line;
    if (section.find("Layers") == section.npos || line.find(arrow) == line.npos) continue;
    const auto words = line.find("   ");  // what follows is for the reader
    std::string rest = line.substr(0, words);
    std::vector<std::string> seen;
    while (!rest.empty()) {
      const auto end = rest.find(arrow);
      const std::vector<std::string> group = words_of(rest.substr(0, end));
      if (group.empty()) throw std::invalid_argument("no layer beside an arrow in: " + line);
      for (const std::string& layer : group) {
        arrows[layer].insert(layer);
        arrows[layer].insert(seen.begin(), seen.end());
      }
      seen.insert(seen.end(), group.begin(), group.end());
      rest = end == rest.npos ? std::string() : rest.substr(end + arrow.size());
    }
  }
  for (bool grown = true; grown;) {
    grown = false;
    for (auto& [layer, sees] : arrows) {
      const std::set<std::string> before = sees;
      for (const std::string& other : before) sees.insert(arrows[other].begin(), arrows[other].end());
      grown = grown || sees.size() != before.size();
    }
  }
  return arrows;
}

std::vector<std::string> wrong_includes(const Arrows& arrows, std::string_view path, std::string_view text) {
  static const std::regex include(R"re(^[ \t]*#[ \t]*include[ \t]*([<"])([^>"]+)[>"])re", std::regex::multiline);
  static const std::regex vendor("^(vtk|itk|gdcm|Q[A-Z])");
  static const std::regex posix("^(sys/[a-z]+|unistd|fcntl|signal|spawn|poll)[.]h$");
  const std::string layer = layer_of(path);
  const bool library = path.starts_with("palpa/");
  std::vector<std::string> wrong;
  const auto complain = [&](const std::string& what) { wrong.push_back(std::string(path) + " includes " + what); };

  if (library && !layer.empty() && !arrows.contains(layer))
    wrong.push_back(std::string(path) + ": the design page has no layer " + layer);
  const std::string source(text);
  for (std::sregex_iterator it(source.begin(), source.end(), include), end; it != end; ++it) {
    const bool quoted = (*it)[1] == "\"";
    const std::string name = (*it)[2];
    if (name.starts_with("palpa/")) {
      const std::string other = layer_of(name);
      if (other.empty()) {
        if (!layer.empty() && library && name == "palpa/palpa.h") complain("palpa/palpa.h, which is for users");
      } else if (!layer.empty() && (!arrows.contains(layer) || !arrows.at(layer).contains(other))) {
        complain(name + ", against the arrows");
      } else if (layer == "reader" && other == "file" && name.find("protocol") == name.npos) {
        complain(name + ": of file, the reader knows the protocol alone");
      }
    } else if (library && quoted) {
      complain('"' + name + "\"; within the library headers are named from palpa/ on");
    } else if (std::regex_search(name, vendor)) {
      const bool pictures = (layer == "view" || layer == "report") && !is_header(path) && name.starts_with("vtk");
      const bool window = layer == "explorer" && (name.starts_with("vtk") || name.starts_with("Q"));
      const bool bridge = layer == "vtk" && name.starts_with("vtk");
      if (layer != "reader" && !pictures && !window && !bridge)
        complain('<' + name +
                 ">; VTK is known to reader, explorer and vtk, and to the sources of view and report; Qt to the explorer, ITK "
                 "and its "
                 "kin to the reader alone");
    } else if (layer == "solver" && name.find_first_of("./") != name.npos) {
      complain('<' + name + ">; solver needs the standard library alone");
    } else if (library && is_header(path) && name.find_first_of("./") != name.npos && !std::regex_search(name, posix)) {
      complain('<' + name + ">; a public header needs the standard library and POSIX alone");
    }
  }
  return wrong;
}

}  // namespace palpa::architecture
