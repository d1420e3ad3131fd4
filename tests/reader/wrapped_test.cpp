// Wrapped files: gzip of a whole file, or lines before the format's magic.
#include <cmath>

#include "hdf5_file.h"

namespace palpa::test {
namespace wrapped_test {

const FileGrid grid{{6, 5, 4}, {{{0.5, 0, 0}, {0, 0.25, 0}, {0, 0, 2}}}, {1, 2, 3}};
Vec3 metres(const Vec3& p) { return p; }
Vec3 millimetres(const Vec3& p) { return 1e-3 * p; }

std::string numbers_of(Vec3 (*to_world_m)(const Vec3&) = metres) { return linear_voxels<double>(grid, to_world_m); }

std::string as_text(const std::string& doubles) {
  std::string text;
  for (std::size_t at = 0; at < doubles.size(); at += 8) {
    double value = 0;
    std::memcpy(&value, doubles.data() + at, 8);
    char number[40];
    std::snprintf(number, sizeof number, "%.17g%s", value, at / 8 % 6 == 5 ? "\n" : " ");
    text += number;
  }
  return text;
}

std::string legacy(const std::string& title, const std::string& numbers, const std::string& end = "\n") {
  return "# vtk DataFile Version 3.0" + end + title + end + "ASCII" + end + "DATASET STRUCTURED_POINTS" + end +
         "DIMENSIONS 6 5 4" + end + "ORIGIN 1 2 3" + end + "SPACING 0.5 0.25 2" + end + "POINT_DATA 120" + end +
         "SCALARS s double" + end + "LOOKUP_TABLE default" + end + numbers;
}

std::string vti(const std::string& before, const std::string& tag, const std::string& array) {
  return before + tag +
         "<ImageData WholeExtent=\"0 5 0 4 0 3\" Origin=\"1 2 3\" Spacing=\"0.5 0.25 2\"><Piece Extent=\"0 5 0 4 0 "
         "3\"><PointData>" +
         array + "</PointData></Piece></ImageData></VTKFile>";
}
const char* const plain_tag = "<VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\">";
std::string plain_array() {
  return "<DataArray type=\"Float64\" Name=\"s\" format=\"ascii\">" + as_text(numbers_of()) + "</DataArray>";
}

const char* const nrrd_header =
    "NRRD0004\ntype: double\ndimension: 3\nspace: LPS\nsizes: 6 5 4\nspace directions: (0.5,0,0) (0,0.25,0) (0,0,2)\n"
    "space origin: (1,2,3)\nspace units: \"m\" \"m\" \"m\"\nendian: little\nencoding: raw\n";
const char* const meta_header =
    "ObjectType = Image\nNDims = 3\nBinaryData = True\nTransformMatrix = 1 0 0 0 1 0 0 0 1\nOffset = 1 2 3\n"
    "ElementSpacing = 0.5 0.25 2\nDimSize = 6 5 4\nElementType = MET_DOUBLE\n";

class Wrapped : public ReaderTest {
 protected:
  std::string hdf5() const {
    const fs::path path = folder_.path() / "made.h5";
    const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    write_array<double>(file, "/p", {4, 5, 6}, numbers_of());
    H5Fclose(file);
    std::string bytes(std::filesystem::file_size(path), '\0');
    std::FILE* const raw = std::fopen(path.c_str(), "rb");
    bytes.resize(std::fread(bytes.data(), 1, bytes.size(), raw));
    std::fclose(raw);
    std::filesystem::remove(path);
    return bytes;
  }
  std::string refused(const std::string& name, const std::string& bytes, VolumeRequest request = {}) const {
    return error_of([&] { read(folder_.write(name, bytes), request); });
  }
};

TEST_F(Wrapped, AFileThatIsPackedAsAWholeIsReadAsItIs) {
  VolumeRequest placed;
  placed.layout.spacing_m = {0.5, 0.25, 2}, placed.layout.origin_m = Vec3{1, 2, 3};
  struct {
    const char* name;
    std::string bytes;
    VolumeRequest request;
    Vec3 (*to_world_m)(const Vec3&) = metres;
  } files[] = {{"a.vtk", legacy("made", as_text(numbers_of())), {}},
               {"a.vti", vti("", plain_tag, plain_array()), {}},
               {"a.nrrd", std::string(nrrd_header) + "\n" + numbers_of(), {}},
               {"a.mha", std::string(meta_header) + "ElementDataFile = LOCAL\n" + numbers_of(millimetres), {}, millimetres},
               {"a.h5", hdf5(), placed}};
  for (const auto& file : files) {
    SCOPED_TRACE(file.name);
    const std::string packed = gzipped(file.bytes);
    // One stream, two concatenated as by pigz and bgzip, and zeros that fill a block.
    const std::size_t half = file.bytes.size() / 2;
    const std::string in_two = gzipped(file.bytes.substr(0, half)) + gzipped(file.bytes.substr(half));
    for (const std::string& bytes : {file.bytes, packed, in_two, packed + std::string(512, '\0')}) {
      const fs::path path = folder_.write(std::string(file.name) + (bytes == file.bytes ? "" : ".gz"), bytes);
      const Volume volume = read(path, file.request);
      expect_linear(*volume.fields[0].field, grid, file.to_world_m);
      ASSERT_EQ(volume.files.size(), 1U);
      EXPECT_EQ(volume.files[0].path, path.string());
      EXPECT_EQ(volume.files[0].bytes, bytes.size());
      EXPECT_EQ(all_warnings(volume).find("/proc"), std::string::npos) << all_warnings(volume);
    }
    for (const std::size_t left : {packed.size() - 1, packed.size() - 8, packed.size() / 2, std::size_t{30}}) {
      const std::string error = refused(std::string(file.name) + ".gz", packed.substr(0, left), file.request);
      EXPECT_EQ(error.find("/proc"), std::string::npos) << error;
    }
    std::string damaged = packed;
    damaged[damaged.size() - 6] = static_cast<char>(damaged[damaged.size() - 6] ^ 1);
    EXPECT_NE(refused(std::string(file.name) + ".gz", damaged, file.request).find("gzip"), std::string::npos);
  }
}

TEST_F(Wrapped, NoMoreIsUnpackedThanIsAllowed) {
  ReadOptions options = options_;
  options.max_bytes = 1'000'000;
  const std::string bomb = gzipped(legacy("made", as_text(numbers_of())) + std::string(5'000'000, '\n'));
  const fs::path path = folder_.write("a.vtk.gz", bomb);
  const std::string error = error_of([&] { read_volume(path, options); });
  EXPECT_NE(error.find("unpacks to more than"), std::string::npos) << error;
}

TEST_F(Wrapped, AHeaderThatNamesOthersIsNotPacked) {
  folder_.write("a.raw", numbers_of());
  for (const auto& [name, header] : {std::pair{"a.nhdr.gz", std::string(nrrd_header) + "data file: a.raw\n"},
                                     {"a.mhd.gz", std::string(meta_header) + "ElementDataFile = a.raw\n"}}) {
    const std::string error = refused(name, gzipped(header));
    EXPECT_NE(error.find("gunzip"), std::string::npos) << error;
  }
  VolumeRequest raw;
  raw.layout = {.type = "uint8", .dims = {2, 2, 2}, .spacing_m = {1, 1, 1}};
  EXPECT_NE(refused("a.raw.gz", gzipped(numbers_of()), raw).find("gunzip"), std::string::npos);
}

TEST_F(Wrapped, WhatStandsBeforeTheFirstElementIsPassedOver) {
  const std::string declaration = "<?xml version=\"1.0\"?>\n";
  for (const std::size_t length : {10U, 900U, 1100U, 5000U, 2'000'000U}) {
    for (const char* name : {"a.vti", "a.xml", "a"}) {
      const std::string before = declaration + "<!-- <VTKFile type=\"PolyData\"> " + std::string(length, 'x') + " -->\n";
      expect_linear(*read(folder_.write(name, vti(before, plain_tag, plain_array()))).fields[0].field, grid, metres);
    }
  }
  const char* const other_tags[] = {
      "<VTKFile\n  version='1.0'\n  type = 'ImageData'\n  byte_order='LittleEndian'>",
      "<VTKFile byte_order=\"LittleEndian\" type=\"ImageData\" compressor=\"a > b\" version=\"0.1\" >"};
  expect_linear(*read(folder_.write("a.vti", vti("\xef\xbb\xbf" + declaration, other_tags[0], plain_array()))).fields[0].field,
                grid, metres);
  EXPECT_NE(refused("a.xml", declaration + "<Xdmf Version=\"2.0\"></Xdmf>").find("XDMF"), std::string::npos);
  EXPECT_NE(refused("b.xml", declaration + "<!-- VTKFile --><svg/>").find("not 'VTKFile'"), std::string::npos);
}

TEST_F(Wrapped, TitlesOfLegacyFilesMayBeAnything) {
  for (const char* title :
       {"made", "", "Dataset 3 of patient", "DATASET STRUCTURED_GRID", "dataset", "ASCII", "BINARY", "nan inf"}) {
    for (const char* end : {"\n", "\r\n"}) {
      SCOPED_TRACE(title);
      expect_linear(*read(folder_.write("a.vtk", legacy(title, as_text(numbers_of()), end))).fields[0].field, grid, metres);
    }
  }
}

TEST_F(Wrapped, NumbersThatAreNotFiniteAreNoDataInText) {
  const Linear linear;
  for (const char* word : {"nan", "NaN", "-nan", "NAN", "inf", "-inf", "Infinity", "+INF", "nan(0x1)", "-nan(ind)", "1.#QNAN",
                           "-1.#IND", "1.#INF"}) {
    for (const char* type : {"double", "float"}) {
      std::string numbers = as_text(numbers_of());
      const std::size_t second = numbers.find(' ') + 1, third = numbers.find(' ', second);
      numbers.replace(second, third - second, word);
      std::string text = legacy("nan of what", numbers);
      text.replace(text.find("double"), 6, type);
      const Volume volume = read(folder_.write("a.vtk", text));
      EXPECT_FALSE(volume.fields[0].field->scalar({1.5, 2, 3}).inside) << word;
      const ScalarSample beside = volume.fields[0].field->scalar({2.25, 2.1, 4});
      ASSERT_TRUE(beside.inside) << word;
      EXPECT_NEAR(beside.value, linear({2.25, 2.1, 4}), 1e-3);
      EXPECT_TRUE(warns_of(volume, "1 voxel is not finite")) << all_warnings(volume);
    }
  }
  std::string numbers = as_text(numbers_of());
  EXPECT_NE(refused("b.vtk", legacy("made", numbers.replace(0, numbers.find(' '), "nano"))).find("whole"), std::string::npos);
}

// The library silently stops at this word.
TEST_F(Wrapped, NumbersOfMetaImageAsTextAreReadToTheLastOrRefused) {
  std::string header = meta_header;
  header.replace(header.find("BinaryData = True"), 17, "BinaryData = False");
  const auto with = [&](const std::string& word, bool apart = false) {
    std::string numbers = as_text(numbers_of(millimetres));
    const std::size_t second = numbers.find(' ') + 1, third = numbers.find(' ', second);
    if (!word.empty()) numbers.replace(second, third - second, word);
    if (!apart) return folder_.write("a.mha", header + "ElementDataFile = LOCAL\n" + numbers);
    folder_.write("a.raw", numbers);
    return folder_.write("a.mhd", header + "ElementDataFile = a.raw\n");
  };
  for (const bool apart : {false, true}) {
    expect_linear(*read(with("", apart)).fields[0].field, grid, millimetres);
    for (const char* word : {"nan", "NaN", "-inf", "Infinity", "1.#QNAN", "-1.#IND", "1e400"}) {
      const Volume volume = read(with(word, apart));
      EXPECT_TRUE(warns_of(volume, "1 voxel is not finite")) << word << ": " << all_warnings(volume);
      const Vec3 beside{2.25e-3, 2.1e-3, 4e-3};
      EXPECT_NEAR(volume.fields[0].field->scalar(beside).value, Linear{}(beside), 1e-3) << word;
    }
    for (const char* word : {"1,5", "1d3", "--", "NULL", "0x10"}) {
      const std::string error = error_of([&] { read(with(word, apart)); });
      EXPECT_NE(error.find("a word among its numbers"), std::string::npos) << word << ": " << error;
    }
  }
  std::string nrrd = nrrd_header;
  nrrd.replace(nrrd.find("raw"), 3, "ascii");
  expect_linear(*read(folder_.write("a.nrrd", nrrd + "\n" + as_text(numbers_of()))).fields[0].field, grid, metres);
  for (const char* word : {"1,5", "1d3"}) {
    std::string numbers = as_text(numbers_of());
    numbers.replace(0, numbers.find(' '), word);
    EXPECT_NE(refused("a.nrrd", nrrd + "\n" + numbers).find("a word among its numbers"), std::string::npos) << word;
  }
}

TEST_F(Wrapped, WhatIsPackedTwiceOrInUtf16IsCalledSo) {
  EXPECT_NE(refused("a.nii.gz", gzipped(gzipped(numbers_of()))).find("gzip twice"), std::string::npos);
  std::string wide = "\xff\xfe";
  for (const char c : vti("<?xml version=\"1.0\"?>", plain_tag, plain_array())) wide += c, wide += '\0';
  EXPECT_NE(refused("a.vti", wide).find("UTF-16"), std::string::npos);
  const std::string type = "<!DOCTYPE VTKFile [<!ELEMENT VTKFile (ImageData)>]>\n";
  expect_linear(*read(folder_.write("a.vti", vti(type, plain_tag, plain_array()))).fields[0].field, grid, metres);
}

TEST_F(Wrapped, WhatIsNotReadIsCalledByItsName) {
  const std::string rest(2000, '\x07');
  struct {
    const char *name, *bytes, *says;
  } files[] = {{"a.nc", "CDF\x01", "nccopy"},
               {"b.nc", "CDF\x02", "nccopy"},
               {"a.mat", "MATLAB 5.0 MAT-file, Platform: GLNXA64", "-v7.3"},
               {"a.vtk.bz2", "BZh91AY", "unpack it"},
               {"a.zip", "PK\x03\x04", "unpack it"},
               {"a.vtm", "<VTKFile type=\"vtkMultiBlockDataSet\" version=\"1.0\">", "check that the file is whole"},
               {"a.pvd", "<VTKFile type=\"Collection\" version=\"0.1\">", "check that the file is whole"},
               {"mri.general", "file = mri.raw\ngrid = 4 x 4 x 4\nformat = msb\n", "--set type"},
               {"mri.txt", "grid = 4 x 4 x 4\ninterleaving = record\n", "--set type"}};
  for (const auto& [name, bytes, says] : files) {
    const std::string error = refused(name, bytes + rest);
    EXPECT_NE(error.find(says), std::string::npos) << error;
  }
}

}  // namespace wrapped_test
}  // namespace palpa::test
