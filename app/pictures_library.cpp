// Library palpa-pictures.so (pictures.h).
#include "app/check_picture.h"
#include "app/pictures.h"
#include "palpa/data/volume.h"
#include "palpa/version.h"
#include "palpa/view/map_picture.h"
#include "palpa/view/volume_picture.h"

namespace palpa::app {
namespace {

void draw_volume(const Volume& volume, std::size_t field, const Statistics& values, const std::string& what,
                 const std::filesystem::path& file, detail::Existing existing) {
  detail::write_whole(file, png_of(volume_picture(volume, field, values, what)), existing);
}

void draw_map(const Scene& scene, const ForceMap& map, const std::filesystem::path& file, detail::Existing existing) {
  detail::write_whole(file, png_of(map_picture(scene, map)), existing);
}

}  // namespace

extern "C" __attribute__((visibility("default"))) const Pictures palpa_pictures;
const Pictures palpa_pictures{version, write_report, draw_volume, draw_map, draw_check};

}  // namespace palpa::app
