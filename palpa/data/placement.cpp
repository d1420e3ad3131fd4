#include "palpa/data/placement.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace palpa {
namespace {

double degrees(double cosine) { return std::acos(std::clamp(cosine, 0.0, 1.0)) * 180.0 / std::numbers::pi; }

}  // namespace

Placement placement_of(const Volume& volume) {
  static constexpr const char* patient[] = {
      "the patient's left (L)", "the patient's right (R)", "the back (P)", "the front (A)", "the head (S)", "the feet (I)"};
  static constexpr const char* letters[] = {"L", "R", "P", "A", "S", "I"};
  static constexpr const char* axes[] = {"+x", "-x", "+y", "-y", "+z", "-z"};
  Placement placed;
  placed.grid = grid_of(*volume.fields.front().field)->geometry;
  const Mat3 steps = transposed(placed.grid.index_to_world_m);
  double* spacing_m[] = {&placed.spacing_m.x, &placed.spacing_m.y, &placed.spacing_m.z};
  double* size_m[] = {&placed.size_m.x, &placed.size_m.y, &placed.size_m.z};
  Vec3 along[3];
  for (int a = 0; a < 3; ++a) {
    *spacing_m[a] = norm(steps.row[a]);
    *size_m[a] = *spacing_m[a] * static_cast<double>(placed.grid.dims[static_cast<std::size_t>(a)]);
    along[a] = normalized(steps.row[a]);
    const double parts[] = {along[a].x, along[a].y, along[a].z};
    const auto nearest = std::max_element(parts, parts + 3, [](double x, double y) { return std::abs(x) < std::abs(y); });
    const auto direction = 2 * static_cast<std::size_t>(nearest - parts) + (*nearest < 0.0 ? 1 : 0);
    placed.towards[static_cast<std::size_t>(a)] = volume.medical_frame ? patient[direction] : axes[direction];
    placed.letters += volume.medical_frame ? letters[direction] : (a > 0 ? " " : "") + std::string(axes[direction]);
    placed.oblique_deg = std::max(placed.oblique_deg, degrees(std::abs(*nearest)));
  }
  for (int a = 0; a < 3; ++a) {
    placed.sheared_deg = std::max(placed.sheared_deg, 90.0 - degrees(std::abs(dot(along[a], along[(a + 1) % 3]))));
  }
  placed.mirrored = dot(cross(along[0], along[1]), along[2]) < 0.0;
  return placed;
}

}  // namespace palpa
