// Volumes of a scene file: planned from their tables, then opened.
#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "palpa/scene/load_scene.h"
#include "palpa/scene/part_reader.h"

namespace palpa::detail::scene_file {

struct VolumePlan;

/// Checks keys of a request against each other.
void check_request(const Section& section, const VolumeRequest& request);

/// Loads the volumes of a scene: all tables are checked before the first file is opened.
class VolumeLoader {
 public:
  /// \param folder  the scene's own. All outlive this.
  VolumeLoader(const std::filesystem::path& folder, const VolumeReader& read_volume, const SceneOptions& options);
  ~VolumeLoader();

  /// Checks [volume.NAME] of a scene. Throws SceneError.
  void plan(const Section& scene);
  /// Names of the planned volumes, in the order of the file.
  const std::vector<std::string>& names() const noexcept { return names_; }
  /// Names of volumes whose table chooses a filter.
  std::vector<std::string> with_filter() const;
  /// Opens what was planned and adds it to `scene`; appends warnings. Throws SceneError.
  void open(Scene& scene, std::vector<std::string>& warnings) const;

 private:
  VolumePlan plan_volume(const std::string& name, const toml::table& table) const;
  void check_given() const;
  void find_data(const Section& section, VolumePlan& plan) const;
  std::vector<std::filesystem::path> candidates_of(const std::filesystem::path& path) const;
  std::filesystem::path find_file(const std::string& file, const Section& section) const;
  std::vector<std::filesystem::path> find_files(const std::string& pattern, const Section& section) const;
  const Volume& given(const VolumePlan& plan) const;
  Volume data_of(const VolumePlan& plan) const;
  void open(const VolumePlan& plan, Scene& scene, std::vector<std::string>& warnings) const;

  const std::filesystem::path& folder_;
  const VolumeReader& read_volume_;
  const SceneOptions& options_;
  std::vector<VolumePlan> plans_;
  std::vector<std::string> names_;
};

}  // namespace palpa::detail::scene_file
