// A new user's path for each data set of a folder: a first scene, then each simulated hand and each recording, through the
// program. Prints the table of docs/data.md; exit status 1 if a promised figure is missed.
//
//   bench_first_touch PALPA DATA [FILE…]
//
// PALPA: the program. DATA: the shared data with its folder `trajectories`. FILEs replace the sets of DATA.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "palpa/data/quantile.h"
#include "tests/reader/data_sets.h"

namespace fs = std::filesystem;
using nlohmann::json;

namespace {

std::string quoted(const std::string& word) {
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

/// Standard output of a command; empty on failure.
std::string output_of(const std::vector<std::string>& words) {
  std::string command;
  for (const std::string& word : words) command += quoted(word) + " ";
  std::FILE* pipe = ::popen((command + "2>/dev/null").c_str(), "r");
  if (!pipe) return {};
  std::string out;
  char buffer[4096];
  for (std::size_t n = std::fread(buffer, 1, sizeof buffer, pipe); n > 0; n = std::fread(buffer, 1, sizeof buffer, pipe))
    out.append(buffer, n);
  return ::pclose(pipe) == 0 ? out : std::string{};
}

struct Touch {
  bool ran = false;
  double contact_share = 0.0;  // [1] of the ticks
  double below_share = 0.0;    // [1] of the ticks, below the limit
  bool said = true;            // a note reports weak contact
};
Touch touch(const std::string& palpa, const std::string& scene, const std::vector<std::string>& hand) {
  std::vector<std::string> words{palpa, "run", scene, "--json"};
  words.insert(words.end(), hand.begin(), hand.end());
  const std::string text = output_of(words);
  if (text.empty()) return {};
  const json summary = json::parse(text);
  Touch touched{.ran = true, .contact_share = summary["contact_share"]};
  touched.below_share = 1.0 - summary["guard_limited_ticks"].get<double>() / std::max(1.0, summary["ticks"].get<double>());
  if (touched.contact_share < 0.05) {
    touched.said = std::any_of(summary["notes"].begin(), summary["notes"].end(),
                               [](const json& note) { return note.get<std::string>().find(" was felt") != std::string::npos; });
  }
  return touched;
}

const char* const simulated[] = {"press", "stroke", "circle", "helix", "random"};

}  // namespace

int main(int argc, char** argv) {
  if (argc < 3) {
    std::fprintf(stderr, "usage: %s PALPA DATA [FILE...]\n", argv[0]);
    return 2;
  }
  const std::string palpa = argv[1];
  const fs::path data = argv[2];
  std::vector<std::string> files(argv + 3, argv + argc);
  if (files.empty()) {
    for (const auto& set : palpa::test::data_sets()) files.push_back((data / set.file).string());
  }
  std::vector<std::vector<std::string>> recordings;
  for (const fs::directory_entry& entry : fs::directory_iterator(data / "trajectories")) {
    const std::string name = entry.path().filename().string();
    if (name.find("inverse3") != std::string::npos) recordings.push_back({"--hand", entry.path().string()});
    if (name.find("pose") != std::string::npos)
      recordings.push_back({"--hand", entry.path().string(), "--hand-rate-hz", "120"});
  }
  std::sort(recordings.begin(), recordings.end());

  char folder_name[] = "/tmp/palpa-first-touch-XXXXXX";
  if (!::mkdtemp(folder_name)) return 2;
  const fs::path folder = folder_name;
  std::puts("| set | press | stroke | circle | helix | random | recordings: least, median | below the limit, least |");
  std::puts("|---|---|---|---|---|---|---|---|");
  int simulated_runs = 0, simulated_low = 0, recorded_runs = 0, recorded_low = 0, unsaid = 0, at_limit = 0, failed = 0;
  for (const std::string& file : files) {
    const std::string scene = (folder / "first.toml").string();
    fs::remove(scene);
    std::string row = "| " + fs::path(file).filename().string();
    output_of({palpa, "info", file, "--scene", scene});
    if (!fs::exists(scene)) {
      std::printf("%s | no first scene |\n", row.c_str());
      ++failed;
      continue;
    }
    double least_below = 1.0;
    const auto look = [&](const Touch& touched) {
      failed += !touched.ran;
      unsaid += !touched.said;
      at_limit += touched.below_share < 0.99;
      least_below = std::min(least_below, touched.below_share);
    };
    char cell[80];
    for (const char* name : simulated) {
      const Touch touched = touch(palpa, scene, {"--hand", std::string("sim:") + name});
      look(touched);
      ++simulated_runs;
      simulated_low += touched.contact_share < 0.3;
      std::snprintf(cell, sizeof cell, " | %.0f %%", 100.0 * touched.contact_share);
      row += cell;
    }
    std::vector<double> shares;
    for (const auto& recording : recordings) {
      const Touch touched = touch(palpa, scene, recording);
      look(touched);
      ++recorded_runs;
      recorded_low += touched.contact_share < 0.2;
      shares.push_back(touched.contact_share);
    }
    if (!shares.empty()) {
      std::snprintf(cell, sizeof cell, " | %.0f, %.0f %%", 100.0 * palpa::detail::quantile(shares, 0.0),
                    100.0 * palpa::detail::median(shares));
      row += cell;
    }
    std::printf("%s | %.2f %% |\n", row.c_str(), 100.0 * least_below);
    std::fflush(stdout);
  }
  fs::remove_all(folder);
  std::printf(
      "\n%d simulated runs, %d below 30 %% of contact; %d recorded runs, %d below 20 %%; %d below 5 %% and not told; %d with "
      "the force at its limit in more than 1 %% of the ticks; %d that failed\n",
      simulated_runs, simulated_low, recorded_runs, recorded_low, unsaid, at_limit, failed);
  return simulated_low > 0 || 20 * recorded_low > recorded_runs || unsaid + at_limit + failed > 0 ? 1 : 0;
}
