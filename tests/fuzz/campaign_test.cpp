// The campaign frame: finding, minimisation, storage and reproduction of failures; resumption.
#include "tests/fuzz/campaign.h"

#include <gmock/gmock.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <numeric>
#include <set>
#include <sstream>
#include <thread>

namespace palpa::fuzz {
namespace campaign_test {

class CampaignTest : public testing::Test {
 protected:
  CampaignTest() {
    std::string name = (fs::temp_directory_path() / "palpa-test-XXXXXX").string();
    folder_ = ::mkdtemp(name.data());
    options_.findings = folder_ / "findings";
  }
  ~CampaignTest() override { fs::remove_all(folder_); }

  static Campaign of(const Attempt& attempt) {
    return {.name = "made up", .of = "cases", .begin = [=](const fs::path&) { return attempt; }, .patience_s = 0.5};
  }
  /// The one finding that is kept.
  Finding finding() const {
    for (const auto& entry : fs::directory_iterator(options_.findings / "made_up"))
      return load_finding(entry.path() / "choices");
    return {};
  }

  fs::path folder_;
  RunOptions options_;
  Row row_;
};

/// A list of up to 50 numbers below 1000; a number above 900 breaks its promise.
Tried judged_list(Choices& choices) {
  for (std::uint64_t n = choices.below(51); n > 0; --n) {
    if (choices.below(1000) > 900) return {.broken = "no number is above 900: " + std::to_string(n)};
  }
  return {};
}

TEST(Choices, AreThoseOfTheirSeedAndOfTheirList) {
  std::vector<std::uint64_t> record(100);
  Choices seeded(7, record), again(7), other(8);
  std::vector<std::uint64_t> drawn, drawn_again, drawn_other;
  for (std::uint64_t n = 1; n <= 100; ++n) {
    drawn.push_back(seeded.below(n));
    drawn_again.push_back(again.below(n));
    drawn_other.push_back(other.below(n));
    ASSERT_LT(drawn.back(), n);
  }
  EXPECT_EQ(drawn, drawn_again);
  EXPECT_NE(drawn, drawn_other);
  EXPECT_EQ(drawn, record);
  Choices listed(record);
  for (std::uint64_t n = 1; n <= 100; ++n) EXPECT_EQ(listed.below(n), drawn[n - 1]);
  EXPECT_EQ(listed.below(5), 0U) << "beyond its end a list has zeros";
}

TEST(Choices, OfNeighbouringSeedsAreNotTheSameAStepLater) {
  std::set<std::uint64_t> all;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    Choices choices(seed);
    for (int n = 0; n < 100; ++n) all.insert(choices.below(UINT64_MAX));
  }
  EXPECT_EQ(all.size(), 10'000U);
}

TEST(Shrunk, IsTheSmallestThatBreaksTheSamePromise) {
  std::vector<std::uint64_t> list(60);
  std::iota(list.begin(), list.end(), 890);
  list.front() = 50;
  const auto broken = [](const std::vector<std::uint64_t>& smaller) {
    Choices choices(smaller);
    return judged_list(choices).broken;
  };
  ASSERT_NE(broken(list), "");
  EXPECT_EQ(shrunk(list, 10'000, broken), (std::vector<std::uint64_t>{1, 901}));
}

TEST_F(CampaignTest, CountsWhatItTried) {
  run(of([](Choices&, const fs::path& folder) {
        EXPECT_TRUE(fs::is_empty(folder));
        return Tried{.tries = 10, .slowest_s = 0.25};
      }),
      100, row_, options_);
  EXPECT_EQ(row_.tries, 100);
  EXPECT_EQ(row_.next_seed, 11U);
  EXPECT_EQ(row_.failures, 0);
  EXPECT_EQ(row_.slowest_s, 0.25);
  EXPECT_FALSE(fs::exists(options_.findings));
}

TEST_F(CampaignTest, KeepsWhatBrokeAPromiseMadeSmaller) {
  while (row_.failures == 0)
    run(of([](Choices& choices, const fs::path&) { return judged_list(choices); }), row_.tries + 1, row_, options_);
  EXPECT_EQ(finding().campaign, "made up");
  EXPECT_EQ(finding().choices, (std::vector<std::uint64_t>{1, 901}));
}

TEST_F(CampaignTest, SurvivesACaseThatCrashes) {
  run(of([](Choices& choices, const fs::path&) -> Tried {
        if (choices.below(20) > 10) ::raise(SIGKILL);
        return {};
      }),
      30, row_, options_);
  EXPECT_GE(row_.tries, 30);
  EXPECT_GT(row_.failures, 3);
  EXPECT_LT(row_.failures, 30);
  EXPECT_EQ(finding().choices, (std::vector<std::uint64_t>{11}));
}

TEST_F(CampaignTest, EndsACaseThatNeverEnds) {
  options_.findings.clear();
  run(of([](Choices& choices, const fs::path&) -> Tried {
        if (choices.below(2) == 1) std::this_thread::sleep_for(std::chrono::hours(1));
        return {};
      }),
      4, row_, options_);
  EXPECT_EQ(row_.tries, 4);
  EXPECT_GT(row_.failures, 0);
}

TEST_F(CampaignTest, GoesOnWhereItsTableEnds) {
  const Campaign campaign = of([](Choices&, const fs::path&) { return Tried{}; });
  Table table;
  table["made up"] = {
      .next_seed = 42, .tries = 41, .failures = 2, .slowest_s = 0.1, .slowest_seed = 3, .peak_bytes = 1e7, .spent_s = 5};
  save_table(folder_ / "table", table);
  Table loaded = load_table(folder_ / "table");
  run(campaign, 51, loaded["made up"], options_);
  EXPECT_EQ(loaded["made up"].next_seed, 52U);
  EXPECT_EQ(loaded["made up"].tries, 51);
  EXPECT_EQ(loaded["made up"].failures, 2);
  std::ostringstream text;
  print_table(text, table, {campaign});
  EXPECT_THAT(text.str(), testing::HasSubstr("| made up | 41 cases | 2 | 100.000 (3) | 10 | 0.001 |"));
  EXPECT_THROW(load_table("/proc/self/status"), std::runtime_error);
}

}  // namespace campaign_test
}  // namespace palpa::fuzz
