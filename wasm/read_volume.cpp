// Files of a scene: a module opens none.
#include "palpa/file/read_volume.h"

#include "palpa/base/load_error.h"

namespace palpa {

VolumeReader volume_reader(ReadOptions) {
  return [](const VolumeRequest& request) -> Volume {
    throw LoadError(request.files.front().string() + ": is not given; give the page this file, too");
  };
}

}  // namespace palpa
