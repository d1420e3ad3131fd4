// Coarse image of a scene's volume, for a client of OpenIGTLink.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "devices/igtl_messages.h"
#include "palpa/data/field.h"
#include "palpa/scene/scene.h"

namespace palpa::app {

/// IMAGE of a scalar field, sampled on a grid along the world's axes in steps, so that the thread that samples also does other
/// work. At most 256 voxels along each side, no finer than the field's own; int16 of values that it holds to within a
/// thousandth of their range, else float32; the least value where there are no data. A volume that changes is that of its first
/// moment; one that is larger than memory is its coarsest octave. Allocates; one thread.
class IgtlImage {
 public:
  /// Throws LoadError if the scene has no scalar field of that name.
  /// \param name  of a volume, or VOLUME.FIELD; empty: the first with a scalar field
  IgtlImage(const Scene& scene, std::string_view name);
  /// Samples the next slice. False: there is none any more.
  bool step();
  /// The whole message, after the last step.
  igtl::Bytes message();

 private:
  void sample(std::size_t i, std::size_t j, std::size_t k);

  std::string name_;
  FieldPtr field_;
  igtl::ImageGrid grid_;
  Vec3 first_m_, step_m_;  // [m, world]
  double least_ = 0.0;
  std::size_t slice_ = 0;
  std::uint64_t crc_ = 0;
  igtl::Bytes bytes_;
};

}  // namespace palpa::app
