// Grouping of a stack's images into frames of one volume: one image per position, all of one kind.
#pragma once

#include <string>
#include <vector>

#include "dicom_slices.h"

namespace palpa::reader {

struct Frames {
  std::vector<std::vector<Slice>> frames;  ///< with equal numbers of slices, in order along their normal
  std::string differ;  ///< difference between the frames: "echo time (4.6, 9.2 ms) and complex component"; empty: none
};

/// Sorts a stack into frames: by each attribute that distinguishes images (dicom_traits.h); images that differ only in times or
/// counters by their order. Images without a position are stacked in sequence. Warns of frames that lack positions, and of
/// slices of one frame with different acquisition. Throws LoadError if images at one position are indistinguishable.
Frames frames_of(std::vector<Slice> stack, std::vector<std::string>& warnings);

}  // namespace palpa::reader
