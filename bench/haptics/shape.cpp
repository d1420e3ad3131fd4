#include "bench/haptics/shape.h"

#include <numbers>

#include "bench/haptics/volume.h"
#include "palpa/base/load_error.h"
#include "palpa/device/sine_cosine.h"
#include "tests/path/bumpy_sphere.h"

namespace palpa::haptics {

using nlohmann::json;

namespace {

Shape sphere(double radius_m) {
  return {[=](const Vec3& x) { return radius_m - norm(x); }, [](const Vec3& x) { return normalized(x); }};
}

Shape bumpy_sphere(double radius_m) {
  const test::BumpySphere body(radius_m);
  return {[=](const Vec3& x) {
            const double from_sphere_m = norm(x) - radius_m;  // the bumps are 0.05 radii high
            return std::abs(from_sphere_m) > 0.2 * radius_m ? -from_sphere_m : body.depth_m(x);
          },
          [=](const Vec3& x) { return body.normal(x); }};
}

Shape torus(double radius_m, double tube_m) {
  const auto from_ring = [=](const Vec3& x) { return x - radius_m * normalized(Vec3{x.x, x.y, 0}); };
  return {[=](const Vec3& x) { return tube_m - norm(from_ring(x)); }, [=](const Vec3& x) { return normalized(from_ring(x)); }};
}

Shape plate(double thickness_m) {
  return {[=](const Vec3& x) { return std::min(-x.y, x.y + thickness_m); },
          [=](const Vec3& x) {
            return Vec3{0, x.y > -0.5 * thickness_m ? 1.0 : -1.0, 0};
          }};
}

// Distance to a wedge: below 0 inside.
double beyond_wedge_m(const Vec3& x_m, const Faces& faces) {
  const double nearest_m = std::max(dot(faces.a, x_m), dot(faces.b, x_m));
  return nearest_m <= 0.0 ? nearest_m : distance(x_m, nearest_in_wedge(x_m, faces.a, faces.b));
}

Vec3 out_of_wedge(const Vec3& x_m, const Faces& faces) { return dot(faces.a, x_m) > dot(faces.b, x_m) ? faces.a : faces.b; }

Shape wedge(double opening_deg) {
  const auto [sine, cosine] = detail::sine_cosine(opening_deg / 360.0);
  const Faces faces{{0, 1, 0}, {sine, -cosine, 0}};
  return {[=](const Vec3& x) { return -beyond_wedge_m(x, faces); }, [=](const Vec3& x) { return out_of_wedge(x, faces); }};
}

// Here the free space is the wedge: its faces point into the solid.
Shape groove(double opening_deg) {
  const Faces faces = faces_of_groove(opening_deg);
  return {[=](const Vec3& x) {
            return beyond_wedge_m(x, {-faces.a, -faces.b});
          },
          [=](const Vec3& x) {
            return -out_of_wedge(x, {-faces.a, -faces.b});
          }};
}

Shape helix(double radius_m, double rise_m) {
  const auto off_m = [=](const Vec3& x) {
    if (rise_m == 0.0) return distance(x, radius_m * normalized(Vec3{x.x, x.y, 0}));
    // Newton's steps for the angle of the nearest point, from the equal height on the nearest turn.
    constexpr double whole_rad = 2.0 * std::numbers::pi;
    double angle_rad = std::atan2(x.y, x.x);
    angle_rad += whole_rad * std::round((x.z / rise_m - angle_rad) / whole_rad);
    const auto place = [&] { return Vec3{radius_m * std::cos(angle_rad), radius_m * std::sin(angle_rad), rise_m * angle_rad}; };
    for (int i = 0; i < 20; ++i) {
      const Vec3 at = place();
      const Vec3 along{-at.y, at.x, rise_m};
      angle_rad += dot(x - at, along) / norm_squared(along);
    }
    return distance(x, place());
  };
  return {[=](const Vec3& x) { return -off_m(x); }, {}};
}

// The region above a level in a measured volume.
Shape scan(const std::filesystem::path& file, double level) {
  const auto volume = std::make_shared<const SampledVolume>(read_nrrd(file));
  return {[=](const Vec3& x) {
            Vec3 on_level = x;
            for (int i = 0; i < 30; ++i) {
              const Vec3 slope = volume->slope_per_m(on_level);
              const double steep = std::max(norm_squared(slope), 1e-12);
              const Vec3 step = ((level - volume->value(on_level)) / steep) * slope;
              on_level += shortened(step, 0.5 * volume->grid.spacing_m.x);
              if (norm(step) < 1e-9) break;
            }
            const double depth = volume->value(x) >= level ? 1.0 : -1.0;
            return depth * distance(x, on_level);
          },
          [=](const Vec3& x) { return -normalized(volume->slope_per_m(x)); }};
}

Shape upright(const json& description, const std::filesystem::path& folder) {
  const std::string kind = description.at("kind");
  if (kind == "plane") return {[](const Vec3& x) { return -x.y; }, [](const Vec3&) { return Vec3{0, 1, 0}; }};
  if (kind == "sphere") return sphere(description.at("radius_m"));
  if (kind == "bumpy_sphere") return bumpy_sphere(description.at("radius_m"));
  if (kind == "torus") return torus(description.at("radius_m"), description.at("tube_m"));
  if (kind == "plate") return plate(description.at("thickness_m"));
  if (kind == "wedge") return wedge(description.at("opening_deg"));
  if (kind == "groove") return groove(description.at("opening_deg"));
  if (kind == "helix") return helix(description.at("radius_m"), description.at("rise_m"));
  if (kind == "scan") return scan(folder / std::string(description.at("file")), description.at("level"));
  throw LoadError("'" + kind + "': no shape is of this kind; it is one of those of bench/haptics/shape.h");
}

}  // namespace

Mat3 turn_of(const json& quaternion) {
  const double w = quaternion.at(0), x = quaternion.at(1), y = quaternion.at(2), z = quaternion.at(3);
  const double all = w * w + x * x + y * y + z * z;
  return {{Vec3{w * w + x * x - y * y - z * z, 2 * (x * y - w * z), 2 * (x * z + w * y)} / all,
           Vec3{2 * (x * y + w * z), w * w - x * x + y * y - z * z, 2 * (y * z - w * x)} / all,
           Vec3{2 * (x * z - w * y), 2 * (y * z + w * x), w * w - x * x - y * y + z * z} / all}};
}

Mat3 turn_in(const json& description) {
  return description.contains("turn") ? turn_of(description.at("turn")) : Mat3::identity();
}

Shape shape_of(const json& description, const std::filesystem::path& folder) {
  const Shape own = upright(description, folder);
  if (!description.contains("turn")) return own;
  const Mat3 turn = turn_in(description), back = transposed(turn);
  Shape turned{[=](const Vec3& x) { return own.depth_m(back * x); }, {}};
  if (own.outward) turned.outward = [=](const Vec3& x) { return turn * own.outward(back * x); };
  return turned;
}

Vec3 nearest_in_wedge(const Vec3& x_m, const Vec3& outward_a, const Vec3& outward_b) {
  const double before_a_m = dot(outward_a, x_m), before_b_m = dot(outward_b, x_m);
  if (before_a_m <= 0.0 && before_b_m <= 0.0) return x_m;
  const Vec3 on_a = x_m - before_a_m * outward_a, on_b = x_m - before_b_m * outward_b;
  if (before_a_m > 0.0 && dot(outward_b, on_a) <= 0.0) return on_a;
  if (before_b_m > 0.0 && dot(outward_a, on_b) <= 0.0) return on_b;
  return {0, 0, x_m.z};
}

Faces faces_of_groove(double opening_deg) {
  const auto [sine, cosine] = detail::sine_cosine(0.5 * opening_deg / 360.0);
  return {{cosine, sine, 0}, {-cosine, sine, 0}};
}

}  // namespace palpa::haptics
