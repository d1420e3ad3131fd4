// A scan's acquisition in palpa-read's answer, without any person's data.
#include <cctype>
#include <functional>
#include <map>
#include <nlohmann/json.hpp>

#include "app/info.h"
#include "dicom_file.h"

namespace palpa::test {
namespace dicom_scan_test {

using Json = nlohmann::json;

class DicomScan : public ReaderTest {
 protected:
  /// A series of four images with these elements as well.
  fs::path series(const std::function<void(DicomElements&)>& add) const {
    fs::create_directories(folder_.path() / "s");
    for (int n = 0; n < 4; ++n) {
      DicomElements e = series_.image(series_.at_mm({0, 0, double(n)}), n + 1);
      add(e);
      folder_.write("s/" + std::to_string(n), series_.file(e));
    }
    return folder_.path() / "s";
  }
  std::map<std::string, std::string> facts(const fs::path& path) const {
    std::map<std::string, std::string> all;
    for (const ScanFact& fact : read(path).scan)
      all[std::string(name_of(fact.kind))] = is_number(fact.kind) ? decimal(fact.number) : fact.words;
    return all;
  }
  std::string printed(const fs::path& path, bool json) const {
    app::InfoArguments arguments;
    arguments.files = {path}, arguments.json = json, arguments.read = options_;
    ::testing::internal::CaptureStdout();
    ::testing::internal::CaptureStderr();
    EXPECT_EQ(app::run_info(arguments), 0);
    return ::testing::internal::GetCapturedStdout() + ::testing::internal::GetCapturedStderr();
  }
  DicomSeries series_;
};

TEST_F(DicomScan, SaysHowACtWasMade) {
  const fs::path path = series([](DicomElements& e) {
    e.set(0x00080070, "LO", "SIEMENS");
    e.set(0x00081090, "LO", "SOMATOM Definition AS+");
    e.set(0x00180010, "LO", "Ultravist 300");
    e.set(0x00180015, "CS", "HEAD");
    e.set(0x00180060, "DS", "120");
    e.set(0x00181030, "LO", "01_HeadAngio/Head Routine 5.0mm");
    e.set(0x00181151, "IS", "210");
    e.set(0x00181210, "SH", "H31s");
  });
  const std::map<std::string, std::string> expected{{"body_part", "head"},      {"protocol", "head routine"},
                                                    {"contrast", "yes"},        {"scanner", "Siemens SOMATOM Definition AS"},
                                                    {"kernel", "H31s"},         {"slice_thickness_mm", "2.5"},
                                                    {"tube_voltage_kv", "120"}, {"tube_current_ma", "210"}};
  EXPECT_EQ(facts(path), expected);
  const Json json = Json::parse(printed(path, true));
  EXPECT_EQ(json["scan"]["tube_voltage_kv"], 120);
  EXPECT_EQ(json["what"], "CT, head, with contrast agent, in Hounsfield units");
  const std::string words = printed(path, false);
  for (const char* part : {"120 kVp", "210 mA", "kernel H31s", "slices 2.5 mm thick", "head routine", "Siemens"})
    EXPECT_NE(words.find(part), std::string::npos) << part << " in\n" << words;
}

TEST_F(DicomScan, NoContrastAgentIsNone) {
  for (const char* none : {"", "NO", "none", "W/O", "No contrast", "0"})
    EXPECT_EQ(facts(series([&](DicomElements& e) { e.set(0x00180010, "LO", none); })).count("contrast"), 0U) << none;
}

TEST_F(DicomScan, SaysHowAnMrWasMade) {
  const auto mr = [&](const std::function<void(DicomElements&)>& add) {
    return series([&](DicomElements& e) {
      e.set(0x00080060, "CS", "MR");
      e.set(0x00180020, "CS", "GR\\IR");
      e.set(0x00180021, "CS", "SK\\SP\\MP");
      e.set(0x00180023, "CS", "3D");
      e.set(0x00180024, "SH", "*tfl3d1_16ns");
      e.set(0x00180080, "DS", "2300");
      e.set(0x00180081, "DS", "2.98");
      e.set(0x00180082, "DS", "900");
      e.set(0x00180087, "DS", "3");
      e.set(0x00181314, "DS", "9");
      add(e);
    });
  };
  std::map<std::string, std::string> said = facts(mr([](DicomElements&) {}));
  EXPECT_EQ(said["sequence"], "3D spoiled magnetization-prepared gradient echo, inversion recovery (tfl3d1_16ns)");
  EXPECT_EQ(said["repetition_time_ms"], "2300");
  EXPECT_EQ(said["echo_time_ms"], "2.98");
  EXPECT_EQ(said["inversion_time_ms"], "900");
  EXPECT_EQ(said["flip_angle_deg"], "9");
  EXPECT_EQ(said["field_strength_t"], "3");
  const auto what = [&](const fs::path& path) { return Json::parse(printed(path, true))["what"].get<std::string>(); };
  EXPECT_EQ(what(mr([](DicomElements&) {})), "MR");
  EXPECT_EQ(what(mr([](DicomElements& e) { e.set(0x00180025, "CS", "Y"); })), "MR angiogram");
  EXPECT_EQ(what(mr([](DicomElements& e) { e.set(0x00189087, "FD", bytes_of(1000.0)); })), "diffusion MR");
  EXPECT_EQ(what(mr([](DicomElements& e) { e.set(0x00189217, "FD", bytes_of(150.0)); })), "velocity MR (phase contrast)");
}

TEST_F(DicomScan, TheUnitIsTheFilesOwn) {
  const auto unit = [&](const char* modality, std::uint32_t tag, const char* code) {
    return read(series([&](DicomElements& e) {
             e.set(0x00080060, "CS", modality);
             if (code != nullptr) e.set(tag, tag == 0x00281054 ? "LO" : "CS", code);
           }))
        .fields[0]
        .unit;
  };
  constexpr std::uint32_t rescale_type = 0x00281054, units = 0x00541001;
  EXPECT_EQ(unit("CT", 0, nullptr), "HU");
  EXPECT_EQ(unit("CT", rescale_type, "HU"), "HU");
  EXPECT_EQ(unit("CT", rescale_type, "ED"), "10²³/ml");  // of two energies: an electron density
  EXPECT_EQ(unit("CT", rescale_type, "US"), "");
  EXPECT_EQ(unit("PT", units, "BQML"), "Bq/ml");
  EXPECT_EQ(unit("MR", 0, nullptr), "");
  EXPECT_EQ(unit("MR", rescale_type, "DOE^JANE"), "");
}

TEST_F(DicomScan, AGantryTiltIsCalledOne) {
  const double tilt = 18.5 * 3.14159265358979 / 180;
  series_.down = {0, std::cos(tilt), std::sin(tilt)};
  EXPECT_NE(printed(series([](DicomElements&) {}), false).find("sheared by a gantry tilt of 18.5°"), std::string::npos);
  const std::string mr = printed(series([](DicomElements& e) { e.set(0x00080060, "CS", "MR"); }), false);
  EXPECT_NE(mr.find("sheared by 18.5°"), std::string::npos) << mr;
}

TEST_F(DicomScan, AModalityThatNoFileSaysIsNotClaimed) {
  const std::string header =
      "NRRD0004\ntype: uint8\ndimension: 3\nspace: left-posterior-superior\nsizes: 6 5 4\nspace directions: (1,0,0) (0,1,0) "
      "(0,0,1)\nspace origin: (0,0,0)\nspace units: \"mm\" \"mm\" \"mm\"\nencoding: raw\n\n";
  std::string voxels;
  for (int n = 0; n < 120; ++n) voxels += static_cast<char>(n * 37 % 251);
  const auto what = [&](const std::string& name) {
    return Json::parse(printed(folder_.write(name, header + voxels), true))["what"].get<std::string>();
  };
  EXPECT_EQ(what("CT_AVM.nrrd"), "a scan of unknown modality (CT by its file's name)");
  EXPECT_EQ(what("CT_pitch.nrrd"), "a scan of unknown modality (CT by its file's name)");
  EXPECT_EQ(what("template_T2.nrrd"), "a scan of unknown modality (MR, T2-weighted by its file's name)");
  for (const char* name : {"a.nrrd", "act.nrrd", "subject07.nrrd"})
    EXPECT_EQ(what(name), "a scan of unknown modality (the file does not say it)");
}

TEST_F(DicomScan, TheModalityOfOtherFormatsIsTheFilesOwn) {
  std::string voxels;
  for (int n = 0; n < 120; ++n) voxels += static_cast<char>(n * 37 % 251);
  for (const std::string modality : {"CT", "MR", "NM", "US"}) {
    const fs::path meta =
        folder_.write("CT_T2.mha", "ObjectType = Image\nNDims = 3\nBinaryData = True\nModality = MET_MOD_" + modality +
                                       "\nElementSpacing = 1 1 1\nDimSize = 6 5 4\nElementType = MET_UCHAR\n"
                                       "ElementDataFile = LOCAL\n" +
                                       voxels);
    const fs::path nrrd =
        folder_.write("CT_T2.nrrd", "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 6 5 4\nencoding: raw\nmodality:=" + modality +
                                        "\n\n" + voxels);
    const std::string kind = modality == "NM" ? "nuclear medicine" : modality == "US" ? "ultrasound" : modality;
    for (const fs::path& file : {meta, nrrd}) {
      EXPECT_EQ(read(file).modality, modality) << file;
      EXPECT_EQ(Json::parse(printed(file, true))["what"], kind) << file;
    }
  }
}

TEST_F(DicomScan, NobodyIsNamed) {
  constexpr const char *person = "Doe^Jane", *secret = "Quillfeather";
  const fs::path path = series([&](DicomElements& e) {
    // Names, numbers, dates and places of people and institutions; then every text that is read, with a name among its words.
    for (const std::uint32_t tag : {0x00080090U, 0x00081048U, 0x00081050U, 0x00081060U, 0x00081070U, 0x00100010U, 0x00101005U,
                                    0x00101060U, 0x00102297U, 0x00321032U, 0x00400006U, 0x0040a123U}) {
      e.set(tag, "PN", person);
    }
    for (const std::uint32_t tag :
         {0x00080080U, 0x00081010U, 0x00081030U, 0x0008103eU, 0x00081040U, 0x00100020U, 0x00101000U, 0x00101040U, 0x00102154U,
          0x00102180U, 0x00104000U, 0x00204000U, 0x00321060U, 0x00400254U}) {
      e.set(tag, "LO", secret);
    }
    e.set(0x00100030, "DA", "19471103");
    e.set(0x00080020, "DA", "20190407");
    e.set(0x00080008, "CS", "ORIGINAL\\PRIMARY\\" + std::string(secret));
    e.set(0x00080070, "LO", std::string("SIEMENS ") + secret);
    e.set(0x00081090, "LO", std::string("Skyra Jane ") + secret);
    e.set(0x00180010, "LO", std::string(secret) + " 19471103");
    e.set(0x00180015, "CS", "HEAD QUILLFEATHER");
    e.set(0x00180020, "CS", "SE\\QUILLFEATHER");
    e.set(0x00180021, "CS", "SP\\QUILLFEATHER");
    e.set(0x00180024, "SH", "se_jane_doe_1");
    e.set(0x00181030, "LO", "Head Jane Doe 19471103 Quillfeather routine 0815");
    e.set(0x00181210, "SH", "Quillfeather");
  });
  EXPECT_EQ(facts(path)["body_part"], "head");
  EXPECT_EQ(facts(path)["protocol"], "head routine");
  EXPECT_EQ(facts(path)["scanner"], "Siemens Skyra");
  EXPECT_EQ(facts(path)["sequence"], "spoiled spin echo");
  EXPECT_EQ(facts(path).count("kernel"), 0U);
  for (const bool json : {false, true}) {
    std::string all = printed(path, json);
    for (char& c : all) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    for (const char* name : {"doe", "jane", "quillfeather", "1947", "2019", "0815"})
      EXPECT_EQ(all.find(name), std::string::npos) << name << " in\n" << all;
  }
}

TEST_F(DicomScan, PaddingIsCalledPadding) {
  const fs::path path = series([](DicomElements& e) { e.set_short(0x00280120, 0); });
  const std::string before = printed(path, false);
  EXPECT_EQ(before.find("not finite"), std::string::npos);
  DicomElements e = series_.image(series_.at_mm({0, 0, 0}), 1);
  std::string pixels = series_.pixels(series_.at_mm({0, 0, 0}));
  pixels[0] = pixels[1] = '\0';
  e.set(0x7fe00010, "OW", pixels), e.set_short(0x00280120, 0);
  folder_.write("s/0", series_.file(e));
  const std::string words = printed(path, false);
  EXPECT_NE(words.find("1 voxel is padding"), std::string::npos) << words;
}

}  // namespace dicom_scan_test
}  // namespace palpa::test
