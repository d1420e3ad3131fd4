// Each mode of a scene is checked once, where it enters.
#include <gtest/gtest.h>

#include "palpa/data/analytic.h"
#include "palpa/mode/modes.h"
#include "palpa/scene/load_scene.h"
#include "palpa/session/session.h"

namespace palpa {
namespace checked_once_test {

struct Counted {
  static constexpr auto type = "test.counted";
  static constexpr auto parameters() { return std::tuple{}; }
  static inline int checks = 0;
  std::string problem() const { return ++checks, std::string(); }
  void place(const ModeContext&, PrimitiveSink) const noexcept {}
};

TEST(CheckedOnce, ByTheSceneAndByNoSession) {
  Counted::checks = 0;
  Scene scene;
  scene.add("ball", sphere_field());
  scene.add("counted", Counted{});
  scene.add("thick", Viscosity{.strength_n = 1.0});
  EXPECT_EQ(Counted::checks, 1);
  const Session session(scene);
  scene.edit<Viscosity>("thick", [](auto& thick) { thick.strength_n = 2.0; });
  scene.edit<CouplingOptions>([](auto& coupling) { coupling.stiffness_n_per_m = 300.0; });
  const Session changed(scene);
  EXPECT_TRUE(scene.check().empty());
  EXPECT_EQ(Counted::checks, 1) << "of an edit of another part";
  scene.edit_mode("counted", [](SceneMode& mode) { mode.enabled = false; });
  EXPECT_EQ(Counted::checks, 2);
}

TEST(CheckedOnce, OfALoadedScene) {
  Counted::checks = 0;
  ModeCatalog modes = standard_modes();
  modes.add(Counted{});
  const LoadedScene loaded = parse_scene(
      "palpa = 1\n[volume.ball]\nanalytic = 'sphere'\n[[mode]]\nname = 'counted'\ntype = 'test.counted'\n", "s.toml", {},
      [](const VolumeRequest&) { return Volume{}; }, modes);
  const Session session(loaded.scene);
  EXPECT_EQ(Counted::checks, 1);
}

}  // namespace checked_once_test
}  // namespace palpa
