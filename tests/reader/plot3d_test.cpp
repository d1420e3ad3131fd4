// PLOT3D files made here: byte orders, padding, blanks, names; and the real files.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>

#include "files.h"

namespace palpa::test {
namespace plot3d_test {

class Plot3d : public ReaderTest {
 protected:
  /// A grid of 6 × 5 × 4 points, bent or straight, and its solution: density 2, momentum 2·(x, −y, 1), energy 10.
  void write(const std::string& grid, const std::string& solution, bool big, bool bent, bool blanks,
             const std::string& padding) {
    std::string xyz, q;
    for (std::string* file : {&xyz, &q}) {
      for (const std::int32_t n : {6, 5, 4}) *file += bytes_of(n, big);
    }
    for (const float of : {3.0F, 0.0F, 1e6F, 0.5F}) q += bytes_of(of, big);
    const auto over_points = [&](std::string& to, auto value) {
      for (int k = 0; k < 4; ++k)
        for (int j = 0; j < 5; ++j)
          for (int i = 0; i < 6; ++i) to += bytes_of(value(i, j, k), big);
    };
    const auto at = [&](int i, int j, int k) { return Vec3{0.1 * i * i + (bent ? 0.02 * j * j : 0.0), 0.5 * j, 0.25 * k}; };
    over_points(xyz, [&](int i, int j, int k) { return static_cast<float>(at(i, j, k).x); });
    over_points(xyz, [&](int i, int j, int k) { return static_cast<float>(at(i, j, k).y); });
    over_points(xyz, [&](int i, int j, int k) { return static_cast<float>(at(i, j, k).z); });
    // A solid at i <= 1: the cells that touch it are no data.
    if (blanks) over_points(xyz, [](int i, int, int) { return std::int32_t{i > 1}; });
    over_points(q, [](int, int, int) { return 2.0F; });
    over_points(q, [&](int i, int j, int k) { return static_cast<float>(2.0 * at(i, j, k).x); });
    over_points(q, [&](int i, int j, int k) { return static_cast<float>(-2.0 * at(i, j, k).y); });
    over_points(q, [](int, int, int) { return 2.0F; });
    over_points(q, [](int, int, int) { return 10.0F; });
    folder_.write(grid, xyz);
    folder_.write(solution, q + padding);
  }
  static const VolumeField& field_of(const Volume& volume, const std::string& name) {
    for (const VolumeField& f : volume.fields) {
      if (f.name == name) return f;
    }
    throw std::runtime_error("no field " + name);
  }
};

TEST_F(Plot3d, PartnersAreFoundByNameInEitherByteOrder) {
  struct {
    const char *grid, *solution;
  } names[] = {{"flowxyz.bin", "flowq.bin"}, {"flow.xyz", "flow.q"}, {"flow.x", "flow.q"}, {"FLOW.XYZ", "FLOW.Q"}};
  for (const auto& name : names) {
    for (const bool big : {false, true}) {
      write(name.grid, name.solution, big, true, false, big ? std::string(484, '\0') : "");
      for (const char* asked : {name.grid, name.solution}) {
        const Volume volume = read(folder_.path() / asked);
        EXPECT_EQ(volume.files.size(), 2U);
        const VolumeField& velocity = field_of(volume, "velocity");
        EXPECT_EQ(velocity.unit, "a∞");
        ASSERT_TRUE(velocity.resampling);
        EXPECT_EQ(velocity.resampling->dims, (std::array<std::int64_t, 3>{6, 5, 4}));
        const Vec3 at{1.3, 1.1, 0.4};
        const VectorSample s = velocity.field->vector(at);
        ASSERT_TRUE(s.inside);
        EXPECT_NEAR(s.value.x, at.x, 0.02);
        EXPECT_NEAR(s.value.y, -at.y, 0.02);
        EXPECT_NEAR(s.value.z, 1.0, 1e-5);
        const double speed2 = dot(s.value, s.value), pressure = 0.4 * (10.0 - speed2);
        EXPECT_NEAR(field_of(volume, "pressure").field->scalar(at).value, pressure, 0.1);
        EXPECT_NEAR(field_of(volume, "mach").field->scalar(at).value, std::sqrt(speed2 / (1.4 * pressure / 2.0)), 0.1);
      }
      std::filesystem::remove(folder_.path() / name.grid);
      std::filesystem::remove(folder_.path() / name.solution);
    }
  }
}

/// Numbers as Fortran writes them as text.
std::string as_text(const std::vector<double>& numbers, const char* form) {
  std::string text;
  for (std::size_t n = 0; n < numbers.size(); ++n) {
    char number[60];
    std::snprintf(number, sizeof number, form, numbers[n]);
    text += number + std::string(n % 5 == 4 ? "\n" : " ");
  }
  return text;
}

TEST_F(Plot3d, TextOfOneOrSeveralBlocksIsReadAsBinaryFilesAre) {
  for (const bool counted : {false, true}) {
    for (const bool blanks : {false, true}) {
      for (const char* form : {"%.9g", "%.9E,", "  %g"}) {
        const int blocks = counted ? 2 : 1;
        std::string head = counted ? "2\n" : "";
        for (int b = 0; b < blocks; ++b) head += "6 5 4\n";
        std::string xyz = head, q = head;
        for (int b = 0; b < blocks; ++b) {
          std::vector<double> x, y, z, values;
          for (int n = 0; n < 120; ++n) {
            x.push_back(0.1 * (n % 6) * (n % 6) + 2.5 * b), y.push_back(0.5 * (n / 6 % 5)), z.push_back(0.25 * (n / 30));
          }
          for (const auto* of : {&x, &y, &z}) xyz += as_text(*of, form);
          for (int n = 0; blanks && n < 120; ++n) xyz += n % 6 > 1 ? "1 " : "0 ";
          q += "0.5 0 1D6 0\n120*2.0\n";
          for (int n = 0; n < 120; ++n) values.push_back(2.0 * x[static_cast<std::size_t>(n)]);
          q += as_text(values, form) + "120*0 120*2.0e0\n" + as_text(std::vector<double>(120, 10.0), form);
        }
        folder_.write("a.xyz", xyz), folder_.write("a.q", q);
        const Volume volume = read(folder_.path() / "a.xyz");
        const Field& velocity = *field_of(volume, "velocity").field;
        EXPECT_NEAR(velocity.vector({1.3, 1.1, 0.4}).value.x, 1.3, 0.05) << form << counted << blanks;
        EXPECT_NEAR(velocity.vector({1.3, 1.1, 0.4}).value.z, 1.0, 1e-5);
        EXPECT_EQ(velocity.vector({0.05, 1.1, 0.4}).inside, !blanks);
        if (counted) {
          EXPECT_NEAR(velocity.vector({4.0, 1.1, 0.4}).value.x, 4.0, 0.05);
        }
      }
    }
  }
  write("c.xyz", "c.q", false, true, false, "");
  folder_.write("c.q", "6 5 4\n0.5 0 1e6 0\n");
  EXPECT_NE(error_of([&] { read(folder_.path() / "c.xyz"); }).find("write both in one way"), std::string::npos);
  for (const char* bad :
       {"6 5 4\n1 2 3\n", "6 5 4\n1.0 2.0 spam\n", "0 0 0\n1 2 3 4 5 6 7 8 9\n", "1000000000 1000000000 1000000000\n 1 2 3\n",
        "6 5 4\n1000000000*1.0\n", "2 2 2 1e400 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1 1\n"}) {
    folder_.write("b.xyz", bad), folder_.write("b.q", "6 5 4\n");
    const std::string error = error_of([&] { read(folder_.path() / "b.xyz"); });
    EXPECT_EQ(error.find("palpa-read"), std::string::npos) << bad << ": " << error;
  }
}

TEST_F(Plot3d, ASolutionOfDensityOneHasNoMachNumber) {
  for (const float density : {1.0F, 1.001F}) {
    std::string xyz, q;
    for (std::string* file : {&xyz, &q}) {
      for (const std::int32_t n : {6, 5, 4}) *file += bytes_of(n);
    }
    for (int n = 0; n < 4; ++n) q += bytes_of(0.0F);
    for (int c = 0; c < 3; ++c) {
      for (int n = 0; n < 120; ++n)
        xyz += bytes_of(static_cast<float>(c == 0 ? 0.1 * (n % 6) + 0.02 * (n / 6 % 5) : c == 1 ? n / 6 % 5 : n / 30));
    }
    for (int c = 0; c < 5; ++c) {
      for (int n = 0; n < 120; ++n) q += bytes_of(c == 0 ? density : c == 4 ? 2.0F + 0.01F * static_cast<float>(n) : 0.3F);
    }
    folder_.write("a.xyz", xyz), folder_.write("a.q", q);
    const Volume volume = read(folder_.path() / "a.xyz");
    const bool incompressible = density == 1.0F;
    EXPECT_EQ(field_of(volume, "velocity").unit, incompressible ? "U∞" : "a∞");
    EXPECT_EQ(warns_of(volume, "density 1 everywhere"), incompressible);
    for (const char* name : {"mach", "pressure", "energy"}) {
      const bool has = std::ranges::any_of(volume.fields, [&](const VolumeField& f) { return f.name == name; });
      EXPECT_EQ(has, !incompressible) << name;
    }
    if (incompressible) {
      EXPECT_EQ(field_of(volume, "q5").unit, "");
    }
  }
}

TEST_F(Plot3d, AStraightGridIsFeltAsItIsAndBlanksAreNoData) {
  write("a.xyz", "a.q", true, false, false, "");
  const Volume whole = read(folder_.path() / "a.q");
  EXPECT_FALSE(whole.fields[0].resampling);
  EXPECT_TRUE(grid_of(*field_of(whole, "velocity").field)->geometry.is_rectilinear());
  EXPECT_NEAR(field_of(whole, "velocity").field->vector({1.3, 1.1, 0.4}).value.x, 1.3, 1e-6);
  EXPECT_TRUE(field_of(whole, "density").field->scalar({0.05, 1, 0.4}).inside);

  write("b.xyz", "b.q", true, false, true, "");
  const Volume blanked = read(folder_.path() / "b.q");
  const Field& density = *field_of(blanked, "density").field;
  EXPECT_FALSE(density.scalar({0.05, 1, 0.4}).inside);
  EXPECT_FALSE(density.scalar({0.3, 1, 0.4}).inside);  // a cell with a blanked corner
  ASSERT_TRUE(density.scalar({1.3, 1, 0.4}).inside);
  EXPECT_NEAR(density.scalar({1.3, 1, 0.4}).value, 2.0, 1e-6);
}

TEST_F(Plot3d, WhatIsMissingOrDoesNotFitIsSaid) {
  write("a.xyz", "a.q", true, true, false, "");
  std::filesystem::rename(folder_.path() / "a.q", folder_.path() / "b.q");
  EXPECT_NE(error_of([&] { read(folder_.path() / "a.xyz"); }).find("without its solution"), std::string::npos);
  EXPECT_NE(error_of([&] { read(folder_.path() / "b.q"); }).find("without its grid"), std::string::npos);
  VolumeRequest both;
  both.files = {folder_.path() / "a.xyz", folder_.path() / "b.q"};
  EXPECT_EQ(read_volume(both, options_).files.size(), 2U);
  std::ifstream in(folder_.path() / "b.q", std::ios::binary);
  const std::string q((std::istreambuf_iterator<char>(in)), {});
  folder_.write("b.q", q.substr(0, q.size() / 2));
  error_of([&] { read_volume(both, options_); });
  folder_.write("b.q", q.substr(0, 10));
  error_of([&] { read_volume(both, options_); });
  std::ifstream grid(folder_.path() / "a.xyz", std::ios::binary);
  const std::string xyz((std::istreambuf_iterator<char>(grid)), {});
  for (std::size_t bytes = 1; bytes < 60; ++bytes) {
    folder_.write("a.xyz", xyz.substr(0, bytes));
    const std::string error = error_of([&] { read_volume(both, options_); });
    EXPECT_EQ(error.find("palpa-read"), std::string::npos) << bytes << ": " << error;  // no crash of the reader
  }
}

TEST_F(Plot3d, DimensionsThatCannotBeAreRefused) {
  for (const std::uint32_t damaged : {0x80000003U, 0xd8d8d8d8U, 0x7fffffffU}) {
    std::string xyz = bytes_of(2), q = xyz;
    for (const std::uint32_t n : {4U, damaged, 3U, 4U, 3U, 3U}) xyz += bytes_of(n), q += bytes_of(n);
    folder_.write("a.xyz", xyz + std::string(864, '\0'));
    folder_.write("a.q", q + std::string(1472, '\0'));
    EXPECT_NE(error_of([&] { read(folder_.path() / "a.xyz"); }).find("cannot be read as PLOT3D"), std::string::npos) << damaged;
  }
}

TEST_F(Plot3d, FactsOfTheRealOnes) {
  using Json = nlohmann::json;
  if (shared_file("facts.json").empty()) GTEST_SKIP() << "the shared data are not here: set PALPA_SHARED to their folder";
  const Json facts = Json::parse(std::ifstream(shared_file("facts.json")));
  struct {
    const char *set, *name, *file;
  } sets[] = {{"cfd_bluntfin", "bluntfinxyz.bin + bluntfinq.bin", "bluntfinxyz.bin"},
              {"cfd_combustor", "combxyz.bin + combq.bin", "combq.bin"}};
  for (const auto& [set, name, file] : sets) {
    const Json& fact = facts[set][name];
    const Volume volume = read(shared_file(std::string(set) + "/" + file));
    const Box box = volume.bounds_m();
    const double low[3] = {box.low_m.x, box.low_m.y, box.low_m.z}, high[3] = {box.high_m.x, box.high_m.y, box.high_m.z};
    for (std::size_t a = 0; a < 3; ++a) {
      EXPECT_NEAR(low[a], fact["bounds"][2 * a].get<double>(), 1e-5);
      EXPECT_NEAR(high[a], fact["bounds"][2 * a + 1].get<double>(), 1e-5);
      EXPECT_EQ(volume.fields[0].resampling->dims[a], fact["dims"][a].get<std::int64_t>());
    }
    for (const char* scalar : {"density", "energy"}) {
      const ValueRange range = field_of(volume, scalar).resampling->value_ranges[0];
      EXPECT_NEAR(range.min, fact[scalar]["min"].get<double>(), 1e-6);
      EXPECT_NEAR(range.max, fact[scalar]["max"].get<double>(), 1e-4);
    }
    // Values at points of the file, within the reported error.
    const Json& points = fact["points"];
    for (const Json& point : points) {
      for (const char* array : {"density", "momentum", "velocity"}) {
        const Json& known = fact[std::string(array) == "velocity" ? "velocity(momentum/density)" : array];
        for (const Json& voxel : known["voxels"]) {
          if (voxel["ijk"] != point["ijk"]) continue;
          const VolumeField& field = field_of(volume, array);
          const Vec3 at{point["xyz"][0].get<double>(), point["xyz"][1].get<double>(), point["xyz"][2].get<double>()};
          double range = 0.0;
          for (const ValueRange& e : field.resampling->value_ranges) range = std::max(range, e.max - e.min);
          const double bound = range * field.resampling->by_cell.max + 1e-6;
          if (field.field->components() == 1) {
            ASSERT_TRUE(field.field->scalar(at).inside);
            EXPECT_NEAR(field.field->scalar(at).value, voxel["value"].get<double>(), bound) << set << " " << array;
          } else {
            const Vec3 expected{voxel["value"][0].get<double>(), voxel["value"][1].get<double>(),
                                voxel["value"][2].get<double>()};
            ASSERT_TRUE(field.field->vector(at).inside);
            EXPECT_LT(norm(field.field->vector(at).value - expected), bound) << set << " " << array;
          }
        }
      }
    }
    const bool burns = std::string(set) == "cfd_combustor";
    EXPECT_EQ(warns_of(volume, "energy 0 everywhere"), burns);
    EXPECT_EQ(volume.fields.size(), burns ? 4U : 6U);
  }
  const Volume office = read(shared_file("cfd_office/office.binary.vtk"));
  const Json& fact = facts["cfd_office"]["office.binary.vtk"];
  const VolumeField& velocity = field_of(office, "vectors");
  const GridGeometry& grid = grid_of(*velocity.field)->geometry;
  EXPECT_TRUE(grid.is_rectilinear());
  const auto close = [](const Vec3& v, const Json& to) {
    return norm(v - Vec3{to[0].get<double>(), to[1].get<double>(), to[2].get<double>()}) < 1e-6;
  };
  const auto index = [](const Json& ijk) {
    return GridPoint{ijk[0].get<double>(), ijk[1].get<double>(), ijk[2].get<double>()};
  };
  for (std::size_t a = 0; a < 3; ++a) {
    EXPECT_EQ(grid.dims[a], fact["dims"][a].get<std::int64_t>());
    EXPECT_NEAR(velocity.field->value_ranges()[a].min, fact["component_min"][a].get<double>(), 1e-6);
    EXPECT_NEAR(velocity.field->value_ranges()[a].max, fact["component_max"][a].get<double>(), 1e-6);
  }
  EXPECT_NEAR(field_of(office, "scalars").field->value_ranges()[0].min, fact["scalars"]["min"].get<double>(), 1e-6);
  for (const Json& point : fact["points"]) EXPECT_TRUE(close(grid.to_world(index(point["ijk"])), point["xyz"]));
  for (const Json& voxel : fact["voxels"])
    EXPECT_TRUE(close(velocity.field->vector(grid.to_world(index(voxel["ijk"]))).value, voxel["value"]));
  EXPECT_TRUE(
      close(velocity.field->vector(grid.to_world(index(fact["trilinear"]["index"]))).value, fact["trilinear"]["value"]));
  for (const char* dx : {"wind.dx", "temperature.dx", "cloudwater.dx", "rainwater.dx"}) {
    EXPECT_NE(error_of([&] { read(shared_file(std::string("weather_storm_dx/") + dx)); }).find("OpenDX"), std::string::npos);
  }
  EXPECT_NE(error_of([&] { read(shared_file("mol_water_dx/watermolecule.dx")); }).find("OpenDX"), std::string::npos);
}

}  // namespace plot3d_test
}  // namespace palpa::test
