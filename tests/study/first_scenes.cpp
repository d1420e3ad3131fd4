#include "tests/study/first_scenes.h"

#include <algorithm>

#include "palpa/device/hand.h"
#include "palpa/file/directions.h"
#include "palpa/loop/loop.h"
#include "palpa/scene/first_scene.h"
#include "palpa/scene/load_scene.h"
#include "palpa/study/summary.h"
#include "palpa/study/unyielding.h"

namespace palpa::test {

FirstTouch first_touch(const std::filesystem::path& data, const std::filesystem::path& recording, const ReadOptions& read) {
  constexpr double duration_s = 10.0, dt_s = 1e-3;
  VolumeRequest request;
  request.files = {data};
  FirstTouch touch;
  VolumeFile file = read_volume_file(request, read);
  if (const auto directions = as_directions(request, file, read)) {
    request = *directions;
    file = read_volume_file(request, read);
  }
  touch.scene = first_scene(file.volume, request);
  const Scene scene = parse_scene(touch.scene, "first.toml", {}, volume_reader(read), standard_modes()).scene;

  const auto levels = unyielding_levels(scene, scene.coupling().max_force_n);
  const auto is_on_what_holds = [&](const Session& felt) {
    const auto pushes_n = [](const ModeForce& mode) { return norm(mode.force_n); };
    const auto most = std::ranges::max_element(felt.modes(), {}, pushes_n) - felt.modes().begin();
    return std::ranges::find(levels, static_cast<std::size_t>(most), &UnyieldingLevel::mode) != levels.end();
  };
  std::vector<Probe> path;
  SummaryBuilder builder(scene);
  std::int64_t below = 0;
  Session session(scene);
  const auto hand = open_hand(recording.string(), Hold::firm);
  run_simulated(session, *hand, {.duration_s = duration_s, .time_ticks = false}, nullptr,
                [&](const TickFrame& frame, const Session& felt) {
                  builder.add(frame, felt);
                  below += norm(frame.result.force_n) < scene.coupling().max_force_n || is_on_what_holds(felt);
                  path.push_back({.position_m = frame.result.probe_m});
                });
  const Summary summary = builder.finish(1.0);
  touch.contact_share = summary.contact_share;
  touch.force_max_n = summary.force_max_n;
  touch.below_limit_share = static_cast<double>(below) / static_cast<double>(summary.ticks);
  touch.faults = static_cast<long>(summary.faults + summary.capped_ticks + summary.bad_input_ticks);

  Session again(scene);
  for (std::size_t n = 0; n < path.size(); ++n) {
    again.tick(path[n], dt_s);
    if (n % 1000 != 999) continue;
    Vec3 low_n{1e9, 1e9, 1e9}, high_n = -low_n;
    for (int still = 0; still < 300; ++still) {
      const Vec3 f = again.tick(path[n], dt_s).force_n;
      if (still < 200) continue;
      low_n = {std::min(low_n.x, f.x), std::min(low_n.y, f.y), std::min(low_n.z, f.z)};
      high_n = {std::max(high_n.x, f.x), std::max(high_n.y, f.y), std::max(high_n.z, f.z)};
    }
    touch.buzz_n = std::max(touch.buzz_n, norm(high_n - low_n));
  }
  return touch;
}

}  // namespace palpa::test
