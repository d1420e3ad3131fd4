#include "palpa/file/store_image.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "palpa/base/input_file.h"
#include "palpa/base/load_error.h"
#include "palpa/file/store_array.h"

namespace palpa::detail {
namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr const char* right = "give the folder of an image in OME-Zarr 0.4 or 0.5";
constexpr std::size_t most_bytes = std::size_t{4} << 20;
constexpr int most_depth = 16;

[[noreturn]] void refuse(const fs::path& store, const std::string& what) {
  throw LoadError(store.string() + ": " + what + "; " + right);
}

Json read_json(const fs::path& store, const fs::path& name) {
  const InputFile file(name);
  if (!file.is_open()) refuse(store, name.filename().string() + " " + file.problem());
  if (file.bytes() > most_bytes) refuse(store, name.filename().string() + " has more than 4 MiB");
  std::string text(static_cast<std::size_t>(file.bytes()), '\0');
  text.resize(file.read(0, text.data(), text.size()));
  bool deep = false;
  const Json json = Json::parse(
      text,
      [&](int depth, Json::parse_event_t, Json&) {
        deep = deep || depth > most_depth;
        return !deep;
      },
      false);
  if (deep) refuse(store, name.filename().string() + " is nested deeper than 16 times");
  if (!json.is_object()) refuse(store, name.filename().string() + " is no JSON object");
  return json;
}

/// Attributes of a store, with the place of the image's own ones in them.
struct Attributes {
  int zarr = 2;
  Json whole;  ///< content of the file
  Json& all() { return zarr == 2 ? whole : whole["attributes"]; }
  Json& image() { return zarr == 2 ? whole : whole["attributes"]["ome"]; }
};

Attributes attributes_of(const fs::path& store) {
  Attributes found;
  found.zarr = InputFile(store / "zarr.json").is_open() ? 3 : 2;
  if (!InputFile(store / attributes_file(found.zarr)).is_open()) refuse(store, "has neither .zattrs nor zarr.json");
  found.whole = read_json(store, store / attributes_file(found.zarr));
  if (found.zarr == 3 && (!found.whole.contains("attributes") || !found.whole["attributes"].is_object() ||
                          !found.whole["attributes"].contains("ome")))
    refuse(store, "has no attributes of OME");
  const Json& image = found.image();
  const bool good = image.is_object() && image.contains("multiscales") && image["multiscales"].is_array() &&
                    !image["multiscales"].empty() && image["multiscales"][0].is_object() &&
                    image["multiscales"][0].contains("datasets") && image["multiscales"][0]["datasets"].is_array() &&
                    !image["multiscales"][0]["datasets"].empty() && image["multiscales"][0].contains("axes") &&
                    image["multiscales"][0]["axes"].is_array();
  if (!good) refuse(store, "has no multiscales with axes and datasets");
  return found;
}

Json transform(const char* type, std::size_t before, const std::array<double, 3>& of_ijk, double first) {
  std::vector<double> values(before, first);
  values.insert(values.end(), {of_ijk[2], of_ijk[1], of_ijk[0]});
  return {{"type", type}, {type, values}};
}

std::string color_of(std::size_t channel) {
  static constexpr const char* colors[] = {"FFFFFF", "00FF00", "FF00FF", "00FFFF", "FFFF00", "FF0000", "0000FF"};
  return colors[channel % std::size(colors)];
}

/// Numbers of a transform of a dataset; `none` for each axis without one.
std::vector<double> transform_of(const Json& dataset, const char* type, std::size_t axes, double none) {
  std::vector<double> values(axes, none);
  const auto all = dataset.find("coordinateTransformations");
  if (all == dataset.end() || !all->is_array()) return values;
  for (const Json& each : *all) {
    if (!each.is_object() || each.value("type", Json()) != type || !each.contains(type)) continue;
    const Json& numbers = each[type];
    if (!numbers.is_array() || numbers.size() != axes) continue;
    for (std::size_t a = 0; a < axes; ++a) {
      if (numbers[a].is_number()) values[a] = numbers[a].get<double>();
    }
  }
  return values;
}

/// Dataset of an octave, whose transforms follow from the finest one's.
Json dataset_after(const Json& finest, const std::string& path, int octave, std::size_t axes) {
  std::vector<double> scale = transform_of(finest, "scale", axes, 1.0);
  std::vector<double> shift = transform_of(finest, "translation", axes, 0.0);
  for (std::size_t a = axes - 3; a < axes; ++a) {
    shift[a] += 0.5 * (std::ldexp(1.0, octave) - 1.0) * scale[a];
    scale[a] = std::ldexp(scale[a], octave);
  }
  return {{"path", path},
          {"coordinateTransformations",
           Json::array({{{"type", "scale"}, {"scale", scale}}, {{"type", "translation"}, {"translation", shift}}})}};
}

}  // namespace

std::vector<std::string> StoreImage::axes() const {
  std::vector<std::string> names;
  if (has_time) names.emplace_back("t");
  if (has_channels) names.emplace_back("c");
  names.insert(names.end(), {"z", "y", "x"});
  return names;
}

const char* attributes_file(int zarr) noexcept { return zarr == 2 ? ".zattrs" : "zarr.json"; }

std::string image_metadata(const NewImage& image) {
  Json axes = Json::array();
  const std::size_t before = image.channels.size() > 1;
  if (before == 1) axes.push_back({{"name", "c"}, {"type", "channel"}});
  for (const char* name : {"z", "y", "x"}) axes.push_back({{"name", name}, {"type", "space"}, {"unit", image.length_unit}});
  Json scale{
      {"name", image.name},
      {"axes", axes},
      {"datasets",
       Json::array({{{"path", "0"},
                     {"coordinateTransformations", Json::array({transform("scale", before, image.spacing, 1.0),
                                                                transform("translation", before, image.origin, 0.0)})}}})},
      {"type", "mean"}};
  Json channels = Json::array(), units = Json::array();
  for (std::size_t c = 0; c < image.channels.size(); ++c) {
    const auto& [low, high] = image.window;
    channels.push_back({{"label", image.channels[c]},
                        {"color", color_of(c)},
                        {"active", true},
                        {"window", {{"min", low}, {"max", high}, {"start", low}, {"end", high}}}});
    units.push_back(image.units[c]);
  }
  Json ome, palpa{{"units", units}};
  if (image.zarr == 3) ome["version"] = "0.5";
  if (image.zarr == 2) scale["version"] = "0.4";
  ome["multiscales"] = Json::array({scale});
  ome["omero"] = {{"channels", channels}};
  if (image.zarr == 2) {
    ome["palpa"] = palpa;
    return ome.dump(2) + "\n";
  }
  const Json whole{{"zarr_format", 3}, {"node_type", "group"}, {"attributes", {{"ome", ome}, {"palpa", palpa}}}};
  return whole.dump(2) + "\n";
}

namespace {

/// Octaves are written with scale and translation alone.
void refuse_other_transforms(const fs::path& store, const Json& dataset) {
  const auto all = dataset.find("coordinateTransformations");
  if (all == dataset.end() || !all->is_array()) return;
  for (const Json& each : *all) {
    const Json type = each.is_object() ? each.value("type", Json()) : Json();
    if (type != "scale" && type != "translation" && type != "identity")
      refuse(store, "has a transformation beside scale and translation, which no octave of 0.4 or 0.5 has");
  }
}

}  // namespace

StoreImage read_image(const fs::path& store) {
  Attributes attributes = attributes_of(store);
  StoreImage image;
  image.zarr = attributes.zarr;
  const Json& scales = attributes.image()["multiscales"][0];
  std::string axes;
  for (const Json& axis : scales["axes"]) {
    const std::string name = axis.is_object() ? axis.value("name", std::string()) : std::string();
    axes += name.size() == 1 ? name : "?";
  }
  image.has_time = axes.starts_with('t');
  image.has_channels = axes.find('c') != std::string::npos;
  std::string expected;
  for (const std::string& name : image.axes()) expected += name;
  if (axes != expected) refuse(store, "has other axes than t, c, z, y, x in this order");
  for (const Json& dataset : scales["datasets"]) {
    const bool named = dataset.is_object() && dataset.contains("path") && dataset["path"].is_string();
    if (!named) refuse(store, "has a dataset without a path");
    image.paths.push_back(dataset["path"].get<std::string>());
    refuse_other_transforms(store, dataset);
  }
  const Json& all = attributes.all();
  if (all.contains("palpa") && all["palpa"].is_object()) {
    const Json own = all["palpa"].value("octaves_from", Json());
    if (own.is_number_integer()) image.own_from = std::clamp(own.get<int>(), 0, 64);
  }
  return image;
}

std::string image_metadata_with(const fs::path& store, const AddedOctaves& added) {
  Attributes attributes = attributes_of(store);
  Json& scales = attributes.image()["multiscales"][0];
  const std::size_t axes = scales["axes"].size();
  if (axes < 3) refuse(store, "has fewer than three axes");
  const Json finest = scales["datasets"][0];
  if (!finest.is_object()) refuse(store, "has a dataset that is no object");
  Json datasets = Json::array();
  for (int n = 0; n < added.first && added.beside.empty(); ++n)
    datasets.push_back(scales["datasets"][static_cast<std::size_t>(n)]);
  for (std::size_t n = 0; n < added.paths.size(); ++n)
    datasets.push_back(dataset_after(finest, added.paths[n], added.first + static_cast<int>(n), axes));
  scales["datasets"] = datasets;
  Json& palpa = attributes.all()["palpa"];
  if (!palpa.is_object()) palpa = Json::object();
  palpa["octaves_from"] = added.own_from;
  palpa["unit"] = {added.unit[2], added.unit[1], added.unit[0]};
  if (!added.beside.empty()) palpa["beside"] = added.beside;
  if (!added.ranges.empty()) {
    palpa["ranges"] = added.ranges;
    palpa["octave_1_loses_rms"] = added.lost;
    Json histograms = Json::array();
    for (const Histogram& h : added.histograms) histograms.push_back({{"low", h.low}, {"high", h.high}, {"counts", h.counts}});
    palpa["histograms"] = histograms;
  }
  return attributes.whole.dump(2) + "\n";
}

}  // namespace palpa::detail
