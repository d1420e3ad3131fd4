#include "palpa/field/labels.h"

#include <algorithm>

#include "palpa/field/grid_base.h"

namespace palpa {

bool looks_like_labels(const Field& field, const Statistics& values) {
  const GridView* grid = grid_behind(field);
  const Histogram& h = values.histogram;
  constexpr double most_labels = 256;
  if (!grid || field.components() != 1 || !values.whole_numbers || values.min < 0.0 || values.max > 65535.0) return false;
  const auto filled =
      static_cast<double>(std::count_if(h.counts.begin(), h.counts.end(), [](std::int64_t n) { return n > 0; }));
  if (filled < 2.0 || filled > most_labels) return false;
  // Neighbours along i are nearly always of one part; of what was measured they nearly never have one value.
  std::int64_t pairs = 0, alike = 0;
  detail::with_values_of(grid->voxels, [&](const auto* voxels) {
    const auto& n = grid->geometry.dims;
    const std::int64_t rows = n[1] * n[2], step = 1 + rows / 4000;
    for (std::int64_t row = 0; row < rows; row += step) {
      for (std::int64_t i = 1; i < n[0]; ++i) {
        const auto here = voxels[row * n[0] + i], before = voxels[row * n[0] + i - 1];
        if (here == 0 && before == 0) continue;
        ++pairs, alike += here == before;
      }
    }
  });
  return pairs > 0 && static_cast<double>(alike) > 0.7 * static_cast<double>(pairs);
}

}  // namespace palpa
