// Cache of derived fields.
#pragma once

#include <mutex>
#include <vector>

#include "palpa/data/derived.h"

namespace palpa::detail {

/// Derived fields by source; a short list, searched linearly.
class DerivedFields {
 public:
  /// Returns `derived` of these arguments, computed at the first request. Any thread; throws like `derived`.
  /// \param smoothing_m  [m] as there
  FieldPtr get(Derivation derivation, const FieldPtr& of, double smoothing_m);

 private:
  struct Entry {
    Derivation derivation;
    FieldPtr of;
    double smoothing_m;
    FieldPtr field;
  };
  std::mutex mutex_;
  std::vector<Entry> entries_;
};

}  // namespace palpa::detail
