#include "palpa/core/similarity.h"

namespace palpa {

bool is_usable(const Similarity& map) noexcept {
  if (!std::isfinite(map.scale) || !(map.scale > 0.0) || !is_finite(map.translation_m) || !is_finite(map.rotation))
    return false;
  const Mat3 gram = map.rotation * transposed(map.rotation);
  const Mat3 one = Mat3::identity();
  for (int i = 0; i < 3; ++i) {
    if (largest_component(gram.row[i] - one.row[i]) > 1e-9) return false;
  }
  return determinant(map.rotation) > 0.0;
}

}  // namespace palpa
