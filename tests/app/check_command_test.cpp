// palpa check from the shell: exit codes, output files, unchanged inputs.
#include <gmock/gmock.h>

#include <cstdio>
#include <nlohmann/json.hpp>

#include "program.h"

namespace palpa {
namespace check_command_test {

using nlohmann::json;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::StartsWith;

class CheckCommand : public ProgramTest {
 protected:
  void write_ball(const std::string& name, const std::string& stiffness_n_per_m, const std::string& damping_ns_per_m) const {
    write(name, text_of_ball(stiffness_n_per_m, damping_ns_per_m));
  }
  static std::string text_of_ball(const std::string& stiffness_n_per_m, const std::string& damping_ns_per_m) {
    return "# mine, größer\npalpa = 1\n\n[coupling]  # of the device\nstiffness_n_per_m = " + stiffness_n_per_m +
           "\t# N/m, on purpose\ndamping_ns_per_m=" + damping_ns_per_m +
           "\nmax_force_n = 10.0\n[volume.ball]\nanalytic = \"sphere\"\n\n[[mode]]\nname = \"skin\"\n"
           "type = \"surface_and_friction\"  \nfield = 'ball'\n[[mode.level]]\nvalue = 0\nstrength_n = 8\nfriction_n = 0.2\n# "
           "end";
  }
};

TEST_F(CheckCommand, LetsPassWhatIsFineAndWhatIsFelt) {
  write_ball("soft.toml", "150", "0.5");
  const Ended fine = palpa({"check", "soft.toml", "--device", "omega", "--fix", "same.toml"});
  EXPECT_EQ(fine.code, 0) << fine.err;
  EXPECT_THAT(fine.err, IsEmpty());
  EXPECT_THAT(fine.out, StartsWith("fine on omega: "));
  EXPECT_EQ(read(folder / "same.toml"), read(folder / "soft.toml")) << "what is fine is not changed";
  EXPECT_THAT(fine.out, HasSubstr("Wrote same.toml: the scene as it is, because no change is proposed"));
  write_ball("rests_by_friction.toml", "1300", "0.5");
  const Ended warned = palpa({"check", "rests_by_friction.toml", "--device", "omega"});
  EXPECT_EQ(warned.code, 0) << warned.err;
  EXPECT_THAT(warned.out, StartsWith("warn on omega: "));
}

TEST_F(CheckCommand, StopsWhatIsUnstableAndFixesItsNumbersOnly) {
  write_ball("ball.toml", "5000", "0");
  const Ended unstable = palpa({"check", "ball.toml", "--device", "omega", "--fix", "fixed.toml", "--json"});
  EXPECT_EQ(unstable.code, 1) << unstable.err;
  const json said = json::parse(unstable.out);
  EXPECT_EQ(said["verdict"], "stop");
  EXPECT_THAT(said["reason"].get<std::string>(), StartsWith("stop on omega: "));

  // The file is byte-identical to the input but for the named numbers.
  std::string stiffness = "5000", damping = "0";
  ASSERT_FALSE(said["changes"].empty());
  const json fixed = [&] {
    const Ended ended = palpa({"check", "fixed.toml", "--device", "omega", "--json"});
    EXPECT_EQ(ended.code, 0) << ended.out;
    return json::parse(ended.out);
  }();
  EXPECT_NE(fixed["verdict"], "stop");
  EXPECT_EQ(fixed["verdict"], said["verdict_after_changes"]);
  const std::string text = read(folder / "fixed.toml");
  const auto number_after = [&](const std::string& key) {
    const std::size_t begin = text.find(key) + key.size();
    return text.substr(begin, text.find_first_of("\t\n", begin) - begin);
  };
  for (const json& change : said["changes"]) {
    const bool of_stiffness = change["path"] == "coupling.stiffness_n_per_m";
    ASSERT_TRUE(of_stiffness || change["path"] == "coupling.damping_ns_per_m") << change;
    std::string& number = of_stiffness ? stiffness : damping;
    EXPECT_EQ(change["from"], std::stod(number));
    number = number_after(of_stiffness ? "stiffness_n_per_m = " : "damping_ns_per_m=");
    EXPECT_EQ(change["to"], std::stod(number));
  }
  EXPECT_EQ(text, text_of_ball(stiffness, damping));
  EXPECT_LT(std::stod(stiffness), 5000.0);
}

TEST_F(CheckCommand, TakesOneValueForOneCheckAndWritesIt) {
  write_ball("ball.toml", "5000", "0");
  const std::vector<std::string> softer{"check",    "ball.toml",
                                        "--device", "omega",
                                        "--set",    "coupling.stiffness_n_per_m=150",
                                        "--set",    "coupling.damping_ns_per_m=0.5",
                                        "--fix",    "softer.toml"};
  const Ended fine = palpa(softer);
  EXPECT_EQ(fine.code, 0) << fine.err;
  EXPECT_THAT(fine.out, StartsWith("fine on omega: "));
  EXPECT_EQ(read(folder / "softer.toml"), text_of_ball("150", "0.5"));
  const std::vector<std::string> weaker{"check", "ball.toml", "--device", "omega", "--set", "coupling.max_force_n=0"};
  expect_refusal(weaker, {"--set coupling.max_force_n", "above 0"});
  expect_refusal({"check", "ball.toml", "--device", "omega", "--set", "mode.skin.enabled=false", "--fix", "no.toml"},
                 {"--set mode.skin.enabled=false", "--fix"});
}

TEST_F(CheckCommand, SaysWhatItChanged) {
  write_ball("ball.toml", "5000", "0");
  const Ended unstable = palpa({"check", "ball.toml", "--device", "omega", "--fix", "fixed.toml"});
  EXPECT_THAT(unstable.out, testing::AllOf(HasSubstr("Wrote fixed.toml: the scene with coupling."),
                                           HasSubstr("Next: palpa check fixed.toml --device omega")));
}

TEST_F(CheckCommand, ReplacesAFileOnlyWhenAsked) {
  write_ball("soft.toml", "150", "0.5");
  write("notes.toml", "my notes");
  const std::vector<std::string> fix{"check", "soft.toml", "--device", "omega", "--fix", "notes.toml"};
  const Ended kept = palpa(fix);
  EXPECT_EQ(kept.code, 2);
  EXPECT_THAT(kept.err, testing::AllOf(HasSubstr("notes.toml"), HasSubstr("--force")));
  EXPECT_EQ(read(folder / "notes.toml"), "my notes");
  std::vector<std::string> forced = fix;
  forced.push_back("--force");
  EXPECT_EQ(palpa(forced).code, 0);
  EXPECT_EQ(read(folder / "notes.toml"), read(folder / "soft.toml"));
}

TEST_F(CheckCommand, RefusesWhatItCannotCheckInOneLine) {
  write_ball("ball.toml", "150", "0.5");
  expect_refusal({"check", "ball.toml"}, {"--device"});
  expect_refusal({"check", "ball.toml", "--device", "phantom"}, {"device: no preset 'phantom'", "touch", "FILE.toml"});
  expect_refusal({"check", "missing.toml", "--device", "touch"}, {"missing.toml"});
  expect_refusal({"check", "ball.toml", "--device", "missing.toml"}, {"missing.toml"});
  expect_refusal({"check", "ball.toml", "--device", "touch", "--fix", "out.txt"}, {"--fix out.txt", "OUT.toml"});
  const auto expect_plant_refused = [&](const std::string& plant, const std::vector<std::string>& pieces) {
    write("plant.toml", plant);
    expect_refusal({"check", "ball.toml", "--device", "plant.toml"}, pieces);
  };
  expect_plant_refused("like = \"touch\"\nmas_kg = 1\n", {"plant.toml:2: ", "'mas_kg'", "mass_kg"});
  expect_plant_refused("like = \"touch\"\n\nmass_kg = 11\n", {"plant.toml:3: ", "'11'", "from 0 to 10"});
  expect_plant_refused("mass_kg = nan\n", {"plant.toml:1: ", "mass_kg", "from 0 to 10"});
  expect_plant_refused("mass_kg = \"heavy\"\n", {"plant.toml:1: mass_kg", "mass_kg = 0.05"});
  expect_plant_refused("like = \"touch\"\ndelay_ticks = 1.5\n", {"plant.toml:2: ", "delay_ticks", "whole number"});
  expect_plant_refused("# mine\nlike = \"feather\"\n", {"plant.toml:2: ", "'feather'", "touch"});
  expect_plant_refused("like = 3\n", {"plant.toml:1: like", "like = \"touch\""});
  expect_plant_refused("like = \"touch\"\nmass_kg 1\n", {"plant.toml:2: ", "mass_kg = 0.05"});
  expect_plant_refused("damping_ns_per_m = 1\n", {"plant.toml has no mass", "mass_kg"});
}

TEST_F(CheckCommand, ADeviceOfAFileIsThatWhichItIsLike) {
  write_ball("soft.toml", "150", "0.5");
  write("mine.toml", "like = \"touch\"\n");
  write("heavy.toml", "like = \"touch\" # mine\nmass_kg = 0.09\n");
  const auto checked = [&](const std::string& device) {
    const Ended ended = palpa({"check", "soft.toml", "--device", device, "--json"});
    EXPECT_EQ(ended.code, 0) << ended.err;
    std::string out = ended.out;
    for (std::size_t at = out.find(device); at != std::string::npos; at = out.find(device, at + 1))
      out.replace(at, device.size(), "it");
    return out;
  };
  const std::string mine = checked("mine.toml"), heavy = checked("heavy.toml");
  EXPECT_EQ(mine, checked("touch"));
  EXPECT_EQ(heavy, checked("touch,mass_kg=0.09"));
  EXPECT_NE(heavy, mine);
}

TEST_F(CheckCommand, SaysTheNumbersOfTheTableAsJsonAndTheSameEveryTime) {
  write_ball("soft.toml", "150", "0.5");
  const std::vector<std::string> as_table{"check", "soft.toml", "--device", "omega"};
  std::vector<std::string> as_json = as_table;
  as_json.push_back("--json");
  const std::string table = palpa(as_table).out, text = palpa(as_json).out;
  EXPECT_EQ(palpa(as_table).out, table);
  EXPECT_EQ(palpa(as_json).out, text);
  const json said = json::parse(text);
  const auto rounded = [](const char* format, double value) {
    char shown[64];
    std::snprintf(shown, sizeof shown, format, value);
    return std::string(shown);
  };
  EXPECT_THAT(table, StartsWith(said["reason"].get<std::string>() + "\n"));
  EXPECT_THAT(table, HasSubstr(rounded("k = %g N/m, ", said["stiffness_n_per_m"])));
  EXPECT_THAT(table, HasSubstr(rounded("D = %g N·s/m, ", said["damping_ns_per_m"])));
  EXPECT_THAT(table, HasSubstr(rounded("at most %g N; ", said["max_force_n"])));
  EXPECT_THAT(table, HasSubstr(rounded("the largest force was %.2f N\n", said["force_max_n"])));
  const json& stable = said["stable"];
  EXPECT_THAT(table, HasSubstr(rounded("stable k   %.0f N/m ", stable["without_friction_n_per_m"]) + "without device friction" +
                               rounded(" at this D, %.0f N/m with", stable["with_friction_n_per_m"])));
  EXPECT_THAT(table, HasSubstr(rounded("bounds     %.0f N/m by linear stability", stable["stable_bound_n_per_m"])));
  EXPECT_THAT(table, HasSubstr(rounded("%.0f N/m passive", stable["passive_bound_n_per_m"])));
  EXPECT_THAT(table, HasSubstr(rounded("%.0f N/m with the encoder", stable["encoder_bound_n_per_m"])));
  EXPECT_THAT(table, testing::AllOf(HasSubstr("stable D   up to "),
                                    HasSubstr(rounded("%.3g N·s/m at this k", said["largest_stable_damping_ns_per_m"]))));
  ASSERT_FALSE(said["findings"].empty());
  for (const json& finding : said["findings"]) EXPECT_THAT(table, HasSubstr(finding["key"].get<std::string>() + " "));
  ASSERT_FALSE(said["places"].empty());
  for (const json& place : said["places"])
    EXPECT_THAT(table, HasSubstr(rounded("%.2f N, changes direction by", place["force_n"]) +
                                 rounded(" %.2f N in a millimetre", place["turn_n_per_mm"])));
}

TEST_F(CheckCommand, ARunOnADeviceSaysTheVerdictOnce) {
  write_ball("soft.toml", "150", "0.5");
  const std::vector<std::string> run{"run", "soft.toml", "--hand", "sim:press", "--duration-s", "0.1"};
  EXPECT_THAT(palpa(run).err, IsEmpty()) << "nothing is known of an ideal device";
  std::vector<std::string> on_device = run;
  on_device.insert(on_device.end(), {"--device", "touch"});
  const Ended ended = palpa(on_device);
  EXPECT_EQ(ended.code, 0) << ended.err;
  EXPECT_THAT(ended.err, testing::MatchesRegex("check: [a-z]+ on touch: [^\n]*; details: palpa check\n"));
  EXPECT_THAT(ended.out, testing::Not(HasSubstr("palpa check")));
}

}  // namespace check_command_test
}  // namespace palpa
