// Cost of a tick in this version over an earlier version, in one run: instructions and distinct lines of code (64 bytes) per
// tick, by valgrind's callgrind; time of hot ticks; time to prepare the cubic filter. And the accuracy of the path:
// bench_path's tables of both versions, at the sizes of the promises.
//
//   bench_versions BASE_BUILD THIS_BUILD DATA [--part instructions|lines|hot|prefilter|path]… [--rounds N]
//
// Both builds are folders with bench_tick_cost, bench_path and palpa-read, built alike and optimised. The earlier version is
// built with these benchmarks, for equal work:
//
//   git worktree add ../palpa-f5900ca f5900ca
//   git -C ../palpa-f5900ca checkout THIS_BRANCH -- bench tests
//   cd ../palpa-f5900ca && cmake --preset bench -DPALPA_VIEW=OFF && cmake --build build/bench --target bench_tick_cost
//   palpa-read
//
// Scenes are the earlier version's, BASE_BUILD/../../scenes; DATA holds the shared sets and `trajectories`. The hand of real
// data is firm on a recording; both versions replay its path in the earlier version.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <set>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include "palpa/data/quantile.h"

namespace fs = std::filesystem;

namespace {

struct Options {
  std::string builds[2];
  std::string data;
  std::vector<std::string_view> parts;
  int rounds = 5;
  bool wants(std::string_view part) const { return parts.empty() || std::ranges::find(parts, part) != parts.end(); }
};

struct Felt {
  std::string name;
  std::string scene;
  fs::path probes;
};

std::string quoted(const std::string& word) {
  std::string out = "'";
  for (const char c : word) out += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return out + "'";
}

std::string command_of(const std::vector<std::string>& words) {
  std::string command;
  for (const std::string& word : words) command += quoted(word) + " ";
  return command;
}

[[noreturn]] void fail(const std::vector<std::string>& words) {
  std::fprintf(stderr, "bench_versions: failed: %s\n", command_of(words).c_str());
  std::exit(2);
}

void run(const std::vector<std::string>& words) {
  if (std::system(command_of(words).c_str()) != 0) fail(words);
}

std::vector<double> numbers_of(const std::vector<std::string>& words) {
  std::vector<double> numbers;
  std::FILE* pipe = ::popen(command_of(words).c_str(), "r");
  char line[256];
  while (pipe && std::fgets(line, sizeof line, pipe)) numbers.push_back(std::atof(line));
  if (!pipe || ::pclose(pipe) != 0 || numbers.empty()) fail(words);
  return numbers;
}

std::string program_of(const Options& options, int version) { return options.builds[version] + "/bin/bench_tick_cost"; }

std::vector<std::string> under_callgrind(const fs::path& out, bool addresses) {
  std::vector<std::string> words{"valgrind",           "--quiet",           "--tool=callgrind",
                                 "--instr-atstart=no", "--compress-pos=no", "--callgrind-out-file=" + out.string()};
  if (addresses) words.insert(words.end(), {"--dump-instr=yes", "--dump-line=no", "--compress-strings=no"});
  return words;
}

/// Callgrind's count of a run: the last line "summary: N" or "totals: N".
double instructions_in(const fs::path& out) {
  std::ifstream file(out);
  double found = 0.0;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("summary: ") || line.starts_with("totals: ")) found = std::atof(line.c_str() + line.find(' '));
  }
  return found;
}

/// Distinct 64 bytes of code in a dump with addresses.
double lines_in(const fs::path& out) {
  std::ifstream file(out);
  std::set<std::pair<std::string, unsigned long long>> seen;
  std::string object;
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("ob=")) object = line;
    if (line.starts_with("0x")) seen.emplace(object, std::stoull(line, nullptr, 16) / 64);
  }
  return static_cast<double>(seen.size());
}

double instructions(const Options& options, const Felt& felt, int version, const fs::path& folder) {
  const fs::path out = folder / "instructions";
  std::vector<std::string> words = under_callgrind(out, false);
  words.insert(words.end(), {program_of(options, version), "count", felt.scene, felt.probes, options.data});
  const std::vector<double> ticks = numbers_of(words);
  return instructions_in(out) / ticks[0];
}

double lines(const Options& options, const Felt& felt, int version, const fs::path& folder) {
  const fs::path out = folder / "lines";
  std::vector<std::string> words = under_callgrind(out, true);
  words.insert(words.end(), {program_of(options, version), "lines", felt.scene, felt.probes, options.data});
  const std::vector<double> ticks = numbers_of(words);
  std::vector<double> each;
  for (int i = 1; i <= static_cast<int>(ticks[0]); ++i) {
    const fs::path dump = out.string() + '.' + std::to_string(i);
    each.push_back(lines_in(dump));
    fs::remove(dump);
  }
  return palpa::detail::median(each);
}

void print_ratio(const std::string& name, double base, double here) {
  std::printf("%-8s %12.1f %12.1f %8.3f\n", name.c_str(), base, here, here / base);
  std::fflush(stdout);
}

void print_times(const Options& options, const std::string& name, const std::vector<std::string>& words) {
  std::vector<double> times[2];
  for (int round = 0; round < options.rounds; ++round) {
    for (const int version : {0, 1}) {
      std::vector<std::string> command{program_of(options, version)};
      command.insert(command.end(), words.begin(), words.end());
      const std::vector<double> passes = numbers_of(command);
      times[version].insert(times[version].end(), passes.begin(), passes.end());
    }
  }
  const double least[]{std::ranges::min(times[0]), std::ranges::min(times[1])};
  const double middle[]{palpa::detail::median(times[0]), palpa::detail::median(times[1])};
  std::printf("%-8s %12.3f %12.3f %8.3f | %12.3f %12.3f %8.3f\n", name.c_str(), least[0], least[1], least[1] / least[0],
              middle[0], middle[1], middle[1] / middle[0]);
  std::fflush(stdout);
}

std::vector<Felt> record_hands(const Options& options, const fs::path& folder) {
  const std::string hand = (fs::path(options.data) / "trajectories/inverse3_woodcarving_20231121_102837.csv").string();
  const fs::path scenes = fs::path(options.builds[0]) / "../../scenes";
  std::vector<Felt> all;
  for (const char* name : {"many", "wing", "flow", "head", "five", "empty"}) {
    Felt felt{name, name, folder / name};
    if (felt.name == "empty") {
      felt.scene = "empty:" + (scenes / "many.toml").string();
    } else if (felt.name != "five") {
      felt.scene = (scenes / (felt.name + ".toml")).string();
    }
    run({program_of(options, 0), "record", felt.scene, hand, "8000", felt.probes, options.data});
    all.push_back(felt);
  }
  return all;
}

void print_paths(const Options& options) {
  const std::pair<const char*, const char*> parts_and_counts[] = {
      {"drift", "0"}, {"bumpy", "0"}, {"grooves", "5"}, {"walls", "100000"}, {"skull", "1000"},    {"follow", "0"},
      {"order", "0"}, {"rate", "0"},  {"halving", "0"}, {"still", "1000"},   {"energy", "1000000"}};
  for (const auto& [part, count] : parts_and_counts) {
    for (const int version : {0, 1}) {
      std::printf("%s\n", version == 0 ? "base" : "this");
      std::fflush(stdout);
      run({options.builds[version] + "/bin/bench_path", "--part", part, "--count", count, options.data});
    }
  }
}

void measure(const Options& options, const fs::path& folder) {
  std::vector<Felt> all;
  if (options.wants("instructions") || options.wants("lines") || options.wants("hot")) all = record_hands(options, folder);
  if (options.wants("instructions")) {
    std::printf("instructions per tick\n%-8s %12s %12s %8s\n", "", "base", "this", "ratio");
    for (const Felt& felt : all)
      print_ratio(felt.name, instructions(options, felt, 0, folder), instructions(options, felt, 1, folder));
  }
  if (options.wants("lines")) {
    std::printf("lines of code (64 bytes) touched in a tick, median of 100 ticks\n%-8s %12s %12s %8s\n", "", "base", "this",
                "ratio");
    for (const Felt& felt : all) print_ratio(felt.name, lines(options, felt, 0, folder), lines(options, felt, 1, folder));
  }
  if (options.wants("hot")) {
    std::printf("us per hot tick: least and median of %d rounds of 5 passes\n%-8s %12s %12s %8s | %12s %12s %8s\n",
                options.rounds, "", "base", "this", "ratio", "base", "this", "ratio");
    for (const Felt& felt : all) print_times(options, felt.name, {"hot", felt.scene, felt.probes, options.data});
  }
  if (options.wants("prefilter")) {
    std::printf("ms to prepare the cubic filter of 512^3 floats, the same\n");
    print_times(options, "cubic", {"prefilter", "512"});
  }
  if (options.wants("path")) print_paths(options);
}

int usage() {
  std::fprintf(stderr,
               "usage: bench_versions BASE_BUILD THIS_BUILD DATA [--part instructions|lines|hot|prefilter|path]... "
               "[--rounds N]\n");
  return 2;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 4) return usage();
  Options options{{argv[1], argv[2]}, argv[3], {}};
  for (int i = 4; i < argc; i += 2) {
    const std::string_view argument = argv[i];
    if (i + 1 == argc) return usage();
    if (argument == "--part") {
      options.parts.emplace_back(argv[i + 1]);
    } else if (argument == "--rounds") {
      options.rounds = std::max(1, std::atoi(argv[i + 1]));
    } else {
      return usage();
    }
  }
  char folder_name[] = "/tmp/palpa-versions-XXXXXX";
  if (!::mkdtemp(folder_name)) return 2;
  measure(options, folder_name);
  fs::remove_all(folder_name);
  return 0;
}
