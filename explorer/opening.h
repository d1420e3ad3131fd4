// Opens scenes, data and traces, and adds data to a scene.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "explorer/document.h"
#include "palpa/file/read_volume.h"

namespace palpa::explorer {

/// Scenes, traces or data to open; for data with the user's choices.
struct Wanted {
  std::vector<std::filesystem::path> paths;           ///< one; of data also several: blocks of one grid, grid and solution
  std::filesystem::path second_trace{};               ///< shown beside a trace; empty: none
  std::string series{};                               ///< as in VolumeRequest
  std::vector<VolumeRequest::FieldRequest> fields{};  ///< likewise; empty: all
  std::filesystem::path beside{};                     ///< further data, which may bound a flow; empty: none
  bool is_decided = false;                            ///< nothing is asked: of several parts the reader chooses
  std::vector<std::string> taken{};                   ///< names that the volume must not have
};

/// Opened files, or the parts of which the user has to choose.
struct Found {
  std::optional<Opened> opened;
  FileContents to_choose{};
};

/// True for the folder of a trace, or of the traces of several hands. Any thread.
bool is_trace(const std::filesystem::path& folder);

/// Loads a scene file; for data, the scene that `palpa info --scene` suggests; for a trace, its scene. Of several series, or
/// HDF5 arrays of several shapes, one has to be chosen; a slice of a DICOM series brings the series. Any thread; duration grows
/// with the data. Throws LoadError, also when stopped.
/// \param data_folders  searched for the scene's files
Found open_or_ask(const Wanted& wanted, const std::vector<std::filesystem::path>& data_folders, std::stop_token stop = {});
/// Likewise, with the reader's choice.
Opened open_any(const std::filesystem::path& path, const std::vector<std::filesystem::path>& data_folders,
                std::stop_token stop = {});

/// Series and arrays of data. Any thread; reads no voxels, unless the file's library reads them with the header. Throws
/// LoadError.
FileContents list_parts(const std::filesystem::path& path, std::stop_token stop = {});

/// Data beside a velocity file whose name differs by one word, as "flow_magnitude.nrrd" beside "flow_velocity.nrrd": masks
/// first; empty: none.
std::filesystem::path find_beside(const std::filesystem::path& velocity);

/// Adds the volumes, modes and layers of opened data to a scene, under new names where theirs are taken. Returns remarks on the
/// place of the data. Throws SceneError.
QStringList add_to(Scene& scene, const Scene& added);

/// Scenes installed with Palpa that need no files, "head_phantom.toml"; empty if not found.
std::vector<std::filesystem::path> embedded_scenes();

}  // namespace palpa::explorer
