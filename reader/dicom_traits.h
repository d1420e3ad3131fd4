// Attributes by which DICOM distinguishes the images of a series, other than positions.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

class vtkDICOMItem;
class vtkDICOMMetaData;

namespace palpa::reader {

/// Effect of an attribute in which images differ.
enum class Apart : std::uint8_t {
  kind,     ///< separate volumes
  setting,  ///< one volume, unless images at one position differ in it
  moment,   ///< a sequence at each position; may drift between positions
  number    ///< like `moment`, for counters and clocks, whose order is checked
};

struct Attribute {
  std::string_view name;
  std::string_view unit{};  ///< of its numbers
  Apart apart = Apart::kind;
  double tolerance = 0.0;       ///< [1] numbers: relative, directions: absolute; closer values are equal
  bool may_count = false;       ///< some programs count images in it: a distinct value for each image or position is no kind
  bool named_if_mixed = false;  ///< warns if the slices of a volume differ in it
};

/// Value of an attribute of an image: numbers or words.
struct Trait {
  int attribute = 0;
  std::vector<double> numbers{};
  std::string words{};
};

/// Number of attributes, and each attribute.
int attributes();
const Attribute& attribute(int number);

/// True if it counts the frames of files without functional groups, as in nuclear medicine.
bool counts_frames(int attribute);

/// Adds the elements of all traits to a header's query.
void add_traits_to(vtkDICOMItem& query);
/// Traits of a frame, in the order of the attributes.
std::vector<Trait> traits_of(vtkDICOMMetaData& headers, int file, int frame, int frames);

/// All other elements of a frame's functional groups, except positions, times, scales and identifiers: each element with its
/// tag, "(0018,9076)1\\2". Empty for other files.
std::vector<std::string> rest_of(vtkDICOMMetaData& headers, int file, int frame);

}  // namespace palpa::reader
