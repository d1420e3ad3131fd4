// Requests above and at each limit.
#include "palpa/base/limits.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/resource.h>

#include <fstream>
#include <set>

#include "palpa/base/free_memory.h"
#include "palpa/trace/trace.h"
#include "tests/scene/scene_files.h"

namespace palpa {
namespace limits_test {

namespace fs = std::filesystem;
using test::error_of;
using test::parse;
using testing::AllOf;
using testing::HasSubstr;
using testing::StartsWith;

const std::string mode = "[[mode]]\nname = \"m\"\ntype = \"viscosity\"\nfield = \"v\"\nstrength_n = 1\n";
std::string scene_with(const std::string& volume) { return "palpa = 1\n[volume.v]\n" + volume + mode; }

/// "[ITEM(0), ITEM(1), …]".
template <class Item>
std::string list_of(std::size_t count, Item item) {
  std::string out = "[";
  for (std::size_t i = 0; i < count; ++i) out += (i ? ", " : "") + item(i);
  return out + "]";
}
std::string poses(std::size_t count) {
  return list_of(count, [](std::size_t i) { return "{time_s=" + std::to_string(i) + "}"; });
}
std::string points(std::size_t count) {
  return list_of(count, [](std::size_t i) { return "[" + std::to_string(i) + ",0]"; });
}

TEST(Limits, SayOfWhatHowManyWhyAndWhatWouldBeRight) {
  std::set<std::string_view> names;
  for (const Limit& limit : all_limits()) {
    EXPECT_TRUE(names.insert(limit.name).second) << limit.name;
    EXPECT_GE(limit.most, 1.0) << limit.name;
    for (const std::string_view words : {limit.unit, limit.of_what, limit.protects, limit.remedy})
      EXPECT_FALSE(words.empty()) << limit.name;
    EXPECT_FALSE(limit.is_passed_by(limit.most));
    EXPECT_TRUE(limit.is_passed_by(limit.most + 1.0));
    EXPECT_TRUE(limit.is_passed_by(std::numeric_limits<double>::quiet_NaN()));
    EXPECT_THAT(more_than(limit), AllOf(StartsWith("more than " + quantity(limit) + "; "), HasSubstr(limit.remedy)));
  }
  EXPECT_EQ(quantity(limit::scene_bytes), "4 MiB");
  EXPECT_EQ(quantity(limit::modes), "1000 modes");
}

TEST(FreeMemory, IsNoMoreThanTheProcessMayTake) {
  const auto free_within = [](auto resource, rlim_t most) {
    rlimit before{};
    EXPECT_EQ(::getrlimit(resource, &before), 0);
    const rlimit limit{most, before.rlim_max};
    EXPECT_EQ(::setrlimit(resource, &limit), 0);
    const std::uint64_t free = detail::free_memory_bytes();
    EXPECT_EQ(::setrlimit(resource, &before), 0);
    return free;
  };
  const std::uint64_t all = detail::free_memory_bytes();
  constexpr std::uint64_t taken = 1 << 26;
  const std::vector<std::byte> memory(taken, std::byte{1});  // a process has more of its own
  EXPECT_LE(free_within(RLIMIT_AS, all / 2), all / 2 - taken);
  EXPECT_LE(free_within(RLIMIT_RSS, all / 2), all / 2 - taken);
}

// Each limit is broken by a scene with one item too many; a scene at the limit is read.
TEST(Limits, OfAScenesLists) {
  const auto sphere = [](const std::string& more) { return scene_with("analytic = \"sphere\"\n" + more); };
  const auto with_poses = [&](std::size_t count) { return sphere("poses = " + poses(count) + "\n"); };
  EXPECT_THAT(error_of(with_poses(limit::poses.count() + 1)),
              AllOf(StartsWith("s.toml:4:9: 'poses' in volume 'v' has "), HasSubstr(more_than(limit::poses))));
  EXPECT_EQ(parse(with_poses(limit::poses.count())).scene.volumes().front().poses.size(), limit::poses.count());

  const auto with_points = [&](std::size_t count) {
    return "palpa = 1\n[volume.v]\nanalytic = \"sphere\"\n[[mode]]\nname = \"m\"\ntype = \"viscosity\"\nfield = \"v\"\n"
           "strength_n = {of = \"v\", points = " +
           points(count) + "}\n";
  };
  EXPECT_THAT(error_of(with_points(limit::points.count() + 1)),
              AllOf(StartsWith("s.toml:8:34: 'points' in "), HasSubstr(more_than(limit::points))));
  EXPECT_EQ(error_of(with_points(limit::points.count())), "no error");

  const auto with_modes = [&](std::size_t count) {
    std::string text = "palpa = 1\n[volume.v]\nanalytic = \"sphere\"\n";
    for (std::size_t i = 0; i < count; ++i)
      text += "[[mode]]\nname = \"m" + std::to_string(i) + "\"\ntype = \"viscosity\"\nfield = \"v\"\nstrength_n = 1\n";
    return text;
  };
  EXPECT_THAT(error_of(with_modes(limit::modes.count() + 1)), HasSubstr("'mode' in the scene has " + more_than(limit::modes)));
  EXPECT_EQ(error_of(with_modes(limit::modes.count())), "no error");

  const auto with_levels = [&](std::size_t count) {
    std::string text =
        "palpa = 1\n[volume.v]\nanalytic = \"sphere\"\n[[mode]]\nname = \"m\"\n"
        "type = \"surface_and_friction\"\nfield = \"v\"\n";
    for (std::size_t i = 0; i < count; ++i) text += "[[mode.level]]\nvalue = " + std::to_string(i) + "\n";
    return text;
  };
  EXPECT_THAT(error_of(with_levels(limit::entries.count() + 1)),
              HasSubstr("'level' in mode 'm' has " + more_than(limit::entries)));
  EXPECT_EQ(error_of(with_levels(limit::entries.count())), "no error");

  const auto with_volumes = [&](std::size_t count) {
    std::string text = sphere("");
    for (std::size_t i = 1; i < count; ++i) text += "[volume.v" + std::to_string(i) + "]\nanalytic = \"sphere\"\n";
    return text;
  };
  EXPECT_THAT(error_of(with_volumes(limit::volumes.count() + 1)),
              HasSubstr("'volume' in the scene has " + more_than(limit::volumes)));
  EXPECT_EQ(error_of(with_volumes(limit::volumes.count())), "no error");

  const auto names = [](std::size_t i) { return '"' + std::to_string(i) + '"'; };
  EXPECT_THAT(error_of(scene_with("file = " + list_of(limit::volume_files.count() + 1, names) + "\n")),
              HasSubstr("'file' in volume 'v' has " + more_than(limit::volume_files)));
}

// 1000 grids of 400³ samples are 256 GB: refused before the first grid is made.
TEST(Limits, OfEmbeddedDataAsGridsAreSaidBeforeTheWorkBegins) {
  EXPECT_THAT(error_of(scene_with("analytic = \"beating_chamber\"\nsampled = 400\nframes = 1000\n")),
              AllOf(HasSubstr(": volume 'v': 1000 × "), HasSubstr(more_than(limit::samples))));
  EXPECT_THROW(sampled(beating_chamber(), 2000), std::invalid_argument);
}

// A component lies along an axis of the world: its derived fields change with every move of its volume, and the grids of the
// moments are the scene's cost.
TEST(Limits, OfWhatIsDerivedOfAVolumeThatMoves) {
  const auto moved = [](std::size_t count, const std::string& field) {
    return "palpa = 1\n[volume.v]\nanalytic = \"burgers_vortex\"\nsampled = 16\nposes = " + poses(count) +
           "\n[[mode]]\nname = \"m\"\ntype = \"gradient_force\"\nfield = \"" + field + "\"\nstrength_n = 1\n";
  };
  EXPECT_THAT(error_of(moved(100'000, "component_x(v)")),
              AllOf(StartsWith("s.toml:6:"), HasSubstr("99999 × "), HasSubstr(more_than(limit::derived_samples))));
  EXPECT_EQ(error_of(moved(3, "component_x(v)")), "no error");
  const FieldPtr still = moving(sampled(burgers_vortex(), 8).fields[0].field, {{0.0, {}}});
  EXPECT_NO_THROW(derived(Derivation::smooth, derived(Derivation::component_x, still))) << "of one pose there is one moment";
  EXPECT_EQ(error_of(moved(100'000, "magnitude(v)")), "no error") << "what turns with its volume is derived once";
}

TEST(Limits, OfAFilesSeries) {
  const fs::path folder = fs::temp_directory_path() / ("palpa-limits-" + std::to_string(::getpid()));
  fs::create_directories(folder);
  for (std::size_t i = 0; i <= limit::series_files.count(); ++i) std::ofstream(folder / ("p" + std::to_string(i) + ".vti"));
  EXPECT_THAT(error_of(scene_with("files = \"p*.vti\"\nframe_period_s = 1\n"), {}, folder),
              HasSubstr("'files' in volume 'v' matches " + more_than(limit::series_files)));
  fs::remove_all(folder);
}

}  // namespace limits_test
}  // namespace palpa
