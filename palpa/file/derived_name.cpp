#include "palpa/file/derived_name.h"

namespace palpa {

std::string name_of(const DerivedArray& array) {
  std::string name = std::string(name_of(array.derivation)) + "_" + array.of;
  for (char& c : name) {
    const bool is_plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_';
    if (!is_plain) c = '_';
  }
  return name;
}

}  // namespace palpa
