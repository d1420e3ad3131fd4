// What a mode reads.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "palpa/mode/crossings.h"
#include "palpa/mode/mode.h"

namespace palpa {

/// The fields that a mode reads, by number, and where in their values it may set in.
struct ModeInputs {
  std::vector<std::int32_t> fields;        ///< once each
  std::int32_t main_field = -1;            ///< its parameter `field`
  std::vector<Threshold> watches;          ///< its levels, and the points of its strengths and masks
  std::vector<const Strength*> strengths;  ///< those of the mode that are functions; it outlives this
  bool onset_is_watched = false;           ///< where it places nothing, only a watch can make it place something
};

/// The number of a field, or of a derivation of it, in whoever holds the fields.
using NumberOfField = std::function<std::int32_t(const FieldRef&, std::optional<Derivation>)>;

/// Gives the references of a mode and of its masks the numbers of their fields. Allocates; throws what `number_of` throws.
ModeInputs resolve(Mode& mode, std::span<Mask> masks, const NumberOfField& number_of);

}  // namespace palpa
