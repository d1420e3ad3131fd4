#include "app/command_line.h"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "app/command_lines.h"
#include "app/reference.h"
#include "app/terminal.h"
#include "palpa/base/wording.h"
#include "palpa/file/reader_process.h"
#include "palpa/version.h"

namespace palpa::app {
namespace {

std::vector<std::string> split(const std::string& list) {
  std::vector<std::string> words(1);
  for (const char c : list) {
    if (c == ',') {
      words.emplace_back();
    } else {
      words.back() += c;
    }
  }
  return words;
}

/// CLI11's error in our form: what is wrong; what would be right.
std::string complaint(const CLI::ParseError& error, const CLI::App& app) {
  const CLI::App* command = &app;
  for (const CLI::App* used : app.get_subcommands()) command = used;
  const std::string name = command == &app ? "command line" : command->get_name();
  const std::string help = command == &app ? "see 'palpa --help'" : "see 'palpa " + name + " --help'";

  const std::vector<std::string> rest = command->remaining();
  if (dynamic_cast<const CLI::ExtrasError*>(&error) && !rest.empty()) {
    const auto option = std::find_if(rest.begin(), rest.end(), [](const std::string& word) { return word.rfind('-', 0) == 0; });
    if (option == rest.end()) return name + ": " + detail::in_quotes(rest.front()) + " is one argument too many; " + help;
    std::vector<std::string> known;
    for (const CLI::Option* there : command->get_options()) {
      for (const std::string& long_name : there->get_lnames()) known.push_back("--" + long_name);
    }
    const std::string given = option->substr(0, option->find('='));
    return name + ": unknown option " + detail::in_quotes(given) + "; " + detail::suggestion(given, known);
  }
  // "--hand-hold: loose not in {rigid,relaxed,firm}", and "Could not convert: --rate-hz = fast"
  const std::string text = error.what();
  const std::size_t colon = text.find(": "), not_in = text.find(" not in {");
  if (dynamic_cast<const CLI::ValidationError*>(&error) && colon < not_in && not_in != std::string::npos &&
      text.back() == '}') {
    const std::size_t open = not_in + 9;
    const std::string given = text.substr(colon + 2, not_in - colon - 2);
    return name + ": " + text.substr(0, colon) + " cannot be " + detail::in_quotes(given) + "; " +
           detail::suggestion(given, split(text.substr(open, text.size() - 1 - open)));
  }
  if (dynamic_cast<const CLI::ConversionError*>(&error) && colon != std::string::npos) {
    const std::size_t equals = std::min(text.find(" = "), text.size() - 3);
    return name + ": " + text.substr(colon + 2, equals - colon - 2) + " cannot be " +
           detail::in_quotes(text.substr(equals + 3)) + "; it must be a number";
  }
  return name + ": " + text + "; " + help;
}

void add_prints(CLI::App& app) {
  app.add_option_function<std::string>(
         "--print",
         [&app](const std::string& what) {
           print(what == "man" ? man_page(app) : bash_completion(app));
           throw CLI::Success();
         },
         "print the man page, or bash's completion, as in: source <(palpa --print bash)")
      ->check(CLI::IsMember({"man", "bash"}))
      ->type_name("WHAT");
  // Hidden: called by bash's completion.
  app.add_option_function<std::string>("--print-sets",
                                       [](const std::string& scene) {
                                         print(settings_of(scene));
                                         throw CLI::Success();
                                       })
      ->group("");
}

/// `--version` also reports missing parts of the sandbox.
void say_what_the_cage_lacks() {
  if (const std::string lacking = detail::lacking_of_cage(); !lacking.empty())
    print_warnings({"files are read in a sandbox that lacks a part on this system: " + lacking});
}

/// CLI11 would report an unknown command as missing.
int refuse_command(const std::string& given, const std::vector<std::string>& names) {
  print_error("command line: unknown command " + detail::in_quotes(given) + "; " + detail::suggestion(given, names));
  return 2;
}

}  // namespace

int run_command_line(int argc, char** argv, const std::atomic<bool>& stop) {
  CLI::App app("Touch volumetric data: feel scans and flows as forces.", "palpa");
  app.set_version_flag("--version", std::string("palpa ") + version);
  app.require_subcommand(1);
  app.footer(
      "First steps:\n"
      "  palpa demo                                             a head from a formula, felt by a simulated hand\n"
      "  palpa info scan.nrrd --scene first.toml                data of your own, and a first scene for them\n"
      "  palpa run first.toml --hand sim:stroke --out first     feel it, record it\n"
      "  palpa report first                                     see the report\n"
      "Each command has help of its own with an example: palpa run --help\n"
      "Exit codes: 0 ok, 1 it ran and the answer is no, 2 wrong usage or input, 130 interrupted.");

  Work work;
  const std::pair<std::string, std::function<void()>> commands[] = {{"demo", [&] { add_demo(app, work, stop); }},
                                                                    {"run", [&] { add_run(app, work, argc, argv, stop); }},
                                                                    {"serve", [&] { add_serve(app, work, argc, argv, stop); }},
                                                                    {"check", [&] { add_check(app, work, stop); }},
                                                                    {"devices", [&] { add_devices(app, work, stop); }},
                                                                    {"explore", [&] { add_explore(app, work); }},
                                                                    {"info", [&] { add_info(app, work); }},
                                                                    {"convert", [&] { add_convert(app, work, stop); }},
                                                                    {"prepare", [&] { add_prepare(app, work, stop); }},
                                                                    {"replay", [&] { add_replay(app, work, stop); }},
                                                                    {"report", [&] { add_report(app, work); }},
                                                                    {"export", [&] { add_export(app, work); }},
                                                                    {"map", [&] { add_map(app, work, stop); }},
                                                                    {"modes", [&] { add_modes(app, work); }}};
  // Building the options of all commands takes a millisecond: if a command is named, only its options are built. A file may
  // have the name of another command.
  const auto named = std::ranges::find_if(commands, [&](const auto& command) { return argc > 1 && command.first == argv[1]; });
  const bool is_named = named != std::end(commands);
  for (const auto& command : commands) {
    if (!is_named || command.first == named->first) command.second();
  }
  add_prints(app);

  if (argc < 2) {
    print(app.help());
    return 0;
  }
  if (argv[1][0] != '-' && !is_named) {
    std::vector<std::string> names;
    for (const auto& command : commands) names.push_back(command.first);
    return refuse_command(argv[1], names);
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) {  // help and version
      const int code = app.exit(error);
      if (dynamic_cast<const CLI::CallForVersion*>(&error) != nullptr) say_what_the_cage_lacks();
      return code;
    }
    print_error(complaint(error, app));
    return 2;
  }
  return work();
}

}  // namespace palpa::app
