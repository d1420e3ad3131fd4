#include "app/info.h"

#include <fmt/format.h>

#include <cstdio>
#include <string>
#include <utility>

#include "app/info_kind.h"
#include "app/info_numbers.h"
#include "app/info_store.h"
#include "app/info_table.h"
#include "app/pictures.h"
#include "app/terminal.h"
#include "palpa/base/web_address.h"
#include "palpa/data/read_series.h"
#include "palpa/scene/first_scene.h"

namespace palpa::app {
namespace {

namespace fs = std::filesystem;

bool is_pattern(const fs::path& path) {
  std::error_code ignored;
  return !is_web_address(path) && path.filename().string().find_first_of("*?") != std::string::npos &&
         !fs::exists(path, ignored);
}

/// Refuses Palpa's own files, traces and scenes, which are no data.
void refuse_our_own(const fs::path& path) {
  std::error_code ignored;
  const std::string name = path.string();
  if (fs::exists(path / "trace.toml", ignored))
    throw LoadError(name + ": is a trace, not data; see it with: palpa report " + name);
  if (path.extension() == ".toml" && fs::is_regular_file(path, ignored))
    throw LoadError(name + ": is a scene, not data; feel it with: palpa run " + name + " --hand sim:stroke");
}

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
      refuse_our_own(path);
      add(path, {path});
      continue;
    }
    const std::vector<fs::path> files = files_matching(path);
    if (files.empty()) throw LoadError(path.string() + ": no files match; check the folder and the pattern");
    add(path, files);
  }
  return all;
}

Facts read_facts(const Asked& asked, const ReadOptions& read, bool all_frames) {
  const Progress progress("reading " + asked.name);
  return facts_of(asked, read, all_frames);
}

/// Writes the first scene to stdout or a new file.
void suggest_scene(const Asked& asked, const Facts& facts, const InfoArguments& arguments) {
  if (asked.is_series) {
    throw LoadError(asked.name +
                    ": is a time series; ask for the scene of one of its files, and give that scene 'files' and "
                    "'frame_period_s' instead of 'file'");
  }
  std::string text;
  try {
    const Progress progress("looking for what can be felt in " + asked.name);
    const fs::path folder = arguments.scene_file.empty() ? fs::path(".") : fs::absolute(arguments.scene_file).parent_path();
    std::vector<std::pair<std::string, double>> labels;
    for (const FilePart& label : facts.file.contents.labels) labels.emplace_back(label.name, static_cast<double>(label.number));
    text = first_scene(facts.file.volume, asked.request, {.folder = folder, .labels = labels});
  } catch (const LoadError& error) {
    const std::string problem = error.what();
    throw LoadError(problem.rfind(asked.name, 0) == 0 ? problem : asked.name + ": " + problem);
  }
  if (arguments.scene_file.empty()) {
    print(text);
    return;
  }
  detail::write_whole(arguments.scene_file, text, arguments.existing);
}

void draw(const Facts& facts, const fs::path& file, detail::Existing existing) {
  const auto field = field_to_feel(facts.file.volume, facts.values);
  if (!field) throw LoadError(facts.name + ": has no field that varies; there is nothing to draw");
  const Progress progress("drawing " + file.string());
  const fs::path named = fs::path(facts.name).has_filename() ? fs::path(facts.name) : fs::path(facts.name).parent_path();
  const std::string tilt = gantry_tilt(facts);
  const std::string title = named.filename().string() + ": " + facts.what + (tilt.empty() ? "" : ", " + tilt);
  pictures_for(file.string()).volume(facts.file.volume, *field, facts.values[*field], title, file, existing);
}

/// Writes scene and picture of a volume, and reports the files and the next step on stderr.
void make_files(const Asked& asked, const Facts& facts, const InfoArguments& arguments) {
  if (arguments.scene) suggest_scene(asked, facts, arguments);
  if (!arguments.picture.empty()) draw(facts, arguments.picture, arguments.existing);
  for (const fs::path& file : {arguments.scene ? arguments.scene_file : fs::path(), arguments.picture}) {
    if (!file.empty()) tell("Wrote " + file.string() + "\n");
  }
  if (arguments.scene && !arguments.scene_file.empty()) {
    const std::string scene = for_shell(arguments.scene_file.string()), out = for_shell(arguments.scene_file.stem().string());
    tell("Next: palpa run " + scene + " --hand sim:stroke --out " + out + "\n");
  }
}

/// `make_files`, of directions and of vectors in arrays of their own as such.
void make_files_to_feel(Asked asked, Facts facts, const InfoArguments& arguments) {
  if (const auto otherwise = request_to_feel(asked, facts, arguments.read)) {
    asked.request = *otherwise;
    facts = read_facts(asked, arguments.read, false);
  }
  make_files(asked, facts, arguments);
}

/// `make_files` of a store that is felt through windows, or is read as a whole where it has no octaves and fits into memory.
void make_files_of_large(const Asked& asked, const InfoArguments& arguments) {
  Facts facts{.name = asked.name};
  {
    const Progress progress("reading " + asked.name);
    ReadOptions read = arguments.read;
    read.preview = false;  // which would be the store as a whole
    facts.file = read_volume_file(asked.request, read);
    for (const VolumeField& field : facts.file.volume.fields) facts.values.push_back(statistics(*field.field));
  }
  facts.what = "volume in octaves";
  make_files(asked, facts, arguments);
}

/// Prints a store that is too large to be read as a whole, or adds it to the list of JSON objects.
void print_large_store(const StoreFacts& store, const InfoArguments& arguments, bool is_further, nlohmann::ordered_json& list) {
  if (!arguments.at_m.empty() || !arguments.places.empty() || arguments.level) {
    throw LoadError(store.name +
                    ": is too large to be read as a whole, which --at and --level need; give the folder of a coarser octave of "
                    "it, or another memory_mb by --set");
  }
  InfoTable table = store_table(store);
  if (arguments.json) {
    list.push_back(std::move(table.json));
    return;
  }
  if (is_further) print("\n");
  print(table.words);
  if (arguments.files.size() == 1 && arguments.picture.empty())
    print(fmt::format("\n  next      palpa info {} --scene first.toml, to feel it\n", for_shell(store.name)));
  std::fflush(stdout);
  std::vector<std::string> warnings;
  for (const auto* all : {&store.contents.warnings, &store.places.warnings})
    for (const std::string& warning : *all) warnings.push_back(store.name + ": " + warning);
  print_warnings(warnings);
}

}  // namespace

int run_info(const InfoArguments& arguments) {
  const auto all = asked_for(arguments);
  if (all.size() > 1 && (arguments.scene || !arguments.picture.empty())) {
    throw LoadError("info: --scene and --picture are of one file; name one");
  }
  if (const std::string picture = arguments.picture.string(); !picture.empty() && arguments.picture.extension() != ".png")
    throw LoadError("--picture " + picture + ": is no name of a PNG file, which is what is drawn; write --picture " +
                    fs::path(picture).replace_extension(".png").string());
  std::vector<AskedPlace> places;
  for (const Vec3& at : arguments.at_m)
    places.push_back({AskedPlace::In::world, at, fmt::format("{},{},{}", at.x, at.y, at.z)});
  places.insert(places.end(), arguments.places.begin(), arguments.places.end());
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const Asked& asked : all) {
    const std::optional<StoreFacts> store = [&] {
      const Progress progress("looking for the chunks of " + asked.name);
      return store_facts_of(asked, arguments.read);
    }();
    if (store && store->is_large()) {
      if (arguments.scene || !arguments.picture.empty()) make_files_of_large(asked, arguments);
      if (arguments.scene) continue;
      print_large_store(*store, arguments, &asked != &all.front(), list);
      continue;
    }
    const Facts facts = read_facts(asked, options_for_whole(asked, arguments.read), !arguments.scene);
    for (const AskedPlace& place : places) world_of(place, facts);  // throws on unknown positions before anything is printed
    if (arguments.scene || !arguments.picture.empty()) make_files_to_feel(asked, facts, arguments);
    if (arguments.scene) continue;
    InfoTable table = info_table(facts, places, arguments.level);
    if (store) add_store(table, *store);
    if (arguments.json) {
      list.push_back(std::move(table.json));
      continue;
    }
    if (&asked != &all.front()) print("\n");
    print(table.words);
    if (all.size() == 1 && arguments.picture.empty() && !asked.is_series && field_to_feel(facts.file.volume, facts.values))
      print(fmt::format("\n  next      palpa info {} --scene first.toml, to feel it\n", for_shell(asked.name)));
    std::fflush(stdout);
    std::vector<std::string> warnings;
    for (const std::string& warning : facts.file.volume.warnings) warnings.push_back(asked.name + ": " + warning);
    if (store) {
      for (const std::string& warning : store->places.warnings) warnings.push_back(asked.name + ": " + warning);
    }
    print_warnings(warnings);
  }
  if (arguments.json && !arguments.scene) {
    const auto& printed = list.size() == 1 ? list.front() : list;
    print(fmt::format("{}\n", printed.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace)));
  }
  return 0;
}

}  // namespace palpa::app
