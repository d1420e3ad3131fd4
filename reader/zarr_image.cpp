#include "zarr_image.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "palpa/base/wording.h"
#include "palpa/file/store_protocol.h"

namespace palpa::reader {
namespace {

std::string lower(std::string text) {
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

/// Assigns an index to the axis of a name and type. Returns false if it is another, or assigned already.
bool take_axis(ZarrAxes& axes, std::size_t index, const std::string& name, const std::string& type, const std::string& unit) {
  const auto assign = [&](std::size_t& axis) { return axis == SIZE_MAX ? (axis = index, true) : false; };
  const std::string small = lower(name);
  if (type == "channel" || (type.empty() && small == "c")) return assign(axes.channel);
  if (type == "time" || (type.empty() && (small == "t" || small == "time"))) {
    axes.time_unit = unit;
    return assign(axes.time);
  }
  if (small.size() != 1 || small[0] < 'x' || small[0] > 'z' || (!type.empty() && type != "space")) return false;
  const auto a = static_cast<std::size_t>(small[0] - 'x');
  axes.length_unit[a] = unit;
  return assign(axes.space[a]);
}

/// Axes of a list: objects with name, type and unit, or names alone (0.3). Throws LoadError.
ZarrAxes axes_of(const ZarrJson& list, const ZarrMetadata& of) {
  if (!list.is_array() || list.empty() || list.size() > 5)
    throw of.error("whose 'axes' are no list of 2 to 5 axes; write the store again");
  ZarrAxes axes;
  axes.rank = list.size();
  for (std::size_t n = 0; n < list.size(); ++n) {
    const ZarrJson& axis = list[n];
    const std::string name = axis.is_string() ? axis.get<std::string>() : ZarrMetadata::text(axis, "name");
    const std::string type = lower(ZarrMetadata::text(axis, "type"));
    if (!take_axis(axes, n, name, type, ZarrMetadata::text(axis, "unit"))) {
      throw of.error("with an axis " + detail::in_quotes(name) +
                     (type.empty() ? "" : " of the type " + detail::in_quotes(type)) +
                     ", which is not read; axes are t (time), c (channel), z, y, x (space), each once");
    }
  }
  if (axes.space[0] == SIZE_MAX || axes.space[1] == SIZE_MAX)
    throw of.error("without the axes y and x; a volume has z, y and x");
  return axes;
}

/// Axes of a plain array: by names of its own, else z, y, x from the last.
ZarrAxes axes_of_array(const ZarrArray& array, std::vector<std::string>& warnings) {
  ZarrAxes axes;
  axes.rank = array.shape.size();
  bool is_named = !array.axes.empty();
  for (std::size_t n = 0; is_named && n < axes.rank; ++n) is_named = take_axis(axes, n, array.axes[n], "", "");
  if (is_named && axes.space[0] != SIZE_MAX && axes.space[1] != SIZE_MAX) return axes;
  axes = {};
  axes.rank = array.shape.size();
  std::vector<std::size_t> left;
  for (std::size_t n = 0; n < axes.rank; ++n) left.push_back(n);
  const auto take = [&](std::size_t& axis, std::size_t at) {
    axis = left[at], left.erase(left.begin() + static_cast<std::ptrdiff_t>(at));
  };
  if (axes.rank >= 4 && array.shape.back() == 3) {
    take(axes.channel, left.size() - 1);
  } else if (axes.rank >= 4 && array.shape[axes.rank - 4] == 3) {
    take(axes.channel, axes.rank - 4);
  } else if (axes.rank == 5) {
    take(axes.channel, 1);
  }
  if (left.size() == 4) take(axes.time, 0);
  if (left.size() < 2 || left.size() > 3)
    throw LoadError("is an array of " + std::to_string(axes.rank) +
                    " indices; a volume has 3, and up to 2 of channels and time");
  for (std::size_t n = 0; n < left.size(); ++n) axes.space[left.size() - 1 - n] = left[n];
  warnings.push_back("says no axes: its last indices are taken for z, y, x");
  return axes;
}

/// Rows of numbers of a transformation. Throws LoadError.
std::vector<double> rows_of(const ZarrJson& transform, const ZarrMetadata& of, const std::string& key, std::size_t rows,
                            std::size_t columns) {
  const ZarrJson* list = ZarrMetadata::member(transform, key.c_str());
  std::vector<double> numbers;
  if (list != nullptr && list->is_array() && list->size() == rows) {
    for (const ZarrJson& row : *list) {
      if (!row.is_array() || row.size() != columns) break;
      for (const ZarrJson& n : row) {
        if (n.is_number() && std::isfinite(n.get<double>())) numbers.push_back(n.get<double>());
      }
    }
  }
  if (numbers.size() == rows * columns) return numbers;
  throw of.error("whose '" + key + "' is no list of " + std::to_string(rows) + " lists of " + std::to_string(columns) +
                 " numbers; write the store again");
}

/// Applies a linear map with `columns` numbers a row, of which the last is a translation where there is one more than rows.
void apply_rows(const std::vector<double>& rows, std::size_t columns, ZarrLevel& to) {
  const std::size_t rank = to.translation.size();
  const std::vector<double> matrix = to.matrix, translation = to.translation;
  for (std::size_t r = 0; r < rank; ++r) {
    const auto at = [&](std::size_t n) { return rows[r * columns + n]; };
    to.translation[r] = columns > rank ? at(rank) : 0.0;
    for (std::size_t n = 0; n < rank; ++n) to.translation[r] += at(n) * translation[n];
    for (std::size_t c = 0; c < rank; ++c) {
      to.matrix[r * rank + c] = 0.0;
      for (std::size_t n = 0; n < rank; ++n) to.matrix[r * rank + c] += at(n) * matrix[n * rank + c];
    }
  }
}

/// Applies a transformation of 0.4 to 0.6 to matrix and translation. Throws LoadError.
void apply(const ZarrJson& transform, const ZarrMetadata& of, std::size_t rank, ZarrLevel& to) {
  const std::string type = ZarrMetadata::text(transform, "type");
  if (to.matrix.empty()) {
    to.matrix.assign(rank * rank, 0.0), to.translation.assign(rank, 0.0);
    for (std::size_t n = 0; n < rank; ++n) to.matrix[n * rank + n] = 1.0;
  }
  if (type == "identity") return;
  if (type == "scale") {
    const std::vector<double> by = of.numbers(transform, "scale", rank);
    for (std::size_t n = 0; n < rank; ++n) {
      if (!(by[n] > 0.0)) throw of.error("with a scale that is not above 0; write the store again");
      for (std::size_t c = 0; c < rank; ++c) to.matrix[n * rank + c] *= by[n];
      to.translation[n] *= by[n];
    }
  } else if (type == "translation") {
    const std::vector<double> by = of.numbers(transform, "translation", rank);
    for (std::size_t n = 0; n < rank; ++n) to.translation[n] += by[n];
  } else if (type == "affine" || type == "rotation") {
    const std::size_t columns = type == "affine" ? rank + 1 : rank;
    apply_rows(rows_of(transform, of, type, rank, columns), columns, to);
  } else if (type == "sequence") {
    const ZarrJson* parts = ZarrMetadata::member(transform, "transformations");
    if (parts == nullptr || !parts->is_array() || parts->size() > 8)
      throw of.error("with a sequence of no transformations; write the store again");
    for (const ZarrJson& part : *parts) apply(part, of, rank, to);
  } else {
    throw of.error("with a transformation of the type " + detail::in_quotes(type) +
                   ", which is not read; scale, translation, rotation and affine are");
  }
}

/// Refuses a matrix that mixes space with time or channels, or lays voxels onto each other.
void check_matrix(const ZarrLevel& level, const ZarrAxes& axes, const ZarrMetadata& of) {
  if (level.matrix.empty()) return;
  const std::size_t rank = axes.rank;
  for (std::size_t n = 0; n < rank * rank; ++n) {
    const std::size_t row = n / rank, column = n % rank;
    const auto is_space = [&](std::size_t index) { return std::ranges::find(axes.space, index) != axes.space.end(); };
    const bool is_apart = row != column && !(is_space(row) && is_space(column));
    if (is_apart && level.matrix[n] != 0.0)
      throw of.error("with a transformation that mixes space with time or channels; give one within space");
    if (row == column && !is_space(row) && !(level.matrix[n] > 0.0))
      throw of.error("with a transformation that reverses time or channels; give one within space");
  }
}

/// Transformations of a dataset, or of all of them. Throws LoadError.
std::vector<const ZarrJson*> transforms_of(const ZarrJson& holder, const ZarrMetadata& of) {
  std::vector<const ZarrJson*> transforms;
  const ZarrJson* list = ZarrMetadata::member(holder, "coordinateTransformations");
  if (list == nullptr) return transforms;
  if (!list->is_array() || list->size() > 8)
    throw of.error("whose 'coordinateTransformations' are no list of up to 8; write the store again");
  for (const ZarrJson& transform : *list) transforms.push_back(&transform);
  return transforms;
}

/// Name of the coordinate system that is a transformation's "input" or "output": a text, or of an object. Empty: none here.
std::string system_name(const ZarrJson& transform, const char* key) {
  const ZarrJson* system = ZarrMetadata::member(transform, key);
  if (system == nullptr || !system->is_object()) return ZarrMetadata::text(transform, key);
  return ZarrMetadata::member(*system, "path") != nullptr ? std::string() : ZarrMetadata::text(*system, "name");
}

/// Frame of an image: axes, and what leads from each dataset's own transformations into them.
struct ImageFrame {
  const ZarrJson* axes = nullptr;  ///< none: of 0.1 and 0.2
  std::vector<const ZarrJson*> transforms{};
};

/// Names of axes, to compare coordinate systems.
std::vector<std::string> names_in(const ZarrJson* axes) {
  std::vector<std::string> names;
  if (axes == nullptr || !axes->is_array()) return names;
  for (const ZarrJson& axis : *axes) names.push_back(ZarrMetadata::text(axis, "name"));
  return names;
}

/// Of 0.6 the frame is the coordinate system to which the first dataset leads, and from there on each only further one. Throws
/// LoadError.
ImageFrame frame_of(const ZarrJson& scales, const ZarrJson& datasets, const ZarrMetadata& of,
                    std::vector<std::string>& warnings) {
  const std::vector<const ZarrJson*> all = transforms_of(scales, of), first = transforms_of(datasets.front(), of);
  const ZarrJson* systems = ZarrMetadata::member(scales, "coordinateSystems");
  if (const ZarrJson* axes = ZarrMetadata::member(scales, "axes")) return {axes, all};
  if (systems == nullptr || !systems->is_array() || systems->empty()) return {nullptr, all};
  const auto axes_of_system = [&](const std::string& name) -> const ZarrJson* {
    for (const ZarrJson& system : *systems) {
      if (ZarrMetadata::text(system, "name") == name) return ZarrMetadata::member(system, "axes");
    }
    return nullptr;
  };
  std::string at = first.empty() ? std::string() : system_name(*first.back(), "output");
  ImageFrame frame{axes_of_system(at)};
  if (frame.axes == nullptr) return {ZarrMetadata::member(systems->front(), "axes"), all};
  for (std::size_t step = 0; step < all.size(); ++step) {
    std::vector<const ZarrJson*> further;
    for (const ZarrJson* transform : all) {
      const bool is_known = axes_of_system(system_name(*transform, "output")) != nullptr;
      if (is_known && system_name(*transform, "input") == at) further.push_back(transform);
    }
    if (further.empty()) break;
    const std::string next = system_name(*further.front(), "output");
    if (further.size() > 1 || names_in(axes_of_system(next)) != names_in(frame.axes)) {
      warnings.push_back("leads into several coordinate systems, or into other axes: it lies in " + detail::in_quotes(at));
      break;
    }
    at = next, frame.axes = axes_of_system(at);
    frame.transforms.push_back(further.front());
  }
  return frame;
}

std::vector<std::string> channels_of(const ZarrJson& attributes) {
  std::vector<std::string> labels;
  const ZarrJson* omero = ZarrMetadata::member(attributes, "omero");
  const ZarrJson* channels = omero != nullptr ? ZarrMetadata::member(*omero, "channels") : nullptr;
  if (channels == nullptr || !channels->is_array()) return labels;
  for (std::size_t n = 0; n < std::min(channels->size(), protocol::most_store_fields); ++n)
    labels.push_back(ZarrMetadata::text((*channels)[n], "label").substr(0, 100));
  return labels;
}

/// Units and histograms that palpa wrote, as far as they are sound.
void take_own(const ZarrJson& own, ZarrImage& image) {
  if (const ZarrJson* units = ZarrMetadata::member(own, "units"); units != nullptr && units->is_array()) {
    for (std::size_t n = 0; n < std::min(units->size(), protocol::most_store_fields); ++n)
      image.units.push_back((*units)[n].is_string() ? (*units)[n].get<std::string>().substr(0, 100) : "");
  }
  const ZarrJson* all = ZarrMetadata::member(own, "histograms");
  if (all == nullptr || !all->is_array()) return;
  for (std::size_t n = 0; n < std::min(all->size(), protocol::most_histograms); ++n) {
    const ZarrJson& each = (*all)[n];
    const ZarrJson *low = ZarrMetadata::member(each, "low"), *high = ZarrMetadata::member(each, "high"),
                   *counts = ZarrMetadata::member(each, "counts");
    Histogram& made = image.histograms.emplace_back();
    const bool is_sound = low != nullptr && low->is_number() && high != nullptr && high->is_number() && counts != nullptr &&
                          counts->is_array() && counts->size() <= protocol::most_histogram_classes &&
                          low->get<double>() <= high->get<double>();
    if (!is_sound) continue;
    made.low = low->get<double>(), made.high = high->get<double>();
    for (const ZarrJson& count : *counts)
      made.counts.push_back(count.is_number_unsigned() ? static_cast<std::int64_t>(std::min<std::uint64_t>(
                                                             count.get<std::uint64_t>(), protocol::most_counted))
                                                       : 0);
  }
}

/// Image by its attributes. Throws LoadError.
ZarrImage image_of(const ZarrFolder& folder, const std::string& where, const ZarrJson& attributes, const ZarrMetadata& of,
                   std::uint64_t most_chunk_bytes) {
  const ZarrJson* all = ZarrMetadata::member(attributes, "multiscales");
  if (!all->is_array() || all->empty()) throw of.error("whose 'multiscales' are no list; write the store again");
  const ZarrJson& scales = all->front();
  const ZarrJson* datasets = ZarrMetadata::member(scales, "datasets");
  if (datasets == nullptr || !datasets->is_array() || datasets->empty())
    throw of.error("whose 'multiscales' have no 'datasets'; write the store again");
  ZarrImage image{.folder = where};
  if (all->size() > 1) image.warnings.push_back("holds several images in one folder: the first is read");
  const ImageFrame frame = frame_of(scales, *datasets, of, image.warnings);
  static const ZarrJson earliest = {"t", "c", "z", "y", "x"};
  image.axes = axes_of(frame.axes != nullptr ? *frame.axes : earliest, of);
  const std::size_t count = std::min(datasets->size(), protocol::most_octaves);
  if (count < datasets->size()) image.warnings.push_back("has more than 24 octaves: the coarsest are left out");
  for (std::size_t n = 0; n < count; ++n) {
    const ZarrJson& dataset = (*datasets)[n];
    const std::string path = ZarrMetadata::text(dataset, "path");
    if (!is_plain_path(path)) {
      throw of.error("with a dataset at " + detail::in_quotes(path) +
                     ", which is no plain path within the store; write the store again");
    }
    ZarrLevel level{.array = read_zarr_array(folder, joined_path(where, path), most_chunk_bytes)};
    if (level.array.shape.size() != image.axes.rank)
      throw of.error("with " + std::to_string(image.axes.rank) + " axes, where the array '" + path + "' has " +
                     std::to_string(level.array.shape.size()) + "; write the store again");
    for (const ZarrJson* transform : transforms_of(dataset, of)) apply(*transform, of, image.axes.rank, level);
    for (const ZarrJson* transform : frame.transforms) apply(*transform, of, image.axes.rank, level);
    check_matrix(level, image.axes, of);
    image.levels.push_back(std::move(level));
  }
  image.channels = channels_of(attributes);
  const std::string version = ZarrMetadata::text(attributes, "version", ZarrMetadata::text(scales, "version"));
  image.format =
      "OME-Zarr" + (version.empty() ? "" : " " + version) + ", Zarr v" + std::to_string(image.levels.front().array.format);
  return image;
}

ZarrImage plain_image(const ZarrFolder& folder, std::uint64_t most_chunk_bytes) {
  ZarrImage image;
  ZarrLevel level{.array = read_zarr_array(folder, "", most_chunk_bytes)};
  image.axes = axes_of_array(level.array, image.warnings);
  image.format = "Zarr v" + std::to_string(level.array.format);
  image.warnings.push_back(
      "is a plain array without 'multiscales': one octave, whose voxels are taken to be 1 µm apart; write an OME-Zarr, or "
      "convert it by palpa convert");
  image.levels.push_back(std::move(level));
  return image;
}

/// The sentence for a group that is no image: a plate, a collection, arrays.
LoadError not_an_image(const ZarrFolder& folder, const ZarrJson& attributes) {
  const std::vector<std::string> parts = folder.parts(8);
  const std::string such = parts.empty() ? "STORE/0" : "STORE/" + parts.front();
  if (ZarrMetadata::member(attributes, "plate") != nullptr || ZarrMetadata::member(attributes, "well") != nullptr)
    return LoadError("is a plate of many images; name one, as STORE/ROW/COLUMN/0");
  if (parts.empty()) return LoadError("is a group of Zarr without an array or image; name the folder of an OME-Zarr image");
  return LoadError("is a group of Zarr without 'multiscales', of " + detail::joined(parts) + "; name one, as " + such);
}

/// Metadata of a group in either version.
struct Group {
  ZarrJson attributes;
  ZarrJson own;      ///< of palpa; null: none
  std::string name;  ///< of the file
  bool is_array = false;
};

std::optional<Group> group_at(const ZarrFolder& folder, const std::string& where) {
  const std::string new_name = joined_path(where, "zarr.json"), old_name = joined_path(where, ".zattrs");
  if (auto json = folder.json(new_name)) {
    const bool is_array = ZarrMetadata::text(*json, "node_type") == "array";
    const ZarrJson* attributes = ZarrMetadata::member(*json, "attributes");
    const ZarrJson* ome = attributes != nullptr ? ZarrMetadata::member(*attributes, "ome") : nullptr;
    // Copied first: the assignment would else read from what it replaces.
    ZarrJson found = ome != nullptr ? *ome : attributes != nullptr ? *attributes : ZarrJson::object();
    const ZarrJson* own = attributes != nullptr ? ZarrMetadata::member(*attributes, "palpa") : nullptr;
    return Group{std::move(found), own != nullptr ? *own : ZarrJson(), new_name, is_array};
  }
  const bool is_array = folder.has_json(joined_path(where, ".zarray"));
  auto attributes = folder.json(old_name);
  if (!attributes && !is_array && !folder.has_json(joined_path(where, ".zgroup"))) return std::nullopt;
  const ZarrJson* own = attributes ? ZarrMetadata::member(*attributes, "palpa") : nullptr;
  ZarrJson of_palpa = own != nullptr ? *own : ZarrJson();
  return Group{attributes ? std::move(*attributes) : ZarrJson::object(), std::move(of_palpa), old_name, is_array};
}

}  // namespace

ZarrImage read_zarr_image(const ZarrFolder& folder, std::uint64_t most_chunk_bytes) {
  std::string where;
  std::optional<Group> group = group_at(folder, where);
  if (!group)
    throw LoadError("has no metadata of Zarr" + folder.why_absent() + "; name the folder with .zattrs, .zarray or zarr.json");
  // Several images, as of Bio-Formats: a single one is meant.
  if (ZarrMetadata::member(group->attributes, "bioformats2raw.layout") != nullptr &&
      ZarrMetadata::member(group->attributes, "multiscales") == nullptr) {
    if (group_at(folder, "1")) throw LoadError("holds several images; name one, as STORE/0");
    if (auto first = group_at(folder, "0")) group = std::move(first), where = "0";
  }
  if (ZarrMetadata::member(group->attributes, "multiscales") != nullptr) {
    ZarrImage image = image_of(folder, where, group->attributes, {group->name, group->attributes}, most_chunk_bytes);
    take_own(group->own, image);
    return image;
  }
  if (group->is_array) return plain_image(folder, most_chunk_bytes);
  throw not_an_image(folder, group->attributes);
}

}  // namespace palpa::reader
