// Names of fields that are derived from those of stores.
#pragma once

#include <string>

#include "palpa/data/derived.h"

namespace palpa {

/// Field to derive from another of a store.
struct DerivedArray {
  Derivation derivation = Derivation::q;
  std::string of;  ///< field of the store
};

/// Name of the derived field, and of its folder: "q_velocity".
std::string name_of(const DerivedArray& array);

}  // namespace palpa
