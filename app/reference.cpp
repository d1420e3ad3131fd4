#include "app/reference.h"

#include <CLI/CLI.hpp>
#include <span>
#include <sstream>
#include <vector>

#include "app/hand_words.h"
#include "palpa/base/input_file.h"
#include "palpa/base/limits.h"
#include "palpa/device/hand.h"
#include "palpa/mode/mode.h"
#include "palpa/scene/load_scene.h"
#include "palpa/version.h"

namespace palpa::app {
namespace {

/// Commands in `--help`, and below options: hidden ones have an empty group.
std::vector<const CLI::App*> commands_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App* command) { return !command->get_group().empty(); });
}
std::vector<const CLI::Option*> options_of(const CLI::App& app) {
  return app.get_options([](const CLI::Option* option) { return !option->get_group().empty(); });
}

/// Value of an option in its help: "HOLD:{rigid,relaxed,firm}"; empty for a flag.
std::string value_of(const CLI::Option& option) {
  return option.get_items_expected_max() == 0 ? std::string() : option.get_type_name();
}

/// Words between the braces of "HOLD:{rigid,relaxed,firm}"; empty without braces.
std::vector<std::string> choices_of(const CLI::Option& option) {
  const std::string value = option.get_type_name();
  const std::size_t open = value.find('{'), close = value.find('}');
  std::vector<std::string> words;
  if (open == std::string::npos || close == std::string::npos || close < open) return words;
  std::istringstream list(value.substr(open + 1, close - open - 1));
  for (std::string word; std::getline(list, word, ',');) words.push_back(word);
  return words;
}

/// Text escaped for roff, with hyphens that can be copied into a shell.
std::string roff(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else if (c == '\'') {
      out += "\\(aq";
    } else if (c == '\n') {
      out += "\n\\&";
    } else if (c == '.' && (out.empty() || out.back() == '\n')) {
      out += "\\&.";
    } else {
      out += c;
    }
  }
  return out;
}

void put_options(std::string& page, const CLI::App& app) {
  for (const CLI::Option* option : options_of(app)) {
    const std::string name = option->get_positional() ? option->get_name(true) : option->get_name(false, true);
    std::string value = option->get_positional() ? std::string() : value_of(*option);
    page += ".TP\n.B " + roff(name) + (value.empty() ? "" : " \\fI" + roff(value) + "\\fR") + "\n";
    page += roff(option->get_description()) + (option->get_required() ? " (required)" : "") + "\n";
  }
}

/// Man page sections on scenes, `--set` and modes.
std::string scene_sections() {
  std::string page = ".SH SCENES\n" +
                     roff(
                         "A scene is a short text in TOML: volumes (the data), modes (what they feel "
                         "like), the coupling (the spring between hand and data) and the workspace (where the hand's reach "
                         "lies in the data). For data without one, 'palpa info FILE --scene first.toml' writes a first one. "
                         "'palpa modes TYPE' lists the keys of a mode, docs/scene.md all keys.") +
                     "\n.SH SETTINGS\n" +
                     roff(
                         "'palpa run SCENE --set PATH=VALUE' changes one value for one run, as in "
                         "--set mode.surface.level.skin.strength_n=2. VALUE is written as in the scene; a text needs no "
                         "quotes. Besides volume.NAME.KEY, mode.NAME.KEY, mode.NAME.level.NAME.KEY, hand.NAME.at_m and "
                         "hand.NAME.tool.KEY, PATH is one of") +
                     "\n.PP\n.nf\n";
  for (const std::string& path : set_paths("", standard_modes())) {
    if (path.find('=') == std::string::npos) page += roff(path) + "\n";
  }
  page += ".fi\n.SH MODES\n";
  for (const Mode& mode : standard_modes().modes()) {
    page += ".TP\n.B " + roff(std::string(mode.type())) + "\n" + roff(std::string(mode.summary())) + "\n";
  }
  return page;
}

/// Words as lines in single quotes for a shell. No word may contain a single quote.
template <class Words>
std::string quoted_lines(const Words& words) {
  std::string out;
  for (const std::string& word : words) out += (out.empty() ? "" : "\n") + word;
  return "'" + out + "'";
}

std::string names_of(std::span<const Described> rows) {
  std::string names;
  for (const Described& row : rows) names += (names.empty() ? "" : " ") + std::string(row.name);
  return names;
}

/// Paths of settings as typed, each with an '='.
std::vector<std::string> with_equals(std::vector<std::string> paths) {
  for (std::string& path : paths) {
    if (path.find('=') == std::string::npos) path += '=';
  }
  return paths;
}

/// Completion script command that offers values of this option or argument; empty: any file.
std::string offer_of(const CLI::App& command, const CLI::Option& option) {
  const std::vector<std::string> words = choices_of(option);
  if (!words.empty()) return "_palpa_offer " + quoted_lines(words);
  const std::string name = option.get_positional() ? option.get_name(true) : option.get_lnames().front();
  if (name == "hand") return "_palpa_offer_hands";
  if (name == "device") return "_palpa_offer_devices";
  const bool reads_scene = command.get_option_no_throw("SCENE") != nullptr;
  if (name == "set") return reads_scene ? "_palpa_offer_settings" : "_palpa_offer_parts \"$_palpa_reading\"";
  if (name == "SCENE") return "_palpa_offer_files .toml";
  if (name == "plugin") return "_palpa_offer_files .so";
  if (name == "TRACE" || name == "beside" || option.get_type_name() == "DIR") return "_palpa_offer_folders";
  if (name == "TYPE") {
    std::vector<std::string> types;
    for (const Mode& mode : standard_modes().modes()) types.emplace_back(mode.type());
    return "_palpa_offer " + quoted_lines(types);
  }
  return {};
}

// Bash splits words at ':' and '=' and replaces only the part behind the last: `word` is the whole word, `left` the kept part.
constexpr const char* completion_functions = R"sh(
_palpa_offer() {  # _palpa_offer LINES: those that begin with the word
  local line
  while IFS= read -r line; do
    if [[ -n $line && $line == "$word"* ]]; then COMPREPLY+=("${line#"$left"}"); fi
  done <<<"$1"
}
_palpa_offer_parts() {  # of a.b.c=value the next part alone
  local line rest last=
  while IFS= read -r line; do
    [[ -n $line && $line == "$word"* && $line != "$word" ]] || continue
    rest=${line#"$word"}
    if [[ $word != *=* ]]; then
      rest=${rest%%[.=]*}
      line=$word$rest${line:$((${#word} + ${#rest})):1}
    fi
    if [[ $line != "$last" ]]; then COMPREPLY+=("${line#"$left"}"); fi
    last=$line
  done < <(LC_ALL=C sort <<<"$1")
  if [[ $word != *=* ]]; then compopt -o nospace 2>/dev/null || true; fi
}
_palpa_offer_settings() {  # those of the scene on the line
  local name scene=
  for name in "${words[@]}"; do
    if [[ $name == *.toml ]]; then scene=${name/#\~\//$HOME/}; fi
  done
  _palpa_offer_parts "$($program --print-sets "$scene" 2>/dev/null)"
}
_palpa_offer_keys() {  # _palpa_offer_keys KEYS: behind the last comma
  local given=${word%,*}, key lines=
  for key in $1; do lines+=$given$key=$'\n'; done
  compopt -o nospace 2>/dev/null || true
  _palpa_offer "$lines"
}
_palpa_offer_devices() {
  if [[ $word == *,* ]]; then _palpa_offer_keys "$_palpa_device_keys"; else _palpa_offer "$_palpa_devices"; fi
}
_palpa_offer_hands() {
  if [[ $word == sim:*,* ]]; then
    _palpa_offer_keys "$_palpa_hand_keys"
  else
    _palpa_offer "$_palpa_hands"
    _palpa_offer_files .csv
  fi
}
_palpa_offer_files() {  # _palpa_offer_files ENDING: and the folders on the way to them
  local name names
  mapfile -t names < <(compgen -d -- "$word" || true; compgen -f -X "!*$1" -- "$word")
  for name in "${names[@]}"; do COMPREPLY+=("${name#"$left"}"); done
  if ((${#names[@]} > 0)); then compopt -o filenames 2>/dev/null || true; fi
}
_palpa_offer_folders() { _palpa_offer_files /; }
_palpa() {
  local program=${1:-palpa} words=("${COMP_WORDS[@]:0:COMP_CWORD+1}")
  program=${BASH_ALIASES[$program]:-$program}
  if [[ -n ${COMP_LINE-} && $COMP_LINE != *[\\\'\"]* ]]; then  # a line with quotes stays as bash has cut it
    read -ra words <<<"${COMP_LINE:0:COMP_POINT}"
    if [[ ${COMP_LINE:0:COMP_POINT} == *[[:space:]] ]]; then words+=(''); fi
  fi
  local count=${#words[@]} word before command='' left='' kept=${COMP_WORDS[COMP_CWORD]}
  word=${words[count-1]} before=${words[count-2]}
  if ((count > 2)) && [[ ${words[1]} != -* ]]; then command=${words[1]}; fi
  if [[ $word == --*=* ]]; then before=${word%%=*} word=${word#*=}; fi
  if [[ $kept == [:=] ]]; then kept=; fi
  if [[ $word == *"$kept" ]]; then left=${word:0:${#word}-${#kept}}; fi
  COMPREPLY=()
)sh";

}  // namespace

std::string settings_of(const std::filesystem::path& scene) {
  const detail::InputFile file(scene);
  const std::string text =
      file.is_open() ? detail::read_whole(file, limit::scene_bytes, "name a scene file (.toml)") : std::string();
  std::string lines;
  for (const std::string& path : with_equals(set_paths(text, standard_modes()))) lines += path + "\n";
  return lines;
}

std::string man_page(const CLI::App& app) {
  std::string page = ".TH PALPA 1 \"\" \"palpa " + std::string(version) + "\" \"User Commands\"\n";
  page += ".SH NAME\npalpa \\- " + roff(app.get_description()) + "\n";
  page += ".SH SYNOPSIS\n";
  for (const CLI::App* command : commands_of(app)) {
    page += ".B palpa " + roff(command->get_name()) + "\n[\\fIoptions\\fR]";
    for (const CLI::Option* option : options_of(*command)) {
      if (!option->get_positional()) continue;
      const std::string name = roff(option->get_name(true)) + (option->get_items_expected_max() > 1 ? "..." : "");
      page += option->get_required() ? " \\fI" + name + "\\fR" : " [\\fI" + name + "\\fR]";
    }
    page += "\n.br\n";
  }
  page += ".SH OPTIONS\n";
  put_options(page, app);
  page += ".SH COMMANDS\n";
  for (const CLI::App* command : commands_of(app)) {
    page += ".SS palpa " + roff(command->get_name()) + "\n" + roff(command->get_description()) + ".\n";
    put_options(page, *command);
    if (!command->get_footer().empty()) page += ".PP\n.nf\n" + roff(command->get_footer()) + "\n.fi\n";
  }
  page += scene_sections();
  page += ".SH NOTES\n.nf\n" + roff(app.get_footer()) + "\n.fi\n";
  page += ".SH ENVIRONMENT\n";
  for (const auto& [name, sentence] :
       {std::pair{"PALPA_DATA", "a folder in which a scene's relative paths are looked for last"},
        std::pair{"PALPA_READER", "the program palpa-read, which opens files"},
        std::pair{"PALPA_READER_FOLDERS",
                  "further folders that palpa-read may read, with : between them, for files that name others far away"},
        std::pair{"PALPA_SCENES", "the folder of the scenes that palpa demo feels"}}) {
    page += ".TP\n.B " + std::string(name) + "\n" + roff(sentence) + "\n";
  }
  return page;
}

std::string bash_completion(const CLI::App& app) {
  std::vector<std::pair<std::string, const CLI::App*>> commands = {{"", &app}};
  for (const CLI::App* command : commands_of(app)) commands.emplace_back(command->get_name(), command);
  std::vector<std::string> hands;
  for (const Described& hand : simulated_hands) hands.emplace_back(hand.name);

  std::vector<std::string> devices;
  for (const DevicePlant& plant : device_presets()) devices.push_back(plant.name);

  std::ostringstream out;
  out << "# Completion of palpa " << version << " for bash; written by palpa itself.\n"
      << "_palpa_reading=" << quoted_lines(with_equals(how_to_read_paths())) << "\n"
      << "_palpa_hands=" << quoted_lines(hands) << "\n"
      << "_palpa_hand_keys='" << names_of(simulated_hand_keys) << "'\n"
      << "_palpa_devices=" << quoted_lines(devices) << "\n"
      << "_palpa_device_keys='" << names_of(device_keys) << "'" << completion_functions;

  // The script first completes the value of an option, then options, commands and arguments.
  out << "  case $command:$before in\n";
  for (const auto& [name, command] : commands) {
    for (const CLI::Option* option : options_of(*command)) {
      if (option->get_positional() || option->get_items_expected_max() == 0) continue;
      for (const std::string& long_name : option->get_lnames()) {
        const std::string offer = offer_of(*command, *option);
        out << "    " << name << ":--" << long_name << ") " << offer << (offer.empty() ? "" : "; ") << "return ;;\n";
      }
    }
  }
  out << "  esac\n"
      << "  case $command:$word in\n";
  for (const auto& [name, command] : commands) {
    std::vector<std::string> options, others;
    for (const CLI::Option* option : options_of(*command)) {
      for (const std::string& long_name : option->get_lnames()) options.push_back("--" + long_name);
      for (const std::string& short_name : option->get_snames()) options.push_back("-" + short_name);
    }
    out << "    " << name << ":-*) _palpa_offer " << quoted_lines(options) << " ;;\n";
    if (command == &app) {
      for (const auto& [other, unused] : commands) {
        if (!other.empty()) others.push_back(other);
      }
      out << "    :*) _palpa_offer " << quoted_lines(others) << " ;;\n";
      continue;
    }
    for (const CLI::Option* option : options_of(*command)) {
      if (!option->get_positional()) continue;
      if (const std::string offer = offer_of(*command, *option); !offer.empty())
        out << "    " << name << ":*) " << offer << " ;;\n";
      break;
    }
  }
  out << "  esac\n"
      << "}\n"
      << "complete -o default -F _palpa palpa\n";
  return out.str();
}

}  // namespace palpa::app
