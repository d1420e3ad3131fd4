// Attributes of HDF5 and netCDF-4, written with the library itself: packed numbers, fill values, coordinates, time. Sampled
// values equal the conventions' values.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

#include "hdf5_file.h"
#include "palpa/data/grid_base.h"
#include "palpa/file/components.h"

namespace palpa::test {
namespace cf_test {

template <class T>
hid_t type_of() {
  if constexpr (std::is_same_v<T, std::int8_t>) return H5T_STD_I8LE;
  if constexpr (std::is_same_v<T, std::uint8_t>) return H5T_STD_U8LE;
  if constexpr (std::is_same_v<T, std::int16_t>) return H5T_STD_I16LE;
  if constexpr (std::is_same_v<T, std::uint16_t>) return H5T_STD_U16LE;
  if constexpr (std::is_same_v<T, std::int32_t>) return H5T_STD_I32LE;
  if constexpr (std::is_same_v<T, std::uint32_t>) return H5T_STD_U32LE;
  if constexpr (std::is_same_v<T, std::int64_t>) return H5T_STD_I64LE;
  if constexpr (std::is_same_v<T, std::uint64_t>) return H5T_STD_U64LE;
  if constexpr (std::is_same_v<T, float>) return H5T_IEEE_F32LE;
  return H5T_IEEE_F64LE;
}

class NewHdf5 {
 public:
  explicit NewHdf5(const fs::path& path, hsize_t block_bytes = 0) : path_(path) {
    const hid_t creation = H5Pcreate(H5P_FILE_CREATE);
    H5Pset_userblock(creation, block_bytes);
    file_ = H5Fcreate(path.c_str(), H5F_ACC_TRUNC, creation, H5P_DEFAULT);
    H5Pclose(creation);
  }
  ~NewHdf5() { close(); }
  void close() {
    if (file_ >= 0) H5Fclose(std::exchange(file_, -1));
  }
  const fs::path& path() const { return path_; }
  hid_t id() const { return file_; }

  template <class T>
  void array(const std::string& name, const std::vector<hsize_t>& lengths, const std::vector<T>& numbers,
             const T* fill = nullptr) {
    const hid_t space = H5Screate_simple(static_cast<int>(lengths.size()), lengths.data(), nullptr);
    const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
    if (fill != nullptr) H5Pset_fill_value(creation, type_of<T>(), fill);
    const hid_t data = H5Dcreate2(file_, name.c_str(), type_of<T>(), space, H5P_DEFAULT, creation, H5P_DEFAULT);
    if (!numbers.empty()) H5Dwrite(data, type_of<T>(), H5S_ALL, H5S_ALL, H5P_DEFAULT, numbers.data());
    H5Dclose(data), H5Pclose(creation), H5Sclose(space);
  }
  template <class T>
  void attribute(const std::string& of, const char* name, const std::vector<T>& numbers) {
    const hid_t object = H5Oopen(file_, of.c_str(), H5P_DEFAULT);
    const hsize_t count = numbers.size();
    const hid_t space = count == 1 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &count, nullptr);
    const hid_t attribute = H5Acreate2(object, name, type_of<T>(), space, H5P_DEFAULT, H5P_DEFAULT);
    H5Awrite(attribute, type_of<T>(), numbers.data());
    H5Aclose(attribute), H5Sclose(space), H5Oclose(object);
  }
  void text(const std::string& of, const char* name, const std::string& words, bool variable = false) {
    const hid_t object = H5Oopen(file_, of.c_str(), H5P_DEFAULT);
    if (variable) {
      const hid_t type = H5Tcopy(H5T_C_S1), space = H5Screate(H5S_SCALAR);
      H5Tset_size(type, H5T_VARIABLE), H5Tset_cset(type, H5T_CSET_UTF8);
      const hid_t attribute = H5Acreate2(object, name, type, space, H5P_DEFAULT, H5P_DEFAULT);
      const char* pointer = words.c_str();
      H5Awrite(attribute, type, &pointer);
      H5Aclose(attribute), H5Sclose(space), H5Tclose(type);
    } else {
      write_text(object, name, words);
    }
    H5Oclose(object);
  }
  /// Attaches scales, one for each index, as netCDF-4 and h5py do; empty: none.
  void scales(const std::string& of, const std::vector<std::string>& names) {
    std::vector<hobj_ref_t> references(names.size());
    std::vector<hvl_t> lists(names.size());
    for (std::size_t n = 0; n < names.size(); ++n) {
      if (names[n].empty()) continue;
      H5Rcreate(&references[n], file_, names[n].c_str(), H5R_OBJECT, -1);
      lists[n] = {1, &references[n]};
    }
    const hid_t object = H5Oopen(file_, of.c_str(), H5P_DEFAULT), type = H5Tvlen_create(H5T_STD_REF_OBJ);
    const hsize_t count = names.size();
    const hid_t space = H5Screate_simple(1, &count, nullptr);
    const hid_t attribute = H5Acreate2(object, "DIMENSION_LIST", type, space, H5P_DEFAULT, H5P_DEFAULT);
    H5Awrite(attribute, type, lists.data());
    H5Aclose(attribute), H5Sclose(space), H5Tclose(type), H5Oclose(object);
  }
  template <class T>
  void scale(const std::string& name, const std::vector<T>& at, const std::string& units, const std::string& axis = {}) {
    array<T>(name, {at.size()}, at);
    text(name, "CLASS", "DIMENSION_SCALE");
    if (!units.empty()) text(name, "units", units);
    if (!axis.empty()) text(name, "axis", axis);
  }

 private:
  fs::path path_;
  hid_t file_;
};

class Conventions : public ReaderTest {
 protected:
  fs::path path(const std::string& name = "a.nc") const { return folder_.path() / name; }
  static VolumeRequest with_spacing() {
    VolumeRequest request;
    request.layout.spacing_m = {1, 1, 1};
    return request;
  }
  /// The value of a voxel; NaN if missing. Not a sample, which is NaN beside a missing voxel too.
  static double at(const Volume& volume, std::int64_t i, std::int64_t j = 0, std::int64_t k = 0) {
    const GridView& grid = *grid_of(*volume.fields[0].field);
    const auto& dims = grid.geometry.dims;
    double value = 0.0;
    detail::with_values_of(grid.voxels, [&](const auto* from) {
      value = static_cast<double>(from[i + dims[0] * (j + dims[1] * k)]) * grid.scale + grid.offset;
    });
    return value;
  }
};

template <class T>
class Packed : public Conventions {};
using Stored = ::testing::Types<std::int8_t, std::uint8_t, std::int16_t, std::uint16_t, std::int32_t, std::uint32_t,
                                std::int64_t, std::uint64_t, float, double>;
TYPED_TEST_SUITE(Packed, Stored);

/// Numbers 10, 11 … of 8 × 2 × 2, packed: single voxels are read, as neighbours may be missing.
template <class T>
std::vector<T> counted() {
  std::vector<T> numbers;
  for (int n = 0; n < 32; ++n) numbers.push_back(static_cast<T>(10 + n));
  return numbers;
}

TYPED_TEST(Packed, ValuesAreWhatScaleAndOffsetMakeOfThem) {
  for (const bool with_fill : {false, true}) {
    NewHdf5 file(this->path());
    file.array<TypeParam>("T", {2, 2, 8}, counted<TypeParam>());
    file.template attribute<double>("T", "scale_factor", {-0.25});
    file.template attribute<float>("T", "add_offset", {273.0F});
    if (with_fill) file.attribute<TypeParam>("T", "_FillValue", {static_cast<TypeParam>(100)});
    file.text("T", "units", "K", with_fill);
    file.close();
    const Volume volume = this->read(file.path(), this->with_spacing());
    EXPECT_EQ(volume.fields[0].unit, "K");
    for (int n = 0; n < 32; ++n) EXPECT_DOUBLE_EQ(this->at(volume, n % 8, n / 8 % 2, n / 16), 273.0 - 0.25 * (10 + n)) << n;
  }
}

TYPED_TEST(Packed, NumbersThatStandForNoneAreNoData) {
  struct {
    const char* name;
    std::vector<int> numbers;
    std::vector<int> gone;
  } cases[] = {{"_FillValue", {12}, {12}},    {"missing_value", {11}, {11}}, {"missing_value", {11, 13}, {11, 13}},
               {"valid_min", {12}, {10, 11}}, {"valid_max", {15}, {16, 17}}, {"valid_range", {12, 15}, {10, 11, 16, 17}}};
  for (const auto& c : cases) {
    NewHdf5 file(this->path());
    file.array<TypeParam>("T", {2, 2, 8}, counted<TypeParam>());
    file.template attribute<double>("T", "scale_factor", {0.5});
    std::vector<TypeParam> numbers(c.numbers.begin(), c.numbers.end());
    file.attribute<TypeParam>("T", c.name, numbers);
    file.close();
    const Volume volume = this->read(file.path(), this->with_spacing());
    for (int i = 0; i < 8; ++i) {
      const double value = this->at(volume, i);
      if (std::ranges::find(c.gone, 10 + i) != c.gone.end()) {
        EXPECT_TRUE(std::isnan(value)) << c.name << " " << i << ": " << value;
      } else {
        EXPECT_DOUBLE_EQ(value, 0.5 * (10 + i)) << c.name << " " << i;
      }
    }
  }
}

TEST_F(Conventions, TheFillValueOfNetcdfItselfIsNoData) {
  for (const bool is_netcdf : {true, false}) {
    NewHdf5 file(path());
    const float fill = 9.9692099683868690e+36F;
    std::vector<float> numbers(32, 2.0F);
    numbers[3] = fill;
    file.array<float>("T", {2, 2, 8}, numbers, &fill);
    if (is_netcdf) file.text("/", "_NCProperties", "version=2,netcdf=4.9.0");
    file.close();
    const Volume volume = read(file.path(), with_spacing());
    EXPECT_EQ(std::isnan(at(volume, 3)), is_netcdf);
    EXPECT_EQ(at(volume, 5), 2.0);
  }
  NewHdf5 file(path());
  const std::int16_t fill = -32767;
  std::vector<std::int16_t> numbers(32, 200);
  numbers[3] = fill;
  file.array<std::int16_t>("T", {2, 2, 8}, numbers, &fill);
  file.text("/", "_NCProperties", "version=2,netcdf=4.9.0", true);
  file.attribute<double>("T", "scale_factor", {0.01});
  file.close();
  const Volume volume = read(file.path(), with_spacing());
  EXPECT_TRUE(std::isnan(at(volume, 3)));
  EXPECT_DOUBLE_EQ(at(volume, 5), 2.0);
  EXPECT_TRUE(warns_of(volume, "without a value")) << all_warnings(volume);
}

TEST_F(Conventions, SignedNumbersThatStandForUnsignedOnes) {
  NewHdf5 file(path());
  std::vector<std::int8_t> numbers(32, 5);
  numbers[2] = -1, numbers[3] = -56, numbers[4] = -6;
  file.array<std::int8_t>("T", {2, 2, 8}, numbers);
  file.text("T", "_Unsigned", "true");
  file.attribute<std::int8_t>("T", "_FillValue", {-1});
  file.attribute<std::int8_t>("T", "valid_range", {0, -6});  // to 250
  file.attribute<double>("T", "scale_factor", {2.0});
  file.close();
  const Volume volume = read(file.path(), with_spacing());
  EXPECT_TRUE(std::isnan(at(volume, 2)));
  EXPECT_EQ(at(volume, 3), 400.0);
  EXPECT_EQ(at(volume, 4), 500.0);
  EXPECT_EQ(at(volume, 0), 10.0);
}

TEST_F(Conventions, ARangeAndASignAreThoseOfTheNumbersThatAreMeant) {
  for (const bool is_unsigned : {true, false}) {
    SCOPED_TRACE(is_unsigned);
    NewHdf5 file(path());
    const std::vector<int> bits{5, 200, 250, 252, 100, 128, 127, 0};
    std::vector<std::int8_t> as_signed;
    std::vector<std::uint8_t> as_unsigned;
    for (int n = 0; n < 32; ++n) {
      as_unsigned.push_back(static_cast<std::uint8_t>(bits[static_cast<std::size_t>(n % 8)]));
      as_signed.push_back(static_cast<std::int8_t>(as_unsigned.back()));
    }
    if (is_unsigned) {
      file.array<std::int8_t>("T", {2, 2, 8}, as_signed);
      file.attribute<std::int8_t>("T", "valid_range", {0, -6});  // to 250
    } else {
      file.array<std::uint8_t>("T", {2, 2, 8}, as_unsigned);
      file.attribute<std::uint8_t>("T", "valid_range", {200, 127});  // from -56
    }
    file.text("T", "_Unsigned", is_unsigned ? "True" : "false");
    file.close();
    const Volume volume = read(file.path(), with_spacing());
    for (int i = 0; i < 8; ++i) {
      const int meant = bits[static_cast<std::size_t>(i)] - (!is_unsigned && bits[static_cast<std::size_t>(i)] > 127 ? 256 : 0);
      const bool is_valid = is_unsigned ? meant <= 250 : meant >= -56;
      EXPECT_EQ(std::isnan(at(volume, i)), !is_valid) << meant;
      if (is_valid) {
        EXPECT_EQ(at(volume, i), meant);
      }
    }
    EXPECT_FALSE(warns_of(volume, "exchanged")) << all_warnings(volume);
  }
}

TEST_F(Conventions, AttributesOfNoConventionThatIsReadAreNamed) {
  for (const char* name :
       {"scale", "Offset", "slope", "Intercept", "gain", "ScaleFactor", "FillValue", "nodata", "voxel_size"}) {
    NewHdf5 file(path());
    file.array<float>("T", {2, 2, 8}, counted<float>());
    file.attribute<double>("T", name, {2.0});
    file.attribute<double>("T", "scale_factor", {2.0});
    file.close();
    const Volume volume = read(file.path(), with_spacing());
    EXPECT_TRUE(warns_of(volume, "has attributes that are not applied: '" + std::string(name) + "';")) << all_warnings(volume);
  }
}

TEST_F(Conventions, ArraysOfProgramsThatScaleOrPlaceThemElsewhereAreRefused) {
  for (const auto& [array, says] : {std::pair{"/minc-2.0/image/0/image", "mnc2nii"},
                                    {"/ITKImage/0/VoxelData", "give spacing_m"},
                                    {"/DataSet/ResolutionLevel 0/TimePoint 0/Channel 0/Data", "give spacing_m"}}) {
    const hid_t file = H5Fcreate(path().c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT);
    write_array<double>(file, array, {2, 2, 8}, std::string(256, '\0'));
    H5Fclose(file);
    const std::string error = error_of([&] { read(path()); });
    EXPECT_NE(error.find(says), std::string::npos) << error;
  }
  const Volume placed = read(path(), with_spacing());
  EXPECT_EQ(placed.fields.size(), 1U);
}

TEST_F(Conventions, ARangeOfTheTypeOfTheValuesIsInTheirUnit) {
  NewHdf5 file(path());
  file.array<std::int16_t>("T", {2, 2, 8}, counted<std::int16_t>());
  file.attribute<double>("T", "scale_factor", {-0.5});
  file.attribute<double>("T", "valid_range", {-6.0, -5.5});  // of values: 11 and 12 are stored
  file.close();
  const Volume volume = read(file.path(), with_spacing());
  for (int i = 0; i < 8; ++i) EXPECT_EQ(std::isnan(at(volume, i)), i != 1 && i != 2) << i;
  EXPECT_TRUE(warns_of(volume, "in their unit"));
}

TEST_F(Conventions, AttributesThatCannotBeAreRefusedOrNotApplied) {
  struct {
    const char* name;
    std::vector<double> numbers;
    const char* says;
  } cases[] = {{"scale_factor", {0.0}, "a scale_factor of 0"},
               {"scale_factor", {std::nan("")}, "not one finite number"},
               {"scale_factor", {std::numeric_limits<double>::infinity()}, "not one finite number"},
               {"scale_factor", {1.0, 2.0}, "not one finite number"},
               {"add_offset", {std::nan("")}, "not one finite number"}};
  const auto written = [&](const std::string& name, const auto& write) {
    NewHdf5 file(path(name));
    file.array<float>("T", {2, 2, 8}, counted<float>());
    write(file);
    file.close();
    return file.path();
  };
  for (const auto& c : cases) {
    const fs::path file = written("a.h5", [&](NewHdf5& f) { f.attribute<double>("T", c.name, c.numbers); });
    EXPECT_NE(error_of([&] { read(file, with_spacing()); }).find(c.says), std::string::npos) << c.name;
  }
  const fs::path words = written("b.h5", [](NewHdf5& f) { f.text("T", "scale_factor", "0.01"); });
  EXPECT_NE(error_of([&] { read(words, with_spacing()); }).find("scale_factor"), std::string::npos);
  const fs::path odd = written("c.h5", [](NewHdf5& f) {
    f.text("T", "_FillValue", "none");
    f.attribute<double>("T", "valid_range", {20, 10});
    f.attribute<double>("T", "valid_min", std::vector<double>(1001, 3.0));
    f.text("T", "units", std::string(50'000, 'K'));
    f.text("T", "unit", std::string(50'000, 'K'), true);
  });
  const Volume volume = read(odd, with_spacing());
  EXPECT_EQ(at(volume, 3), 13.0);
  EXPECT_TRUE(warns_of(volume, "_FillValue that holds no number: it is not applied"));
  EXPECT_TRUE(warns_of(volume, "exchanged: it is not applied"));
  EXPECT_TRUE(warns_of(volume, "valid_min that does not hold one number: it is not applied"));
  EXPECT_LE(volume.fields[0].unit.size(), 1000U);
}

/// Numbers of a linear function of the position [m] on these coordinates [m], x fastest.
std::vector<double> linear_on(const std::vector<double>& x, const std::vector<double>& y, const std::vector<double>& z) {
  std::vector<double> numbers;
  for (const double c : z)
    for (const double b : y)
      for (const double a : x) numbers.push_back(Linear{}(Vec3{a, b, c}));
  return numbers;
}

void expect_linear_at(const Volume& volume, const Vec3& at_m, double tolerance = 1e-6) {
  const ScalarSample sample = volume.fields[0].field->scalar(at_m);
  ASSERT_TRUE(sample.inside);
  EXPECT_NEAR(sample.value, Linear{}(at_m), tolerance);
}

TEST_F(Conventions, CoordinatesRisingFallingAndUnevenPlaceTheGrid) {
  const std::vector<double> rising{1, 1.5, 2, 2.5, 3}, falling{4, 3, 2, 1}, uneven{0, 1, 3, 7};
  for (const auto& x : {rising, falling, uneven}) {
    for (const auto& z : {rising, falling, uneven}) {
      for (const char* axes : {"XYZ", ""}) {
        const bool named = *axes != '\0';
        NewHdf5 file(path());
        file.array<double>("T", {z.size(), rising.size(), x.size()}, linear_on(x, rising, z));
        file.scale<double>(named ? "a" : "x", x, "m", named ? "X" : "");
        file.scale<double>(named ? "b" : "y", rising, "m", named ? "Y" : "");
        file.scale<double>(named ? "c" : "z", z, "m", named ? "Z" : "");
        file.scales("T", named ? std::vector<std::string>{"c", "b", "a"} : std::vector<std::string>{"z", "y", "x"});
        file.close();
        const Volume volume = read(file.path());
        EXPECT_EQ(volume.length_unit, "m");
        EXPECT_FALSE(volume.length_unit_assumed);
        EXPECT_TRUE(volume.warnings.empty()) << all_warnings(volume);
        expect_linear_at(volume, {x[0] + 0.3 * (x[1] - x[0]), 2.2, z[1] + 0.6 * (z[2] - z[1])});
        expect_linear_at(volume, {x[2], 1.1, z[0]});
      }
    }
  }
  NewHdf5 file(path());  // not monotone: no grid
  file.array<double>("T", {5, 5, 4}, linear_on({1, 3, 2, 4}, rising, rising));
  file.scale<double>("x", {1, 3, 2, 4}, "m");
  file.scales("T", {"", "", "x"});
  file.close();
  EXPECT_NE(error_of([&] { read(file.path()); }).find("coordinates that are no grid"), std::string::npos);
}

TEST_F(Conventions, AxesInAnyOrderAreWhatTheirScalesSay) {
  // x slowest. By axis, by standard name, by unit, and by name alone.
  const std::vector<double> x{0, 1, 2}, y{0, 2, 4, 6}, z{0, 1, 2, 3, 4};
  std::vector<double> numbers;
  for (const double a : x)
    for (const double b : y)
      for (const double c : z) numbers.push_back(Linear{}(Vec3{a, b, c}));
  for (const char* by : {"axis", "standard_name", "name"}) {
    NewHdf5 file(path());
    const bool by_name = std::string(by) == "name", by_axis = std::string(by) == "axis";
    const std::vector<std::string> names =
        by_name ? std::vector<std::string>{"easting", "northing", "height"} : std::vector<std::string>{"p", "q", "r"};
    file.array<double>("T", {3, 4, 5}, numbers);
    file.scale<double>(names[0], x, "m", by_axis ? "X" : "");
    file.scale<double>(names[1], y, "m", by_axis ? "Y" : "");
    file.scale<double>(names[2], z, "m", by_axis ? "Z" : "");
    if (!by_name && !by_axis) {
      file.text(names[0], "standard_name", "projection_x_coordinate");
      file.text(names[1], "standard_name", "projection_y_coordinate", true);
      file.text(names[2], "standard_name", "height");
    }
    file.scales("T", names);
    file.close();
    const Volume volume = read(file.path());
    EXPECT_EQ(grid_of(*volume.fields[0].field)->geometry.dims, (std::array<std::int64_t, 3>{3, 4, 5})) << by;
    expect_linear_at(volume, {1.5, 3, 2.5});
  }
}

TEST_F(Conventions, CoordinatesHaveUnitsOfTheirOwn) {
  const std::vector<double> x{0, 1, 2, 3}, y{0, 1, 2}, z{0, 10, 20};
  const auto written = [&](const char* ux, const char* uy, const char* uz) {
    NewHdf5 file(path());
    file.array<double>("T", {3, 3, 4}, std::vector<double>(36, 1.0));
    file.scale<double>("x", x, ux), file.scale<double>("y", y, uy), file.scale<double>("z", z, uz);
    file.scales("T", {"z", "y", "x"});
    file.close();
    return file.path();
  };
  const auto size = [](const Volume& volume) {
    const Box box = volume.bounds_m();
    return box.high_m - box.low_m;
  };
  for (const auto& [unit, metres] : {std::pair{"mm", 1e-3}, {"m", 1.0}, {"km", 1e3}, {"meters", 1.0}}) {
    const Volume volume = read(written(unit, unit, unit));
    EXPECT_FALSE(volume.length_unit_assumed);
    EXPECT_LT(distance(size(volume), metres * Vec3{3, 2, 20}), 1e-6 * metres) << unit;
  }
  EXPECT_LT(distance(size(read(written("km", "km", "m"))), {3000, 2000, 20}), 1e-6);
  const Volume unsaid = read(written("", "", ""));
  EXPECT_TRUE(unsaid.length_unit_assumed);
  EXPECT_TRUE(warns_of(unsaid, "no unit of length"));
  const Volume partly = read(written("mm", "mm", ""));
  EXPECT_LT(distance(size(partly), {3e-3, 2e-3, 20e-3}), 1e-9);
  EXPECT_TRUE(warns_of(partly, "have no unit"));
  const Volume degrees = read(written("degrees_east", "degrees_north", "km"));
  EXPECT_TRUE(warns_of(degrees, "on the Earth"));
  EXPECT_NEAR(size(degrees).y, 2 * 111'195, 10);
  EXPECT_NEAR(size(degrees).x, 3 * 111'195 * std::cos(3.14159265 / 180), 10);
  EXPECT_NEAR(size(degrees).z, 20e3, 1e-3);
  const Volume pressure = read(written("km", "km", "hPa"));
  EXPECT_TRUE(warns_of(pressure, "no length"));
  EXPECT_NEAR(size(pressure).z, 2000, 1e-6);
}

TEST_F(Conventions, AUnitThatIsNoLengthIsAskedForWhereNothingElseIs) {
  const auto written = [&](const char* ux, const char* uy, const char* uz) {
    NewHdf5 file(path());
    file.array<double>("T", {3, 3, 4}, std::vector<double>(36, 1.0));
    file.scale<double>("x", {0, 2, 4, 6}, ux), file.scale<double>("y", {0, 2, 4}, uy), file.scale<double>("z", {0, 2, 4}, uz);
    file.scales("T", {"z", "y", "x"});
    file.close();
    return file.path();
  };
  for (const char* unit : {"furlong", "pixel", "meter (m)", "1"}) {
    const std::string error = error_of([&] { read(written(unit, unit, unit)); });
    EXPECT_NE(error.find("'" + std::string(unit) + "', which is unknown; give it by length_unit"), std::string::npos) << error;
    VolumeRequest request;
    request.length_unit = "mm";
    EXPECT_LT(distance(read(path(), request).bounds_m().high_m, {6e-3, 4e-3, 4e-3}), 1e-9) << unit;
  }
  const std::string error = error_of([&] { read(written("mm", "furlong", "mm")); });
  EXPECT_NE(error.find("coordinates in 'furlong', which is no known unit of length"), std::string::npos) << error;
}

TEST_F(Conventions, WhatTheRequestSaysIsBelievedFirst) {
  NewHdf5 file(path());
  file.array<double>("T", {3, 3, 4}, std::vector<double>(36, 1.0));
  file.scale<double>("x", {5, 6, 7, 8}, "km");
  file.scales("T", {"", "", "x"});
  file.close();
  const Volume volume = read(file.path(), with_spacing());
  EXPECT_LT(distance(volume.bounds_m().high_m, {3, 2, 2}), 1e-9);
  EXPECT_FALSE(warns_of(volume, "coordinates"));
  VolumeRequest request;
  request.length_unit = "mm";
  EXPECT_LT(distance(read(file.path(), request).bounds_m().high_m, {8e-3, 2e-3, 2e-3}), 1e-9);
}

TEST_F(Conventions, ScalesThatDoNotFitAreSaid) {
  NewHdf5 file(path());
  file.array<double>("T", {3, 3, 4}, std::vector<double>(36, 1.0));
  file.scale<double>("x", {5, 6, 7}, "km");
  file.scale<double>("y", {1, std::nan(""), 3}, "m");
  file.scales("T", {"T", "y", "x"});  // an array is a scale of itself
  file.close();
  const Volume volume = read(file.path());
  EXPECT_TRUE(warns_of(volume, "not as many")) << all_warnings(volume);
  EXPECT_TRUE(warns_of(volume, "not finite")) << all_warnings(volume);
  EXPECT_TRUE(warns_of(volume, "no distances of voxels")) << all_warnings(volume);
}

TEST_F(Conventions, TimeIsNoAxisOfSpace) {
  const std::vector<double> x{0, 1, 2, 3}, y{0, 1, 2}, z{0, 1};
  for (const hsize_t moments : {1, 3}) {
    for (const bool named : {true, false}) {
      if (moments > 1 && !named) continue;
      NewHdf5 file(path());
      std::vector<double> numbers;
      for (hsize_t t = 0; t < moments; ++t) {
        for (const double n : linear_on(x, y, z)) numbers.push_back(n + 1000.0 * static_cast<double>(t));
      }
      file.array<double>("T", {moments, 2, 3, 4}, numbers);
      if (named) {
        file.scale<double>("moments", std::vector<double>(moments, 7.0), "hours since 2020-01-01");
        file.scales("T", {"moments", "", "", ""});
      }
      file.close();
      VolumeRequest request = with_spacing();
      const Volume first = read(file.path(), request);
      expect_linear_at(first, {1.5, 1.5, 0.5});
      EXPECT_EQ(first.frames, static_cast<int>(moments));
      EXPECT_EQ(grid_of(*first.fields[0].field)->geometry.dims, (std::array<std::int64_t, 3>{4, 3, 2}));
      if (moments == 1) continue;
      EXPECT_TRUE(warns_of(first, "3 frames"));
      request.frame = 2;
      EXPECT_NEAR(read(file.path(), request).fields[0].field->scalar({1.5, 1.5, 0.5}).value, 2000 + Linear{}({1.5, 1.5, 0.5}),
                  1e-6);
      request.frame = VolumeRequest::all_frames;
      EXPECT_EQ(read(file.path(), request).frames, 3);
    }
  }
}

TEST_F(Conventions, ATimeThatNothingSaysIsAskedForAndCanBeSaid) {
  NewHdf5 file(path());
  std::vector<double> numbers;
  for (int t = 0; t < 5; ++t) {
    for (const double n : linear_on({0, 1, 2, 3}, {0, 1}, {0, 1})) numbers.push_back(n + 1000.0 * t);
  }
  file.array<double>("T", {5, 2, 2, 4}, numbers);
  file.close();
  VolumeRequest request = with_spacing();
  EXPECT_NE(error_of([&] { read(file.path(), request); }).find("axes = \"tzyx\""), std::string::npos);
  request.layout.axes = "tzyx", request.frame = 4;
  EXPECT_NEAR(read(file.path(), request).fields[0].field->scalar({1.5, 0.5, 0.5}).value, 4000 + Linear{}({1.5, 0.5, 0.5}),
              1e-6);
}

TEST_F(Conventions, ThreeArraysOfOneShapeAreTheFieldsOfAVolume) {
  for (const bool with_time : {false, true}) {
    NewHdf5 file(path());
    const std::vector<hsize_t> lengths = with_time ? std::vector<hsize_t>{1, 6, 8, 10} : std::vector<hsize_t>{6, 8, 10};
    std::vector<float> u, v, w;
    for (int n = 0; n < 480; ++n) {
      const float y = static_cast<float>(n / 10 % 8) - 3.5F, z = static_cast<float>(n / 80) - 2.5F;
      u.push_back(10.0F - 0.3F * (y * y + z * z)), v.push_back(0.2F * z), w.push_back(-0.2F * y);
    }
    file.array<float>("u", lengths, u), file.array<float>("v", lengths, v), file.array<float>("w", lengths, w);
    file.array<float>("mag_u", lengths, u), file.array<float>("mag_v", lengths, v), file.array<float>("mag_w", lengths, w);
    file.array<float>("signal", {6, 8, 10}, u);
    file.array<float>("mask", {6, 4, 2}, std::vector<float>(48, 1.0F));
    file.close();
    const VolumeRequest request = with_spacing();
    const Volume volume = read(file.path(), request);
    EXPECT_EQ(volume.fields.size(), 7U);
    EXPECT_TRUE(warns_of(volume, "/mask")) << all_warnings(volume);
    const auto vectors = separate_vectors(volume);
    ASSERT_EQ(vectors.size(), 1U);
    EXPECT_EQ(vectors[0].arrays, (std::vector<std::string>{"u", "v", "w"}));
    VolumeRequest joined = request;
    joined.fields = {{"velocity", "", "m/s", {"u", "v", "w"}}};
    const VectorSample sample = read(file.path(), joined).fields[0].field->vector({4, 4, 3});
    ASSERT_TRUE(sample.inside);
    EXPECT_LT(distance(sample.value, {10.0 - 0.3 * 0.5, 0.1, -0.1}), 1e-5);
  }
}

TEST_F(Conventions, AUserBlockOfAnySizeIsGotPast) {
  for (const hsize_t bytes : {512, 1024, 2048, 4096, 65536}) {
    for (const char* name : {"a.h5", "a.mat", "a"}) {
      NewHdf5 file(path(name), bytes);
      file.array<double>("T", {2, 3, 4}, linear_on({0, 1, 2, 3}, {0, 1, 2}, {0, 1}));
      file.close();
      std::FILE* const raw = std::fopen(file.path().c_str(), "r+b");
      std::fputs("MATLAB 7.3 MAT-file, Platform: GLNXA64", raw);
      std::fclose(raw);
      expect_linear_at(read(file.path(), with_spacing()), {1.5, 1.5, 0.5});
    }
  }
  error_of([&] { read(folder_.write("b.h5", std::string(1'000'000, '\0'))); });
}

}  // namespace cf_test
}  // namespace palpa::test
