// Content of files that hold several series, arrays or segments.
#include "dicom_file.h"
#include "hdf5_file.h"
#include "palpa/mode/mode.h"
#include "palpa/scene/first_scene.h"
#include "palpa/scene/load_scene.h"

namespace palpa::test {
namespace contents_test {

class Contents : public ReaderTest {
 protected:
  /// Content by the callback, which ends the reading.
  FileContents listed(const fs::path& file) {
    struct Enough {};
    VolumeRequest request;
    request.files = {file};
    FileContents found;
    ReadOptions options = options_;
    options.found = [&](const FileContents& contents) {
      found = contents;
      throw Enough();
    };
    EXPECT_THROW(read_volume(request, options), Enough);
    return found;
  }
};

TEST_F(Contents, SeriesAreListedWithTheirWordsAndNumbersOfImages) {
  for (const int series : {1, 2}) {
    DicomSeries made;
    made.uid = "1.2." + std::to_string(series);
    for (int n = 0; n < 3 * series; ++n) {
      DicomElements image = made.image(made.at_mm({0, 0, static_cast<double>(n)}), n);
      image.set(0x00200011, "IS", std::to_string(200 + series));
      image.set(0x0008103e, "LO", series == 1 ? "DOE JANE head bone" : "Localizer");
      folder_.write(std::to_string(series) + "-" + std::to_string(n), made.file(image));
    }
  }
  const FileContents contents = listed(folder_.path());
  EXPECT_EQ(contents.format, "dicom");
  EXPECT_EQ(contents.series, (std::vector<FilePart>{{"1.2.1", "CT 201 head bone", 3}, {"1.2.2", "CT 202 localizer", 6}}))
      << "only known words";
  VolumeRequest request;
  request.files = {folder_.path()};
  const VolumeFile file = read_volume_file(request, options_);
  EXPECT_EQ(file.contents.series, contents.series);
  EXPECT_EQ(grid_of(*file.volume.fields[0].field)->geometry.dims[2], 6);
}

TEST_F(Contents, ArraysOfWhichOneHasToBeNamedAreListed) {
  const fs::path path = folder_.path() / "a.h5";
  const hid_t file = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
  const std::string zeros(8 * 24, '\0');
  write_array<double>(file, "/one/p", {2, 3, 4}, zeros);
  write_array<double>(file, "/two", {4, 3, 2}, zeros);
  H5Fclose(file);
  const FileContents contents = listed(path);
  EXPECT_TRUE(contents.arrays.empty());
  EXPECT_EQ(contents.alternatives, (std::vector<FilePart>{{"/one/p", "2 × 3 × 4", 24}, {"/two", "4 × 3 × 2", 24}}));
  EXPECT_NE(error_of([&] { read(path); }).find("name one: a.h5:/one/p"), std::string::npos);
  ReadOptions options = options_;
  options.found = [](const FileContents&) {};
  VolumeRequest request;
  request.files = {path};
  EXPECT_NE(error_of([&] { read_volume(request, options); }).find("name one, as FILE:/one/p"), std::string::npos);
  request.files = {path.string() + ":/two"};
  EXPECT_EQ(read_volume_file(request, options).contents.arrays.at(0).name, "two");
}

constexpr int columns = 16, rows = 12, places = 5, first_column = 1, bar = 5;

/// A segmentation of two bars along the slices: five columns from `first_column` on and five from `second_column`.
std::string segmentation(DicomSeries series, int second_column, const std::string& type = "BINARY") {
  series.columns = columns, series.rows = rows;
  DicomElements image = series.image(series.origin_mm, 1), orientation, measures, shared;
  for (const std::uint32_t tag : {0x00200032, 0x00200037, 0x00280030, 0x00281052, 0x00281053}) image.erase(tag);
  image.set(0x00080060, "CS", "SEG");
  image.set(0x00620001, "CS", type);
  image.set_short(0x00280100, 1);
  image.set_short(0x00280101, 1);
  image.set_short(0x00280102, 0);
  orientation.set(0x00200037, "DS", decimals(series.right) + "\\" + decimals(series.down));
  measures.set(0x00280030, "DS", decimal(series.row_mm) + "\\" + decimal(series.column_mm));
  measures.set(0x00180050, "DS", "2.5");
  shared.set_items(0x00209116, {orientation});
  shared.set_items(0x00289110, {measures});
  image.set_items(0x52009229, {shared});
  std::vector<DicomElements> frames, segments;
  std::string bits;
  std::size_t count = 0;
  for (const int segment : {1, 7}) {
    DicomElements described;
    described.set_short(0x00620004, segment);
    described.set(0x00620005, "LO", segment == 1 ? "Left kidney" : "Tumor (1)");
    segments.push_back(described);
    for (int place = 0; place < places; ++place) {
      DicomElements position, number, groups;
      position.set(0x00200032, "DS", decimals(series.at_mm({0, 0, static_cast<double>(place)})));
      groups.set_items(0x00209113, {position});
      number.set_short(0x0062000b, segment);
      groups.set_items(0x0062000a, {number});
      frames.push_back(groups);
      for (int j = 0; j < rows; ++j)
        for (int i = 0; i < columns; ++i, ++count) {
          if (count % 8 == 0) bits += '\0';
          const int from = segment == 1 ? first_column : second_column;
          if (i >= from && i < from + bar && j >= 3 && j < 9) bits.back() = static_cast<char>(bits.back() | 1 << count % 8);
        }
    }
  }
  image.set_items(0x00620002, segments);
  image.set_items(0x52009230, frames);
  image.set(0x00280008, "IS", std::to_string(frames.size()));
  image.set(0x7fe00010, "OB", bits);
  return series.file(image);
}

TEST_F(Contents, SegmentsAreLabelsWithNames) {
  const DicomSeries series;
  VolumeRequest request;
  request.files = {folder_.write("seg.dcm", segmentation(series, 9))};
  const VolumeFile file = read_volume_file(request, options_);
  EXPECT_EQ(file.contents.labels, (std::vector<FilePart>{{"Left kidney", "", 1}, {"Tumor (1)", "", 7}}));
  EXPECT_EQ(file.frames, 1);
  EXPECT_TRUE(file.volume.warnings.empty()) << all_warnings(file.volume);
  for (int i = 0; i < columns; ++i) {
    const double expected = i >= 1 && i < 6 ? 1.0 : i >= 9 && i < 14 ? 7.0 : 0.0;
    EXPECT_NEAR(file.volume.fields[0].field->scalar(1e-3 * series.at_mm({static_cast<double>(i), 4, 3})).value, expected, 1e-9)
        << i;
  }
  request.frame = 1;  // one segment, as before
  const Volume one = read_volume(request, options_);
  EXPECT_EQ(one.frames, 2);
  EXPECT_NEAR(one.fields[0].field->scalar(1e-3 * series.at_mm({10, 4, 3})).value, 1.0, 1e-9);
  EXPECT_NEAR(one.fields[0].field->scalar(1e-3 * series.at_mm({2, 4, 3})).value, 0.0, 1e-9);
}

TEST_F(Contents, AFirstSceneOfSegmentsHasTheirNames) {
  VolumeRequest request;
  request.files = {folder_.write("seg.dcm", segmentation({}, 9))};
  const VolumeFile file = read_volume_file(request, options_);
  const std::string text = first_scene(file.volume, request, {.labels = {{"Left kidney", 1.0}, {"Tumor (1)", 7.0}}});
  EXPECT_NE(text.find("Left_kidney = 1"), std::string::npos) << text;
  EXPECT_NE(text.find("Tumor__1_ = 7"), std::string::npos) << text;
  const Scene scene = parse_scene(text, "seg.toml", folder_.path(), volume_reader(options_), standard_modes()).scene;
  EXPECT_NEAR(scene.field({"seg.Left_kidney"}).field->scalar(1e-3 * DicomSeries().at_mm({3, 5, 2})).value, 1.0, 1e-6);
}

// 3D Slicer keeps overlapping segments in layers, in which one value can be two segments.
TEST_F(Contents, NamesOfSegmentsInNrrdAreReadWhereNoneOverlap) {
  const auto labels = [&](const std::string& file, const std::string& layer_of_second) {
    std::string text =
        "NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: 2 2 2\n"
        "space directions: (2,0,0) (0,2,0) (0,0,2)\nspace origin: (0,0,0)\nencoding: raw\n"
        "Segment0_LabelValue:=1\nSegment0_Layer:=0\nSegment0_Name:=liver\n"
        "Segment1_LabelValue:=7\nSegment1_Layer:=" +
        layer_of_second + "\nSegment1_Name:=left kidney\n\n";
    VolumeRequest request;
    request.files = {folder_.write(file, text + std::string("\0\1\7\0\0\1\7\0", 8))};
    return read_volume_file(request, options_).contents.labels;
  };
  EXPECT_EQ(labels("apart.seg.nrrd", "0"), (std::vector<FilePart>{{"liver", "", 1}, {"left kidney", "", 7}}));
  EXPECT_EQ(labels("overlapping.seg.nrrd", "1"), std::vector<FilePart>{});
}

TEST_F(Contents, OverlappingSegmentsAreAWarningAndFractionsAreNoLabels) {
  const DicomSeries series;
  const Volume volume = read(folder_.write("seg.dcm", segmentation(series, 5)));
  EXPECT_TRUE(warns_of(volume, "segments that overlap in 30 voxels")) << all_warnings(volume);
  EXPECT_NEAR(volume.fields[0].field->scalar(1e-3 * series.at_mm({5, 4, 3})).value, 7.0, 1e-9);
  VolumeRequest request;
  request.files = {folder_.write("parts.dcm", segmentation(series, 5, "FRACTIONAL"))};
  const VolumeFile parts = read_volume_file(request, options_);
  EXPECT_TRUE(parts.contents.labels.empty());
  EXPECT_EQ(parts.frames, 2);
}

}  // namespace contents_test
}  // namespace palpa::test
