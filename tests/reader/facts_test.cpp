// Facts of the shared data, found with other tools.
#include <cmath>

#include "shared_facts.h"

namespace palpa::test {
namespace facts_test {

using Json = nlohmann::json;

class Facts : public SharedFacts {
 protected:
  Volume open(const std::string& name, VolumeRequest request = {}) { return read(shared_file(name), std::move(request)); }
};

const VolumeField& field_of(const Volume& volume, const std::string& name) {
  for (const VolumeField& field : volume.fields) {
    if (name.empty() || field.name == name) return field;
  }
  throw std::runtime_error("no field " + name);
}

GridPoint point(const Json& ijk) { return {ijk[0].get<double>(), ijk[1].get<double>(), ijk[2].get<double>()}; }
Vec3 vec(const Json& v) { return {v[0].get<double>(), v[1].get<double>(), v[2].get<double>()}; }
double tolerance(double value) { return 1e-5 * std::max(1.0, std::abs(value)); }

/// Checks dims, range, voxels and the trilinear value, all at index positions of the file.
/// `unit_m`: metres per unit of length of the file.
void check(const Field& field, const Json& fact, double unit_m) {
  const GridView& view = *grid_of(field);
  for (std::size_t a = 0; a < 3; ++a) EXPECT_EQ(view.geometry.dims[a], fact["dims"][a].get<std::int64_t>());
  const auto expect_value = [&](const GridPoint& at, const Json& value) {
    const Vec3 world_m = view.geometry.to_world(at);
    if (value.is_number()) {
      const ScalarSample sample = field.scalar(world_m);
      EXPECT_TRUE(sample.inside);
      EXPECT_NEAR(sample.value, value.get<double>(), tolerance(value.get<double>()));
    } else {
      const VectorSample sample = field.vector(world_m);
      const Vec3 expected = vec(value);
      EXPECT_TRUE(sample.inside);
      EXPECT_LT(distance(sample.value, expected), tolerance(norm(expected)));
    }
  };
  for (const Json& voxel : fact["voxels"]) {
    if (voxel.contains("value")) expect_value(point(voxel["ijk"]), voxel["value"]);
  }
  if (fact.contains("trilinear")) expect_value(point(fact["trilinear"]["index"]), fact["trilinear"]["value"]);
  const std::vector<ValueRange> value_ranges = field.value_ranges();
  if (fact.contains("component_min")) {
    for (std::size_t c = 0; c < 3; ++c) {
      EXPECT_NEAR(value_ranges[c].min, fact["component_min"][c].get<double>(), 1e-4);
      EXPECT_NEAR(value_ranges[c].max, fact["component_max"][c].get<double>(), 1e-4);
    }
  } else if (value_ranges.size() == 1 && fact["dims"].size() == 3) {
    EXPECT_NEAR(value_ranges[0].min, fact["min"].get<double>(), tolerance(fact["min"].get<double>()));
    EXPECT_NEAR(value_ranges[0].max, fact["max"].get<double>(), tolerance(fact["max"].get<double>()));
  }
  if (fact.contains("spacing")) {
    const Mat3 steps = transposed(view.geometry.index_to_world_m);
    for (std::size_t a = 0; a < 3; ++a) {
      EXPECT_NEAR(norm(steps.row[a]), unit_m * fact["spacing"][a].get<double>(), 1e-6 * unit_m);
    }
  }
}

TEST_F(Facts, CraniumByMetaImageAndNrrdIsTheSame) {
  const Json& fact = facts_["ct_head_cranium"]["cranium.mhd / cranium.nhdr"];
  const Volume mhd = open("ct_head_cranium/cranium.mhd"), nhdr = open("ct_head_cranium/cranium.nhdr");
  for (const Volume* volume : {&mhd, &nhdr}) {
    check(*volume->fields[0].field, fact, 1e-3);
    EXPECT_FALSE(volume->medical_frame);
    EXPECT_EQ(grid_of(*volume->fields[0].field)->voxels.type, VoxelType::int16);
  }
  const GridView &a = *grid_of(*mhd.fields[0].field), &b = *grid_of(*nhdr.fields[0].field);
  EXPECT_EQ(a.geometry, b.geometry);
  EXPECT_EQ(a.geometry.index_to_world_m.row[2], (Vec3{0, 0, 1.5e-3}));
  EXPECT_EQ(std::memcmp(a.voxels.data.get(), b.voxels.data.get(), 256 * 256 * 108 * 2), 0);
  EXPECT_EQ(mhd.files[1].sha256, "df133aa4a1cbaff7242852884604656b62eb867dc8e511813cd92180659ffad9");
}

TEST_F(Facts, HeadsqOfNinetyThreeFiles) {
  const Volume volume = open("ct_head_headsq/quarter.nhdr");
  check(*volume.fields[0].field, facts_["ct_head_headsq"]["quarter.nhdr"], 1e-3);
  EXPECT_EQ(volume.files.size(), 94U);
  EXPECT_TRUE(warns_of(volume, "left-handed"));
  EXPECT_DOUBLE_EQ(volume.bounds_m().low_m.x, -63 * 3.2e-3);
}

TEST_F(Facts, NrrdWithDirections) {
  for (const auto& [set, file] : {std::pair{"mri_flair_nrrd", "FLAIR.nrrd"}, std::pair{"mra_avf_nrrd", "avf_float_32.nrrd"}}) {
    SCOPED_TRACE(file);
    const Json& fact = facts_[set][file];
    const Volume volume = open(std::string(set) + "/" + file);
    EXPECT_TRUE(volume.medical_frame);
    const Field& field = *volume.fields[0].field;
    check(field, fact, 1e-3);
    for (const Json& voxel : fact["voxels"]) {
      const Vec3 world_m = 1e-3 * vec(voxel["world_in_file_space"]);
      EXPECT_LT(distance(grid_of(field)->geometry.to_world(point(voxel["ijk"])), world_m), 1e-9);
      EXPECT_NEAR(field.scalar(world_m).value, voxel["value"].get<double>(), 1e-3 * voxel["value"].get<double>());
    }
  }
}

TEST_F(Facts, MetaImages) {
  const Volume mha = open("mri_mha_zlib/mha.mha");
  check(*mha.fields[0].field, facts_["mri_mha_zlib"]["mha.mha"], 1e-3);
  EXPECT_TRUE(mha.medical_frame);
  EXPECT_FALSE(warns_of(mha, "AnatomicalOrientation"));
  EXPECT_LT(grid_of(*mha.fields[0].field)->geometry.index_to_world_m.row[1].y, 0.0);
  const Volume mhd = open("mri_head_mhd/HeadMRVolume.mhd");
  check(*mhd.fields[0].field, facts_["mri_head_mhd"]["HeadMRVolume.mhd"], 1e-3);
  EXPECT_FALSE(mhd.medical_frame);
}

/// RAS millimetres in Palpa's world.
Vec3 lps_m(const Json& ras_mm) {
  return 1e-3 * Vec3{-ras_mm[0].get<double>(), -ras_mm[1].get<double>(), ras_mm[2].get<double>()};
}

TEST_F(Facts, DicomSeries) {
  const Json& fact = facts_["ct_headphantom_dicom"]["series of 28 files"];
  const Volume volume = open("ct_headphantom_dicom");
  const Field& field = *volume.fields[0].field;
  check(field, fact, 1e-3);
  EXPECT_TRUE(volume.medical_frame);
  EXPECT_EQ(volume.modality, "CT");
  EXPECT_EQ(volume.files.size(), fact["slices"].get<std::size_t>());
  EXPECT_TRUE(volume.warnings.empty()) << all_warnings(volume);
  const GridGeometry& grid = grid_of(field)->geometry;
  EXPECT_LT(distance(grid.to_world({0, 0, 0}), 1e-3 * vec(fact["first_position_LPS"])), 1e-9);
  EXPECT_LT(distance(grid.to_world({0, 0, 27}), 1e-3 * vec(fact["last_position_LPS"])), 1e-9);
  EXPECT_LT(distance(grid.to_world({0, 0, 1}) - grid.to_world({0, 0, 0}), 1e-3 * vec(fact["slice_step_vector_first"])), 1e-9);
  EXPECT_NEAR(distance(grid.to_world({0, 1, 0}), grid.to_world({0, 0, 0})),
              1e-3 * fact["pixel_spacing_row_col"][0].get<double>(), 1e-12);
  EXPECT_EQ(grid_of(field)->offset, fact["rescale_intercept"].get<double>());
}

TEST_F(Facts, NiftiScalars) {
  for (const auto& [set, file] :
       {std::pair{"dti_brain", "FA.nii.gz"}, std::pair{"mri_avg152_bigendian", "avg152T1_RL_nifti.nii.gz"}}) {
    SCOPED_TRACE(file);
    const Json& fact = facts_[set][file];
    const Volume volume = open(std::string(set) + "/" + file);
    const Field& field = *volume.fields[0].field;
    check(field, fact, 1e-3);
    EXPECT_TRUE(volume.medical_frame);
    for (const Json& voxel : fact["voxels"]) {
      EXPECT_LT(distance(grid_of(field)->geometry.to_world(point(voxel["ijk"])), lps_m(voxel["world_RAS_mm"])), 1e-8);
    }
  }
}

TEST_F(Facts, NiftiVectorsTurnIntoTheWorld) {
  const Json& fact = facts_["dti_brain"]["V1.nii.gz (4-D, last axis = xyz)"];
  VolumeRequest request;
  request.as = "vector";
  const Volume volume = open("dti_brain/V1.nii.gz", request);
  const GridView& view = *grid_of(*volume.fields[0].field);
  for (const Json& voxel : fact["voxels"]) {
    const VectorSample sample = volume.fields[0].field->vector(view.geometry.to_world(point(voxel["ijk"])));
    const Vec3 ras = vec(voxel["values"]);
    EXPECT_LT(distance(sample.value, {-ras.x, -ras.y, ras.z}), 1e-6);
  }
  EXPECT_EQ(volume.fields[0].field->components(), 3);
}

TEST_F(Facts, NiftiFrames) {
  for (const auto& [key, file] : {std::pair{"example4d.nii.gz (4-D, 2 time steps)", "example4d.nii.gz"},
                                  std::pair{"example_nifti2.nii.gz (NIfTI-2, 4-D)", "example_nifti2.nii.gz"}}) {
    SCOPED_TRACE(file);
    const Json& fact = facts_["mri_epi_4d"][key];
    for (int frame = 0; frame < 2; ++frame) {
      VolumeRequest request;
      request.frame = frame;
      const Volume volume = open(std::string("mri_epi_4d/") + file, request);
      const GridGeometry& grid = grid_of(*volume.fields[0].field)->geometry;
      for (const Json& voxel : fact["voxels"]) {
        const Vec3 world_m = grid.to_world(point(voxel["ijk"]));
        EXPECT_LT(distance(world_m, lps_m(voxel["world_RAS_mm"])), 1e-8);
        EXPECT_NEAR(volume.fields[0].field->scalar(world_m).value,
                    voxel["values"][static_cast<std::size_t>(frame)].get<double>(), 1e-6);
      }
    }
  }
}

TEST_F(Facts, OneBrainInTwelveOrientationsIsOneBrain) {
  int files = 0;
  for (const auto& [file, fact] : facts_["nifti_orientations"].items()) {
    SCOPED_TRACE(file);
    const Volume volume = open("nifti_orientations/" + file);
    const Field& field = *volume.fields[0].field;
    for (std::size_t a = 0; a < 3; ++a) EXPECT_EQ(grid_of(field)->geometry.dims[a], fact["dims"][a].get<std::int64_t>());
    for (const Json& sample : fact["world_samples_trilinear"]) {
      EXPECT_NEAR(field.scalar(lps_m(sample["RAS_mm"])).value, sample["value"].get<double>(), 1e-3);
    }
    ++files;
  }
  EXPECT_EQ(files, 12);
}

TEST_F(Facts, ColoursAreRefused) {
  EXPECT_NE(error_of([&] { open("ct_perfusion_rgb/ct_perfusion.nii.gz"); }).find("colours (RGB)"), std::string::npos);
}

TEST_F(Facts, VtkImageData) {
  const Volume wing = open("cfd_wing/wing.vti");
  check(*field_of(wing, "velocity").field, facts_["cfd_wing"]["wing.vti : velocity"], 1.0);
  check(*field_of(wing, "pressure").field, facts_["cfd_wing"]["wing.vti : pressure"], 1.0);
  EXPECT_EQ(grid_of(*field_of(wing, "fluid").field)->voxels.type, VoxelType::uint8);
  EXPECT_EQ(grid_of(*wing.fields[0].field)->geometry.origin_m, vec(facts_["cfd_wing"]["wing.vti : velocity"]["origin"]));
  check(*open("weather_isabel/isabel_30.vti").fields[0].field, facts_["weather_isabel"]["isabel_30.vti : velocityMag"], 1.0);
  check(*open("mol_hydrogen/hydrogen.vti").fields[0].field, facts_["mol_hydrogen"]["hydrogen.vti"], 1.0);
}

TEST_F(Facts, LegacyVtk) {
  const Volume carotid = open("mri_flow_carotid/carotid.vtk");
  check(*field_of(carotid, "vectors").field, facts_["mri_flow_carotid"]["carotid.vtk : vectors"], 1.0);
  check(*field_of(carotid, "scalars").field, facts_["mri_flow_carotid"]["carotid.vtk : scalars"], 1.0);
  EXPECT_EQ(grid_of(*carotid.fields[0].field)->geometry.origin_m, (Vec3{100, 80, 1}));
  check(*open("mol_ironprot/ironProt.vtk").fields[0].field, facts_["mol_ironprot"]["ironProt.vtk"], 1.0);
}

}  // namespace facts_test
}  // namespace palpa::test
