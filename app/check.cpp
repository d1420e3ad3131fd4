#include "palpa/study/check.h"

#include <charconv>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>

#include "app/commands.h"
#include "app/output_names.h"
#include "app/pictures.h"
#include "app/terminal.h"
#include "palpa/base/new_file.h"
#include "palpa/base/printed.h"
#include "palpa/mode/plugin.h"
#include "palpa/scene/change_text.h"
#include "palpa/scene/load_scene.h"

namespace palpa::app {
namespace {

struct CouplingNumber {
  std::string key;
  double value = 0.0;
};
/// Number of the coupling in a `--set PATH=VALUE`; none for other paths.
std::optional<CouplingNumber> coupling_number(const std::string& path, const std::string& value) {
  constexpr std::string_view table = "coupling.";
  double number = 0.0;
  const auto [end, error] = std::from_chars(value.data(), value.data() + value.size(), number);
  if (!path.starts_with(table) || error != std::errc() || end != value.data() + value.size()) return std::nullopt;
  return CouplingNumber{path.substr(table.size()), number};
}

void check_names(const CheckArguments& arguments) {
  if (!arguments.fix.empty() && arguments.fix.extension() != ".toml")
    throw LoadError("--fix " + arguments.fix.string() + ": is no name of a scene; write --fix OUT.toml");
  if (!arguments.picture.empty()) {
    check_output(arguments.picture, ".png", arguments.existing);
    pictures_for("--picture " + arguments.picture.string());
  }
  if (arguments.fix.empty()) return;
  for (const auto& [path, value] : arguments.scene_options.sets) {
    if (coupling_number(path, value)) continue;
    throw LoadError("--set " + path + "=" + value +
                    ": is not written by --fix, which changes numbers of [coupling] only; write it into the scene, or leave "
                    "--fix out");
  }
}

/// Scene file text with the changes of --set and the check, otherwise unchanged.
std::string fixed(const LoadedScene& loaded, const CheckArguments& arguments, const CheckReport& report) {
  std::string text = loaded.text;
  for (const auto& [path, value] : arguments.scene_options.sets) {
    const CouplingNumber set = *coupling_number(path, value);
    text = with_number(text, "coupling", set.key, set.value);
  }
  for (const Change& change : report.changes) text = with_number(text, change.table, change.key, change.to);
  return text;
}

std::string format_fix(const CheckArguments& arguments, const CheckReport& report) {
  std::string words = "\nWrote " + arguments.fix.string() + ": the scene";
  for (std::size_t n = 0; n < report.changes.size(); ++n) {
    const Change& change = report.changes[n];
    words += (n == 0 ? " with " : ", ") + change.table + "." + change.key + detail::text(" = %g", change.to);
  }
  if (!report.changes.empty())
    return words + "\nNext: palpa check " + arguments.fix.string() + " --device " + arguments.device + "\n";
  return words + (arguments.scene_options.sets.empty() ? " as it is, because" : " with the values of --set;") +
         " no change is proposed\n";
}

}  // namespace

int run_check(const CheckArguments& arguments) {
  check_names(arguments);
  const DevicePlant plant = checked_plant(device_plant(arguments.device));
  LoadedScene loaded;
  CheckReport report;
  {
    Progress progress("checking " + arguments.scene.filename().string());
    loaded = load_scene(arguments.scene, volume_reader(arguments.read), modes_with(arguments.plugins), arguments.scene_options);
    report = check(
        loaded.scene, plant,
        {.map = !arguments.picture.empty(), .read = arguments.read, .progress = [&](double share) { progress.show(share); }});
  }
  print_warnings(loaded.warnings);
  print(arguments.json ? to_json(report) : to_table(report));
  if (!arguments.picture.empty())
    pictures_for("--picture " + arguments.picture.string()).check(report, arguments.picture, arguments.existing);
  if (!arguments.fix.empty()) {
    detail::write_whole(arguments.fix, fixed(loaded, arguments, report), arguments.existing);
    if (!arguments.json) print(format_fix(arguments, report));
  }
  return report.grade == Grade::stop ? 1 : 0;
}

}  // namespace palpa::app
