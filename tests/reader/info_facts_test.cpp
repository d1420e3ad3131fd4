// `palpa info --json` and `--at-m` against facts of the shared data from other tools.
#include <cmath>
#include <tuple>

#include "app/info.h"
#include "files.h"
#include "shared_facts.h"

namespace palpa::test {
namespace info_facts_test {

using Json = nlohmann::json;

class InfoFacts : public SharedFacts {
 protected:
  Json info_of(const std::string& file, const std::vector<Vec3>& at_m = {}, const VolumeRequest& request = {}) {
    app::InfoArguments arguments{.files = {shared_file(file)}, .json = true, .at_m = at_m, .read = options_};
    arguments.request = request;
    ::testing::internal::CaptureStdout();
    ::testing::internal::CaptureStderr();
    EXPECT_EQ(app::run_info(arguments), 0);
    EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
    return Json::parse(::testing::internal::GetCapturedStdout());
  }

  /// Dims, range, mean, steps and every value of one field, queried by the affine and at world positions.
  void expect_facts(const std::string& file, const Json& fact, const std::string& field, const VolumeRequest& request = {}) {
    SCOPED_TRACE(file + " " + field);
    const Json info = info_of(file, {}, request);
    std::size_t f = 0;
    while (f < info["fields"].size() && !field.empty() && info["fields"][f]["name"] != field) ++f;
    ASSERT_LT(f, info["fields"].size());
    const Json &entry = info["fields"][f], &values = info["statistics"][f];
    const std::string name = entry["name"];
    for (std::size_t a = 0; a < 3; ++a) EXPECT_EQ(entry["dims"][a], fact["dims"][a]);
    const auto near = [](const Json& found, double expected) {
      EXPECT_NEAR(found.get<double>(), expected, 1e-5 * std::max(1.0, std::abs(expected)));
    };
    const bool scalar = entry["components"] == 1, frames = fact["dims"].size() > 3;
    if (scalar && !frames) {
      near(entry["min"], fact["min"]), near(entry["max"], fact["max"]);
      if (fact.contains("mean")) near(values["mean"], fact["mean"]);
    }
    if (fact.contains("max_speed")) {
      near(values["max"], fact["max_speed"]), near(values["mean"], fact["mean_speed"]);
      for (std::size_t a = 0; a < 3; ++a) EXPECT_EQ(values["max_ijk"][a].get<double>(), fact["max_speed_ijk"][a].get<double>());
    }
    if (fact.contains("component_min")) {
      for (std::size_t c = 0; c < 3; ++c)
        near(entry["min"][c], fact["component_min"][c]), near(entry["max"][c], fact["component_max"][c]);
    }
    const double unit_m = info["length_unit"] == "mm" ? 1e-3 : 1.0;
    if (fact.contains("spacing")) {
      for (std::size_t a = 0; a < 3; ++a)
        EXPECT_NEAR(info["spacing_m"][a].get<double>(), unit_m * fact["spacing"][a].get<double>(), 1e-6 * unit_m);
    }

    const auto world_m = [&](const Json& ijk) { return world_of(info, ijk); };
    for (const Json& point : fact.value("points", Json::array())) {
      EXPECT_LT(distance(world_m(point["ijk"]), {point["xyz"][0], point["xyz"][1], point["xyz"][2]}), 1e-6);
    }
    const auto place = [](const Json& of) { return Vec3{of[0], of[1], of[2]}; };
    if (fact.contains("origin") && fact["origin"].is_array()) {
      EXPECT_LT(distance(place(info["origin_m"]), unit_m * place(fact["origin"])), 1e-6 * unit_m);
    }
    if (fact.contains("axcodes")) {
      EXPECT_EQ(info["axes_towards"], fact["axcodes"]);
    }
    if (fact.contains("affine_RAS_mm")) {
      for (std::size_t c = 0; c < 4; ++c) {
        for (std::size_t r = 0; r < 3; ++r) {
          const double lps_m = (r < 2 ? -1e-3 : 1e-3) * fact["affine_RAS_mm"][r][c].get<double>();
          EXPECT_NEAR(info["index_to_world_m"][r][c].get<double>(), lps_m, 1e-7) << r << " " << c;
        }
      }
    }
    for (const Json& voxel : fact["voxels"]) {
      const Vec3 here_m = world_m(voxel["ijk"]);
      if (voxel.contains("world_RAS_mm")) {
        const Vec3 ras_mm = place(voxel["world_RAS_mm"]);
        EXPECT_LT(distance(here_m, 1e-3 * Vec3{-ras_mm.x, -ras_mm.y, ras_mm.z}), 1e-7);
      }
      if (voxel.contains("world_in_file_space")) {  // LPS, in all files that declare it
        EXPECT_LT(distance(here_m, 1e-3 * place(voxel["world_in_file_space"])), 1e-7);
      }
    }
    std::vector<Vec3> at_m;
    std::vector<Json> expected;
    const auto ask = [&](const Json& ijk, const Json& value) { at_m.push_back(world_m(ijk)), expected.push_back(value); };
    for (const Json& voxel : fact["voxels"]) {
      if (voxel.contains("value")) ask(voxel["ijk"], voxel["value"]);
      if (voxel.contains("values") && scalar) {
        ask(voxel["ijk"], voxel["values"][static_cast<std::size_t>(std::max(request.frame, 0))]);
      }
    }
    if (fact.contains("trilinear")) ask(fact["trilinear"]["index"], fact["trilinear"]["value"]);
    ASSERT_FALSE(at_m.empty());
    const Json samples = info_of(file, at_m, request)["samples"];
    ASSERT_EQ(samples.size(), expected.size());
    for (std::size_t n = 0; n < samples.size(); ++n) {
      EXPECT_EQ(samples[n]["inside"], true);
      const Json& found = samples[n]["values"][name];
      if (scalar) {
        near(found, expected[n]);
      } else {
        for (std::size_t c = 0; c < 3; ++c) near(found[c], expected[n][c]);
      }
    }
  }

  /// The position of an index, by the documented formula.
  static Vec3 world_of(const Json& info, const Json& ijk) {
    const Json& m = info["index_to_world_m"];
    double at[3], steps[3];
    for (std::size_t a = 0; a < 3; ++a) {
      steps[a] = ijk[a];
      if (!info.contains("planes_steps") || info["planes_steps"][a].empty()) continue;
      const auto cell = std::min(static_cast<std::size_t>(steps[a]), info["planes_steps"][a].size() - 2);
      const double from = info["planes_steps"][a][cell], to = info["planes_steps"][a][cell + 1];
      steps[a] = from + (steps[a] - static_cast<double>(cell)) * (to - from);
    }
    for (std::size_t r = 0; r < 3; ++r) {
      at[r] = m[r][3].get<double>();
      for (std::size_t c = 0; c < 3; ++c) at[r] += m[r][c].get<double>() * steps[c];
    }
    return {at[0], at[1], at[2]};
  }
};

TEST_F(InfoFacts, OfScans) {
  for (const auto& [file, key] : std::vector<std::pair<std::string, std::string>>{
           {"ct_head_cranium/cranium.mhd", "cranium.mhd / cranium.nhdr"},
           {"ct_head_cranium/cranium.nhdr", "cranium.mhd / cranium.nhdr"},
           {"ct_head_headsq/quarter.nhdr", "quarter.nhdr"},
           {"mri_flair_nrrd/FLAIR.nrrd", "FLAIR.nrrd"},
           {"mra_avf_nrrd/avf_float_32.nrrd", "avf_float_32.nrrd"},
           {"mri_mha_zlib/mha.mha", "mha.mha"},
           {"mri_head_mhd/HeadMRVolume.mhd", "HeadMRVolume.mhd"},
           {"mri_avg152_bigendian/avg152T1_RL_nifti.nii.gz", "avg152T1_RL_nifti.nii.gz"},
           {"dti_brain/FA.nii.gz", "FA.nii.gz"}}) {
    expect_facts(file, facts_[file.substr(0, file.find('/'))][key], "");
  }
}

TEST_F(InfoFacts, OfEachFrame) {
  for (const auto& [file, key] : std::vector<std::pair<std::string, std::string>>{
           {"mri_epi_4d/example4d.nii.gz", "example4d.nii.gz (4-D, 2 time steps)"},
           {"mri_epi_4d/example_nifti2.nii.gz", "example_nifti2.nii.gz (NIfTI-2, 4-D)"}}) {
    const Json& fact = facts_["mri_epi_4d"][key];
    for (int frame = 0; frame < fact["dims"][3].get<int>(); ++frame) {
      VolumeRequest request;
      request.frame = frame;
      expect_facts(file, fact, "", request);
    }
    EXPECT_EQ(info_of(file)["frames"], fact["dims"][3]);
  }
}

TEST_F(InfoFacts, OfDirections) {
  const Json& fact = facts_["dti_brain"]["V1.nii.gz (4-D, last axis = xyz)"];
  std::vector<Vec3> at_m;
  const Json where = info_of("dti_brain/V1.nii.gz");
  EXPECT_EQ(where["axes_towards"], fact["axcodes"]);
  for (const Json& voxel : fact["voxels"]) at_m.push_back(world_of(where, voxel["ijk"]));
  VolumeRequest request;
  request.as = "vector";
  const Json along_ras = info_of("dti_brain/V1.nii.gz", at_m, request);
  request.components_along = "index";
  const Json along_grid = info_of("dti_brain/V1.nii.gz", at_m, request);
  EXPECT_NEAR(along_ras["statistics"][0]["max"], fact["max_norm"], 1e-5);
  EXPECT_EQ(along_ras["statistics"][0]["zeros"], fact["zero_vectors"]);
  // Along RAS x and y turn into LPS. Its grid goes to the left, the front and the head: along it only y does.
  for (std::size_t n = 0; n < at_m.size(); ++n) {
    const Json &values = fact["voxels"][n]["values"], &ras = along_ras["samples"][n]["values"].front(),
               &grid = along_grid["samples"][n]["values"].front();
    const double to_ras[] = {-1, -1, 1}, to_grid[] = {1, -1, 1};
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_NEAR(ras[c], to_ras[c] * values[c].get<double>(), 1e-6);
      EXPECT_NEAR(grid[c], to_grid[c] * values[c].get<double>(), 1e-6);
    }
  }
}

TEST_F(InfoFacts, OfEveryOrientation) {
  const Json& all = facts_["nifti_orientations"];
  ASSERT_EQ(all.size(), 12U);
  for (const auto& [name, fact] : all.items()) {
    SCOPED_TRACE(name);
    std::vector<Vec3> at_m;
    for (const Json& sample : fact["world_samples_trilinear"]) {
      const Json& ras_mm = sample["RAS_mm"];
      at_m.push_back(1e-3 * Vec3{-ras_mm[0].get<double>(), -ras_mm[1].get<double>(), ras_mm[2].get<double>()});
    }
    const Json info = info_of("nifti_orientations/" + name, at_m);
    EXPECT_EQ(info["axes_towards"], fact["axcodes"]);
    EXPECT_EQ(info["fields"][0]["dims"], fact["dims"]);
    for (std::size_t n = 0; n < at_m.size(); ++n) {
      EXPECT_EQ(info["samples"][n]["inside"], true);
      const double expected = fact["world_samples_trilinear"][n]["value"];
      EXPECT_NEAR(info["samples"][n]["values"].front().get<double>(), expected, 1e-4 * std::max(1.0, std::abs(expected)));
    }
  }
}

TEST_F(InfoFacts, OfFlowsAndMolecules) {
  expect_facts("mri_flow_carotid/carotid.vtk", facts_["mri_flow_carotid"]["carotid.vtk : vectors"], "vectors");
  expect_facts("mri_flow_carotid/carotid.vtk", facts_["mri_flow_carotid"]["carotid.vtk : scalars"], "scalars");
  expect_facts("cfd_wing/wing.vti", facts_["cfd_wing"]["wing.vti : velocity"], "velocity");
  expect_facts("cfd_wing/wing.vti", facts_["cfd_wing"]["wing.vti : pressure"], "pressure");
  expect_facts("weather_isabel/isabel_30.vti", facts_["weather_isabel"]["isabel_30.vti : velocityMag"], "");
  expect_facts("mol_ironprot/ironProt.vtk", facts_["mol_ironprot"]["ironProt.vtk"], "");
  expect_facts("mol_hydrogen/hydrogen.vti", facts_["mol_hydrogen"]["hydrogen.vti"], "");
  const Json wing = info_of("cfd_wing/wing.vti");
  EXPECT_EQ(wing["statistics"][2]["zeros"], facts_["cfd_wing"]["wing.vti : fluid"]["zeros(solid)"]);
}

TEST_F(InfoFacts, OfADicomSeries) {
  const Json& fact = facts_["ct_headphantom_dicom"]["series of 28 files"];
  expect_facts("ct_headphantom_dicom", fact, "");
  const Json info = info_of("ct_headphantom_dicom");
  EXPECT_EQ(info["modality"], "CT");
  EXPECT_EQ(info["files"].size(), 28U);
  EXPECT_EQ(info["axes_towards"], "LPS");
  for (std::size_t a = 0; a < 3; ++a) {
    EXPECT_NEAR(1e3 * info["origin_m"][a].get<double>(), fact["first_position_LPS"][a].get<double>(), 1e-9);
    EXPECT_NEAR(1e3 * info["index_to_world_m"][a][2].get<double>(), fact["slice_step_vector_first"][a].get<double>(), 1e-9);
  }
  EXPECT_NEAR(1e3 * info["spacing_m"][0].get<double>(), fact["pixel_spacing_row_col"][1].get<double>(), 1e-9);
  EXPECT_NEAR(1e3 * info["spacing_m"][1].get<double>(), fact["pixel_spacing_row_col"][0].get<double>(), 1e-9);
}

TEST_F(InfoFacts, OfARectilinearGrid) {
  const Json& fact = facts_["cfd_office"]["office.binary.vtk"];
  expect_facts("cfd_office/office.binary.vtk", fact, "vectors");
  const Json info = info_of("cfd_office/office.binary.vtk");
  ASSERT_EQ(info["fields"][0]["name"], "scalars");
  EXPECT_NEAR(info["fields"][0]["min"], fact["scalars"]["min"], 1e-6);
  EXPECT_NEAR(info["fields"][0]["max"], fact["scalars"]["max"], 1e-6);
}

TEST_F(InfoFacts, OfCurvilinearGridsWithinTheErrorThatTheySay) {
  for (const auto& [file, key] :
       std::vector<std::pair<std::string, std::string>>{{"cfd_bluntfin/bluntfinxyz.bin", "bluntfinxyz.bin + bluntfinq.bin"},
                                                        {"cfd_combustor/combxyz.bin", "combxyz.bin + combq.bin"}}) {
    SCOPED_TRACE(file);
    const Json& fact = facts_[file.substr(0, file.find('/'))][key];
    const auto value_at = [](const Json& of, const Json& ijk) {
      for (const Json& voxel : of["voxels"]) {
        if (voxel["ijk"] == ijk) return voxel["value"];
      }
      return Json();
    };
    for (const Json& point : fact["points"]) {
      const Json density = value_at(fact["density"], point["ijk"]), momentum = value_at(fact["momentum"], point["ijk"]);
      const Json info = info_of(file, {{point["xyz"][0], point["xyz"][1], point["xyz"][2]}});
      for (const Json& field : info["fields"]) {
        for (std::size_t a = 0; a < 3; ++a) EXPECT_EQ(field["dims"][a], fact["dims"][a]);
        const double error = field["resampling_error"]["by_cell"]["max"];
        const Json& found = info["samples"][0]["values"][field["name"].get<std::string>()];
        if (field["name"] == "density") {
          EXPECT_NEAR(field["min"], fact["density"]["min"], 1e-6);
          EXPECT_NEAR(field["max"], fact["density"]["max"], 1e-6);
          const double range = fact["density"]["max"].get<double>() - fact["density"]["min"].get<double>();
          if (!density.is_null()) {
            EXPECT_NEAR(found, density, error * range);
          }
        }
        if (field["name"] == "momentum" && !momentum.is_null()) {
          for (std::size_t c = 0; c < 3; ++c)
            EXPECT_NEAR(found[c], momentum[c], error * (field["max"][c].get<double>() - field["min"][c].get<double>()));
        }
      }
    }
  }
}

TEST_F(InfoFacts, SayWhichWayThePatientLies) {
  EXPECT_EQ(info_of("mri_avg152_bigendian/avg152T1_RL_nifti.nii.gz")["axes_towards"], "RAS");
}

TEST_F(InfoFacts, SayWhatTheDataAre) {
  // As in the list of the shared data; undeclared in the file, it "looks like" it, or its modality is unknown, for any file
  // name.
  for (const auto& [file, kind, said] :
       {std::tuple{"ct_head_cranium/cranium.mhd", "CT", false},
        {"ct_head_headsq/quarter.nhdr", "CT", false},
        {"ct_headphantom_dicom", "CT, brain", true},
        {"mri_flow_carotid/carotid.vtk", "velocity MR", false},
        {"mri_flair_nrrd/FLAIR.nrrd", "MR, FLAIR", false},
        {"mra_avf_nrrd/avf_float_32.nrrd", "a scan of unknown modality (the file does not say it)", false},
        {"mri_mha_zlib/mha.mha", "a scan of unknown modality (the file does not say it)", false},
        {"mri_head_mhd/HeadMRVolume.mhd", "MR", false},
        {"mri_avg152_bigendian/avg152T1_RL_nifti.nii.gz", "MR, T1-weighted", false},
        {"mri_epi_4d/example4d.nii.gz", "a scan of unknown modality (the file does not say it)", false},
        {"dti_brain/V1.nii.gz", "diffusion directions", false},
        {"dti_brain/FA.nii.gz", "fractional anisotropy", false},
        {"cfd_wing/wing.vti", "CFD", false},
        {"cfd_office/office.binary.vtk", "CFD", false},
        {"cfd_bluntfin/bluntfinxyz.bin", "CFD", true},
        {"cfd_combustor/combq.bin", "CFD", true},
        {"weather_isabel/isabel_30.vti", "wind", false}}) {
    const std::string what = info_of(file)["what"];
    EXPECT_NE(what.find(kind), std::string::npos) << file << ": " << what;
    const bool guessed = what.find("looks like") != std::string::npos || what.find("unknown modality") != std::string::npos;
    EXPECT_EQ(!guessed, said) << file << ": " << what;
  }
}

TEST_F(InfoFacts, FindWhatIsSuspicious) {
  const auto suspicious = [&](const std::string& file) { return info_of(file)["suspicious"].dump(); };
  EXPECT_NE(suspicious("mol_ironprot/ironProt.vtk").find("cut off"), std::string::npos);
  EXPECT_NE(suspicious("dti_brain/FA.nii.gz").find("exactly 0"), std::string::npos);
  EXPECT_NE(suspicious("dti_brain/V1.nii.gz").find("takes them so"), std::string::npos);
}

}  // namespace info_facts_test
}  // namespace palpa::test
