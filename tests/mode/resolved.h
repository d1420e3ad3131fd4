// Field references as a session resolves them.
#pragma once

#include <cstdint>
#include <string>
#include <utility>

#include "palpa/mode/parameters.h"

namespace palpa::test {

/// A reference to these numbers of a field and of its companion.
inline FieldRef resolved(std::string name, std::int32_t field, std::int32_t companion = -1) {
  FieldRef ref(std::move(name));
  detail::field_numbers(ref) = {field, companion};
  return ref;
}

}  // namespace palpa::test
