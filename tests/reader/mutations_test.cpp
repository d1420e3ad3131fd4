// Small real files, damaged at random: each is a result or one line, never a crash, a hang or a lie about size.
#include <cmath>
#include <fstream>
#include <random>
#include <sstream>

#include "files.h"

namespace palpa::test {
namespace {

class Mutations : public ReaderTest, public ::testing::WithParamInterface<const char*> {
 protected:
  void SetUp() override { ReaderTest::SetUp(); }
};

std::string damaged(std::string bytes, std::mt19937& random) {
  const auto below = [&](std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(random); };
  // Headers are small and matter most: half of the damage goes to the first 400 bytes.
  const auto place = [&] { return below(2) == 0 ? below(std::min<std::size_t>(bytes.size(), 400)) : below(bytes.size()); };
  switch (below(5)) {
    case 0: bytes.resize(place()); break;
    case 1:
      for (int n = 0; n < 4; ++n) bytes[place()] ^= static_cast<char>(1 << below(8));
      break;
    case 2:
      for (int n = 0; n < 3; ++n) bytes[place()] = static_cast<char>("09-9e\xff"[below(6)]);
      break;
    case 3: bytes.erase(place(), 1 + below(16)); break;
    default: bytes.insert(place(), std::string(1 + below(16), static_cast<char>(below(256)))); break;
  }
  return bytes;
}

TEST_P(Mutations, GiveAResultOrOneLine) {
  const fs::path original = shared_file(GetParam());
  if (original.empty()) GTEST_SKIP() << "the shared data are not here: set PALPA_SHARED to their folder";
  std::stringstream content;
  content << std::ifstream(original, std::ios::binary).rdbuf();
  options_.max_bytes = 100'000'000;
  options_.idle_limit_s = 5;
  std::mt19937 random(1);
  int read_well = 0;
  for (int n = 0; n < 30; ++n) {
    SCOPED_TRACE("mutation " + std::to_string(n));
    const std::string bytes = damaged(content.str(), random);
    const fs::path file = folder_.write(original.filename().string(), bytes);
    try {
      const Volume volume = read(file);
      for (const VolumeField& field : volume.fields) {
        const Vec3 middle_m = field.field->bounds_m().centre_m();
        EXPECT_TRUE(std::isfinite(field.field->components() == 1 ? field.field->scalar(middle_m).value
                                                                 : field.field->vector(middle_m).value.x));
      }
      ++read_well;
    } catch (const LoadError& error) {
      const std::string text = error.what();
      EXPECT_EQ(text.rfind(file.string() + ": ", 0), 0U) << text;
      EXPECT_EQ(text.find('\n'), std::string::npos) << text;
    }
  }
  RecordProperty("read_well", read_well);
}

INSTANTIATE_TEST_SUITE_P(Files, Mutations,
                         ::testing::Values("mri_epi_4d/example_nifti2.nii.gz", "mri_mha_zlib/mha.mha",
                                           "mra_avf_nrrd/avf_float_32.nrrd", "mol_hydrogen/hydrogen.vti",
                                           "mol_ironprot/ironProt.vtk"),
                         [](const auto& file) {
                           std::string name = fs::path(file.param).stem().stem().string();
                           for (char& c : name) c = std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
                           return name;
                         });

}  // namespace
}  // namespace palpa::test
