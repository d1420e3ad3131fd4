// Fields of a store's channels: scalars, and vectors where three channels are named as components.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace palpa::reader {

struct ZarrFields {
  struct Field {
    std::string name;
    std::vector<std::int64_t> channels;  ///< one, or those along x, y, z
  };
  std::vector<Field> fields;
  bool are_named = false;  ///< by the file
};

/// Fields of `count` channels with these labels, which may be fewer. Names differ. Allocates; any thread.
/// \param is_plain  of an array without labels: three channels are one vector
ZarrFields fields_of_channels(const std::vector<std::string>& labels, std::size_t count, bool is_plain);

}  // namespace palpa::reader
