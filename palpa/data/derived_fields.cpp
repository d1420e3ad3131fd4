#include "palpa/data/derived_fields.h"

namespace palpa::detail {

FieldPtr DerivedFields::get(Derivation derivation, const FieldPtr& of, double smoothing_m) {
  const std::lock_guard lock(mutex_);
  for (const Entry& entry : entries_) {
    if (entry.derivation == derivation && entry.of == of && entry.smoothing_m == smoothing_m) return entry.field;
  }
  entries_.push_back({derivation, of, smoothing_m, derived(derivation, of, smoothing_m)});
  return entries_.back().field;
}

}  // namespace palpa::detail
