// Fields that are derived from others, kept.
#pragma once

#include <mutex>
#include <vector>

#include "palpa/data/derived.h"

namespace palpa::detail {

/// Derived fields by what they derive from. A few: looked through in order.
class DerivedFields {
 public:
  /// `derived` of these, computed the first time that it is asked for. Any thread; throws what `derived` throws.
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
