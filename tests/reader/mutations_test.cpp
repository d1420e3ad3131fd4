// Real files of every kind, damaged at random: each is a result or one line, never a crash, a hang or a lie about size.
#include "mutations.h"

#include "files.h"

namespace palpa::test {
namespace {

class Mutations : public ReaderTest, public ::testing::WithParamInterface<DataSet> {};

TEST_P(Mutations, GiveAResultOrOneLine) {
  if (shared_file(GetParam().file).empty()) GTEST_SKIP() << "the shared data are not here: set PALPA_SHARED to their folder";
  options_.max_bytes = 100'000'000;
  options_.idle_limit_s = 5;
  const MutationResult result = read_mutations(shared_file("facts.json").parent_path(), GetParam(), 30, 1, options_);
  EXPECT_EQ(result.read + result.refused, 30);
  for (const std::string& wrong : result.wrong) ADD_FAILURE() << wrong;
  RecordProperty("read_well", result.read);
}

INSTANTIATE_TEST_SUITE_P(Files, Mutations, ::testing::ValuesIn(data_sets()), [](const auto& set) {
  std::string name = set.param.file;
  for (char& c : name) c = std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  return name;
});

}  // namespace
}  // namespace palpa::test
