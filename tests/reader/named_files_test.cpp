// Files that a header names, and libraries' messages on headers: no foreign bytes, no leaked words.
#include <sys/stat.h>
#include <unistd.h>

#include "files.h"

namespace palpa::test {
namespace named_files_test {

class NamedFiles : public ReaderTest {
 protected:
  void SetUp() override {
    ReaderTest::SetUp();
    outside_ = outside_folder_.write("secret", std::string(64, 's'));
    folder_.write("inside.raw", std::string(64, 'i'));
    fs::create_symlink(outside_, folder_.path() / "link.raw");
    fs::create_symlink("inside.raw", folder_.path() / "own-link.raw");
    ASSERT_EQ(::mkfifo((folder_.path() / "pipe.raw").c_str(), 0600), 0);
  }
  fs::path nrrd(const std::string& data_file, const std::string& more = {}) const {
    return folder_.write("a.nhdr", "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nspacings: 1 1 1\nencoding: raw\n" +
                                       more + "data file: " + data_file + "\n");
  }
  fs::path metaimage(const std::string& data_file) const {
    return folder_.write("a.mhd",
                         "ObjectType = Image\nNDims = 3\nDimSize = 4 4 4\nElementSpacing = 1 1 1\nElementType = MET_UCHAR\n"
                         "ElementDataFile = " +
                             data_file + "\n");
  }
  fs::path pieces(const std::string& piece) const {
    return folder_.write("a.pvti",
                         "<?xml version=\"1.0\"?>\n<VTKFile type=\"PImageData\" version=\"0.1\" byte_order=\"LittleEndian\">\n"
                         "<PImageData WholeExtent=\"0 3 0 3 0 3\" GhostLevel=\"0\" Origin=\"0 0 0\" Spacing=\"1 1 1\">\n"
                         "<PPointData><PDataArray type=\"UInt8\" Name=\"a\"/></PPointData>\n"
                         "<Piece Extent=\"0 3 0 3 0 3\" Source=\"" +
                             piece + "\"/>\n</PImageData>\n</VTKFile>\n");
  }
  void expect_refused(const fs::path& file, const std::string& words) {
    const std::string error = error_of([&] { read(file); });
    EXPECT_NE(error.find(words), std::string::npos) << error;
  }

  TemporaryFolder outside_folder_;
  fs::path outside_;
};

TEST_F(NamedFiles, LieWithTheirHeader) {
  for (const std::string& name :
       {outside_.string(), "../" + fs::relative(outside_, folder_.path().parent_path()).string(), std::string("link.raw")}) {
    expect_refused(nrrd(name), "lies outside its header's folder");
    expect_refused(metaimage(name), "lies outside its header's folder");
    expect_refused(pieces(name), "lies outside its header's folder");
  }
  for (const std::string& name :
       {std::string("inside.raw"), (folder_.path() / "inside.raw").string(), std::string("own-link.raw")}) {
    for (const fs::path& header : {nrrd(name), metaimage(name)})
      EXPECT_EQ(read(header).fields[0].field->value_ranges()[0].max, static_cast<double>('i')) << header << name;
  }
  fs::create_directory(folder_.path() / "below");
  fs::rename(folder_.path() / "inside.raw", folder_.path() / "below/inside.raw");
  EXPECT_NO_THROW(read(nrrd("below/inside.raw")));
  EXPECT_NO_THROW(read(metaimage("below/inside.raw")));
}

TEST_F(NamedFiles, HaveAnEnd) {
  for (const Checksums checksums : {Checksums::none, Checksums::now, Checksums::later}) {
    options_.checksums = checksums;
    for (const char* name : {"/dev/zero", "/dev/random", "pipe.raw"}) {
      for (const char* more : {"", "line skip: 1\n", "byte skip: -1\n"})
        expect_refused(nrrd(name, more), "is no ordinary file");
      expect_refused(nrrd(std::string("LIST\n") + name), "is no ordinary file");
      expect_refused(metaimage(name), "is no ordinary file");
      expect_refused(metaimage(std::string("LIST\n") + name), "is no ordinary file");
    }
  }
  expect_refused(nrrd("none.raw"), "none.raw', which does not exist");
  expect_refused(metaimage("none.raw"), "none.raw', which does not exist");
}

TEST_F(NamedFiles, WordsOfAHeaderDoNotGetOut) {
  const std::string patient = "Doe Jane 19700101";
  int errors = 0;
  const auto expect_kept = [&](const std::string& name, const std::string& bytes) {
    std::string said;
    try {
      said = all_warnings(read(folder_.write(name, bytes)));
    } catch (const LoadError& error) {
      said = error.what();
      ++errors;
    }
    for (const char* word : {"Doe", "Jane", "1970"}) EXPECT_EQ(said.find(word), std::string::npos) << said;
  };
  const std::string nrrd = "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 4 4 4\nspacings: 1 1 1\nencoding: raw\n";
  for (const char* field : {"type: ", "dimension: ", "sizes: ", "spacings: ", "endian: ", "encoding: ", "space: ", "kinds: ",
                            "", "centers: ", "space directions: ", "space origin: ", "number: ", "old min: ", "line skip: ",
                            "labels: ", "thicknesses: ", "measurement frame: ", "blocksize: "})
    expect_kept("a.nrrd", nrrd + field + patient + "\n\n" + std::string(64, 'x'));
  for (const char* field : {"type: ", "dimension: ", "encoding: "})
    expect_kept("a.nrrd", std::string("NRRD0004\n") + field + patient + "\n\n");
  for (const char* field : {"NDims = ", "DimSize = ", "ElementType = ", "ElementSpacing = ", "Offset = ", "", " = "})
    expect_kept("a.mha", "ObjectType = Image\nNDims = 3\n" + std::string(field) + patient + "\nElementDataFile = LOCAL\n");
  for (const char* keyword :
       {"", "DATASET ", "DATASET STRUCTURED_POINTS\n", "DATASET STRUCTURED_POINTS\nDIMENSIONS ",
        "DATASET STRUCTURED_POINTS\nDIMENSIONS 4 4 4\nSPACING 1 1 1\nORIGIN 0 0 0\nPOINT_DATA 64\nSCALARS "})
    expect_kept("a.vtk", "# vtk DataFile Version 3.0\nt\nASCII\n" + std::string(keyword) + patient + "\n");
  expect_kept("a.vti", "<?xml version=\"1.0\"?><VTKFile type=\"ImageData\"><" + patient + "><ImageData WholeExtent=\"" +
                           patient + "\"></VTKFile>");
  EXPECT_GT(errors, 30) << "damage that nobody minds";
}

}  // namespace named_files_test
}  // namespace palpa::test
