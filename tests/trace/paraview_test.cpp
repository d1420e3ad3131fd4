// Tasks of docs/paraview.md on exported files: in VTK's filters, and in ParaView where it is scriptable here.
#include <gtest/gtest.h>
#include <stdlib.h>
#include <vtkCell.h>
#include <vtkClipDataSet.h>
#include <vtkDataArray.h>
#include <vtkDataObject.h>
#include <vtkNew.h>
#include <vtkPointData.h>
#include <vtkThreshold.h>
#include <vtkUnstructuredGrid.h>
#include <vtkXMLPolyDataReader.h>

#include <cstdlib>
#include <fstream>

#include "palpa/study/map_file.h"
#include "palpa/trace/export_trace.h"

namespace palpa {
namespace paraview_test {

namespace fs = std::filesystem;

class InParaView : public testing::Test {
 protected:
  InParaView() {
    std::string name = (fs::temp_directory_path() / "palpa-paraview-XXXXXX").string();
    folder = ::mkdtemp(name.data());
  }
  ~InParaView() override { fs::remove_all(folder); }

  /// way.vtp: 100 ticks of 1 ms along x, level 'skin' broken through in tick 40.
  void export_way() const {
    {
      TraceWriter writer(folder / "trace", {}, "palpa = 1\n", {"skin"});
      const SessionEvent broken[] = {{.kind = SessionEventKind::break_through, .mode = 0, .value = -300}};
      const ModeForce modes[] = {{.force_n = {0, 1, 0}}};
      for (std::int64_t n = 0; n < 100; ++n) {
        TickFrame tick{.tick = n, .t_s = 1e-3 * static_cast<double>(n), .dt_s = 1e-3};
        tick.result.proxy_m = {1e-3 * static_cast<double>(n), 0, 0};
        tick.result.force_n = {0, 1, 0};
        if (n == 40) {
          writer.append(tick, modes, {}, {}, broken);
        } else {
          writer.append(tick, modes, {}, {}, {});
        }
      }
      writer.finish();
    }
    export_trace(folder / "trace", folder / "way.vtp");
  }
  /// The line that a script of ParaView writes to the file "seen"; empty if it fails.
  std::string seen_by(const std::string& script) const {
    std::ofstream(folder / "look.py") << "from paraview.simple import *\n" << script;
    const std::string command = "cd '" + folder.string() + "' && '" PALPA_PVPYTHON "' look.py >output 2>&1";
    EXPECT_EQ(std::system(command.c_str()), 0) << std::ifstream(folder / "output").rdbuf();
    std::string seen;
    std::getline(std::ifstream(folder / "seen"), seen);
    return seen;
  }

  fs::path folder;
};

constexpr bool has_paraview = sizeof PALPA_PVPYTHON > 1;
constexpr const char* why_not = "no pvpython; install python3-paraview to try exported files in ParaView";

TEST_F(InParaView, MapsOpen) {
  if (!has_paraview) GTEST_SKIP() << why_not;
  ForceMap map(map_slice(0, 0.0, 0.1, 4));
  for (MapPoint& point : map.points) point.steady_n = {0.0, 3.0, 4.0};
  write_map(map, Similarity{}, folder / "map.vti", detail::Existing::refused);
  EXPECT_EQ(seen_by("read = XMLImageDataReader(FileName=['map.vti'])\n"
                    "read.UpdatePipeline()\n"
                    "open('seen', 'w').write('%d %.6f' % (read.GetDataInformation().GetNumberOfPoints(), "
                    "read.PointData['steady_n'].GetRange(-1)[1]))\n"),
            "16 5.000000");
}

TEST_F(InParaView, ATaskOfThePageIsAFilter) {
  if (!has_paraview) GTEST_SKIP() << why_not;
  export_way();
  EXPECT_EQ(seen_by("way = XMLPolyDataReader(FileName=['way.vtp'])\n"
                    "breaks = Threshold(Input=way, Scalars=['POINTS', 'event.break_through'], UpperThreshold=1,\n"
                    "                   ThresholdMethod='Above Upper Threshold', AllScalars=1)\n"
                    "piece = IsoVolume(Input=way, InputScalars=['POINTS', 't_s'], ThresholdRange=[0.02, 0.03])\n"
                    "tube = Tube(Input=ExtractSurface(Input=piece))\n"
                    "arrows = Glyph(Input=way, GlyphType='Arrow', OrientationArray=['POINTS', 'force_n'],\n"
                    "               ScaleArray=['POINTS', 'force_n'])\n"
                    "for each in (breaks, tube, arrows): each.UpdatePipeline()\n"
                    "low, high = tube.PointData['mode.skin.force_n'].GetRange(-1)\n"
                    "x = tube.GetDataInformation().GetBounds()\n"
                    "open('seen', 'w').write('%g %d %.3f %.3f %g %d' % (\n"
                    "    breaks.PointData['tick'].GetRange()[1], breaks.GetDataInformation().GetNumberOfPoints(),\n"
                    "    x[0], x[1], low, arrows.GetDataInformation().GetNumberOfPoints() > 0))\n"),
            "40 1 0.020 0.030 1 1");
}

// The filters behind ParaView's Threshold and Iso Volume.
TEST_F(InParaView, TicksAndPiecesOfThePathAreCells) {
  export_way();
  vtkNew<vtkXMLPolyDataReader> reader;
  reader->SetFileName((folder / "way.vtp").c_str());
  vtkNew<vtkThreshold> breaks;
  breaks->SetInputConnection(reader->GetOutputPort());
  breaks->SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS, "event.break_through");
  breaks->SetThresholdFunction(vtkThreshold::THRESHOLD_UPPER);
  breaks->SetUpperThreshold(1);
  breaks->SetAllScalars(1);
  breaks->Update();
  ASSERT_EQ(breaks->GetOutput()->GetNumberOfPoints(), 1);
  EXPECT_EQ(breaks->GetOutput()->GetPointData()->GetArray("tick")->GetComponent(0, 0), 40);

  vtkNew<vtkClipDataSet> after, piece;
  const auto clip = [](vtkClipDataSet& filter, vtkAlgorithmOutput* input, double t_s, bool before) {
    filter.SetInputConnection(input);
    filter.SetInputArrayToProcess(0, 0, 0, vtkDataObject::FIELD_ASSOCIATION_POINTS, "t_s");
    filter.SetValue(t_s);
    filter.SetInsideOut(before);
  };
  clip(*after, reader->GetOutputPort(), 0.0205, false);
  clip(*piece, after->GetOutputPort(), 0.0305, true);
  piece->Update();
  double box[6];
  piece->GetOutput()->GetBounds(box);
  EXPECT_NEAR(box[0], 0.0205, 1e-9);
  EXPECT_NEAR(box[1], 0.0305, 1e-9);
  vtkIdType steps = 0;  // VTK 9.3 joins the lines of a piece to one
  for (vtkIdType c = 0; c < piece->GetOutput()->GetNumberOfCells(); ++c)
    steps += piece->GetOutput()->GetCell(c)->GetNumberOfPoints() - 1;
  EXPECT_EQ(steps, 11) << "two ends between ticks, nine whole steps";
}

}  // namespace paraview_test
}  // namespace palpa
