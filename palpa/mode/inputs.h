// Fields and thresholds of a mode.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <span>
#include <vector>

#include "palpa/mode/crossings.h"
#include "palpa/mode/mode.h"

namespace palpa {

/// Fields that a mode reads, by number, and thresholds of their values.
struct ModeInputs {
  std::vector<std::int32_t> fields;        ///< without duplicates
  std::int32_t main_field = -1;            ///< its parameter `field`
  std::vector<Threshold> watches;          ///< levels, and points of strengths and masks
  std::vector<const Strength*> strengths;  ///< strengths of the mode that are functions; the mode outlives this
  bool onset_is_watched = false;           ///< a mode without primitives can set in only at a watch
};

/// Number of a field, or of its derivation.
using NumberOfField = std::function<std::int32_t(const FieldRef&, std::optional<Derivation>)>;

/// Resolves the field references of a mode and its masks. Allocates; throws the exceptions of `number_of`.
ModeInputs resolve(Mode& mode, std::span<Mask> masks, const NumberOfField& number_of);

}  // namespace palpa
