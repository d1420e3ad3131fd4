// Separation of image kinds: files with each attribute by which the standard distinguishes images, in shuffled orders, whose
// values show the kind of each voxel.
#include <numeric>
#include <random>
#include <set>

#include "dicom_file.h"
#include "palpa/data/read_series.h"
#include "palpa/data/timed_field.h"

namespace palpa::test {
namespace dicom_kinds_test {

constexpr int places = 5;

/// An attribute, and its values in images of three kinds. Empty: absent.
struct Kind {
  std::string name;
  std::uint32_t tag;
  const char* vr;
  std::vector<std::string> values;
  std::uint32_t group = 0;   ///< its sequence, in functional groups
  std::uint32_t deeper = 0;  ///< a sequence within that one
};

std::string doubles(std::initializer_list<double> numbers) {
  std::string bytes;
  for (const double n : numbers) bytes += bytes_of(n);
  return bytes;
}
std::string short_of(int n) { return bytes_of(static_cast<std::uint16_t>(n)); }
std::string long_of(int n) { return bytes_of(static_cast<std::uint32_t>(n)); }
std::string float_of(float n) { return bytes_of(n); }

std::vector<Kind> classic_kinds() {
  return {
      {"echo time", 0x00180081, "DS", {"4.6", "9.2", "13.8"}},
      {"echo number", 0x00180086, "IS", {"1", "2", "3"}},
      {"temporal position", 0x00200100, "IS", {"1", "2", "3"}},
      {"complex component", 0x00089208, "CS", {"MAGNITUDE", "PHASE", "REAL"}},
      {"image type", 0x00080008, "CS", {"ORIGINAL\\PRIMARY\\M_FFE", "ORIGINAL\\PRIMARY\\PHASE MAP", "ORIGINAL\\PRIMARY\\R"}},
      {"b-value", 0x00189087, "FD", {doubles({0}), doubles({500}), doubles({1000})}},
      {"gradient direction", 0x00189089, "FD", {"", doubles({1, 0, 0}), doubles({0, 0.6, 0.8})}},
      {"directionality", 0x00189075, "CS", {"NONE", "DIRECTIONAL", "ISOTROPIC"}},
      {"inversion time", 0x00180082, "DS", {"100", "400", "900"}},
      {"flip angle", 0x00181314, "DS", {"5", "10", "20"}},
      {"repetition time", 0x00180080, "DS", {"500", "700", "900"}},
      {"tube voltage", 0x00180060, "DS", {"80", "100", "140"}},
      {"kernel", 0x00181210, "SH", {"B20f", "B30f", "B70f"}},
      {"sequence", 0x00180024, "SH", {"*ep_b0", "*ep_b500#1", "*ep_b500#2"}},
      {"contrast agent", 0x00180010, "LO", {"", "GD", "IODINE"}},
      {"trigger time", 0x00181060, "DS", {"0", "40", "80"}},
      {"reference time", 0x00541300, "DS", {"500", "1500", "2500"}},
      {"acquisition number", 0x00200012, "IS", {"1", "2", "3"}},
      {"acquisition time", 0x00080032, "TM", {"101500.25", "101501.5", "101502"}},
      {"units", 0x00541001, "CS", {"BQML", "CNTS", "GML"}},
      {"rescale type", 0x00281054, "LO", {"HU", "US", "ED"}},
      {"slice thickness", 0x00180050, "DS", {"1", "2", "5"}},
      {"cardiac phase", 0x00209241, "FL", {float_of(0), float_of(40), float_of(75)}},
      {"temporal index", 0x00209128, "UL", {long_of(1), long_of(2), long_of(3)}}};
}

std::vector<Kind> enhanced_kinds() {
  return {{"complex component", 0x00089208, "CS", {"MAGNITUDE", "PHASE", "IMAGINARY"}, 0x00189226},
          {"frame type",
           0x00089007,
           "CS",
           {"ORIGINAL\\PRIMARY\\T1\\NONE", "ORIGINAL\\PRIMARY\\T2\\NONE", "D\\P\\ADC\\NONE"},
           0x00189226},
          {"echo time", 0x00189082, "FD", {doubles({4.6}), doubles({9.2}), doubles({20})}, 0x00189114},
          {"b-value", 0x00189087, "FD", {doubles({0}), doubles({700}), doubles({1400})}, 0x00189117},
          {"gradient direction",
           0x00189089,
           "FD",
           {doubles({0, 0, 1}), doubles({1, 0, 0}), doubles({0, 1, 0})},
           0x00189117,
           0x00189076},
          {"temporal position", 0x00209128, "UL", {long_of(1), long_of(2), long_of(3)}, 0x00209111},
          {"segment", 0x0062000b, "US", {short_of(1), short_of(2), short_of(7)}, 0x0062000a},
          {"inversion times", 0x00189079, "FD", {doubles({100}), doubles({400}), doubles({900})}, 0x00189115},
          {"flip angle", 0x00181314, "DS", {"5", "10", "20"}, 0x00189112},
          {"trigger delay", 0x00209153, "FD", {doubles({0}), doubles({30}), doubles({60})}, 0x00189118},
          {"cardiac phase", 0x00209241, "FL", {float_of(0), float_of(40), float_of(75)}, 0x00189118},
          {"velocity direction", 0x00189090, "FD", {doubles({1, 0, 0}), doubles({0, 1, 0}), doubles({0, 0, 1})}, 0x00189197},
          {"ASL context", 0x00189257, "CS", {"LABEL", "CONTROL", "M_ZERO_SCAN"}, 0x00189251},
          {"contrast phase", 0x00189344, "CS", {"PRE_CONTRAST", "DYNAMIC", "DELAYED"}, 0x00189341},
          {"stack", 0x00209056, "SH", {"1", "2", "3"}, 0x00209111},
          {"tube voltage", 0x00180060, "DS", {"80", "100", "140"}, 0x00189325},
          {"an element that no list has", 0x00189105, "FD", {doubles({1}), doubles({2}), doubles({3})}, 0x00189103}};
}

/// Pixels that all encode their kind and position.
int value_of(int kind, int place) { return 1000 * (kind + 1) + 10 * place; }
std::string pixels_of(const DicomSeries& series, int kind, int place) {
  std::string bytes;
  for (std::int64_t n = 0; n < series.columns * series.rows; ++n) bytes += short_of(value_of(kind, place));
  return bytes;
}

class DicomKinds : public ReaderTest {
 protected:
  DicomKinds() {
    series_.intercept = 0;
    series_.columns = 4, series_.rows = 3;
  }

  /// Reads every frame; each must be of one kind, all kinds must occur, and a warning must name the difference.
  void expect_unmixed(const fs::path& path, int kinds, const std::string& named) {
    VolumeRequest request;
    const Volume first = read(path);
    ASSERT_EQ(first.frames, kinds) << all_warnings(first);
    EXPECT_TRUE(warns_of(first, "has frames that differ in " + named)) << all_warnings(first);
    request.files = {path};
    const Volume all = read_series(request, 1.0, BetweenFrames::linear, volume_reader(options_));
    const SeriesView* const view = series_of(*all.fields[0].field);
    ASSERT_NE(view, nullptr);
    std::set<int> there;
    for (const auto& frame : view->frames) {
      ASSERT_EQ(grid_of(*frame)->geometry.dims[2], places);
      std::set<int> of_frame;
      for (int place = 0; place < places; ++place) {
        const ScalarSample sample = frame->scalar(1e-3 * series_.at_mm({1, 1, static_cast<double>(place)}));
        ASSERT_TRUE(sample.inside);
        of_frame.insert(static_cast<int>(std::lround((sample.value - 10 * place) / 1000)));
      }
      EXPECT_EQ(of_frame.size(), 1U) << "a frame mixes kinds";
      there.insert(of_frame.begin(), of_frame.end());
    }
    EXPECT_EQ(static_cast<int>(there.size()), kinds);
  }

  void empty_folder() const {
    for (const auto& entry : fs::directory_iterator(folder_.path())) fs::remove_all(entry.path());
  }

  /// All images of all kinds and positions, in a random order.
  std::vector<std::pair<int, int>> shuffled(int kinds) {
    std::vector<std::pair<int, int>> all;
    for (int kind = 0; kind < kinds; ++kind)
      for (int place = 0; place < places; ++place) all.emplace_back(kind, place);
    std::ranges::shuffle(all, random_);
    return all;
  }

  DicomSeries series_;
  std::mt19937 random_{20261127};
};

TEST_F(DicomKinds, ClassicSeriesAreNeverMixed) {
  for (const Kind& kind : classic_kinds()) {
    SCOPED_TRACE(kind.name);
    const int kinds = static_cast<int>(kind.values.size());
    empty_folder();
    int number = 0;
    for (const auto& [k, place] : shuffled(kinds)) {
      DicomElements image = series_.image(series_.at_mm({0, 0, static_cast<double>(place)}), ++number);
      image.set(0x00080060, "CS", "MR");
      if (const std::string& value = kind.values[static_cast<std::size_t>(k)]; !value.empty())
        image.set(kind.tag, kind.vr, value);
      image.set(0x7fe00010, "OW", pixels_of(series_, k, place));
      folder_.write("i" + std::to_string(number), series_.file(image));
    }
    expect_unmixed(folder_.path(), kinds, "");
  }
}

/// Private elements of a maker. Several numbers: in successive elements.
struct PrivateKind {
  std::string name;
  const char* creator;
  std::uint32_t group, element;
  const char* vr;
  std::vector<std::vector<std::string>> values;
  std::string named;  ///< by a warning
};

std::vector<PrivateKind> private_kinds() {
  const auto floats = [](float x, float y, float z) { return std::vector{float_of(x), float_of(y), float_of(z)}; };
  const std::string b = "b-value (0, 500, 1000 s/mm²)", part = "complex component (MAGNITUDE, PHASE, REAL)";
  return {
      {"GE", "GEMS_PARM_01", 0x0043, 0x39, "IS", {{"0\\8"}, {"500\\8\\0\\0"}, {"1000001000\\8\\0\\0"}}, b},
      {"Philips", "Philips Imaging DD 001", 0x2001, 0x03, "FL", {{float_of(0)}, {float_of(500)}, {float_of(1000)}}, b},
      {"Siemens", "SIEMENS MR HEADER", 0x0019, 0x0c, "IS", {{"0"}, {"500"}, {"1000"}}, b},
      {"UIH", "Image Private Header", 0x0065, 0x09, "FD", {{doubles({0})}, {doubles({500})}, {doubles({1000})}}, b},
      {"GE", "GEMS_ACQU_01", 0x0019, 0xbb, "DS", {{"1", "0", "0"}, {"0", "1", "0"}, {"0", "0", "-1"}}, "gradient direction"},
      {"Philips",
       "Philips MR Imaging DD 001",
       0x2005,
       0xb0,
       "FL",
       {floats(0.6F, 0, 0.8F), floats(0, 1, 0), floats(0, 0, 1)},
       "gradient direction"},
      {"Siemens",
       "SIEMENS MR HEADER",
       0x0019,
       0x0e,
       "FD",
       {{doubles({1, 0, 0})}, {doubles({0, 1, 0})}, {doubles({0, 0, 1})}},
       "gradient direction"},
      {"GE", "GEMS_PARM_01", 0x0043, 0x2f, "SS", {{short_of(0)}, {short_of(1)}, {short_of(2)}}, part},
      {"Philips", "Philips MR Imaging DD 001", 0x2005, 0x11, "CS", {{"M"}, {"P"}, {"R"}}, part},
      {"GE",
       "GEMS_PARM_01",
       0x0043,
       0x30,
       "SS",
       {{short_of(9)}, {short_of(10)}, {short_of(11)}},
       "velocity direction (9, 10, 11)"}};
}

TEST_F(DicomKinds, WhatMakersSayInElementsOfTheirOwnIsNeverMixed) {
  // With types, without them, and copied by a program that lacks their types.
  for (const char* how : {"typed", "implicit", "unknown"}) {
    for (const PrivateKind& kind : private_kinds()) {
      SCOPED_TRACE(std::string(how) + ": " + kind.name + ", " + kind.named);
      empty_folder();
      series_.syntax = std::string(how) == "implicit" ? "1.2.840.10008.1.2" : "1.2.840.10008.1.2.1";
      int number = 0;
      for (const auto& [k, place] : shuffled(3)) {
        DicomElements image = series_.image(series_.at_mm({0, 0, static_cast<double>(place)}), ++number);
        const std::uint32_t block = number % 2 == 0 ? 0x10 : 0x12;
        image.set(kind.group << 16 | block, "LO", kind.creator);
        std::uint32_t tag = kind.group << 16 | block << 8 | kind.element;
        for (const std::string& value : kind.values[static_cast<std::size_t>(k)])
          image.set(tag++, std::string(how) == "unknown" ? "UN" : kind.vr, value);
        image.set(0x7fe00010, "OW", pixels_of(series_, k, place));
        folder_.write("i" + std::to_string(number), series_.file(image));
      }
      expect_unmixed(folder_.path(), 3, kind.named);
    }
  }
}

/// One file with functional groups for each frame. \param says  adds to the groups of a frame of a kind
DicomElements enhanced(const DicomSeries& series, const std::vector<std::pair<int, int>>& order,
                       const std::function<void(DicomElements& groups, int kind, int place)>& says) {
  DicomElements image = series.image(series.origin_mm, 1), orientation, measures, shared;
  for (const std::uint32_t tag : {0x00200032, 0x00200037, 0x00280030}) image.erase(tag);
  image.set(0x00080060, "CS", "MR");
  orientation.set(0x00200037, "DS", decimals(series.right) + "\\" + decimals(series.down));
  measures.set(0x00280030, "DS", decimal(series.row_mm) + "\\" + decimal(series.column_mm));
  shared.set_items(0x00209116, {orientation});
  shared.set_items(0x00289110, {measures});
  image.set_items(0x52009229, {shared});
  std::vector<DicomElements> frames;
  std::string pixels;
  for (const auto& [k, place] : order) {
    DicomElements position, groups;
    position.set(0x00200032, "DS", decimals(series.at_mm({0, 0, static_cast<double>(place)})));
    groups.set_items(0x00209113, {position});
    says(groups, k, place);
    frames.push_back(groups);
    pixels += pixels_of(series, k, place);
  }
  image.set_items(0x52009230, frames);
  image.set(0x00280008, "IS", std::to_string(order.size()));
  image.set(0x7fe00010, "OW", pixels);
  return image;
}

TEST_F(DicomKinds, FramesOfEnhancedFilesAreNeverMixed) {
  for (const Kind& kind : enhanced_kinds()) {
    SCOPED_TRACE(kind.name);
    const int kinds = static_cast<int>(kind.values.size());
    const DicomElements image = enhanced(series_, shuffled(kinds), [&](DicomElements& groups, int k, int) {
      DicomElements inner;
      inner.set(kind.tag, kind.vr, kind.values[static_cast<std::size_t>(k)]);
      if (kind.deeper != 0) {
        DicomElements outer;
        outer.set_items(kind.deeper, {inner});
        inner = outer;
      }
      groups.set_items(kind.group, {inner});
    });
    expect_unmixed(folder_.write("enhanced.dcm", series_.file(image)), kinds, "");
  }
}

TEST_F(DicomKinds, DimensionsThatAFileNamesAreKept) {
  // A dimension of its own, whose element occurs nowhere else, beside the position's dimension.
  DicomElements image = enhanced(series_, shuffled(3), [](DicomElements& groups, int k, int place) {
    DicomElements content;
    content.set(0x00209157, "UL", long_of(place + 1) + long_of(k + 1));
    groups.set_items(0x00209111, {content});
  });
  DicomElements position, own;
  position.set(0x00209165, "AT", short_of(0x0020) + short_of(0x0032));
  own.set(0x00209165, "AT", short_of(0x0018) + short_of(0x9999));
  image.set_items(0x00209222, {position, own});
  expect_unmixed(folder_.write("dimensions.dcm", series_.file(image)), 3, "dimension 2 (1, 2, 3)");
}

TEST_F(DicomKinds, DimensionsOfTimeThatStandNowhereElseAreKept) {
  for (const int element : {0x9128, 0x930d, 0x9153}) {
    DicomElements image = enhanced(series_, shuffled(3), [](DicomElements& groups, int k, int place) {
      DicomElements content;
      content.set(0x00209157, "UL", long_of(k + 1) + long_of(place + 1));
      groups.set_items(0x00209111, {content});
    });
    DicomElements position, time;
    time.set(0x00209165, "AT", short_of(0x0020) + short_of(element));
    position.set(0x00209165, "AT", short_of(0x0020) + short_of(0x9057));
    image.set_items(0x00209222, {time, position});
    expect_unmixed(folder_.write("times.dcm", series_.file(image)), 3, "dimension 1 (1, 2, 3)");
  }
}

TEST_F(DicomKinds, TwoAttributesMakeAFrameForEachPair) {
  const DicomElements image = enhanced(series_, shuffled(4), [](DicomElements& groups, int k, int) {
    DicomElements type, echo;
    type.set(0x00089208, "CS", k / 2 == 0 ? "MAGNITUDE" : "PHASE");
    echo.set(0x00189082, "FD", doubles({k % 2 == 0 ? 4.6 : 9.2}));
    groups.set_items(0x00189226, {type});
    groups.set_items(0x00189114, {echo});
  });
  expect_unmixed(folder_.write("pairs.dcm", series_.file(image)), 4,
                 "echo time (4.6, 9.2 ms) and complex component (MAGNITUDE, PHASE)");
}

TEST_F(DicomKinds, VectorsOfNuclearMedicineAreKept) {
  const std::pair<const char*, std::uint32_t> vectors[] = {
      {"energy window", 0x00540010}, {"detector", 0x00540020},  {"phase", 0x00540030},        {"rotation", 0x00540050},
      {"R-R interval", 0x00540060},  {"time slot", 0x00540070}, {"angular view", 0x00540090}, {"time slice", 0x00540100}};
  for (const auto& [name, tag] : vectors) {
    SCOPED_TRACE(name);
    DicomElements image = series_.image(series_.origin_mm, 1), detector;
    std::string of_kind, of_slice, pixels;
    for (const auto& [k, place] : shuffled(3)) {
      of_kind += short_of(k + 1), of_slice += short_of(place + 1);
      pixels += pixels_of(series_, k, place);
    }
    // The file's position is that of the first frame's slice, in any order.
    const int first = static_cast<unsigned char>(of_slice[0]) - 1;
    image.set(0x00080060, "CS", "NM");
    for (const std::uint32_t at : {0x00200032, 0x00200037}) image.erase(at);
    detector.set(0x00200032, "DS", decimals(series_.at_mm({0, 0, static_cast<double>(first)})));
    detector.set(0x00200037, "DS", decimals(series_.right) + "\\" + decimals(series_.down));
    image.set_items(0x00540022, {detector, detector, detector});
    image.set(0x00180088, "DS", "2.5");
    image.set(0x00280008, "IS", std::to_string(3 * places));
    image.set(tag, "US", of_kind);
    image.set(0x00540080, "US", of_slice);
    image.set(0x7fe00010, "OW", pixels);
    expect_unmixed(folder_.write("nm.dcm", series_.file(image)), 3, std::string(name) + " (1, 2, 3)");
  }
}

TEST_F(DicomKinds, FramesThatAreNoSlicesLieAtOnePlace) {
  // Views of a turning camera, and a film: no slices.
  for (const bool film : {false, true}) {
    SCOPED_TRACE(film);
    DicomElements image = series_.image(series_.origin_mm, 1);
    std::string views, pixels;
    for (int k = 0; k < 3; ++k) views += short_of(k + 1), pixels += pixels_of(series_, k, 0);
    image.set(0x00180088, "DS", "2.5");
    image.set(0x00280008, "IS", "3");
    if (film) {
      image.set(0x00280009, "AT", short_of(0x0018) + short_of(0x1063));
    } else {
      image.set(0x00540090, "US", views);
    }
    image.set(0x7fe00010, "OW", pixels);
    const Volume volume = read(folder_.write("views.dcm", series_.file(image)));
    EXPECT_EQ(volume.frames, 3);
    EXPECT_EQ(grid_of(*volume.fields[0].field)->geometry.dims[2], 1);
  }
}

TEST_F(DicomKinds, SegmentsAreWholeAndZeroWhereTheirFileLeavesImagesOut) {
  // Segment 1 at positions 0 and 1, segment 2 at 1 and 4; positions 2 and 3 have neither.
  DicomElements image = enhanced(series_, {{1, 4}, {0, 1}, {1, 1}, {0, 0}}, [](DicomElements& groups, int k, int) {
    DicomElements segment;
    segment.set(0x0062000b, "US", short_of(k + 1));
    groups.set_items(0x0062000a, {segment});
  });
  image.set(0x00080060, "CS", "SEG");
  const fs::path file = folder_.write("seg.dcm", series_.file(image));
  const std::set<int> there[] = {{0, 1}, {1, 4}};
  VolumeRequest request;
  for (request.frame = 0; request.frame < 2; ++request.frame) {
    const Volume volume = read(file, request);
    EXPECT_TRUE(volume.warnings.empty()) << all_warnings(volume);
    ASSERT_EQ(volume.frames, 2);
    for (int place = 0; place < places; ++place) {
      const ScalarSample sample = volume.fields[0].field->scalar(1e-3 * series_.at_mm({1, 1, static_cast<double>(place)}));
      ASSERT_TRUE(sample.inside);
      EXPECT_NEAR(sample.value, there[request.frame].count(place) > 0 ? value_of(request.frame, place) : 0, 1e-6) << place;
    }
  }
  EXPECT_TRUE(warns_of(read(file), "has frames that differ in segment (1, 2)"));
}

TEST_F(DicomKinds, KindsAtDifferentPlacesMakeNoVolumeOfBoth) {
  for (int place = 0; place < places; ++place) {
    const int k = place < 3 ? 0 : 1;
    DicomElements image = series_.image(series_.at_mm({0, 0, static_cast<double>(place)}), place);
    image.set(0x00189087, "FD", doubles({k * 1000.0}));
    image.set(0x7fe00010, "OW", pixels_of(series_, k, place));
    folder_.write("i" + std::to_string(place), series_.file(image));
  }
  const Volume volume = read(folder_.path());
  EXPECT_EQ(grid_of(*volume.fields[0].field)->geometry.dims[2], 3);
  EXPECT_TRUE(warns_of(volume, "differ in b-value (0, 1000 s/mm²) and are not at the same places: 2 of 5 are left out"))
      << all_warnings(volume);
}

TEST_F(DicomKinds, WhatCannotBeToldApartIsRefused) {
  // No attribute, or a clock that advances by position, beside kinds in a changing order.
  for (const bool timed : {false, true}) {
    SCOPED_TRACE(timed);
    empty_folder();
    std::vector<std::pair<int, int>> order = shuffled(2);
    if (timed) std::ranges::stable_sort(order, {}, [](const auto& image) { return image.second; });
    int number = 0;
    for (const auto& [k, place] : order) {
      DicomElements image = series_.image(series_.at_mm({0, 0, static_cast<double>(place)}), ++number);
      if (timed) image.set(0x00080032, "TM", "1015" + std::to_string(10 + number));
      image.set(0x7fe00010, "OW", pixels_of(series_, k, place));
      folder_.write("i" + std::to_string(number), series_.file(image));
    }
    const std::string error = error_of([&] { read(folder_.path()); });
    EXPECT_NE(error.find("2 images at each place, which no attribute distinguishes"), std::string::npos) << error;
  }
}

TEST_F(DicomKinds, AClockThatGoesFrameAfterFrameTellsFramesApart) {
  // Slice after slice, three times over, as a scanner repeats a volume.
  for (int k = 0; k < 3; ++k) {
    for (int place = 0; place < places; ++place) {
      const int number = k * places + place;
      DicomElements image = series_.image(series_.at_mm({0, 0, static_cast<double>(place)}), 100 - number);
      image.set(0x00080032, "TM", "1015" + std::to_string(10 + number));
      image.set(0x7fe00010, "OW", pixels_of(series_, k, place));
      folder_.write("i" + std::to_string(number), series_.file(image));
    }
  }
  expect_unmixed(folder_.path(), 3, "acquisition time");
}

TEST_F(DicomKinds, ACounterThatGoesFrameAfterFrameByChanceTellsNothing) {
  // Two kinds without a distinguishing element; numbers 1 to 3 are at three positions, but of both kinds.
  const std::pair<int, int> order[] = {{0, 2}, {1, 0}, {0, 1}, {1, 1}, {0, 0}, {1, 2}};
  int number = 0;
  for (const auto& [k, place] : order) {
    DicomElements image = series_.image(series_.at_mm({0, 0, static_cast<double>(place)}), ++number);
    image.set(0x7fe00010, "OW", pixels_of(series_, k, place));
    folder_.write("i" + std::to_string(number), series_.file(image));
  }
  EXPECT_NE(error_of([&] { read(folder_.path()); }).find("which no attribute distinguishes"), std::string::npos);
}

TEST_F(DicomKinds, OneKindStaysOneVolume) {
  // Times and counters that drift from slice to slice, and rounding of a single value, split nothing.
  for (int place = 0; place < places; ++place) {
    DicomElements image = series_.image(series_.at_mm({0, 0, static_cast<double>(place)}), place);
    image.set(0x00180081, "DS", place % 2 == 0 ? "4.6" : "4.605");
    image.set(0x00181060, "DS", std::to_string(7 * place));
    image.set(0x00200012, "IS", std::to_string(place));
    image.set(0x00200100, "IS", std::to_string(place + 1));
    image.set(0x00080032, "TM", "10150" + std::to_string(place));
    image.set(0x00180080, "DS", std::to_string(900 + 20 * place));
    image.set(0x7fe00010, "OW", pixels_of(series_, 0, place));
    folder_.write("i" + std::to_string(place), series_.file(image));
  }
  const Volume volume = read(folder_.path());
  EXPECT_TRUE(volume.warnings.empty()) << all_warnings(volume);
  EXPECT_EQ(volume.frames, 1);
  EXPECT_EQ(grid_of(*volume.fields[0].field)->geometry.dims[2], places);
}

}  // namespace dicom_kinds_test
}  // namespace palpa::test
