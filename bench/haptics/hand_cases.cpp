// A recorded hand on smooth bodies.
#include <algorithm>
#include <cstdio>
#include <fstream>

#include "bench/haptics/cases.h"
#include "bench/haptics/shape.h"
#include "bench/haptics/surface_hands.h"
#include "palpa/base/load_error.h"

namespace palpa::haptics {

using nlohmann::json;

// The recorded hand at a tenth of its size and speed about a surface point of a plane, a ball and a torus (outside), where the
// nearest free point is known short of their centres.
void add_hand_cases(Suite& suite, const std::filesystem::path& hand_file) {
  std::ifstream file(hand_file);
  if (!file) throw LoadError(hand_file.string() + ": cannot be read; name the folder of the benchmark's sources");
  std::vector<std::pair<double, Vec3>> rows;
  for (std::string line; std::getline(file, line);) {
    double t_s = 0.0;
    Vec3 x;
    if (std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf", &t_s, &x.x, &x.y, &x.z) == 4) rows.emplace_back(t_s, x);
  }
  if (rows.size() < 2) throw LoadError(hand_file.string() + ": has no rows of t_s,x_m,y_m,z_m; take it from the sources anew");
  struct Place {
    const Body& body;
    Vec3 middle_m;  // of the hand's path
    double size;    // [1] of the recorded hand
  };
  for (const Place& place :
       {Place{plane, {0, 2e-3, 0}, 0.1}, Place{sphere, {0, 0.027, 0}, 0.1}, Place{torus, {0.031, 0, 0}, 0.08}}) {
    const Body& body = place.body;
    const Shape upright = [&] {
      json description = body.shape;
      description.erase("turn");
      return shape_of(description, {});
    }();
    Trajectory trajectory(turn_in(body.shape));
    const auto at = [&](const Vec3& probe) {
      const double depth_m = upright.depth_m(probe);
      trajectory.held(probe, depth_m > 0.0 ? probe + depth_m * upright.outward(probe) : probe);
    };
    std::size_t row = 0;
    for (int i = 0; time_step_s * i < rows.back().first; ++i) {
      const double t_s = time_step_s * i;
      while (rows[row + 1].first <= t_s) ++row;
      const double share = (t_s - rows[row].first) / (rows[row + 1].first - rows[row].first);
      const Vec3 hand = rows[row].second + share * (rows[row + 1].second - rows[row].second);
      const Vec3 probe = place.middle_m + place.size * hand;
      // From far outside to the recording's start.
      if (i == 0) {
        const Vec3 begin = probe + (0.010 + std::max(upright.depth_m(probe), 0.0)) * upright.outward(probe);
        for (int k = 0; k < 200; ++k) at(begin + (k / 200.0) * (probe - begin));
      }
      at(probe);
    }
    add_surface_case(suite, body, {},
                     {.name = "hand-" + body.name,
                      .family = "hands",
                      .shape = body.shape,
                      .scores = {"surface", "direction", "force", "lost", "ripple"},
                      .touches = std::move(trajectory.touches)});
  }
}

}  // namespace palpa::haptics
