#include "app/info_kind.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <initializer_list>

#include "palpa/data/ct.h"
#include "palpa/data/volume.h"
#include "palpa/file/components.h"

namespace palpa::app {
namespace {

using Words = std::initializer_list<std::string_view>;

std::string lower(std::string_view text) {
  std::string small(text);
  for (char& c : small) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return small;
}

bool has_any(const std::string& text, Words words) {
  return std::any_of(words.begin(), words.end(), [&](std::string_view word) { return text.find(word) != std::string::npos; });
}

/// "a", "a and b", "a, b and c".
std::string list_of(const std::vector<std::string>& names) {
  std::string all;
  for (std::size_t n = 0; n < names.size(); ++n) all += (n == 0 ? "" : n + 1 == names.size() ? " and " : ", ") + names[n];
  return all;
}

/// The words of a file's name: "avg152T1_RL" is avg152, t1, rl.
std::vector<std::string> split_name(const std::string& path) {
  const std::string name = std::filesystem::path(path).filename().string();
  std::vector<std::string> words(1);
  for (std::size_t n = 0; n < name.size(); ++n) {
    const auto c = static_cast<unsigned char>(name[n]);
    if (!std::isalnum(c)) {
      words.emplace_back();
      continue;
    }
    const auto before = static_cast<unsigned char>(n > 0 ? name[n - 1] : ' ');
    const auto after = static_cast<unsigned char>(n + 1 < name.size() ? name[n + 1] : ' ');
    const bool begins =
        std::isupper(c) && (std::islower(before) || std::isdigit(before) || (std::isupper(before) && std::islower(after)));
    if (begins) words.emplace_back();
    words.back() += static_cast<char>(std::tolower(c));
  }
  std::erase(words, std::string());
  return words;
}

/// What a scan is by the words of its file's name, which people choose; empty if they say nothing.
std::string scan_by_name(const std::string& path) {
  const std::vector<std::string> words = split_name(path);
  const auto has = [&](Words any) {
    return std::any_of(words.begin(), words.end(),
                       [&](const std::string& word) { return std::find(any.begin(), any.end(), word) != any.end(); });
  };
  if (has({"flair"})) return "MR, FLAIR";
  if (has({"t1", "t1w", "mprage"})) return "MR, T1-weighted";
  if (has({"t2", "t2w"})) return "MR, T2-weighted";
  if (has({"fa"})) return "fractional anisotropy, of diffusion MR";
  if (has({"adc", "dwi", "dti"})) return "diffusion MR";
  if (has({"bold", "fmri", "epi"})) return "functional MR";
  if (has({"mra", "tof"})) return "MR angiogram";
  if (has({"cta"})) return "CT angiogram";
  if (has({"ct", "cbct", "hrct"})) return "CT";
  if (has({"pet"})) return "PET";
  if (has({"mr", "mri"})) return "MR";
  return {};
}

std::string dicom_kind(const Volume& volume) {
  const std::string protocol = scan_fact(volume, ScanFactKind::protocol), image = scan_fact(volume, ScanFactKind::image),
                    body = scan_fact(volume, ScanFactKind::body_part), &modality = volume.modality;
  const bool angio = !scan_fact(volume, ScanFactKind::angiogram).empty() || has_any(protocol, {"angio", "cta", "mra", "tof"});
  const bool velocity = !scan_fact(volume, ScanFactKind::velocity_range_cm_per_s).empty() || image == "velocity map" ||
                        (image == "phase map" && has_any(protocol, {"flow", "venc", "velocity"}));
  const std::string b_value = scan_fact(volume, ScanFactKind::b_value_s_per_mm2);
  std::string what;
  if (modality == "CT") what = angio ? "CT angiogram" : "CT";
  if (modality == "MR") {
    what = velocity ? "velocity MR (phase contrast)"
           : angio  ? "MR angiogram"
           : (!b_value.empty() && b_value != "0") || has_any(image, {"ADC", "FA map", "diffusion"}) ? "diffusion MR"
                                                                                                    : "MR";
  }
  for (const auto& [code, words] : {std::pair{"PT", "PET"},
                                    {"NM", "nuclear medicine"},
                                    {"US", "ultrasound"},
                                    {"XA", "X-ray angiogram"},
                                    {"CR", "X-ray"},
                                    {"DX", "X-ray"},
                                    {"MG", "mammogram"},
                                    {"OPT", "optical coherence tomography"},
                                    {"SEG", "label map (segmentation)"},
                                    {"RTDOSE", "radiotherapy dose"}}) {
    if (modality == code) what = words;
  }
  if (what.empty()) what = modality.empty() ? "DICOM images of no stated modality" : "DICOM images of modality " + modality;
  if (!image.empty() && image != "velocity map") what += ", " + image;
  if (!body.empty()) what += ", " + body;
  if (!scan_fact(volume, ScanFactKind::contrast).empty()) what += ", with contrast agent";
  return what;
}

/// The names of a volume's fields, in lower case.
std::string names_of(const Volume& volume) {
  std::string all;
  for (const VolumeField& field : volume.fields) all += " " + lower(field.name) + " ";
  return all;
}

bool is_speed_unit(const std::string& unit) { return has_any(lower(unit), {"m/s", "m s-1", "m.s-1", "km/h", "knot"}); }

/// Whether it looks like a measured flow: a signal of whole numbers, and vectors that are near zero in half of the voxels.
bool looks_like_velocity_mr(const Facts& facts) {
  const std::vector<VolumeField>& fields = facts.file.volume.fields;
  if (fields.size() != 2 || facts.placed.grid.is_rectilinear()) return false;
  const std::size_t vectors = fields[0].field->components() == 3 ? 0 : 1;
  const std::size_t signal = 1 - vectors;
  if (fields[vectors].field->components() != 3 || fields[signal].field->components() != 1 || fields[vectors].resampling)
    return false;
  const Statistics &speeds = facts.values[vectors], &strengths = facts.values[signal];
  return strengths.min >= 0.0 && strengths.whole_numbers && strengths.max > 50.0 &&
         speeds.percentile(0.5) < 0.01 * speeds.max && speeds.zeros < speeds.counted / 2;
}

/// [file's unit] The velocity range of a phase-contrast MR that is nothing but vectors: noise in the air fills all of it, in
/// each component alike, up to the corners of the cube. 0: it is none.
double velocity_range(const Facts& facts) {
  const std::vector<VolumeField>& fields = facts.file.volume.fields;
  if (fields.size() != 1 || fields[0].field->components() != 3 || fields[0].resampling) return 0.0;
  const std::vector<ValueRange> value_ranges = fields[0].field->value_ranges();
  const double range = value_ranges[0].max;
  const bool is_filled = std::all_of(value_ranges.begin(), value_ranges.end(), [&](const ValueRange& extent) {
    return std::abs(extent.max - range) < 0.01 * range && std::abs(extent.min + range) < 0.01 * range;
  });
  return range > 0.0 && is_filled && facts.values[0].max > 1.5 * range ? range : 0.0;
}

/// What the fields of a simulation or of a measured flow are, by their names and grids; empty if these do not tell.
std::string flow_kind(const Facts& facts) {
  const Volume& volume = facts.file.volume;
  const std::string names = names_of(volume);
  std::vector<std::string> listed;
  bool resampled = false, vectors = false, speeds = false, scalars = false;
  for (const VolumeField& field : volume.fields) {
    if (listed.size() < 6) listed.push_back(field.name);
    resampled = resampled || field.resampling;
    (field.field->components() == 3 ? vectors : scalars) = true;
    speeds = speeds || is_speed_unit(field.unit);
  }
  if (volume.fields.size() > listed.size()) listed.back() = fmt::format("{} more", volume.fields.size() + 1 - listed.size());
  const std::string with = ": " + list_of(listed);
  if (volume.format == "plot3d" || volume.format == "openfoam") return "CFD" + with;
  const bool velocity = speeds || has_any(names, {"veloc", " u ", " vel", "wind", "flow"}) || !separate_vectors(volume).empty();
  const bool weather = has_any(names, {"wind", "rain", "cloud", "humid", "qvapor", "snow", "ice", "precip", "geopotential"});
  if (weather) return "looks like weather" + with;
  if (velocity &&
      has_any(names, {"pressure", " p ", "mach", "density", "rho", " k ", "omega", "epsilon", "nut", "temperature", " t "}))
    return "looks like CFD" + with;
  if (const double range = velocity_range(facts); range > 0.0)
    return fmt::format("looks like phase-contrast MR, VENC {:.4g}{}", range,
                       volume.fields[0].unit.empty() ? " (no unit in the file)" : " " + volume.fields[0].unit);
  if (looks_like_velocity_mr(facts)) {
    return "looks like velocity MR (phase contrast): a signal and velocities";
  }
  if (vectors && (resampled || facts.placed.grid.is_rectilinear())) {
    return std::string("looks like CFD: ") + (scalars ? "vectors and values" : "vectors") +
           (resampled ? " on a grid of cells of many sizes" : " on a grid of uneven planes");
  }
  if (velocity && (vectors || !separate_vectors(volume).empty())) return "a flow" + with;
  if (velocity) return "looks like the speed of a flow or of wind, without its direction" + with;
  return {};
}

std::string field_kind(const Facts& facts, std::size_t f) {
  const VolumeField& field = facts.file.volume.fields[f];
  const Statistics& values = facts.values[f];
  const bool medical = facts.file.volume.medical_frame;
  if (field.field->components() == 3) {
    if (!looks_like_directions(values)) return {};
    return medical ? "looks like diffusion directions (vectors of length 1)" : "directions (vectors of length 1)";
  }
  if (const auto water = ct_water(values, field.unit, facts.file.volume.modality)) {
    if (field.unit == "HU") return "CT, in Hounsfield units";
    return *water == 0.0 ? "looks like CT, in Hounsfield units (air near -1000, soft tissue near 0)"
                         : "looks like CT with its numbers 1024 above Hounsfield units (air near 0, soft tissue near 1050)";
  }
  if (const std::size_t count = facts.labels[f].labels.size(); count > 0) {
    return count == 1 ? "looks like a mask (two values, in and out)" : fmt::format("looks like a label map of {} parts", count);
  }
  return {};
}

/// What the fields are by their components alone, if nothing more is known.
std::string plain_kind(const Facts& facts) {
  const Volume& volume = facts.file.volume;
  std::vector<std::string> kinds;
  std::size_t vectors = 0;
  for (const VolumeField& field : volume.fields) vectors += field.field->components() == 3;
  const std::size_t scalars = volume.fields.size() - vectors;
  if (vectors > 0) kinds.push_back(vectors == 1 ? "a vector field" : fmt::format("{} vector fields", vectors));
  if (scalars > 0) kinds.push_back(scalars == 1 ? "one value per voxel" : fmt::format("{} values per voxel", scalars));
  return list_of(kinds) + ", of no stated kind";
}

}  // namespace

std::string scan_fact(const Volume& volume, ScanFactKind kind, const char* form) {
  for (const ScanFact& fact : volume.scan) {
    if (fact.kind != kind) continue;
    if (is_number(kind)) return fmt::format(fmt::runtime(form), fact.number);
    return fact.words.empty() ? fact.words : fmt::format(fmt::runtime(form), fact.words);
  }
  return {};
}

LabelMap labels_in(const Volume& volume, const VolumeField& field, const Statistics& values) {
  const auto filled = std::ranges::count_if(values.histogram.counts, [](std::int64_t count) { return count > 0; });
  const bool may_be = values.one_in == 1 && filled <= static_cast<std::ptrdiff_t>(LabelMap::most_values);
  return may_be ? label_map_unless_said(*field.field, values, field.unit, volume.modality) : LabelMap{};
}

bool looks_like_scan(const Facts& facts) {
  const Volume& volume = facts.file.volume;
  if (volume.medical_frame || looks_like_velocity_mr(facts)) return true;
  for (std::size_t f = 0; f < volume.fields.size(); ++f) {
    if (volume.fields[f].field->components() == 1 && ct_water(facts.values[f], volume.fields[f].unit, volume.modality))
      return true;
  }
  return false;
}

std::string gantry_tilt(const Facts& facts) {
  const Volume& volume = facts.file.volume;
  // Slices of a CT are sheared by nothing else.
  if (volume.format != "dicom" || volume.modality != "CT" || !(facts.placed.sheared_deg > least_shear_deg)) return {};
  return fmt::format("gantry tilt of {:.3g}°", facts.placed.sheared_deg);
}

std::string kind_of(const Facts& facts) {
  const Volume& volume = facts.file.volume;
  const std::string in_frames = facts.file.frames > 1 && !facts.directions ? fmt::format(", {} frames", facts.file.frames) : "";
  if (volume.format == "dicom" || !volume.modality.empty()) {
    const VolumeField& first = volume.fields.front();
    const bool hounsfield =
        first.field->components() == 1 && looks_like_hounsfield(facts.values.front(), first.unit, volume.modality);
    return dicom_kind(volume) + (hounsfield ? ", in Hounsfield units" : "") + in_frames;
  }
  if (facts.directions) return "looks like diffusion directions (three frames that are vectors of length 1)";
  const bool scan_format = volume.format == "nifti" || volume.format == "nrrd" || volume.format == "metaimage";
  const std::string by_name = volume.medical_frame || scan_format ? scan_by_name(facts.name) : "";
  if (volume.fields.size() == 1) {
    if (const std::string kind = field_kind(facts, 0); !kind.empty()) return kind + in_frames;
    if (!by_name.empty()) return "a scan of unknown modality (" + by_name + " by its file's name)" + in_frames;
  }
  if (const std::string flow = flow_kind(facts); !flow.empty()) return flow + in_frames;
  std::vector<std::string> kinds;
  for (std::size_t f = 0; f < volume.fields.size(); ++f) {
    if (std::string kind = field_kind(facts, f); !kind.empty()) {
      kinds.push_back(volume.fields.size() > 1 ? "'" + volume.fields[f].name + "' " + kind : kind);
    }
  }
  if (!kinds.empty()) return list_of(kinds) + in_frames;
  const double longest_m = largest_component(facts.placed.size_m);
  if (longest_m < 1e-7 || has_any(names_of(volume), {"electron", "orbital", "probability_density", "molecul"})) {
    return "looks like an atom or a molecule: " + plain_kind(facts) + in_frames;
  }
  if (volume.medical_frame && volume.fields.size() == 1 && volume.fields[0].field->components() == 1) {
    return "a scan of unknown modality (the file does not say it)" + in_frames;
  }
  return plain_kind(facts) + in_frames;
}

}  // namespace palpa::app
