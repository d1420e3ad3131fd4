// Small real files, damaged at random: each is a result or one line, never a crash, a hang or a lie about size.
// PALPA_MUTATIONS in the environment: how many of each.
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <random>
#include <sstream>

#include "dicom_file.h"

namespace palpa::test {
namespace {

int mutations() {
  const char* count = std::getenv("PALPA_MUTATIONS");
  return count != nullptr ? std::max(1, std::atoi(count)) : 30;
}

std::string content_of(const fs::path& file) {
  std::stringstream content;
  content << std::ifstream(file, std::ios::binary).rdbuf();
  return content.str();
}

/// Headers are small and matter most: half of the damage goes to the first `header` bytes.
std::string damaged(std::string bytes, std::mt19937& random, std::size_t header = 400) {
  const auto below = [&](std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(random); };
  const auto place = [&] { return below(2) == 0 ? below(std::min(bytes.size(), header)) : below(bytes.size()); };
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

class AnyMutations : public ReaderTest {
 protected:
  void SetUp() override {
    ReaderTest::SetUp();
    options_.max_bytes = 100'000'000;
    options_.idle_limit_s = 5;
  }

  /// Reads what may be damaged; true where there is a result.
  bool read_or_refuse(const fs::path& path) const {
    try {
      const Volume volume = read(path);
      for (const VolumeField& field : volume.fields) {
        const Vec3 middle_m = field.field->bounds_m().centre_m();
        EXPECT_TRUE(std::isfinite(field.field->components() == 1 ? field.field->scalar(middle_m).value
                                                                 : field.field->vector(middle_m).value.x));
      }
      return true;
    } catch (const LoadError& error) {
      const std::string text = error.what();
      EXPECT_EQ(text.rfind(path.string() + ": ", 0), 0U) << text;
      EXPECT_EQ(text.find('\n'), std::string::npos) << text;
      ended_ += text.find("ended by signal") != std::string::npos;
      return false;
    }
  }
  mutable int ended_ = 0;  ///< times that a library ended palpa-read, and nothing else
  std::mt19937 random_{1};
};

class Mutations : public AnyMutations, public ::testing::WithParamInterface<const char*> {};

TEST_P(Mutations, GiveAResultOrOneLine) {
  const fs::path original = shared_file(GetParam());
  if (original.empty()) GTEST_SKIP() << "the shared data are not here: set PALPA_SHARED to their folder";
  const std::string content = content_of(original);
  for (const char* partner : {"combxyz.bin", "combq.bin"}) {  // a PLOT3D grid is nothing without its solution
    if (const fs::path file = original.parent_path() / partner; fs::exists(file)) fs::copy_file(file, folder_.path() / partner);
  }
  int read_well = 0;
  for (int n = 0; n < mutations(); ++n) {
    SCOPED_TRACE("mutation " + std::to_string(n));
    read_well += read_or_refuse(folder_.write(original.filename().string(), damaged(content, random_)));
  }
  RecordProperty("read_well", read_well);
  RecordProperty("library_ended_the_reader", ended_);
}

INSTANTIATE_TEST_SUITE_P(Files, Mutations,
                         ::testing::Values("mri_epi_4d/example_nifti2.nii.gz", "mri_mha_zlib/mha.mha",
                                           "mra_avf_nrrd/avf_float_32.nrrd", "mol_hydrogen/hydrogen.vti",
                                           "mol_ironprot/ironProt.vtk", "cfd_office/office.binary.vtk",
                                           "cfd_combustor/combxyz.bin", "cfd_combustor/combq.bin"),
                         [](const auto& file) {
                           std::string name = fs::path(file.param).stem().stem().string();
                           for (char& c : name) c = std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
                           return name;
                         });

class DicomMutations : public AnyMutations, public ::testing::WithParamInterface<gdcm::TransferSyntax::TSType> {};

TEST_P(DicomMutations, GiveAResultOrOneLine) {
  DicomSeries series;
  series.columns = 40, series.rows = 32;
  std::vector<fs::path> files;
  for (int n = 0; n < 5; ++n) {
    files.push_back(folder_.write("i" + std::to_string(n), series.file(series.image(series.at_mm({0, 0, double(n)}), n))));
    if (GetParam() != gdcm::TransferSyntax::ExplicitVRLittleEndian) compress_dicom(files.back(), GetParam());
  }
  int read_well = 0;
  for (int n = 0; n < mutations(); ++n) {
    SCOPED_TRACE("mutation " + std::to_string(n));
    const fs::path& file = files[static_cast<std::size_t>(n % 5)];
    const std::string content = content_of(file);
    folder_.write(file.filename().string(), damaged(content, random_, 900));
    read_well += read_or_refuse(n % 2 == 0 ? file : folder_.path());
    folder_.write(file.filename().string(), content);
  }
  RecordProperty("read_well", read_well);
  RecordProperty("library_ended_the_reader", ended_);
}

INSTANTIATE_TEST_SUITE_P(Files, DicomMutations,
                         ::testing::Values(gdcm::TransferSyntax::ExplicitVRLittleEndian,
                                           gdcm::TransferSyntax::JPEGLosslessProcess14_1, gdcm::TransferSyntax::JPEGLSLossless,
                                           gdcm::TransferSyntax::JPEG2000Lossless, gdcm::TransferSyntax::RLELossless),
                         [](const auto& type) { return "Syntax" + std::to_string(static_cast<int>(type.param)); });

}  // namespace
}  // namespace palpa::test
