// Campaigns as a command: runs them from a seed on, and prints the table.
//
//   palpa_campaign [OPTION]... [NAME]...      a NAME, or its beginning: "ticks", "file", "fault disk"; none: all
//
// 0: no failure, 1: failures, 2: wrong usage.
#include <signal.h>

#include <charconv>
#include <cstdio>
#include <cstring>
#include <iostream>
#include <optional>

#include "tests/fuzz/campaigns.h"
#include "tests/today.h"

namespace {

using namespace palpa::fuzz;

constexpr const char* usage =
    "usage: palpa_campaign [OPTION]... [NAME]...\n"
    "  NAME             a campaign, or how its name begins; none: all of them\n"
    "  --count N        until so many tries were made, those of the table included (1000)\n"
    "  --long           until as many were made as of a long run, hours or days\n"
    "  --seed N         begin with this seed (1); the same seed is the same case; 'today': one of this day's own\n"
    "  --table FILE     go on where this table ends, and keep it up to date\n"
    "  --findings DIR   keep what broke a promise, made smaller, in this folder\n"
    "  --jobs N         so many processes try at the same time (1)\n"
    "  --replay FILE    only the case that was kept in this file 'choices', in this process, in the folder 'case'\n"
    "  --print          only the table\n"
    "  --list           only the names\n";

struct Options {
  std::vector<std::string> names;
  std::int64_t count = 1000;
  std::optional<std::uint64_t> seed;
  fs::path table, replay;
  RunOptions run;
  bool prints = false, lists = false, is_long = false;
};

template <class T>
bool take_number(const char* text, T& number) {
  const char* end = text + std::strlen(text);
  const auto [last, error] = std::from_chars(text, end, number);
  return error == std::errc() && last == end && number > 0;
}

/// Far from yesterday's: more than the tries of a day.
std::uint64_t seed_of_today() { return 1'000'000'000U * static_cast<std::uint64_t>(palpa::test::today()); }

std::optional<Options> options_of(int argc, char** argv) {
  Options options;
  for (int n = 1; n < argc; ++n) {
    const std::string_view word = argv[n];
    const char* value = n + 1 < argc ? argv[n + 1] : "";
    if (word == "--print") {
      options.prints = true;
    } else if (word == "--list") {
      options.lists = true;
    } else if (word == "--long") {
      options.is_long = true;
      options.run.round_s = 60.0;  // each process makes the shared parts: less of a round's time
    } else if (!word.starts_with("-")) {
      options.names.emplace_back(word);
    } else {
      std::uint64_t seed = 0;
      bool good = true;
      if (word == "--count") {
        good = take_number(value, options.count);
      } else if (word == "--seed") {
        good = std::string_view(value) == "today" || take_number(value, seed);
        options.seed = seed > 0 ? seed : seed_of_today();
      } else if (word == "--jobs") {
        good = take_number(value, options.run.jobs);
      } else if (word == "--table") {
        options.table = value;
      } else if (word == "--findings") {
        options.run.findings = value;
      } else if (word == "--replay") {
        options.replay = value;
      } else {
        good = false;
      }
      if (!good) return std::nullopt;
      ++n;
    }
  }
  return options;
}

bool is_asked_for(const Campaign& campaign, const Options& options) {
  if (options.names.empty()) return true;
  for (const std::string& name : options.names) {
    if (campaign.name.starts_with(name)) return true;
  }
  return false;
}

int replay(const Options& options, const std::vector<Campaign>& campaigns) {
  const Finding finding = load_finding(options.replay);
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) ::signal(number, SIG_DFL);
  for (const Campaign& campaign : campaigns) {
    if (campaign.name != finding.campaign) continue;
    fs::create_directories("case/shared");
    fs::create_directories("case/own");
    Choices choices(finding.choices);
    const Tried tried = campaign.begin(fs::absolute("case/shared"))(choices, fs::absolute("case/own"));
    std::cout << (tried.broken.empty() ? "nothing is broken" : tried.broken) << '\n';
    return tried.broken.empty() ? 0 : 1;
  }
  throw std::runtime_error(finding.campaign + ": no such campaign; see --list");
}

int run_all(Options& options, const std::vector<Campaign>& campaigns) {
  Table table = options.table.empty() ? Table() : load_table(options.table);
  if (options.prints) return print_table(std::cout, table, campaigns), 0;
  options.run.says = &std::cout;
  bool broken = false;
  for (const Campaign& campaign : campaigns) {
    if (!is_asked_for(campaign, options) || interrupted) continue;
    if (const std::string missing = campaign.missing ? campaign.missing() : ""; !missing.empty()) {
      std::cout << campaign.name << ": left out, " << missing << std::endl;
      continue;
    }
    Row& row = table[campaign.name];
    if (options.seed) row.next_seed = *options.seed;
    options.run.save = [&](const Row&) {
      if (!options.table.empty()) save_table(options.table, table);
    };
    const std::int64_t before = row.failures;
    run(campaign, options.is_long ? campaign.long_tries : options.count, row, options.run);
    broken = broken || row.failures > before;
  }
  print_table(std::cout, table, campaigns);
  return broken ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
  std::optional<Options> options = options_of(argc, argv);
  if (!options) return std::fputs(usage, stderr), 2;
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) ::signal(number, [](int) { interrupted = 1; });
  ::signal(SIGPIPE, SIG_IGN);
  try {
    const std::vector<Campaign> campaigns = all_campaigns();
    if (options->lists) {
      for (const Campaign& campaign : campaigns) std::cout << campaign.name << '\n';
      return 0;
    }
    return options->replay.empty() ? run_all(*options, campaigns) : replay(*options, campaigns);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "palpa_campaign: %s\n", error.what());
    return 2;
  }
}
