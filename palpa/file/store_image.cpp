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

constexpr const char* right = "give the folder of an image in OME-Zarr 0.4 to 0.6";
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

/// Name of a coordinate system: as it is, or of an object.
std::string system_name(const Json& reference) {
  const Json name = reference.is_object() ? reference.value("name", Json()) : reference;
  return name.is_string() ? name.get<std::string>() : std::string();
}

/// Transformations of a dataset.
Json transforms_of(const Json& dataset) {
  const Json all = dataset.is_object() ? dataset.value("coordinateTransformations", Json()) : Json();
  return all.is_array() ? all : Json::array();
}

/// Axes of an image; of 0.6 those of the coordinate system that the first dataset leads to. No array: it has none.
Json axes_of(const Json& scales) {
  if (scales.contains("axes")) return scales["axes"];
  const Json systems = scales.value("coordinateSystems", Json());
  const Json transforms = transforms_of(scales["datasets"][0]);
  const Json last = transforms.empty() ? Json() : transforms.back();
  const std::string output = system_name(last.is_object() ? last.value("output", Json()) : Json());
  Json axes;
  for (const Json& system : systems.is_array() ? systems : Json::array()) {
    const bool is_output = !output.empty() && system_name(system) == output;
    if (system.is_object() && (axes.is_null() || is_output)) axes = system.value("axes", Json());
    if (is_output) break;
  }
  return axes;
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
                    !image["multiscales"][0]["datasets"].empty() && axes_of(image["multiscales"][0]).is_array();
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

/// Map along each axis.
struct AxisMap {
  std::vector<double> scale, shift;

  Json transforms() const {
    return Json::array({{{"type", "scale"}, {"scale", scale}}, {{"type", "translation"}, {"translation", shift}}});
  }
  /// Applies transformations after this. Returns false where one mixes axes.
  bool apply(const Json& transforms) {
    for (const Json& each : transforms.is_array() ? transforms : Json::array()) {
      const std::string type = each.is_object() && each.contains("type") && each["type"].is_string() ? each["type"] : Json("");
      if (type == "sequence") {
        if (!apply(each.value("transformations", Json()))) return false;
      } else if (type == "scale" || type == "translation") {
        const Json numbers = each.value(type, Json());
        for (std::size_t a = 0; a < scale.size() && numbers.is_array() && numbers.size() == scale.size(); ++a) {
          const double number = numbers[a].is_number() ? numbers[a].get<double>() : type == "scale" ? 1.0 : 0.0;
          type == "scale" ? (scale[a] *= number, shift[a] *= number) : shift[a] += number;
        }
      } else if (type != "identity") {
        return false;
      }
    }
    return true;
  }
};

/// Map of an octave's voxels to those of the finest.
AxisMap to_finest(int octave, std::size_t axes) {
  AxisMap map{std::vector<double>(axes, 1.0), std::vector<double>(axes, 0.0)};
  for (std::size_t a = axes - 3; a < axes; ++a)
    map.scale[a] = std::ldexp(1.0, octave), map.shift[a] = 0.5 * (map.scale[a] - 1.0);
  return map;
}

/// Dataset of an octave, whose transformations follow from the finest one's: of 0.4 and 0.5 a list, of 0.6 one, from the
/// octave's array into the coordinate system of the finest.
Json dataset_after(const Json& finest, const std::string& path, int octave, std::size_t axes) {
  Json all = transforms_of(finest), parts;
  AxisMap map = to_finest(octave, axes);
  if (AxisMap whole = map; whole.apply(all)) {
    parts = whole.transforms();
  } else {
    parts = map.transforms();
    for (Json part : all) {
      part.erase("input"), part.erase("output");
      parts.push_back(part);
    }
  }
  const bool has_systems = !all.empty() && all.back().is_object() && all.back().contains("output");
  if (!has_systems) return {{"path", path}, {"coordinateTransformations", parts}};
  const bool is_text = all.back().value("input", Json()).is_string();
  const Json one{{"type", "sequence"},
                 {"input", is_text ? Json(path) : Json{{"path", path}}},
                 {"output", all.back()["output"]},
                 {"transformations", parts}};
  return {{"path", path}, {"coordinateTransformations", Json::array({one})}};
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

/// Octaves of 0.4 and 0.5 have scale and translation alone.
void refuse_other_transforms(const fs::path& store, const Json& dataset) {
  for (const Json& each : transforms_of(dataset)) {
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
  for (const Json& axis : axes_of(scales)) {
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
    if (scales.contains("axes")) refuse_other_transforms(store, dataset);
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
  const std::size_t axes = axes_of(scales).size();
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
