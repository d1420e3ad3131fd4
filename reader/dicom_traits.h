// By which attributes the standard tells the images of a series apart, other than by their places.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

class vtkDICOMItem;
class vtkDICOMMetaData;

namespace palpa::reader {

/// How far images that differ in an attribute are apart.
enum class Apart : std::uint8_t {
  kind,     ///< they never make one volume
  setting,  ///< they make one volume, unless images at one place differ in it
  moment,   ///< images at one place follow one another in it; from place to place it may drift
  number    ///< the same, of counters and clocks, whose order has to be checked
};

struct Attribute {
  std::string_view name;
  std::string_view unit{};  ///< of its numbers
  Apart apart = Apart::kind;
  double tolerance = 0.0;       ///< [1] of a number, relative; of a direction, absolute: values no further apart are one
  bool may_count = false;       ///< some programs count images in it: a value for each image, or for each place, is no kind
  bool named_if_mixed = false;  ///< a volume of slices that differ in it gets a warning
};

/// What an image says of an attribute: numbers, or words.
struct Trait {
  int attribute = 0;
  std::vector<double> numbers{};
  std::string words{};
};

/// How many attributes there are, and each of them.
int attributes();
const Attribute& attribute(int number);

/// Whether it counts the frames of a file without functional groups, as nuclear medicine does.
bool counts_frames(int attribute);

/// Adds the elements that traits need to those that are read of a header.
void add_traits_to(vtkDICOMItem& query);
/// What a frame of a file says, in the order of the attributes.
std::vector<Trait> traits_of(vtkDICOMMetaData& headers, int file, int frame, int frames);

/// Everything else that the functional groups of a frame say, but places, times, scales and identifiers: each element with its
/// tag, "(0018,9076)1\\2". Empty for other files.
std::vector<std::string> rest_of(vtkDICOMMetaData& headers, int file, int frame);

}  // namespace palpa::reader
