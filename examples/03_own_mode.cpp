// A custom mode: four members and one function, no registration; and a custom field.
//
// A hill that rises towards its middle: motion up the field is free, motion down has to overcome a strength. The hand feels a
// one-way road.
#include <palpa/palpa.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>
#include <vector>

// Height above the rim: size - |x| [m], over a cube about the origin.
class Hill final : public palpa::Field {
 public:
  int components() const noexcept override { return 1; }
  palpa::ScalarSample scalar(const palpa::Vec3& world_m) const noexcept override {
    const double r_m = norm(world_m);
    if (!(depth_m(world_m) >= 0.0)) return {};  // no data
    return {.value = size_m - r_m, .gradient = r_m > 0.0 ? -world_m / r_m : palpa::Vec3{}, .inside = true};
  }
  double spacing_m() const noexcept override { return size_m / 32; }
  palpa::Box bounds_m() const noexcept override { return {{-size_m, -size_m, -size_m}, {size_m, size_m, size_m}}; }
  double depth_m(const palpa::Vec3& x) const noexcept override {
    return size_m - std::max({std::abs(x.x), std::abs(x.y), std::abs(x.z)});
  }
  std::vector<palpa::ValueRange> value_ranges() const override { return {{size_m - std::sqrt(3.0) * size_m, size_m}}; }

 private:
  static constexpr double size_m = 0.05;
};

struct Ridge {
  static constexpr auto type = "lab.ridge";
  palpa::FieldRef field;
  palpa::Strength strength_n{1.0};
  static constexpr auto parameters() {
    return std::tuple{palpa::param("field", &Ridge::field, "scalar field to feel"),
                      palpa::param("strength_n", &Ridge::strength_n, "force that holds the hand", palpa::Range{0, 10})};
  }
  void place(const palpa::ModeContext& here, palpa::PrimitiveSink out) const noexcept {
    const auto sample = here.scalar(field);
    if (!sample.inside || norm(sample.gradient) == 0) return;
    out.plane(0, here.proxy_m, normalized(sample.gradient), here.newtons(strength_n));
  }
};

int main() {
  constexpr double strength_n = 0.6;
  palpa::Scene scene({.stiffness_n_per_m = 400});
  palpa::Volume volume{.format = "formula"};
  volume.fields.push_back({.name = "height", .unit = "m", .field = std::make_shared<Hill>()});
  const palpa::FieldRef hill = scene.add("hill", volume);
  scene.add("ridge", Ridge{.field = hill, .strength_n = strength_n});
  palpa::Session session(scene);

  const palpa::Similarity map = session.hand_to_world();
  const palpa::Vec3 outwards = map.direction_to_hand({1, 0, 0});
  palpa::Vec3 hand_m = map.to_hand({0.04, 0, 0});
  const auto stroke = [&](double step_m) {
    double most_n = 0.0;
    for (int i = 0; i < 200; ++i) {
      hand_m += step_m * outwards;
      most_n = std::max(most_n, norm(session.tick({.position_m = hand_m}, 1e-3).force_n));
    }
    return most_n;
  };
  const double up_n = stroke(-5e-5);
  const double down_n = stroke(5e-5);
  std::printf("towards the middle: %.3f N at most\naway from it:       %.3f N at most\n", up_n, down_n);
  return up_n < 1e-6 && std::abs(down_n - strength_n) < 1e-3 ? 0 : 1;
}
