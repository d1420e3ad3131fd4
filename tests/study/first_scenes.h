// Forces of a file's suggested first scene under a recorded hand.
#pragma once

#include <filesystem>
#include <string>

#include "palpa/file/read_volume.h"

namespace palpa::test {

struct FirstTouch {
  std::string scene;
  double contact_share = 0.0;  ///< [1] of the ticks, a mode pushes with more than 1 mN
  double below_limit_share =
      0.0;  ///< [1] of the ticks, the force is below the limit, or a level of greater strength pushes most
  double force_max_n = 0.0;
  double buzz_n = 0.0;  ///< peak to peak, the most of ten stops
  long faults = 0;      ///< ticks that were capped, had a bad input or a force that is not finite
};

/// Ten seconds of a recording, held firmly; then the probe's path once more, with a stop of 0.3 s after each second, whose last
/// 0.1 s are evaluated. Of vectors of length 1 in three frames: taken as one vector field. Throws LoadError.
FirstTouch first_touch(const std::filesystem::path& data, const std::filesystem::path& recording, const ReadOptions& read);

}  // namespace palpa::test
