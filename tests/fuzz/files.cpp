// Files of every format, damaged, each through a palpa-read of its own.
#include <algorithm>
#include <map>

#include "tests/fuzz/campaigns.h"
#include "tests/fuzz/program.h"
#include "tests/reader/mutations.h"

namespace palpa::fuzz {
namespace {

test::Damage damage_of(Choices& choices) {
  return test::Damage([&](std::size_t n) { return static_cast<std::size_t>(choices.below(std::max<std::size_t>(n, 1))); });
}

Attempt begin(const test::SetToDamage& set) {
  ReadOptions options;
  options.reader = programs_folder() / "palpa-read";
  options.max_bytes = 1'000'000'000;
  options.idle_limit_s = 8.0 * slowness;
  options.checksums = false;  // which would notice what a reader passes over
  const auto damaged = std::make_shared<test::DamagedSet>(set, options);
#if defined(__SANITIZE_ADDRESS__)
  const bool is_dicom = set.name.find("dicom") != std::string::npos;
#else
  constexpr bool is_dicom = false;
#endif
  return [damaged, is_dicom](Choices& choices, const fs::path& folder) {
    test::Damage damage = damage_of(choices);
    test::MutationResult read;
    damaged->damage_once(damage, folder / "damaged", read);
    Tried result{.slowest_s = read.slowest_s, .refused = read.refused};
    if (!read.wrong.empty()) result.broken = read.wrong.front();
#if defined(__SANITIZE_ADDRESS__)
    // A reader that ended is its user's one line; here it is also what the sanitizers found in ours. They end by an exit code:
    // an abort is one of GDCM's assertions, which Debian leaves in.
    const auto is_gdcm = [&](const std::string& ended) { return is_dicom && ended.find("signal 6 ") != std::string::npos; };
    const auto found = std::ranges::find_if_not(read.ended, is_gdcm);
    if (result.broken.empty() && found != read.ended.end()) result.broken = "a reader does not end by itself: " + *found;
#endif
    return result;
  };
}

std::string missing(const test::SetToDamage& set) {
  if (const std::string why = missing_program("palpa-read"); !why.empty()) return why;
  const test::TemporaryFolder folder;
  return fs::exists(set.original(folder)) ? "" : "the shared data are not here: set PALPA_SHARED to their folder";
}

}  // namespace

void add_files(std::vector<Campaign>& to) {
  const fs::path facts = test::shared_file("facts.json");
  for (const test::SetToDamage& set : test::sets_to_damage(facts.parent_path())) {
    to.push_back({.name = "file " + set.name,
                  .of = "files",
                  .long_tries = 2'000,  // of each format: of all of them together more than 100 000
                  .begin = [set](const fs::path&) { return begin(set); },
                  .patience_s = 120.0 * slowness,
                  .missing = [set] { return missing(set); }});
  }
}

}  // namespace palpa::fuzz
