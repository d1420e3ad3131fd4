// Damaged files of every format, each through a palpa-read of its own.
#include <algorithm>

#include "tests/fuzz/campaigns.h"
#include "tests/fuzz/program.h"
#include "tests/reader/mutations.h"

namespace palpa::fuzz {
namespace {

test::Damage damage_of(Choices& choices) {
  return test::Damage([&](std::size_t n) { return static_cast<std::size_t>(choices.below(std::max<std::size_t>(n, 1))); });
}

/// A crashed reader is a one-line error for its user; under sanitizers it is also a finding in Palpa's code, and ends with an
/// exit code. A signal counts as an unsanitized library's: a line without findings, too. Only a stack overflow or an address of
/// no memory that is not null looks alike in Palpa's code. An abort may be an assertion of Palpa, but for DICOM, where Debian
/// keeps GDCM's.
bool is_crash_of_library(const std::string& set, const std::string& ended) {
  const auto by = [&](const char* signal) { return ended.find(signal) != std::string::npos; };
  const bool is_gdcm = set.find("dicom") != std::string::npos;
  return by("signal 11 ") || by("signal 8 ") || by("signal 7 ") || (is_gdcm && by("signal 6 "));
}

Attempt begin(const test::SetToDamage& set) {
  ReadOptions options;
  options.reader = programs_folder() / "palpa-read";
  options.max_bytes = 1'000'000'000;
  options.idle_limit_s = 8.0 * slowness;
  options.checksums = Checksums::none;  // which would find damage that a reader passes over
  const auto damaged = std::make_shared<test::DamagedSet>(set, options);
  return [damaged, name = set.name](Choices& choices, const fs::path& folder) {
    test::Damage damage = damage_of(choices);
    test::MutationResult read;
    damaged->damage_once(damage, folder / "damaged", read);
    Tried result{.slowest_s = read.slowest_s, .refused = read.refused};
    for (const std::string& ended : read.ended) {
      if (is_sanitized && !is_crash_of_library(name, ended)) result.broken = "a reader does not end by itself: " + ended;
    }
    if (!read.wrong.empty()) result.broken = read.wrong.front();
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
                  .long_tries = 2'000,  // of each format: more than 100 000 together
                  .begin = [set](const fs::path&) { return begin(set); },
                  .patience_s = 120.0 * slowness,
                  .missing = [set] { return missing(set); }});
  }
}

}  // namespace palpa::fuzz
