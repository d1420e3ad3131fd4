#include "palpa/scene/request_toml.h"

#include "palpa/scene/wording.h"

namespace palpa::detail {
namespace {

std::string line(const std::string& key, const std::string& value) { return key + " = " + value + "\n"; }

std::string numbers(std::initializer_list<double> list) {
  std::string all;
  for (const double number : list) all += (all.empty() ? "[" : ", ") + toml_number(number);
  return all + "]";
}
std::string numbers(const Vec3& v) { return numbers({v.x, v.y, v.z}); }

}  // namespace

std::string file_line(const VolumeRequest& request) {
  std::string paths;
  for (const std::filesystem::path& file : request.files) {
    paths += (paths.empty() ? "" : ", ") + toml_string(std::filesystem::absolute(file).lexically_normal().string());
  }
  return line("file", request.files.size() == 1 ? paths : "[" + paths + "]");
}

std::string field_entry(const VolumeRequest::FieldRequest& field) {
  std::string table;
  if (!field.array.empty() && field.array != field.name) table = "array = " + toml_string(field.array);
  for (const std::string& array : field.arrays) table += (table.empty() ? "arrays = [" : ", ") + toml_string(array);
  if (!field.arrays.empty()) table += "]";
  if (!field.unit.empty()) table += (table.empty() ? "" : ", ") + ("unit = " + toml_string(field.unit));
  return field.name + " = {" + table + "}";
}

std::string asked_for(const VolumeRequest& request) {
  std::string out;
  const auto text = [&](const char* key, const std::string& value) {
    if (!value.empty()) out += line(key, toml_string(value));
  };
  text("series", request.series);
  text("components_along", request.components_along);
  if (request.time_s) out += line("time", toml_number(*request.time_s));
  if (const auto& c = request.crop) {
    out += line("crop_m", numbers({c->low_m.x, c->low_m.y, c->low_m.z, c->high_m.x, c->high_m.y, c->high_m.z}));
  }
  const ArrayLayout& layout = request.layout;
  text("type", layout.type);
  text("byte_order", layout.byte_order);
  if (layout.header_bytes != 0) out += line("header_bytes", std::to_string(layout.header_bytes));
  if (const auto& n = layout.dims; n[0] != 0) {
    out += line("dims", "[" + std::to_string(n[0]) + ", " + std::to_string(n[1]) + ", " + std::to_string(n[2]) + "]");
  }
  text("axes", layout.axes);
  text("components", layout.components);
  if (layout.spacing_m != Vec3{}) out += line("spacing_m", numbers(layout.spacing_m));
  if (layout.origin_m) out += line("origin_m", numbers(*layout.origin_m));
  return out;
}

std::string reading_of(const VolumeRequest& request) {
  std::string out = file_line(request), fields;
  if (!request.length_unit.empty()) out += line("length_unit", toml_string(request.length_unit));
  if (request.frame >= 0) out += line("frame", std::to_string(request.frame));
  if (!request.as.empty()) out += line("as", toml_string(request.as));
  for (const auto& field : request.fields) fields += (fields.empty() ? "" : ", ") + field_entry(field);
  if (!fields.empty()) out += line("fields", "{" + fields + "}");
  return out + asked_for(request);
}

}  // namespace palpa::detail
