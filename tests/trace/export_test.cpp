// Exported traces: other programs find the ticks at their positions in the data.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hdf5.h>
#include <vtkCell.h>
#include <vtkDataArray.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkPolyData.h>
#include <vtkXMLPolyDataReader.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "palpa/trace/export_trace.h"
#include "palpa/vtk/to_vtk.h"

namespace palpa {
namespace export_test {

namespace fs = std::filesystem;
using nlohmann::json;
using testing::DoubleNear;
using testing::ElementsAre;
using testing::EndsWith;
using testing::HasSubstr;

constexpr const char* scene_text = "palpa = 1\n";

/// Three ticks: a quarter turn about z, twice as large, moved by 1 m along x.
class Export : public testing::Test {
 protected:
  Export() {
    std::string name = (fs::temp_directory_path() / "palpa-export-XXXXXX").string();
    root = ::mkdtemp(name.data());
    trace = root / "trace";
  }
  ~Export() override { fs::remove_all(root); }

  TraceHeader header() const {
    TraceHeader made{.primitives = true};
    made.hand_to_world = {rotation_about({0, 0, 1}, 90.0), 2.0, {1, 0, 0}};
    return made;
  }
  static TickFrame frame(std::int64_t number) {
    const double n = static_cast<double>(number);
    TickFrame made{.tick = number, .t_s = 1e-3 * n, .dt_s = 1e-3};
    made.result.proxy_m = {0.01 * n, 0, 0.5};
    made.result.probe_m = {0.01 * n, 0.001, 0.5};
    made.result.force_n = {0, 3, 0};
    made.command.force_n = {0, 2, 0};
    made.result.status = TickStatus::waiting;
    return made;
  }
  void write_three_ticks() const {
    TraceWriter writer(trace, header(), scene_text, {"skin", "with,comma"});
    const PlacedPrimitive strong{.primitive = {.id = {0, 0}, .strength_n = 0.5}};
    const PlacedPrimitive weak{.primitive = {.id = {0, 1}, .strength_n = 0.25}},
        other{.primitive = {.id = {1, 0}, .strength_n = 4}};
    const PlacedPrimitive placed[] = {other, other, strong, weak};
    const SubStep steps[] = {{.first_primitive = 0, .primitives = 2}, {.first_primitive = 2, .primitives = 2}};
    const ModeForce modes[] = {{.force_n = {0, 1, 0}}, {}};
    const SessionEvent onset[] = {{.kind = SessionEventKind::onset, .mode = 0, .value = -300}};
    for (std::int64_t n = 10; n < 13; ++n) {
      if (n == 11) {
        writer.append(frame(n), modes, steps, placed, onset);
      } else {
        writer.append(frame(n), modes, {}, {}, {});
      }
    }
    writer.append_event(12, 0.012, "warning", "<session>", "a \"word\"");
    writer.finish();
  }
  std::string exported(const std::string& name) const {
    export_trace(trace, root / name);
    std::ostringstream text;
    text << std::ifstream(root / name, std::ios::binary).rdbuf();
    return text.str();
  }
  std::string error_of(const fs::path& from, const std::string& name) const {
    try {
      export_trace(from, root / name);
    } catch (const LoadError& error) {
      return error.what();
    }
    return "(no error)";
  }

  fs::path root, trace;
};

TEST_F(Export, ColumnsAreWhatWasFeltInTheFrameOfTheData) {
  write_three_ticks();
  const FeltPath path = felt_path(trace);
  ASSERT_EQ(path.ticks(), 3u);
  EXPECT_THAT(path.column("tick").values, ElementsAre(10, 11, 12));
  // x of the hand is y of the world.
  EXPECT_THAT(path.column("proxy_m").values,
              ElementsAre(1, DoubleNear(0.2, 1e-12), 1, 1, DoubleNear(0.22, 1e-12), 1, 1, DoubleNear(0.24, 1e-12), 1));
  EXPECT_THAT(path.column("probe_m").values[0], DoubleNear(1.0 - 0.002, 1e-12));
  EXPECT_THAT(path.column("force_n").values, ElementsAre(-3, 0, 0, -3, 0, 0, -3, 0, 0)) << "newtons, not scaled";
  EXPECT_THAT(path.column("command_n").values[0], -2);
  EXPECT_THAT(path.column("status").values, ElementsAre(1, 1, 1));
  EXPECT_THAT(path.column("mode.skin.force_n").values, ElementsAre(-1, 0, 0, -1, 0, 0, -1, 0, 0));
  EXPECT_THAT(path.column("mode.skin.strength_n").values, ElementsAre(0, 0.75, 0)) << "the last sub-step's, added up";
  EXPECT_THAT(path.column("mode.with,comma.strength_n").values, ElementsAre(0, 0, 0)) << "of an earlier sub-step";
  EXPECT_THAT(path.column("event.onset").values, ElementsAre(0, 1, 0));
  EXPECT_THAT(path.column("event.warning").values, ElementsAre(0, 0, 1));
  ASSERT_EQ(path.events.size(), 2u);
  EXPECT_EQ(path.events[0].row, 1u);
  EXPECT_EQ(path.events[0].subject, "skin");
  EXPECT_EQ(path.events[1].value, "a \"word\"");
  EXPECT_THROW(static_cast<void>(path.column("else")), std::out_of_range);
}

void expect_same(vtkPolyData& read, const FeltPath& path) {
  ASSERT_EQ(read.GetNumberOfPoints(), static_cast<vtkIdType>(path.ticks()));
  ASSERT_EQ(read.GetNumberOfLines(), 1);
  EXPECT_EQ(read.GetNumberOfVerts(), read.GetNumberOfPoints()) << "a vertex for each tick";
  EXPECT_EQ(read.GetNumberOfCells(), read.GetNumberOfPoints() + 1);
  EXPECT_EQ(read.GetCell(read.GetNumberOfVerts())->GetNumberOfPoints(), read.GetNumberOfPoints()) << "one line";
  EXPECT_EQ(read.GetPointData()->GetNumberOfArrays() + 1, static_cast<int>(path.columns.size()));
  for (const FeltColumn& column : path.columns) {
    vtkDataArray* const array =
        column.name == "proxy_m" ? read.GetPoints()->GetData() : read.GetPointData()->GetArray(column.name.c_str());
    ASSERT_NE(array, nullptr) << column.name;
    EXPECT_EQ(array->GetNumberOfComponents(), column.components);
    for (std::size_t n = 0; n < column.values.size(); ++n) {
      const auto components = static_cast<std::size_t>(column.components);
      EXPECT_EQ(array->GetComponent(static_cast<vtkIdType>(n / components), static_cast<int>(n % components)), column.values[n])
          << column.name;
    }
  }
}

TEST_F(Export, VtksOwnReaderFindsEveryColumnOnOneLine) {
  write_three_ticks();
  const std::string text = exported("felt.vtp");
  EXPECT_EQ(text.find("appended"), text.npos) << "ParaView of Debian 12 does not open that";
  vtkNew<vtkXMLPolyDataReader> reader;
  reader->SetFileName((root / "felt.vtp").c_str());
  reader->Update();
  expect_same(*reader->GetOutput(), felt_path(trace));
  expect_same(*to_vtk(felt_path(trace)), felt_path(trace));
}

TEST_F(Export, ATableHasTheColumnsCellByCell) {
  write_three_ticks();
  const std::string text = exported("felt.csv");
  EXPECT_THAT(text, HasSubstr("tick,t_s,proxy_x_m,proxy_y_m,proxy_z_m,probe_x_m"));
  EXPECT_THAT(text, HasSubstr(",\"mode.with,comma.force_x_n\","));
  EXPECT_THAT(text, HasSubstr("\n11,0.011,1,0.22,1,"));
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 4);
}

TEST_F(Export, OfAToolTurnsAndTorquesGoToEveryFormat) {
  TraceHeader of_tool = header();
  of_tool.has_tool = true;
  TickFrame one = frame(0);
  one.result.probe_turn = {0.6, 0.8, 0, 0};
  one.result.torque_nm = {0.5, 0, 0};
  {
    TraceWriter writer(trace, of_tool, scene_text, {});
    writer.append(one, {}, {}, {}, {});
    writer.finish();
  }
  EXPECT_THAT(exported("felt.csv"),
              HasSubstr(",buttons,probe_turn_w,probe_turn_x,probe_turn_y,probe_turn_z,proxy_turn_w,proxy_turn_x,proxy_turn_y,"
                        "proxy_turn_z,torque_x_nm,torque_y_nm,torque_z_nm,command_torque_x_nm,command_torque_y_nm,"
                        "command_torque_z_nm\n"));
  exported("felt.vtp");
  const vtkNew<vtkXMLPolyDataReader> reader;
  reader->SetFileName((root / "felt.vtp").c_str());
  reader->Update();
  vtkDataArray* const turn = reader->GetOutput()->GetPointData()->GetArray("probe_turn");
  ASSERT_NE(turn, nullptr);
  ASSERT_EQ(turn->GetNumberOfComponents(), 4);
  EXPECT_NEAR(turn->GetComponent(0, 0), 0.6, 1e-15);
  EXPECT_NEAR(turn->GetComponent(0, 2), 0.8, 1e-15) << "x of the hand is y of the world";
  EXPECT_NEAR(reader->GetOutput()->GetPointData()->GetArray("torque_nm")->GetComponent(0, 1), 0.5, 1e-15);
}

TEST_F(Export, Hdf5HoldsAColumnAsADataSet) {
  write_three_ticks();
  exported("felt.h5");
  const hid_t file = H5Fopen((root / "felt.h5").c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
  ASSERT_GE(file, 0);
  for (const FeltColumn& column : felt_path(trace).columns) {
    const hid_t data = H5Dopen2(file, column.name.c_str(), H5P_DEFAULT);
    ASSERT_GE(data, 0) << column.name;
    const hid_t space = H5Dget_space(data), type = H5Dget_type(data);
    ASSERT_EQ(static_cast<std::size_t>(H5Sget_simple_extent_npoints(space)), column.values.size());
    EXPECT_EQ(H5Sget_simple_extent_ndims(space), column.components == 3 ? 2 : 1);
    EXPECT_EQ(H5Tget_class(type), column.is_whole ? H5T_INTEGER : H5T_FLOAT);
    std::vector<double> values(column.values.size());
    H5Dread(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    EXPECT_EQ(values, column.values) << column.name;
    H5Tclose(type), H5Sclose(space), H5Dclose(data);
  }
  H5Fclose(file);
}

TEST_F(Export, SlicerFindsTheCurveAndWhatHappenedInItsFrame) {
  write_three_ticks();
  const json file = json::parse(exported("felt.mrk.json"));
  const json &curve = file["markups"][0], &places = file["markups"][1];
  EXPECT_EQ(curve["type"], "Curve");
  EXPECT_EQ(curve["coordinateSystem"], "RAS");
  EXPECT_EQ(curve["coordinateUnits"], "mm");
  ASSERT_EQ(curve["controlPoints"].size(), 3u);
  // 1, 0.2, 1 m, where x points to the left and y to the back.
  const auto at = curve["controlPoints"][0]["position"].get<std::vector<double>>();
  EXPECT_THAT(at, ElementsAre(-1000, DoubleNear(-200, 1e-9), 1000));
  EXPECT_EQ(places["type"], "Fiducial");
  ASSERT_EQ(places["controlPoints"].size(), 1u);
  EXPECT_EQ(places["controlPoints"][0]["label"], "skin holds");
  EXPECT_EQ(places["controlPoints"][0]["position"][1], curve["controlPoints"][1]["position"][1]);
}

TEST_F(Export, ACurveHasNoMoreHandlesThanSlicerBears) {
  {
    TraceWriter writer(trace, header(), scene_text, {});
    for (std::int64_t n = 0; n < 9000; ++n) {
      TickFrame made = frame(n);
      made.result.proxy_m = {0.05 * std::cos(0.01 * static_cast<double>(n)), 0.05 * std::sin(0.01 * static_cast<double>(n)), 0};
      writer.append(made, {}, {}, {}, {});
    }
    writer.finish();
  }
  const json points = json::parse(exported("felt.mrk.json"))["markups"][0]["controlPoints"];
  EXPECT_LE(points.size(), 2000u);
  EXPECT_GE(points.size(), 1000u);
}

TEST_F(Export, WhatIsWrongIsSaidInOneLine) {
  write_three_ticks();
  EXPECT_THAT(error_of(trace, "felt.vtk"), EndsWith("felt.vtk: has an ending of no format that is written; name it .vtp, .csv, "
                                                    ".h5 or .mrk.json"));
  EXPECT_THAT(error_of(trace, "felt.json"), HasSubstr("no format"));
  EXPECT_THAT(error_of(root / "none", "felt.vtp"), HasSubstr("is no trace"));
  EXPECT_THAT(error_of(trace, "nowhere/felt.vtp"), HasSubstr("nowhere/felt.vtp: "));
  exported("felt.csv");
  EXPECT_THAT(error_of(trace, "felt.csv"), HasSubstr("exists already"));
  std::ofstream(trace / "modes.csv", std::ios::app) << "11,skin,0,much,0,0,0,0,0\n";
  EXPECT_THAT(error_of(trace, "felt.vtp"), HasSubstr("column 'force_y_n' cannot be 'much'"));
  EXPECT_FALSE(fs::exists(root / "felt.vtp"));
  fs::remove_all(trace);
  TraceWriter(trace, header(), scene_text, {}).finish();
  EXPECT_THAT(error_of(trace, "felt.vtp"), HasSubstr("has no ticks to export"));
}

}  // namespace export_test
}  // namespace palpa
