#include "app/info.h"

#include <nlohmann/json.hpp>

#include "files.h"

namespace palpa::test {
namespace info_test {

using Json = nlohmann::json;

class Info : public ReaderTest {
 protected:
  /// The stdout of `run_info`, which must not print to stderr with --json.
  std::string printed(app::InfoArguments arguments) {
    arguments.read = options_;
    ::testing::internal::CaptureStdout();
    ::testing::internal::CaptureStderr();
    EXPECT_EQ(app::run_info(arguments), 0);
    errors_ = ::testing::internal::GetCapturedStderr();
    return ::testing::internal::GetCapturedStdout();
  }

  fs::path two_arrays() const {
    return folder_.write(
        "a.vti",
        "<?xml version=\"1.0\"?><VTKFile type=\"ImageData\" version=\"1.0\" byte_order=\"LittleEndian\"><ImageData "
        "WholeExtent=\"0 1 0 1 0 1\" Origin=\"1 2 3\" Spacing=\"1 2 4\"><Piece Extent=\"0 1 0 1 0 1\"><PointData>"
        "<DataArray type=\"Float32\" Name=\"p\" format=\"ascii\">0 1 0 1 0 1 0 1</DataArray>"
        "<DataArray type=\"Int16\" Name=\"u\" NumberOfComponents=\"3\" format=\"ascii\">"
        "1 2 3 1 2 3 1 2 3 1 2 3 1 2 3 1 2 3 1 2 3 1 2 9</DataArray>"
        "</PointData></Piece></ImageData></VTKFile>");
  }

  std::string errors_;
};

/// A grid of bent lines, 5 x 4 x 4 points, with extrema at single points between others.
std::string bent_grid() {
  std::string points, values;
  for (int n = 0; n < 80; ++n) {
    const double i = n % 5, j = n / 5 % 4, k = n / 20;
    points += std::to_string(i + 0.2 * j * j) + " " + std::to_string(j + 0.1 * i * k) + " " + std::to_string(k) + " ";
    values += n == 31 ? "-123.5 " : n == 52 ? "77.25 " : std::to_string(n % 7) + " ";
  }
  const auto array = [](const char* name, int components, const std::string& numbers) {
    return "<DataArray type=\"Float64\" Name=\"" + std::string(name) + "\" NumberOfComponents=\"" + std::to_string(components) +
           "\" format=\"ascii\">" + numbers + "</DataArray>";
  };
  return "<VTKFile type=\"StructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\"><StructuredGrid WholeExtent=\"0 4 0 3 0 "
         "3\">"
         "<Piece Extent=\"0 4 0 3 0 3\"><Points>" +
         array("points", 3, points) + "</Points><PointData>" + array("p", 1, values) +
         "</PointData></Piece></StructuredGrid></VTKFile>";
}

// Table and JSON give the file's range, and report resampling losses.
TEST_F(Info, TheTableOfAResampledFileHasTheFilesRange) {
  const fs::path file = folder_.write("bent.vts", bent_grid());
  const std::string table = printed({.files = {file}, .read = {}});
  const std::size_t row = table.find("\n  p ");
  ASSERT_NE(row, std::string::npos) << table;
  const std::string line = table.substr(row + 1, table.find('\n', row + 1) - row);
  EXPECT_NE(line.find("-123.5"), std::string::npos) << line;
  EXPECT_NE(line.find("77.25"), std::string::npos) << line;
  EXPECT_NE(table.find("min and max are those of the file"), std::string::npos) << table;
  const Json field = Json::parse(printed({.files = {file}, .json = true, .read = {}}))["fields"][0];
  EXPECT_EQ(field["min"], -123.5);
  EXPECT_GT(field["felt_min"], -123.5);
  const double covered = field["resampling_error"]["by_volume"]["covered"];
  const Volume volume = read(file);
  EXPECT_EQ(warns_of(volume, "of its volume when resampled"), covered < 0.95) << covered;
  EXPECT_LT(covered, 0.95);
}

TEST_F(Info, JsonHasItsPromisedKeys) {
  const Json info =
      Json::parse(printed({.files = {two_arrays()}, .json = true, .at_m = {{1.25, 3, 5}, {0, 0, 0}}, .read = {}}));
  EXPECT_EQ(errors_, "");
  EXPECT_EQ(info["format"], "vti");
  EXPECT_EQ(info["files"].size(), 1U);
  EXPECT_EQ(info["index_to_world_m"], Json::parse("[[1,0,0,1],[0,2,0,2],[0,0,4,3],[0,0,0,1]]"));
  EXPECT_EQ(info["frames"], 1);
  EXPECT_EQ(info["valid_share"], 1.0);
  EXPECT_EQ(info["warnings"].size(), 1U);
  ASSERT_EQ(info["fields"].size(), 2U);
  EXPECT_EQ(
      info["fields"][0],
      Json::parse(R"({"name": "p", "unit": "", "components": 1, "type": "float32", "dims": [2,2,2], "min": 0, "max": 1})"));
  EXPECT_EQ(info["fields"][1]["components"], 3);
  EXPECT_EQ(info["fields"][1]["min"], Json::parse("[1,2,3]"));
  EXPECT_EQ(info["fields"][1]["max"], Json::parse("[1,2,9]"));
  ASSERT_EQ(info["samples"].size(), 2U);
  EXPECT_EQ(info["samples"][0]["at_m"], Json::parse("[1.25,3,5]"));
  EXPECT_EQ(info["samples"][0]["inside"], true);
  EXPECT_DOUBLE_EQ(info["samples"][0]["values"]["p"], 0.25);
  EXPECT_EQ(info["samples"][0]["values"]["u"].size(), 3U);
  EXPECT_EQ(info["samples"][1]["inside"], false);
  EXPECT_TRUE(info["samples"][1]["values"]["p"].is_null());
}

TEST_F(Info, SeveralFilesAreAList) {
  const Json info = Json::parse(printed({.files = {two_arrays(), two_arrays()}, .json = true, .at_m = {}, .read = {}}));
  ASSERT_TRUE(info.is_array());
  EXPECT_EQ(info.size(), 2U);
  EXPECT_FALSE(info[0].contains("samples"));
}

TEST_F(Info, TheTableSaysWhatIsInTheFile) {
  const fs::path file = two_arrays();
  const std::string table = printed({.files = {file}, .json = false, .at_m = {{1.25, 3, 5}}, .read = {}});
  for (const std::string& part : {file.string(), std::string("vti"), std::string("2 × 2 × 2 voxels of 1 × 2 × 4 file units"),
                                  std::string("int16×3"), std::string("p = 0.25")}) {
    EXPECT_NE(table.find(part), std::string::npos) << part << " in\n" << table;
  }
  EXPECT_EQ(errors_.rfind("palpa: warning: " + file.string() + ": ", 0), 0U) << errors_;
}

TEST_F(Info, FilesOfOurOwnAreCalledWhatTheyAre) {
  const fs::path scene = folder_.write("mine.toml", "palpa = 1\n");
  const std::string error = error_of([&] { app::run_info({.files = {scene}, .at_m = {}, .read = options_}); });
  EXPECT_NE(error.find("is a scene"), std::string::npos) << error;
  EXPECT_NE(error.find("palpa run"), std::string::npos) << error;
  fs::create_directories(folder_.path() / "trace");
  folder_.write("trace/trace.toml", "complete = true\n");
  EXPECT_NE(error_of([&] {
              app::run_info({.files = {folder_.path() / "trace"}, .at_m = {}, .read = options_});
            }).find("palpa report"),
            std::string::npos);
}

TEST_F(Info, SaysWhichFilesItWroteAndWhatIsNext) {
  const fs::path scene = folder_.path() / "first.toml";
  EXPECT_EQ(printed({.files = {two_arrays()}, .at_m = {}, .read = {}, .request = {}, .scene = true, .scene_file = scene}), "");
  EXPECT_TRUE(fs::exists(scene));
  EXPECT_NE(errors_.find("Wrote " + scene.string()), std::string::npos) << errors_;
  EXPECT_NE(errors_.find("Next: palpa run " + scene.string() + " --hand sim:stroke --out first"), std::string::npos) << errors_;
}

TEST_F(Info, APictureIsNamedWhatItIs) {
  const std::string error =
      error_of([&] { app::run_info({.files = {two_arrays()}, .at_m = {}, .read = options_, .picture = "a/x.jpg"}); });
  EXPECT_NE(error.find("a/x.png"), std::string::npos) << error;
}

TEST_F(Info, WrongInputIsThrown) {
  error_of([&] { app::run_info({.files = {folder_.path() / "none"}, .json = false, .at_m = {}, .read = options_}); });
}

}  // namespace info_test
}  // namespace palpa::test
