// Force figures of the four scenes with real data and of five suggested scenes of files: a table for each, a table of the
// worst, and optional pictures.
//
//   bench_felt [--part NAME]… [--scene NAME]… [--scenes FOLDER] [--pictures FOLDER] DATA_FOLDER
//
// Without --part all parts, without --scene all scenes. A file NAME.toml in the folder of --scenes replaces a suggested scene:
// the scenes of another version on this engine. The tables are the Markdown of docs/felt.md.
#include "bench/felt.h"

#include <algorithm>
#include <cstdio>

namespace {

using namespace palpa::bench;
using palpa::LoadError;

struct Part {
  const char* name;
  std::vector<Figure> (*measure)(const FeltScene&);
};
constexpr Part parts[] = {{"slides", slides},       {"tremor", tremor},   {"breaks", breaks},
                          {"stiffness", stiffness}, {"normals", normals}, {"held", held}};
constexpr const char* released_part = "letgo";

struct Wanted {
  std::vector<std::string> parts, scenes;
  std::filesystem::path scenes_folder, pictures, data;
};

bool is_wanted(const std::vector<std::string>& names, const std::string& name) {
  return names.empty() || std::find(names.begin(), names.end(), name) != names.end();
}

int usage() {
  std::fprintf(
      stderr, "usage: bench_felt [--part NAME]... [--scene NAME]... [--scenes FOLDER] [--pictures FOLDER] DATA_FOLDER\nparts:");
  for (const Part& part : parts) std::fprintf(stderr, " %s", part.name);
  std::fprintf(stderr, " %s\nscenes:", released_part);
  for (const std::string& name : felt_scene_names()) std::fprintf(stderr, " %s", name.c_str());
  std::fprintf(stderr, "\n");
  return 2;
}

bool read_arguments(int argc, char** argv, Wanted& wanted) {
  for (int i = 1; i < argc; ++i) {
    const std::string argument = argv[i];
    const bool more = i + 1 < argc;
    if (argument == "--part" && more) {
      wanted.parts.emplace_back(argv[++i]);
    } else if (argument == "--scene" && more) {
      wanted.scenes.emplace_back(argv[++i]);
    } else if (argument == "--scenes" && more) {
      wanted.scenes_folder = argv[++i];
    } else if (argument == "--pictures" && more) {
      wanted.pictures = argv[++i];
    } else if (!argument.starts_with("-") && wanted.data.empty()) {
      wanted.data = argument;
    } else {
      return false;
    }
  }
  const auto is_part = [](const std::string& name) {
    return name == released_part ||
           std::any_of(std::begin(parts), std::end(parts), [&](const Part& p) { return name == p.name; });
  };
  const std::vector<std::string> scenes = felt_scene_names();
  return !wanted.data.empty() && std::all_of(wanted.parts.begin(), wanted.parts.end(), is_part) &&
         std::all_of(wanted.scenes.begin(), wanted.scenes.end(),
                     [&](const std::string& name) { return std::find(scenes.begin(), scenes.end(), name) != scenes.end(); });
}

const char* verdict(const Figure& figure) {
  if (!figure.applies || figure.asked.empty()) return "-";
  return figure.met ? "yes" : "**no**";
}

void print_table(const std::vector<Figure>& figures) {
  std::printf("| figure | measured | asked | met |\n|---|---|---|---|\n");
  for (const Figure& figure : figures)
    std::printf("| %s | %s | %s | %s |\n", figure.name.c_str(), figure.measured.c_str(),
                figure.asked.empty() ? "-" : figure.asked.c_str(), verdict(figure));
  std::printf("\n");
}

/// The worst of each figure over all scenes.
class Overview {
 public:
  void add(const std::string& scene, const Figure& figure) {
    const auto known = std::find_if(lines_.begin(), lines_.end(), [&](const Line& l) { return l.worst.name == figure.name; });
    Line& line = known == lines_.end() ? lines_.emplace_back(Line{.worst = figure, .scene = scene}) : *known;
    if (!figure.applies) return;
    ++line.scenes;
    line.met += figure.met;
    if (!line.worst.applies || figure.badness > line.worst.badness) {
      line.worst = figure;
      line.scene = scene;
    }
  }
  void print() const {
    std::printf("| figure | worst measured | in | asked | met |\n|---|---|---|---|---|\n");
    for (const Line& line : lines_) {
      std::printf("| %s | %s | %s | %s | ", line.worst.name.c_str(), line.worst.measured.c_str(), line.scene.c_str(),
                  line.worst.asked.empty() ? "-" : line.worst.asked.c_str());
      line.worst.asked.empty() ? std::printf("- |\n") : std::printf("%d of %d |\n", line.met, line.scenes);
    }
  }

 private:
  struct Line {
    Figure worst;
    std::string scene;
    int scenes = 0, met = 0;
  };
  std::vector<Line> lines_;
};

void measure(const Wanted& wanted) {
  Overview overview;
  const auto scenes = felt_scene_names();
  const bool any_of_scene =
      wanted.parts.empty() || wanted.parts != std::vector<std::string>{released_part} || !wanted.pictures.empty();
  for (const std::string& name : scenes) {
    if (!is_wanted(wanted.scenes, name) || !any_of_scene) continue;
    const FeltScene felt = load_felt_scene(name, PALPA_SCENES_FOLDER, wanted.data, wanted.scenes_folder);
    std::vector<Figure> figures;
    for (const Part& part : parts) {
      if (!is_wanted(wanted.parts, part.name)) continue;
      const std::vector<Figure> found = part.measure(felt);
      figures.insert(figures.end(), found.begin(), found.end());
    }
    std::printf("### %s (%s)\n\n", name.c_str(), felt.origin.c_str());
    print_table(figures);
    for (const Figure& figure : figures) overview.add(name, figure);
#ifdef PALPA_BENCH_PICTURES
    if (!wanted.pictures.empty()) save_felt_picture(felt, wanted.pictures / ("felt-" + name + ".png"));
#endif
  }
  if (is_wanted(wanted.parts, released_part)) {
    const std::vector<Figure> figures = released_device_figures();
    std::printf("### devices let go\n\n");
    print_table(figures);
    for (const Figure& figure : figures) overview.add("a plane", figure);
  }
  std::printf("### all\n\n");
  overview.print();
}

}  // namespace

int main(int argc, char** argv) {
  std::setvbuf(stdout, nullptr, _IOLBF, 0);
  Wanted wanted;
  if (!read_arguments(argc, argv, wanted)) return usage();
  try {
#ifndef PALPA_BENCH_PICTURES
    if (!wanted.pictures.empty()) throw LoadError("--pictures: was built without pictures; configure with PALPA_VIEW");
#endif
    if (!wanted.pictures.empty()) std::filesystem::create_directories(wanted.pictures);
    measure(wanted);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "bench_felt: %s\n", error.what());
    return 2;
  }
  return 0;
}
