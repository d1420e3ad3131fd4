#include "app/info.h"

#include <fmt/format.h>

#include <cstdio>
#include <fstream>
#include <string>

#include "app/info_text.h"
#include "app/pictures.h"
#include "app/terminal.h"
#include "palpa/scene/first_scene.h"
#include "palpa/scene/read_series.h"
#include "palpa/volume/directions.h"

namespace palpa::app {
namespace {

namespace fs = std::filesystem;

bool is_pattern(const fs::path& path) {
  std::error_code ignored;
  return path.filename().string().find_first_of("*?") != std::string::npos && !fs::exists(path, ignored);
}

/// The volumes that are asked for.
std::vector<Asked> asked_for(const InfoArguments& arguments) {
  std::vector<Asked> all;
  const auto add = [&](const fs::path& name, const std::vector<fs::path>& files) {
    all.push_back({name.string(), arguments.request, files.size() > 1});
    if (all.back().is_series && !arguments.request.files.empty()) {
      throw LoadError(name.string() + ": is a time series, whose files have no partners; leave out --with");
    }
    all.back().request.files.insert(all.back().request.files.begin(), files.begin(), files.end());
  };
  if (arguments.series) {
    add(arguments.files.front(), arguments.files);
    return all;
  }
  for (const fs::path& path : arguments.files) {
    if (!is_pattern(path)) {
      add(path, {path});
      continue;
    }
    const std::vector<fs::path> files = files_matching(path);
    if (files.empty()) throw LoadError(path.string() + ": no files match; check the folder and the pattern");
    add(path, files);
  }
  return all;
}

/// The first scene, to stdout or into a new file.
void suggest_scene(const Asked& asked, const InfoArguments& arguments) {
  const auto& [name, request, is_series] = asked;
  if (is_series) {
    throw LoadError(name +
                    ": is a time series; ask for the scene of one of its files, and give that scene 'files' and "
                    "'frame_period_s' instead of 'file'");
  }
  std::string text;
  try {
    VolumeFile file = read_volume_file(request, arguments.read);
    VolumeRequest felt = request;
    if (const auto directions = as_directions(request, file, arguments.read)) {
      felt = *directions;
      file = read_volume_file(felt, arguments.read);
    }
    text = first_scene(file.volume, felt);
  } catch (const LoadError& error) {
    const std::string problem = error.what();
    throw LoadError(problem.rfind(name, 0) == 0 ? problem : name + ": " + problem);
  }
  if (arguments.scene_file.empty()) {
    std::fputs(text.c_str(), stdout);
    return;
  }
  const std::string place = arguments.scene_file.string();
  if (fs::exists(arguments.scene_file)) throw LoadError(place + ": exists already; name a new file");
  std::ofstream file(arguments.scene_file, std::ios::binary);
  if (!(file << text).flush()) throw LoadError(place + ": cannot be written; name a file in a folder that may be written to");
}

void draw(const Facts& facts, const fs::path& file) {
  const auto field = field_to_feel(facts.file.volume, facts.values);
  if (!field) throw LoadError(facts.name + ": has no field that varies; there is nothing to draw");
  pictures_for(file.string()).volume(facts.file.volume, *field, facts.values[*field], facts.what, file);
}

}  // namespace

int run_info(const InfoArguments& arguments) {
  const auto all = asked_for(arguments);
  if (all.size() > 1 && (arguments.scene || !arguments.picture.empty())) {
    throw LoadError("info: --scene and --picture are of one file; name one");
  }
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Asked& asked : all) {
    if (arguments.scene) {
      suggest_scene(asked, arguments);
      if (arguments.picture.empty()) continue;
    }
    const Facts facts = facts_of(asked, arguments.read);
    if (!arguments.picture.empty()) draw(facts, arguments.picture);
    if (arguments.scene) continue;
    if (arguments.json) {
      list.push_back(as_json(facts, arguments.at_m, arguments.level));
      continue;
    }
    if (&asked != &all.front()) fmt::print("\n");
    print_words(facts, arguments.at_m, arguments.level);
    std::fflush(stdout);
    std::vector<std::string> warnings;
    for (const std::string& warning : facts.file.volume.warnings) warnings.push_back(asked.name + ": " + warning);
    print_warnings(warnings);
  }
  if (arguments.json && !arguments.scene) {
    const auto& printed = list.size() == 1 ? list.front() : list;
    fmt::print("{}\n", printed.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace));
  }
  return 0;
}

}  // namespace palpa::app
