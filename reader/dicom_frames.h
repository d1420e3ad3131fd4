// Which images of a stack make one volume: frames, each of one image from every place, all of one kind.
#pragma once

#include <string>
#include <vector>

#include "dicom_slices.h"

namespace palpa::reader {

struct Frames {
  std::vector<std::vector<Slice>> frames;  ///< of equally many slices, which rise along their normal
  std::string differ;  ///< what the frames differ in: "echo time (4.6, 9.2 ms) and complex component"; empty: in nothing
};

/// Sorts a stack into frames: by each attribute that tells images apart (dicom_traits.h), and images that only times or
/// counters tell apart by their order. Places images that say no position one behind the other. Frames that are not at all
/// places, and slices of one frame that differ in how they were made, are named in warnings. Throws LoadError where images at
/// one place are not to be told apart.
Frames frames_of(std::vector<Slice> stack, std::vector<std::string>& warnings);

}  // namespace palpa::reader
