#include "palpa/data/same_data.h"

#include <algorithm>

#include "palpa/data/grid.h"

namespace palpa::detail {

namespace {

bool same_field(const Field& a, const Field& b) {
  const GridView *x = grid_behind(a), *y = grid_behind(b);
  return &a == &b || (x && y && x->geometry == y->geometry && x->voxels.data == y->voxels.data && x->scale == y->scale &&
                      x->offset == y->offset && x->filter == y->filter && x->signless == y->signless);
}

}  // namespace

bool same_data(const Volume& a, const Volume& b, bool same_origin) {
  const auto same_file = [](const SourceFile& x, const SourceFile& y) {
    return x.path == y.path && x.bytes == y.bytes && x.sha256 == y.sha256;
  };
  const auto same = [&](const VolumeField& x, const VolumeField& y) {
    return x.name == y.name && x.unit == y.unit && (same_origin || same_field(*x.field, *y.field));
  };
  return std::ranges::equal(a.files, b.files, same_file) && std::ranges::equal(a.fields, b.fields, same);
}

}  // namespace palpa::detail
