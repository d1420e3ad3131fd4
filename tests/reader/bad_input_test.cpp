// Invalid files: a one-line error, quickly, and no leaks.
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cmath>
#include <fstream>
#include <limits>
#include <thread>

#include "files.h"

namespace palpa::test {
namespace bad_input_test {

std::size_t open_descriptors() {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator("/proc/self/fd"), fs::directory_iterator()));
}

class BadInput : public ReaderTest {
 protected:
  void SetUp() override {
    ReaderTest::SetUp();
    descriptors_ = open_descriptors();
  }
  void TearDown() override {
    EXPECT_EQ(open_descriptors(), descriptors_);
    EXPECT_EQ(::waitpid(-1, nullptr, WNOHANG), -1) << "a child is left";
  }

  /// The error of reading this file, which must name it.
  std::string refused(const fs::path& file, VolumeRequest request = {}) {
    const std::string error = error_of([&] { read(file, std::move(request)); });
    EXPECT_EQ(error.rfind(file.string() + ": ", 0), 0U) << error;
    return error;
  }
  void expect_refused(const std::string& name, const std::string& bytes, const std::string& part) {
    const std::string error = refused(folder_.write(name, bytes));
    EXPECT_NE(error.find(part), std::string::npos) << error;
  }

 private:
  std::size_t descriptors_ = 0;
};

TEST_F(BadInput, MissingEmptyFolderAndText) {
  EXPECT_NE(refused(folder_.path() / "none.nrrd").find("does not exist"), std::string::npos);
  EXPECT_NE(refused(folder_.path()).find("is a folder"), std::string::npos);
  EXPECT_NE(refused("/dev/zero").find("no ordinary file"), std::string::npos);
  expect_refused("empty.nrrd", "", "is empty");
  for (const char* name : {"a.nrrd", "a.nhdr", "a.nii", "a.nii.gz", "a.vti", "a.vtk", "a.mha", "a.txt"}) {
    expect_refused(name, "Dear reader,\nthis is a letter.\n", "; ");
  }
  expect_refused("letter.nrrd", "Dear reader,\nthis is a letter.\n", "is no NRRD file");
  expect_refused("cut.nii.gz", gzipped(std::string(400, 'x')).substr(0, 8), "; ");
}

TEST_F(BadInput, TruncatedHeaders) {
  expect_refused("a.nrrd", "NRRD0004\ntype: short\ndimension: 3\n", "NRRD");
  expect_refused("b.nrrd", "NRRD0004\ntype: short\ndimension: 3\nsizes: 4 4 4\nencoding: raw\nendian: little\n\nxx", "whole");
  expect_refused("c.nhdr",
                 "NRRD0004\ntype: short\ndimension: 3\nsizes: 4 4 4\nencoding: raw\nendian: little\ndata file: none.raw\n",
                 "none.raw");
  expect_refused("d.vti", "<?xml version=\"1.0\"?><VTKFile type=\"ImageData\"><ImageData WholeExtent=\"0 3 0 3", "VTI");
  expect_refused("e.mha", "ObjectType = Image\nNDims = 3\nDimSize = 4 4\n", "; ");
}

// About 10^12 voxels of every format: refused by the header, before memory is allocated.
TEST_F(BadInput, ClaimsOfATrillionVoxels) {
  rusage before{}, after{};
  ::getrusage(RUSAGE_SELF, &before);
  expect_refused("a.nrrd", "NRRD0004\ntype: short\ndimension: 3\nsizes: 10000 10000 10000\nencoding: raw\nendian: little\n\nxx",
                 "claims 10000 × 10000 × 10000 voxels, which need 2 TB");
  expect_refused(
      "b.nrrd",
      "NRRD0004\ntype: short\ndimension: 3\nsizes: 10000000000 10000000000 10000000000\nencoding: raw\nendian: little\n\nxx",
      "; ");
  expect_refused(
      "a.mha",
      "ObjectType = Image\nNDims = 3\nDimSize = 10000 10000 10000\nElementType = MET_UCHAR\nElementDataFile = LOCAL\nxx",
      "claims 10000 × 10000 × 10000 voxels, which need 1 TB");
  std::string nifti(352, '\0');
  const auto put = [&](std::size_t at, auto value) { nifti.replace(at, sizeof value, bytes_of(value)); };
  put(0, std::int32_t{348});
  const std::int16_t dim[8] = {3, 10000, 10000, 10000, 1, 1, 1, 1};
  for (std::size_t d = 0; d < 8; ++d) put(40 + 2 * d, dim[d]), put(76 + 4 * d, 1.0F);
  put(70, std::int16_t{2}), put(72, std::int16_t{8}), put(108, 352.0F);
  nifti.replace(344, 3, "n+1");
  expect_refused("a.nii", nifti, "claims 10000 × 10000 × 10000 voxels");
  expect_refused(
      "a.vti",
      "<?xml version=\"1.0\"?><VTKFile type=\"ImageData\" version=\"0.1\" byte_order=\"LittleEndian\"><ImageData "
      "WholeExtent=\"0 9999 0 9999 0 9999\" Origin=\"0 0 0\" Spacing=\"1 1 1\"><Piece Extent=\"0 9999 0 9999 0 "
      "9999\"><PointData>"
      "<DataArray type=\"UInt8\" Name=\"a\" format=\"ascii\">1</DataArray></PointData></Piece></ImageData></VTKFile>",
      "claims 10000 × 10000 × 10000 voxels");
  expect_refused("a.vtk",
                 "# vtk DataFile Version 3.0\nx\nBINARY\nDATASET STRUCTURED_POINTS\nDIMENSIONS 10000 10000 10000\nORIGIN 0 0 "
                 "0\nSPACING 1 1 1\n"
                 "POINT_DATA 1000000000000\nSCALARS a unsigned_char\nLOOKUP_TABLE default\nx",
                 "claims 10000 × 10000 × 10000 voxels");
  ::getrusage(RUSAGE_SELF, &after);
  EXPECT_LT(after.ru_maxrss - before.ru_maxrss, 100'000) << "kB";
}

TEST_F(BadInput, SmallFilesThatClaimMuch) {
  // NrrdIO would fill memory for all of it first, MetaIO and VTK count to any number.
  const std::string claims = "NRRD0004\ntype: float\ndimension: 3\nsizes: 4000 400 100\nendian: little\nencoding: ";
  expect_refused("a.nrrd", claims + "gzip\n\n" + gzipped(std::string(100'000, 'x')), "is shorter than its header says");
  expect_refused("b.nrrd", claims + "raw\n\n" + std::string(1000, 'x'), "is shorter than its header says");
  expect_refused("c.nrrd", claims + "ascii\n\n1 2 3\n", "is shorter than its header says");
  expect_refused("d.mha", "ObjectType = Image\nNDims = 1e308\nDimSize = 2 2 2\nElementType = MET_UCHAR\n", "NDims");
  const std::string piece =
      "<Piece Extent=\"0 1 0 1 0 1\"><PointData><DataArray type=\"Float64\" Name=\"p\" "
      "format=\"ascii\" NumberOfComponents=\"";
  const std::string image = "<VTKFile type=\"ImageData\" version=\"1.0\"><ImageData WholeExtent=\"0 1 0 1 0 1\">" + piece;
  const std::string rest = "\">1 2 3 4 5 6 7 8</DataArray></PointData></Piece></ImageData></VTKFile>";
  expect_refused("e.vti", image + "4294967296" + rest, "correct its NumberOfComponents");
  const auto whole = [](const std::string& type) {
    return "<VTKFile type=\"PImageData\" version=\"1.0\"><PImageData WholeExtent=\"0 1 0 1 0 1\" GhostLevel=\"0\">"
           "<PPointData><PDataArray type=\"" +
           type +
           "\" Name=\"p\"/></PPointData>"
           "<Piece Extent=\"0 1 0 1 0 1\" Source=\"e.vti\"/></PImageData></VTKFile>";
  };
  expect_refused("e.pvti", whole("Float64"), "correct its NumberOfComponents");
  // VTK would copy as many bytes as the file claims for the piece.
  folder_.write("e.vti", image + "1" + rest);
  EXPECT_EQ(read(folder_.write("f.pvti", whole("Float64"))).fields.size(), 1U);
  expect_refused("f.pvti", whole("Float32"), "not the arrays that the file says");
}

TEST_F(BadInput, MoreCellsThanAFileCanHold) {
  for (const char* claim : {"NumberOfPoints=\"8\" NumberOfCells=\"199999999\"",
                            "NumberOfPoints=\"199999999\" NumberOfCells=\"1\"", "NumberOfPoints=\"8\" NumberOfCells=\"-1\""}) {
    expect_refused("a.vtu",
                   "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\"><UnstructuredGrid><Piece " +
                       std::string(claim) + "></Piece></UnstructuredGrid></VTKFile>",
                   "more than a file of its size can hold");
  }
}

TEST_F(BadInput, ListsWithoutNames) {
  const std::string header =
      "ObjectType = Image\nNDims = 3\nBinaryData = True\nDimSize = 2 2 2\nElementType = MET_UCHAR\nElementDataFile = LIST\n";
  expect_refused("a.mhd", header, "lists no data files");
  expect_refused("a.mhd", header + std::string("s\0\0t\n", 5), "characters that none has");
}

TEST_F(BadInput, HeadersThatMetaIODoesNotSurvive) {
  const std::string start = "ObjectType = Image\nNDims = 3\nBinaryData = True\nDimSize = 20 20 20\n";
  const std::string voxels(8000, '7');
  expect_refused("a.mha", start + "ElementType 9 MET_UCHAR\nElementDataFile = LOCAL\n" + voxels, "without '='");
  // MetaIO missed this header's end: it read on, and wrote the voxels over its memory.
  expect_refused("a.mha", start + "ElementTypeElementDataFile = LOCAL\n" + std::string(2000, 'v'), "get the whole file");
  expect_refused("b.mha", start + "ElementType = METmentDataFile\n" + voxels, "ElementDataFile");
  for (const char* bytes : {"1e308", "-7", "8500"}) {
    expect_refused("c.mha",
                   start + "CompressedData = True\nCompressedDataSize = " + bytes +
                       "\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n" + voxels,
                   "CompressedDataSize");
  }
}

TEST_F(BadInput, CellsWithoutTheirPoints) {
  const auto cells = [](const std::string& corners, int type) {
    return "# vtk DataFile Version 3.0\na\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 4 double\n0 0 0 1 0 0 0 1 0 0 0 1\nCELLS 1 "
           "5\n4 " +
           corners + "\nCELL_TYPES 1\n" + std::to_string(type) +
           "\nPOINT_DATA 4\nSCALARS p double 1\nLOOKUP_TABLE default\n1 2 3 4\n";
  };
  EXPECT_EQ(read(folder_.write("a.vtk", cells("0 1 2 3", 10))).fields.size(), 1U);
  for (const char* corners : {"0 1 2 4", "0 1 2 65536", "0 1 2 -1"})
    expect_refused("a.vtk", cells(corners, 10), "points that are not there");
  expect_refused("a.vtk", cells("0 1 2 3", 12), "points that are not there");
  expect_refused("a.vtk", cells("0 1 2 3", 200), "; ");
  expect_refused("b.vtk", "# vtk DataFile Version 3.0\na\nASCII\nDATASET STRUCTURED_GRID\nDIMENSIONS 4 3 3\n",
                 "not all points");
}

TEST_F(BadInput, MoreThanTheCallerAllows) {
  const fs::path file = folder_.write(
      "a.nrrd", "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 10 10 10\nencoding: raw\n\n" + std::string(1000, 'x'));
  options_.max_bytes = 999;
  EXPECT_NE(refused(file).find("are allowed; crop or downsample"), std::string::npos);
  options_.max_bytes = 1024;
  EXPECT_NO_THROW(read(file));
}

TEST_F(BadInput, NumbersThatAreNotFiniteAreOutside) {
  std::string voxels;
  for (int v = 0; v < 64; ++v) {
    const float value = v == 21 ? std::nanf("") : v == 22 ? std::numeric_limits<float>::infinity() : 1.0F;
    voxels += bytes_of(value);
  }
  const fs::path file =
      folder_.write("a.nrrd", "NRRD0004\ntype: float\ndimension: 3\nsizes: 4 4 4\nencoding: raw\nendian: little\n\n" + voxels);
  const Volume volume = read(file);
  EXPECT_TRUE(warns_of(volume, "2 voxels are not finite: treated as outside")) << all_warnings(volume);
  EXPECT_EQ(grid_of(*volume.fields[0].field)->valid_share, 62.0 / 64.0);
  EXPECT_FALSE(volume.fields[0].field->scalar({1.5e-3, 1.5e-3, 1.5e-3}).inside);
  EXPECT_TRUE(volume.fields[0].field->scalar({2.5e-3, 2.5e-3, 2.5e-3}).inside);
}

TEST_F(BadInput, GridsThatLieNowhere) {
  const std::string start =
      "NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: 2 2 2\nencoding: raw\nspace directions: ";
  expect_refused("flat.nrrd", start + "(1,0,0) (2,0,0) (0,0,1)\n\n12345678", "world");
  expect_refused("far.nrrd",
                 "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\nspacings: 1e308 1e308 1e308\n\n12345678",
                 "; ");
}

TEST_F(BadInput, TwoFilesForOneVolume) {
  VolumeRequest request;
  for (const char* name : {"a.mha", "b.mha"}) {
    request.files.push_back(folder_.write(
        name, "ObjectType = Image\nNDims = 3\nDimSize = 2 2 2\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n12345678"));
  }
  EXPECT_NE(error_of([&] { read_volume(request, options_); }).find("2 files"), std::string::npos);
  request.files = {};
  error_of([&] { read_volume(request, options_); });
}

TEST_F(BadInput, AReaderWithoutThoseThatItBecomes) {
  const fs::path file =
      folder_.write("eight.nrrd", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 2 2 2\nencoding: ascii\n\n0 1 2 3 4 5 6 7\n");
  read(file);
  const fs::path alone = folder_.path() / "palpa-read";
  fs::copy_file(options_.reader, alone);
  options_.reader = alone;
  const std::string error = refused(file);
  EXPECT_NE(error.find("palpa-read-itk beside palpa-read does not start"), std::string::npos) << error;
}

TEST_F(BadInput, AReaderThatIsKilledInTheMiddle) {
  const fs::path file = folder_.write(
      "a.nrrd", "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 10 10 10\nencoding: raw\n\n" + std::string(1000, 'x'));
  std::atomic<bool> done{false};
  std::thread killer([&] {
    // Kills the child at once; until it exists, this polls.
    while (!done) {
      if (const pid_t child = child_process(); child > 0) ::kill(child, SIGKILL);
    }
  });
  const std::string error = refused(file);
  done = true;
  killer.join();
  EXPECT_NE(error.find("signal 9"), std::string::npos) << error;
  EXPECT_NO_THROW(read(file));
}

}  // namespace bad_input_test
}  // namespace palpa::test
