#include "bench/haptics/suite.h"

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <set>
#include <sstream>

#include "palpa/base/load_error.h"
#include "palpa/base/new_file.h"
#include "palpa/data/sha256.h"

namespace palpa::haptics {

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

constexpr const char* families[] = {"surfaces", "ramps", "sampling",    "noise",    "grooves", "thin", "friction",
                                    "shells",   "turns", "streamlines", "vortices", "hands",   "scans"};

void write(const fs::path& file, const std::string& text) { detail::write_whole(file, text, detail::Existing::replaced); }

/// In steps of 1e-9 of the unit, without a negative zero: identical digits everywhere.
std::string number(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.9f", value);
  return std::string(text) == "-0.000000000" ? "0.000000000" : text;
}
std::string numbers(const Vec3& v, const char* between) { return number(v.x) + between + number(v.y) + between + number(v.z); }

json place(const Vec3& v) { return {v.x, v.y, v.z}; }

void write_case(const Case& one, const json& volume, const fs::path& folder) {
  const json told{{"protocol", 1},
                  {"name", one.name},
                  {"volume", volume},
                  {"rule", one.rule},
                  {"stiffness_n_per_m", stiffness_n_per_m},
                  {"time_step_s", time_step_s},
                  {"force_limit_n", force_limit_n}};
  write(folder / "cases" / (one.name + ".json"), told.dump(2) + "\n");
  const json truth{{"family", one.family},
                   {"quick", one.quick},
                   {"scores", one.scores},
                   {"shape", one.shape},
                   {"period_ticks", one.period_ticks},
                   {"friction_deg", one.friction_deg}};
  write(folder / "truth" / (one.name + ".json"), truth.dump(2) + "\n");
  std::string probes = "t_s,x_m,y_m,z_m\n", forces = "fx_n,fy_n,fz_n,phase\n";
  for (std::size_t i = 0; i < one.touches.size(); ++i) {
    const Touch& touch = one.touches[i];
    probes += number(time_step_s * static_cast<double>(i)) + "," + numbers(touch.probe_m, ",") + "\n";
    forces += numbers(touch.force_n, ",") + "," + std::to_string(static_cast<int>(touch.phase)) + "\n";
  }
  write(folder / "probes" / (one.name + ".csv"), probes);
  write(folder / "truth" / (one.name + ".csv"), forces);
}

void write_checksums(const fs::path& folder) {
  std::set<std::string> names;
  for (const char* part : {"cases", "volumes", "probes", "truth"}) {
    for (const auto& entry : fs::directory_iterator(folder / part)) names.insert(fs::relative(entry.path(), folder).string());
  }
  std::string sums;
  for (const std::string& name : names) sums += detail::sha256_of_file((folder / name).string()) + "  " + name + "\n";
  write(folder / "SHA256SUMS", sums);
}

MadeCase read_case(const fs::path& file, const fs::path& folder) {
  MadeCase made{.name = file.stem().string(), .file = file};
  const fs::path truth_file = folder / "truth" / (made.name + ".json");
  std::ifstream in(truth_file);
  try {
    const json truth = json::parse(in);
    made.family = truth.at("family");
    made.quick = truth.at("quick");
    made.scores = truth.at("scores");
    made.shape = truth.at("shape");
    made.period_ticks = truth.at("period_ticks");
    made.friction_deg = truth.at("friction_deg");
  } catch (const json::exception&) {
    throw LoadError(truth_file.string() + ": is not what was made; make the benchmark's data anew");
  }
  return made;
}

void read_touches(MadeCase& made, const fs::path& folder) {
  std::ifstream probes(folder / "probes" / (made.name + ".csv")), forces(folder / "truth" / (made.name + ".csv"));
  std::string probe_line, force_line;
  std::getline(probes, probe_line);
  std::getline(forces, force_line);
  while (std::getline(probes, probe_line) && std::getline(forces, force_line)) {
    Touch touch;
    int phase = 0;
    const bool read =
        std::sscanf(probe_line.c_str(), "%*f,%lf,%lf,%lf", &touch.probe_m.x, &touch.probe_m.y, &touch.probe_m.z) == 3 &&
        std::sscanf(force_line.c_str(), "%lf,%lf,%lf,%d", &touch.force_n.x, &touch.force_n.y, &touch.force_n.z, &phase) == 4;
    if (!read) break;
    touch.phase = static_cast<Phase>(phase);
    made.touches.push_back(touch);
    std::replace(probe_line.begin(), probe_line.end(), ',', ' ');
    made.probe_lines.push_back(probe_line + "\n");
  }
  if (made.touches.size() < 2 || probes || std::getline(forces, force_line))
    throw LoadError((folder / "truth" / made.name).string() + ": is not whole; make the benchmark's data anew");
}

}  // namespace

void make(const fs::path& folder, const MakeOptions& options) {
  Suite suite;
  add_surface_cases(suite);
  add_hand_cases(suite, options.sources / "hand.csv");
  add_field_cases(suite);
  if (!options.head_file.empty()) add_scan_cases(suite, options.head_file);
  if (options.quick) std::erase_if(suite.cases, [](const Case& one) { return !one.quick; });

  for (const char* part : {"cases", "volumes", "probes", "truth"}) fs::create_directories(folder / part);
  std::map<std::string, json> written;
  const auto write_volume = [&](const std::string& name) {
    const SampledVolume volume = suite.volumes.at(name)();
    const std::size_t first = write_nrrd(volume, folder / "volumes" / (name + ".nrrd"));
    written[name] = {{"file", "../volumes/" + name + ".nrrd"},
                     {"type", volume.type},
                     {"components", volume.components},
                     {"size", volume.grid.size},
                     {"spacing_m", place(volume.grid.spacing_m)},
                     {"origin_m", place(volume.grid.origin_m)},
                     {"header_bytes", first}};
  };
  for (const Case& one : suite.cases) {
    if (!written.contains(one.volume)) write_volume(one.volume);
    write_case(one, written[one.volume], folder);
  }
  if (!options.head_file.empty() && !options.quick) write_volume("head-fine");
  write_checksums(folder);
}

std::vector<MadeCase> read_cases(const fs::path& folder, bool quick) {
  if (!fs::is_directory(folder / "cases"))
    throw LoadError(folder.string() + ": has no cases; make them with bench_haptics make " + folder.string());
  std::vector<MadeCase> cases;
  for (const auto& entry : fs::directory_iterator(folder / "cases")) {
    MadeCase made = read_case(fs::absolute(entry.path()), folder);
    if (quick && !made.quick) continue;
    read_touches(made, folder);
    cases.push_back(std::move(made));
  }
  const auto rank = [](const MadeCase& one) {
    return std::pair(std::find(std::begin(families), std::end(families), one.family) - std::begin(families), one.name);
  };
  std::sort(cases.begin(), cases.end(), [&](const MadeCase& a, const MadeCase& b) { return rank(a) < rank(b); });
  return cases;
}

}  // namespace palpa::haptics
