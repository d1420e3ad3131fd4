// Randomly damaged real files of every kind: no crash, hang or wrong size.
#include "mutations.h"

#include "data_sets.h"

namespace palpa::test {
namespace mutations_test {

class Mutations : public ReaderTest, public ::testing::WithParamInterface<SetToDamage> {};

TEST_P(Mutations, GiveAResultOrOneLine) {
  if (const fs::path original = GetParam().original(folder_); !fs::exists(original))
    GTEST_SKIP() << "the shared data are not here: set PALPA_SHARED to their folder";
  options_.max_bytes = 100'000'000;
  options_.idle_limit_s = 5;
  const MutationResult result = read_mutations(GetParam(), 30, 1, options_);
  EXPECT_EQ(result.read + result.refused, 30);
  for (const std::string& wrong : result.wrong) ADD_FAILURE() << wrong;
  RecordProperty("read_well", result.read);
}

INSTANTIATE_TEST_SUITE_P(Files, Mutations, ::testing::ValuesIn(sets_to_damage(shared_file("facts.json").parent_path())),
                         [](const auto& set) { return name_of({set.param.name}); });

}  // namespace mutations_test
}  // namespace palpa::test
