#include "app/igtl_image.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

#include "palpa/base/load_error.h"
#include "palpa/base/wording.h"

namespace palpa::app {
namespace {

/// The first scalar field of that name, with its volume's.
std::pair<std::string, FieldPtr> field_in(const Scene& scene, std::string_view name) {
  for (const SceneVolume& volume : scene.volumes()) {
    for (const VolumeField& field : volume.volume.fields) {
      const bool is_meant = name.empty() || name == volume.name || name == volume.name + '.' + field.name;
      if (is_meant && field.field->components() == 1) return {volume.name, field.field};
    }
  }
  throw LoadError(name.empty() ? "the scene has no scalar volume, and an image is of one"
                               : "no scalar volume " + detail::in_quotes(name) + "; ask with a volume's name, or without");
}

/// The world is LPS: x to the patient's left, y to the back, z to the head.
Vec3 ras_mm(const Vec3& world_m) { return {-1e3 * world_m.x, -1e3 * world_m.y, 1e3 * world_m.z}; }

template <class Number>
void append(igtl::Bytes& to, Number number) {
  static_assert(std::endian::native == std::endian::little, "voxels are little endian");
  const auto bytes = std::bit_cast<std::array<std::byte, sizeof(Number)>>(number);
  to.insert(to.end(), bytes.begin(), bytes.end());
}

}  // namespace

IgtlImage::IgtlImage(const Scene& scene, std::string_view name) {
  constexpr double most = 256.0;       // [voxels] More: longer to send; fewer: coarser
  constexpr double least_range = 1e3;  // in steps of int16. Less: rounding is seen; more: twice the bytes
  std::tie(name_, field_) = field_in(scene, name);
  const Box box = field_->bounds_m();
  const Vec3 size_m = box.size_m();
  const double step_m = std::max(field_->spacing_m(), largest_component(size_m) / (most - 1.0));
  const auto voxels = [&](double length_m) {
    return static_cast<std::uint16_t>(std::clamp(std::floor(length_m / step_m + 1e-6) + 1.0, 1.0, most));
  };
  grid_.dims = {voxels(size_m.x), voxels(size_m.y), voxels(size_m.z)};
  const Vec3 way_m = step_m * Vec3{grid_.dims[0] - 1.0, grid_.dims[1] - 1.0, grid_.dims[2] - 1.0};
  first_m_ = box.centre_m() - 0.5 * way_m;
  step_m_ = {step_m, step_m, step_m};
  grid_.step_mm = ras_mm(step_m_);
  grid_.centre_mm = ras_mm(box.centre_m());
  const ValueRange range = field_->value_ranges().front();
  constexpr std::numeric_limits<std::int16_t> int16;
  grid_.is_float = !(range.min >= int16.min() && range.max <= int16.max() && range.max - range.min >= least_range);
  least_ = range.min;
  const igtl::Bytes head = igtl::image_head(grid_);
  const std::size_t voxel_bytes = grid_.is_float ? sizeof(float) : sizeof(std::int16_t);
  const std::size_t all = std::size_t{grid_.dims[0]} * grid_.dims[1] * grid_.dims[2];
  bytes_.reserve(igtl::head_bytes + head.size() + all * voxel_bytes);
  bytes_.resize(igtl::head_bytes);
  bytes_.insert(bytes_.end(), head.begin(), head.end());
  crc_ = igtl::crc64(head);
}

void IgtlImage::sample(std::size_t i, std::size_t j, std::size_t k) {
  const Vec3 at_m = first_m_ + Vec3{static_cast<double>(i) * step_m_.x, static_cast<double>(j) * step_m_.y,
                                    static_cast<double>(k) * step_m_.z};
  const ScalarSample found = field_->scalar(at_m);
  const double value = found.inside ? found.value : least_;
  if (grid_.is_float) return append(bytes_, static_cast<float>(value));
  constexpr std::numeric_limits<std::int16_t> int16;
  append(bytes_, static_cast<std::int16_t>(std::lround(std::clamp<double>(value, int16.min(), int16.max()))));
}

bool IgtlImage::step() {
  if (slice_ == grid_.dims[2]) return false;
  const std::size_t before = bytes_.size();
  for (std::size_t j = 0; j < grid_.dims[1]; ++j)
    for (std::size_t i = 0; i < grid_.dims[0]; ++i) sample(i, j, slice_);
  crc_ = igtl::crc64(std::span<const std::byte>(bytes_).subspan(before), crc_);
  ++slice_;
  return true;
}

igtl::Bytes IgtlImage::message() {
  const igtl::Bytes head = igtl::head_for("IMAGE", name_, bytes_.size() - igtl::head_bytes, crc_);
  std::ranges::copy(head, bytes_.begin());
  return std::move(bytes_);
}

}  // namespace palpa::app
