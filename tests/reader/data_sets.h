// The shared data sets, for tests and commands that run on each of them.
#pragma once

#include <cctype>
#include <ostream>
#include <string>
#include <vector>

namespace palpa::test {

/// A file or a folder of the shared data, and the files that are read with it.
struct DataSet {
  std::string file;
  std::vector<std::string> with{};
};
inline void PrintTo(const DataSet& set, std::ostream* to) { *to << set.file; }

/// The file as part of a test's name.
inline std::string name_of(const DataSet& set) {
  std::string name = set.file;
  for (char& c : name) c = std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  return name;
}

/// One of each readable file type.
inline std::vector<DataSet> data_sets() {
  return {
      {"ct_head_cranium/cranium.mhd", {"cranium.raw.gz"}},
      {"ct_head_cranium/cranium.nhdr", {"cranium.raw.gz"}},
      {"ct_head_headsq/quarter.nhdr", {"quarter.1", "quarter.50"}},
      {"ct_headphantom_dicom"},
      {"mri_flow_carotid/carotid.vtk"},
      {"cfd_combustor/combxyz.bin", {"combq.bin"}},
      {"cfd_bluntfin/bluntfinxyz.bin", {"bluntfinq.bin"}},
      {"cfd_office/office.binary.vtk"},
      {"cfd_wing/wing.vti"},
      {"weather_isabel/isabel_30.vti"},
      {"dti_brain/FA.nii.gz"},
      {"dti_brain/V1.nii.gz"},
      {"mri_flair_nrrd/FLAIR.nrrd"},
      {"mra_avf_nrrd/avf_float_32.nrrd"},
      {"mri_mha_zlib/mha.mha"},
      {"mri_head_mhd/HeadMRVolume.mhd", {"HeadMRVolume.raw"}},
      {"mri_avg152_bigendian/avg152T1_RL_nifti.nii.gz"},
      {"mri_epi_4d/example4d.nii.gz"},
      {"mri_epi_4d/example_nifti2.nii.gz"},
      {"nifti_orientations/AIL.nii.gz"},
      {"nifti_orientations/SPL.nii.gz"},
      {"mol_ironprot/ironProt.vtk"},
      {"mol_hydrogen/hydrogen.vti"},
  };
}

inline std::vector<DataSet> refused_sets() {
  return {
      {"weather_storm_dx/wind.dx", {"storm_data.dx"}},
      {"mol_water_dx/watermolecule.dx"},
      {"ct_perfusion_rgb/ct_perfusion.nii.gz"},
  };
}

}  // namespace palpa::test
