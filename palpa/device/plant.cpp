#include <toml++/toml.h>

#include <array>
#include <string_view>
#include <utility>

#include "palpa/base/input_file.h"
#include "palpa/base/limits.h"
#include "palpa/base/load_error.h"
#include "palpa/base/printed.h"
#include "palpa/base/toml_problem.h"
#include "palpa/base/wording.h"
#include "palpa/device/described.h"
#include "palpa/device/hand.h"

namespace palpa {

namespace {

// Key and its range: that of devices, with margin. Wider: motions that no arm follows; narrower: real devices are refused.
struct Key {
  const char* name;
  const char* right;
  double least, most;
  double& (*of)(DevicePlant&);
};
constexpr std::array keys{
    Key{"mass_kg", "it is a number of kilograms from 0 to 10, as in 0.045", 0.0, 10.0,
        [](DevicePlant& plant) -> double& { return plant.mass_kg; }},
    Key{"damping_ns_per_m", "it is a number of N·s/m from 0 to 100, as in 0.1", 0.0, 100.0,
        [](DevicePlant& plant) -> double& { return plant.damping_ns_per_m; }},
    Key{"coulomb_friction_n", "it is a number of newtons from 0 to 100, as in 0.26", 0.0, 100.0,
        [](DevicePlant& plant) -> double& { return plant.coulomb_friction_n; }},
    Key{"max_force_n", "it is a number of newtons from 0.001 to 100, as in 3.3", 1e-3, 100.0,
        [](DevicePlant& plant) -> double& { return plant.limits.max_force_n; }},
    Key{"max_torque_nm", "it is a number of N·m from 0 to 10, as in 0.4", 0.0, 10.0,
        [](DevicePlant& plant) -> double& { return plant.limits.max_torque_nm; }},
    Key{"max_stiffness_n_per_m", "it is a number of N/m from 1 to 100000, as in 400", 1.0, 1e5,
        [](DevicePlant& plant) -> double& { return plant.limits.max_stiffness_n_per_m; }},
    Key{"workspace_radius_m", "it is a number of metres from 0.001 to 10, as in 0.075", 1e-3, 10.0,
        [](DevicePlant& plant) -> double& { return plant.limits.workspace_radius_m; }},
    Key{"encoder_step_m", "it is a number of metres from 0 to 0.01, as in 55e-6", 0.0, 0.01,
        [](DevicePlant& plant) -> double& { return plant.limits.encoder_step_m; }},
};
constexpr std::string_view delay_key = "delay_ticks";

std::string known_keys() {
  std::string names;
  for (const Key& key : keys) names += std::string(key.name) + ", ";
  return names + std::string(delay_key);
}

[[noreturn]] void refuse(const std::string& what, const std::string& right) {
  throw LoadError("device: " + what + "; " + right);
}

void change(DevicePlant& plant, std::string_view name, std::string_view value) {
  const auto refuse_value = [&](const std::string& right) {
    refuse("'" + std::string(value) + "' cannot be used for " + std::string(name), right);
  };
  if (name == delay_key) {
    int ticks = 0;
    if (!detail::read_number(value, ticks) || ticks < 0 || ticks > DevicePlant::longest_delay_ticks)
      refuse_value("it is a whole number from 0 to " + std::to_string(DevicePlant::longest_delay_ticks));
    plant.delay_ticks = ticks;
    return;
  }
  for (const Key& key : keys) {
    if (name != key.name) continue;
    double number = 0.0;
    if (!detail::read_number(value, number) || !(number >= key.least && number <= key.most)) refuse_value(key.right);
    key.of(plant) = number;
    return;
  }
  refuse("unknown key '" + std::string(name) + "'", "there are " + known_keys());
}

}  // namespace

std::span<const DevicePlant> device_presets() {
  static const DevicePlant presets[] = {
      {.name = "touch",
       .mass_kg = 0.045,
       .damping_ns_per_m = 0.005,
       .coulomb_friction_n = 0.26,
       .limits = {.max_force_n = 3.3, .max_stiffness_n_per_m = 400, .workspace_radius_m = 0.075, .encoder_step_m = 55e-6}},
      {.name = "omega",
       .mass_kg = 0.2,
       .damping_ns_per_m = 0.1,
       .coulomb_friction_n = 0.1,
       .limits = {.max_force_n = 12, .max_stiffness_n_per_m = 5000, .workspace_radius_m = 0.075, .encoder_step_m = 10e-6}},
      {.name = "falcon",
       .mass_kg = 0.2,
       .damping_ns_per_m = 0.5,
       .coulomb_friction_n = 0.3,
       .limits = {.max_force_n = 8, .max_stiffness_n_per_m = 3000, .workspace_radius_m = 0.04, .encoder_step_m = 60e-6}},
      {.name = "inverse3",
       .mass_kg = 0.2,
       .damping_ns_per_m = 0.1,
       .coulomb_friction_n = 0.2,
       .limits = {.max_force_n = 3, .max_stiffness_n_per_m = 800, .workspace_radius_m = 0.1, .encoder_step_m = 10e-6}},
      {.name = "desktop",
       .mass_kg = 0.045,
       .damping_ns_per_m = 0.02,
       .coulomb_friction_n = 0.06,
       .limits = {.max_force_n = 7.9, .max_stiffness_n_per_m = 1000, .workspace_radius_m = 0.1, .encoder_step_m = 23e-6}},
  };
  return presets;
}

namespace {

constexpr std::string_view file_ending = ".toml", like_key = "like";

[[noreturn]] void refuse_file(const std::string& file, std::size_t line, const std::string& sentence) {
  throw LoadError(detail::one_line(file + ":" + std::to_string(line) + ": " + sentence));
}

/// Device from a file: `like = "touch"`, then the differences.
DevicePlant plant_in(const std::string& file) {
  const std::string text = detail::read_whole(detail::InputFile(file), limit::notes_bytes, limit::notes_bytes.remedy);
  if (const auto problem = detail::problem_with_toml(text)) refuse_file(file, problem->line, problem->sentence);
  toml::table said;
  try {
    said = toml::parse(std::string_view(text));
  } catch (const toml::parse_error& error) {
    refuse_file(file, error.source().begin.line, std::string(error.description()) + "; it holds lines like mass_kg = 0.05");
  }
  DevicePlant plant;
  if (const toml::node* const like = said.get(like_key)) {
    const auto name = like->value<std::string>();
    if (!name || name->ends_with(file_ending))
      refuse_file(file, like->source().begin.line, "like is no name of a device; write it as in like = \"touch\"");
    try {
      plant = device_plant(*name);
    } catch (const LoadError& error) {
      refuse_file(file, like->source().begin.line, error.what());
    }
  }
  for (const auto& [key, node] : said) {
    if (key.str() == like_key) continue;
    if (!node.is_number())
      refuse_file(file, node.source().begin.line, std::string(key.str()) + " is no number; write it as in mass_kg = 0.05");
    const std::string number =
        node.is_integer() ? std::to_string(node.as_integer()->get()) : detail::toml_number(node.as_floating_point()->get());
    try {
      change(plant, key.str(), number);
    } catch (const LoadError& error) {
      refuse_file(file, node.source().begin.line, error.what());
    }
  }
  return plant;
}

}  // namespace

DevicePlant device_plant(const std::string& description) {
  std::string_view rest = description;
  const std::string_view name = detail::next_word(rest);
  const auto with_values = [&](DevicePlant plant) {
    plant.name = description;
    while (!rest.empty()) {
      const auto [key, value] = detail::key_and_value(detail::next_word(rest));
      change(plant, key, value);
    }
    return plant;
  };
  if (name.ends_with(file_ending)) return with_values(plant_in(std::string(name)));
  std::string names;
  for (const DevicePlant& preset : device_presets()) {
    names += (names.empty() ? "" : ", ") + preset.name;
    if (preset.name == name) return with_values(preset);
  }
  refuse("no preset '" + std::string(name) + "'", "there are " + names + ", or a file FILE.toml");
}

std::string format_plant(const DevicePlant& plant) {
  return detail::text("at most %g N and %g N/m, encoder step %g um, %g kg, %g N·s/m, friction %g N, delay %d tick%s",
                      plant.limits.max_force_n, plant.limits.max_stiffness_n_per_m, 1e6 * plant.limits.encoder_step_m,
                      plant.mass_kg, plant.damping_ns_per_m, plant.coulomb_friction_n, plant.delay_ticks,
                      plant.delay_ticks == 1 ? "" : "s");
}

}  // namespace palpa
