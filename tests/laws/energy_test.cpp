// Energy table of every shipped scene under several hands and at two rates, recomputed from its trace's files alone.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "palpa/device/hand.h"
#include "palpa/palpa.h"
#include "palpa/study/energy_table.h"
#include "palpa/study/run.h"
#include "palpa/study/summary.h"
#include "tests/laws/shipped_scenes.h"
#include "tests/laws/trace_check.h"
#include "tests/today.h"

namespace palpa {
namespace energy_test {

namespace fs = std::filesystem;
using Entries = std::map<std::string, double>;

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr double share_of_time = 0.1;  // a sanitizer checks every access, so fewer ticks suffice
#else
constexpr double share_of_time = 1.0;
#endif

struct Table {
  Entries in, out;
};

double sum_of(const Entries& entries) {
  double sum_j = 0.0;
  for (const auto& [key, energy_j] : entries) sum_j += energy_j;
  return sum_j;
}

double largest_of(const Table& table) {
  double largest_j = 0.0;
  for (const Entries* side : {&table.in, &table.out}) {
    for (const auto& [key, energy_j] : *side) largest_j = std::max(largest_j, std::abs(energy_j));
  }
  return largest_j;
}

struct Row {
  bool usable = false;
  Vec3 probe_m, proxy_m, force_n, command_n;
  double stored_j = 0.0, elastic_j = 0.0;

  explicit Row(const test::CsvRows& ticks)
      : usable(ticks.integer("probe_valid") == 1 && ticks.text("status") != "bad_input"),
        probe_m(ticks.vector("probe", "m")),
        proxy_m(ticks.vector("proxy", "m")),
        force_n(ticks.vector("force", "n")),
        command_n(ticks.vector("command", "n")),
        stored_j(ticks.number("stored_j")),
        elastic_j(ticks.number("elastic_j")) {}
};

/// The spring's stiffness at the largest extension; 0 without an extension.
double stiffness_of(const fs::path& trace) {
  double k = 0.0, most_j = 0.0;
  for (test::CsvRows ticks(trace / "ticks.csv"); ticks.next();) {
    const Row row(ticks);
    if (row.stored_j <= most_j) continue;
    most_j = row.stored_j;
    k = 2.0 * row.stored_j / norm_squared(row.proxy_m - row.probe_m);
  }
  return k;
}

/// Loss of each tick's moves where the proxy outran the hand and the data took the energy, from balances.csv and, for moving
/// data, works.csv (docs/trace.md, Energy).
std::map<std::int64_t, double> released_j(const fs::path& trace) {
  std::map<std::pair<std::int64_t, std::int64_t>, double> carried_m;
  if (fs::exists(trace / "works.csv")) {
    for (test::CsvRows works(trace / "works.csv"); works.next();) {
      double& most_m = carried_m[{works.integer("tick"), works.integer("sub_step")}];
      most_m = std::max(most_m, norm(works.vector("carried", "m")));
    }
  }
  std::map<std::int64_t, double> lost_j;
  Vec3 last_probe_m;
  double left_m2 = 0.0;
  std::int64_t tick = -1;
  for (test::CsvRows balances(trace / "balances.csv"); balances.next();) {
    const Vec3 probe_m = balances.vector("probe", "m"), start_m = balances.vector("start", "m");
    const Vec3 proxy_m = balances.vector("proxy", "m"), balance_m = balances.vector("balance", "m");
    if (tick < 0) last_probe_m = probe_m;
    if (balances.integer("tick") != tick) left_m2 = 0.0;
    if (probe_m != last_probe_m) left_m2 = norm_squared(probe_m - last_probe_m);
    tick = balances.integer("tick");
    last_probe_m = probe_m;
    const double way_m =
        std::sqrt(left_m2) + balances.number("move_fraction") * carried_m[{tick, balances.integer("sub_step")}];
    const double moved_m2 = std::max(0.0, 2.0 * dot(proxy_m - start_m, balance_m - 0.5 * (start_m + proxy_m)));
    const double beyond_m = std::max(0.0, std::sqrt(moved_m2) - way_m);
    lost_j[tick] += 0.5 * balances.number("k_n_per_m") * beyond_m * beyond_m;
    left_m2 = std::max(0.0, way_m * way_m - moved_m2);
  }
  return lost_j;
}

/// The whole table, from positions, forces and the modes' works by the plain definitions.
Table worked_out(const fs::path& trace) {
  const double k = stiffness_of(trace);
  const bool primitives = fs::exists(trace / "balances.csv");
  std::map<std::int64_t, double> released = primitives ? released_j(trace) : std::map<std::int64_t, double>{};

  Table table;
  table.in = {{"hand", 0.0}, {"guard_held_back", 0.0}, {"data", 0.0}, {"ticks", 0.0}};
  table.out = {{"let_go", 0.0}, {"damper", 0.0}, {"spring", 0.0}};
  std::map<std::int64_t, double> works_j;
  for (test::CsvRows modes(trace / "modes.csv"); modes.next();) {
    const double work_j = modes.number("injected_j") - modes.number("dissipated_j");
    table.out[std::string(modes.text("mode"))] -= work_j;
    works_j[modes.integer("tick")] += work_j;
  }
  std::optional<Row> last;
  for (test::CsvRows ticks(trace / "ticks.csv"); ticks.next();) {
    const std::int64_t tick = ticks.integer("tick");
    const Row row(ticks);
    const bool goes_on = row.usable && last && last->usable;
    // A reset of the proxy to the probe discards the energy of spring and elastic levels.
    const double lost_j = goes_on || !last ? 0.0 : last->stored_j + last->elastic_j;
    const double took_j = row.elastic_j - (goes_on ? last->elastic_j : 0.0);
    double snapped_j = ticks.number("let_go_j") - lost_j;
    if (primitives) {
      EXPECT_NEAR(snapped_j, released[tick], 1e-15) << ticks.place();
      snapped_j = released[tick];
    }
    table.out["let_go"] += lost_j + snapped_j;
    table.out["spring"] = row.stored_j;
    table.out["elastic_levels"] = row.elastic_j;
    table.in["data"] += ticks.number("moved_j");
    if (row.usable) {
      const Vec3 step_m = goes_on ? row.probe_m - last->probe_m : Vec3{};
      const Vec3 from_m = goes_on ? last->proxy_m : row.probe_m;
      if (goes_on) {
        table.in["hand"] -= dot(last->command_n, step_m);
        table.in["guard_held_back"] -= dot(last->force_n - last->command_n, step_m);
        table.out["damper"] -= dot(last->force_n - k * (last->proxy_m - last->probe_m), step_m);
      }
      const double gained_j = k * dot(row.proxy_m - from_m, 0.5 * (row.proxy_m + from_m) - row.probe_m);
      table.in["ticks"] +=
          gained_j - works_j[tick] + took_j - ticks.number("moved_j") + 0.5 * k * norm_squared(step_m) + snapped_j;
    }
    last = row;
  }
  if (table.out["elastic_levels"] == 0.0) table.out.erase("elastic_levels");
  return table;
}

Table table_of(const Summary& summary) {
  const nlohmann::json json = nlohmann::json::parse(to_json(summary))["energy_j"];
  return {json["in"].get<Entries>(), json["out"].get<Entries>()};
}

class EnergyOfScene : public testing::TestWithParam<std::string> {
 protected:
  const fs::path folder_ = fs::temp_directory_path() / ("palpa-energy-" + GetParam() + "-" + std::to_string(::getpid()));
  void SetUp() override { fs::remove_all(folder_); }
  void TearDown() override { fs::remove_all(folder_); }
};

TEST_P(EnergyOfScene, ClosesAndIsThatOfTheFilesAlone) {
  if (const std::string missing = test::missing_for(GetParam()); !missing.empty()) GTEST_SKIP() << missing;
  const bool phantom = GetParam().ends_with("_phantom");
  const fs::path recorded = test::shared_data() / "trajectories/inverse3_woodcarving_20231121_102837.csv";
  std::vector<std::pair<std::string, std::optional<Hold>>> hands{{"sim:stroke", {}}, {"sim:helix", {}}};
  if (fs::exists(recorded)) {
    hands.emplace_back(recorded.string(), Hold::rigid);
    hands.emplace_back(recorded.string(), Hold::firm);
  }
  RunOptions options;
  options.scene = test::scene_file(GetParam());
  options.read.reader = test::reader();
  options.scene_options.data_folders = {test::shared_data_folder()};
  const LoadedScene loaded =
      load_scene(options.scene, volume_reader(options.read), standard_modes(), options.scene_options);  // once for all runs
  std::printf("%-13s %-11s %7s | %10s %10s %9s | %9s %9s %9s\n", "scene", "hand", "rate/Hz", "in/mJ", "out/mJ", "differ/J",
              "ticks/mJ", "bound/mJ", "letgo/mJ");
  // Each day the scenes share the eight pairs of hand and rate.
  const std::vector<std::string> scenes = test::shipped_scenes();
  auto number = std::ranges::find(scenes, GetParam()) - scenes.begin();
  for (const auto& [hand, hold] : hands) {
    for (const double rate_hz : {1000.0, 4000.0}) {
      if (!test::is_of_today(number++, 4)) continue;
      fs::remove_all(folder_);
      options.hand = hand;
      options.hold = hold;
      options.rate_hz = rate_hz;
      options.duration_s = share_of_time * (hold ? 8.0 : 4.0);  // the recording presses through at 6 s
      options.out = folder_;
      options.primitives = phantom && !hold;
      const Summary summary = run(prepare(loaded, options), options).summary;

      const Table claimed = table_of(summary), found = worked_out(folder_);
      const std::string name = hold ? *hold == Hold::firm ? "rec. firm" : "rec. rigid" : hand;
      SCOPED_TRACE(name + ", " + std::to_string(rate_hz) + " Hz");
      const double in_j = sum_of(claimed.in), out_j = sum_of(claimed.out), largest_j = largest_of(claimed);
      std::printf("%-13s %-11s %7.0f | %10.4f %10.4f %9.1e | %9.4f %9.4f %9.4f\n", GetParam().c_str(), name.c_str(), rate_hz,
                  1e3 * in_j, 1e3 * out_j, std::abs(in_j - out_j), 1e3 * claimed.in.at("ticks"),
                  1e3 * energy_table(summary).sampling_bound_j, 1e3 * claimed.out.at("let_go"));
      EXPECT_NEAR(in_j, out_j, 1e-9 + 1e-6 * largest_j);
      EXPECT_NEAR(sum_of(found.in), sum_of(found.out), 1e-9 + 1e-6 * largest_j);
      for (const auto& [ours, theirs] : {std::pair{&claimed.in, &found.in}, std::pair{&claimed.out, &found.out}}) {
        EXPECT_EQ(ours->size(), theirs->size());
        for (const auto& [key, energy_j] : *ours) {
          ASSERT_TRUE(theirs->contains(key)) << key;
          EXPECT_NEAR(energy_j, theirs->at(key), 1e-11 + 1e-9 * largest_j) << key;
        }
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, EnergyOfScene, testing::ValuesIn(test::shipped_scenes()),
                         [](const auto& scene) { return scene.param; });

}  // namespace energy_test
}  // namespace palpa
