#include "palpa/trace/export_trace.h"

#include <dlfcn.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

#include "palpa/base/own_files.h"
#include "palpa/base/sanitized.h"
#include "palpa/base/wording.h"
#include "palpa/file/vtk_xml.h"
#include "palpa/trace/columns.h"
#include "palpa/trace/csv.h"
#include "palpa/trace/hdf5.h"
#include "palpa/version.h"

namespace palpa {
namespace {

namespace fs = std::filesystem;
using detail::NewFile;

Vec3 vector_in(const FeltColumn& column, std::size_t row) {
  const double* const v = column.values.data() + 3 * row;
  return {v[0], v[1], v[2]};
}

// ---- .vtp ----

void put_array(NewFile& file, const std::string& name, int components, const std::vector<double>& values) {
  detail::VtkArrayWriter array(file, "Float64", name, components, values.size() * sizeof(double));
  array.write(values.data(), values.size() * sizeof(double));
  array.finish();
}
void put_array(NewFile& file, const std::string& name, int components, const std::vector<std::int64_t>& values) {
  detail::VtkArrayWriter array(file, "Int64", name, components, values.size() * sizeof(std::int64_t));
  array.write(values.data(), values.size() * sizeof(std::int64_t));
  array.finish();
}

void write_vtp(const FeltPath& path, NewFile& file) {
  file.write(detail::vtk_xml_begin("PolyData"));
  file.write("<PolyData>\n<Piece NumberOfPoints=\"" + std::to_string(path.ticks()) + "\" NumberOfVerts=\"" +
             std::to_string(path.ticks()) +
             "\" NumberOfLines=\"1\" NumberOfStrips=\"0\" NumberOfPolys=\"0\">\n"
             "<PointData Vectors=\"force_n\">\n");
  for (const FeltColumn& column : path.columns) {
    if (column.name == "proxy_m") continue;
    if (column.is_whole) {
      put_array(file, column.name, column.components, std::vector<std::int64_t>(column.values.begin(), column.values.end()));
    } else {
      put_array(file, column.name, column.components, column.values);
    }
  }
  file.write("</PointData>\n<Points>\n");
  put_array(file, "proxy_m", 3, path.column("proxy_m").values);
  std::vector<std::int64_t> points(path.ticks()), ends(path.ticks());
  for (std::size_t n = 0; n < points.size(); ++n) points[n] = static_cast<std::int64_t>(n), ends[n] = points[n] + 1;
  // A vertex for each tick beside the line: filters that choose cells, as Threshold does, can choose ticks.
  file.write("</Points>\n<Verts>\n");
  put_array(file, "connectivity", 1, points);
  put_array(file, "offsets", 1, ends);
  file.write("</Verts>\n<Lines>\n");
  put_array(file, "connectivity", 1, points);
  put_array(file, "offsets", 1, std::vector<std::int64_t>{static_cast<std::int64_t>(points.size())});
  file.write("</Lines>\n</Piece>\n</PolyData>\n</VTKFile>\n");
}

// ---- .csv ----

/// Names of a column's cells, as in a trace.
std::vector<std::string> cells_of(const FeltColumn& column) {
  if (column.components == 1) return {column.name};
  if (column.components == 4) return detail::cell_names(column.name, "", column.components);
  const std::size_t unit = column.name.rfind('_');
  return detail::cell_names(column.name.substr(0, unit), column.name.substr(unit + 1), column.components);
}

void write_csv(const FeltPath& path, NewFile& file) {
  std::string text;
  for (const FeltColumn& column : path.columns) {
    for (const std::string& name : cells_of(column)) {
      if (!text.empty()) text += ',';
      detail::put_text(text, name);
    }
  }
  text += '\n';
  for (std::size_t row = 0; row < path.ticks(); ++row) {
    bool first = true;
    for (const FeltColumn& column : path.columns) {
      const auto components = static_cast<std::size_t>(column.components);
      for (std::size_t c = 0; c < components; ++c) {
        if (!first) text += ',';
        first = false;
        const double value = column.values[row * components + c];
        column.is_whole ? detail::put_number(text, static_cast<std::int64_t>(value)) : detail::put_number(text, value);
      }
    }
    text += '\n';
    if (text.size() > std::size_t{1} << 16) file.write(text), text.clear();
  }
  file.write(text);
}

// ---- .h5 ----

const detail::Hdf5& hdf5() {
  for (const fs::path& folder : own_files_folders()) {
    const fs::path file = folder / "palpa-hdf5.so";
    std::error_code none;
    if (!fs::exists(file, none)) continue;
    void* const library = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (!library)
      throw LoadError(detail::one_line(file.string() + ": cannot be loaded (" + ::dlerror() + "); install palpa again"));
    const auto* const found = static_cast<const detail::Hdf5*>(::dlsym(library, "palpa_hdf5"));
    if (!found || std::strcmp(found->palpa_version, version) != 0)
      throw LoadError(file.string() + ": is not of this palpa, " + version + "; install palpa again");
    return *found;
  }
  throw LoadError("cannot be written: HDF5 needs a part of the program palpa that is not installed; write .csv or .vtp");
}

// ---- .mrk.json ----

/// Converts a position of the world (LPS for medical data) to Slicer's.
std::array<double, 3> ras_mm(const Vec3& world_m) { return {-1e3 * world_m.x, -1e3 * world_m.y, 1e3 * world_m.z}; }

/// Rows of a path for handles: at the least distance that leaves at most `most`.
std::vector<std::size_t> handles_of(const FeltColumn& places_m, std::size_t ticks, std::size_t most) {
  const Vec3 first_m = vector_in(places_m, 0);
  double farthest_m = 0.0;
  for (std::size_t row = 0; row < ticks; ++row) farthest_m = std::max(farthest_m, distance(vector_in(places_m, row), first_m));
  std::vector<std::size_t> rows;
  for (double apart_m = farthest_m / static_cast<double>(most);; apart_m *= 2.0) {
    rows.assign(1, 0);
    for (std::size_t row = 1; row < ticks; ++row) {
      if (distance(vector_in(places_m, row), vector_in(places_m, rows.back())) > apart_m) rows.push_back(row);
    }
    if (rows.size() <= most) return rows;
  }
}

nlohmann::json control_point(std::size_t number, const std::string& label, const std::string& words, const Vec3& at_m) {
  return {{"id", std::to_string(number)}, {"label", label},   {"description", words},
          {"position", ras_mm(at_m)},     {"selected", true}, {"positionStatus", "defined"}};
}

nlohmann::json markup(const char* type, nlohmann::json points, bool labels) {
  return {{"type", type},
          {"coordinateSystem", "RAS"},
          {"coordinateUnits", "mm"},
          {"locked", true},
          {"controlPoints", std::move(points)},
          {"display", {{"pointLabelsVisibility", labels}, {"propertiesLabelVisibility", false}}}};
}

std::string markups_of(const FeltPath& path) {
  constexpr std::size_t most_handles = 2000, most_events = 500;  // more: Slicer becomes slow
  const FeltColumn& proxy_m = path.column("proxy_m");
  const FeltColumn& t_s = path.column("t_s");
  const auto moment = [&](std::size_t row) {
    std::string text;
    detail::put_number(text, t_s.values[row]);
    return text + " s";
  };
  nlohmann::json curve = nlohmann::json::array(), places = nlohmann::json::array();
  for (const std::size_t row : handles_of(proxy_m, path.ticks(), most_handles))
    curve.push_back(control_point(curve.size() + 1, "", moment(row), vector_in(proxy_m, row)));
  for (const FeltEvent& event : path.events) {
    if ((event.kind != "onset" && event.kind != "break_through") || places.size() == most_events) continue;
    const std::string label = detail::sanitized(event.subject) + (event.kind == "onset" ? " holds" : " gives way");
    places.push_back(control_point(places.size() + 1, label, moment(event.row), vector_in(proxy_m, event.row)));
  }
  nlohmann::json all = nlohmann::json::array({markup("Curve", std::move(curve), false)});
  if (!places.empty()) all.push_back(markup("Fiducial", std::move(places), true));
  const nlohmann::json file = {
      {"@schema",
       "https://raw.githubusercontent.com/slicer/slicer/master/Modules/Loadable/Markups/Resources/Schema/"
       "markups-schema-v1.0.3.json#"},
      {"markups", std::move(all)}};
  return file.dump() + "\n";
}

void write(const FeltPath& path, const std::string& name, NewFile& file) {
  if (name.ends_with(".vtp")) return write_vtp(path, file);
  if (name.ends_with(".csv")) return write_csv(path, file);
  if (name.ends_with(".mrk.json")) return file.write(markups_of(path));
  const std::string bytes = hdf5().file_of(path);
  if (bytes.empty()) throw LoadError("cannot be written as HDF5: its library refuses; write .csv or .vtp");
  file.write(bytes);
}

}  // namespace

std::size_t export_trace(const fs::path& folder, const fs::path& file, detail::Existing existing) {
  const std::string name = file.filename().string();
  const auto has = [&](std::string_view ending) { return name.ends_with(ending); };
  if (!has(".vtp") && !has(".csv") && !has(".h5") && !has(".mrk.json"))
    throw LoadError(file.string() + ": has an ending of no format that is written; name it .vtp, .csv, .h5 or .mrk.json");
  const FeltPath path = felt_path(folder);
  if (path.ticks() == 0) throw LoadError(folder.string() + ": has no ticks to export; record a trace that is felt");
  try {
    NewFile whole(file, existing);
    write(path, name, whole);
    whole.finish();
  } catch (const LoadError& error) {
    throw LoadError(file.string() + ": " + error.what());
  }
  return path.ticks();
}

}  // namespace palpa
