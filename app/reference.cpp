#include "app/reference.h"

#include <CLI/CLI.hpp>
#include <sstream>
#include <vector>

#include "palpa/version.h"

namespace palpa::app {
namespace {

/// Commands and options that `--help` shows: an empty group hides.
std::vector<const CLI::App*> commands_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App* command) { return !command->get_group().empty(); });
}
std::vector<const CLI::Option*> options_of(const CLI::App& app) {
  return app.get_options([](const CLI::Option* option) { return !option->get_group().empty(); });
}

/// What an option takes, as its help has it: "HOLD:{rigid,relaxed,firm}"; empty for a flag.
std::string value_of(const CLI::Option& option) {
  return option.get_items_expected_max() == 0 ? std::string() : option.get_type_name();
}

/// The words between the braces of "HOLD:{rigid,relaxed,firm}"; none where there are none.
std::vector<std::string> words_of(const CLI::Option& option) {
  const std::string value = option.get_type_name();
  const std::size_t open = value.find('{'), close = value.find('}');
  std::vector<std::string> words;
  if (open == std::string::npos || close == std::string::npos || close < open) return words;
  std::istringstream list(value.substr(open + 1, close - open - 1));
  for (std::string word; std::getline(list, word, ',');) words.push_back(word);
  return words;
}

/// Text for roff: no character of it is a command, a hyphen is one that can be typed.
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

}  // namespace

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
  page += ".SH NOTES\n.nf\n" + roff(app.get_footer()) + "\n.fi\n";
  page += ".SH ENVIRONMENT\n";
  for (const auto& [name, sentence] :
       {std::pair{"PALPA_DATA", "a folder in which a scene's relative paths are looked for last"},
        std::pair{"PALPA_READER", "the program palpa-read, which opens files"},
        std::pair{"PALPA_SCENES", "the folder of the scenes that palpa demo feels"}}) {
    page += ".TP\n.B " + std::string(name) + "\n" + roff(sentence) + "\n";
  }
  return page;
}

std::string bash_completion(const CLI::App& app) {
  std::ostringstream out;
  std::vector<std::pair<std::string, const CLI::App*>> commands = {{"", &app}};
  for (const CLI::App* command : commands_of(app)) commands.emplace_back(command->get_name(), command);

  // First what the value of an option may be, then the options and commands themselves.
  out << "# Completion of palpa " << version << " for bash; written by palpa itself.\n"
      << "_palpa() {\n"
      << "  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} command= words=\n"
      << "  COMPREPLY=()\n"
      << "  ((COMP_CWORD > 1)) && command=${COMP_WORDS[1]}\n"
      << "  case $command:$before in\n";
  for (const auto& [name, command] : commands) {
    for (const CLI::Option* option : options_of(*command)) {
      if (option->get_positional() || option->get_items_expected_max() == 0) continue;
      for (const std::string& long_name : option->get_lnames()) {
        out << "    " << name << ":--" << long_name << ")\n";
        const std::vector<std::string> words = words_of(*option);
        if (!words.empty()) {
          out << "      COMPREPLY=($(compgen -W '";
          for (const std::string& word : words) out << (&word == words.data() ? "" : " ") << word;
          out << "' -- \"$word\"))\n";
        } else if (option->get_type_name() == "DIR") {
          out << "      compopt -o filenames; COMPREPLY=($(compgen -d -- \"$word\"))\n";
        }
        out << "      return ;;\n";  // without a reply bash offers files
      }
    }
  }
  out << "  esac\n"
      << "  case $command in\n";
  for (const auto& [name, command] : commands) {
    std::string options, words;
    for (const CLI::Option* option : options_of(*command)) {
      for (const std::string& long_name : option->get_lnames()) options += " --" + long_name;
      for (const std::string& short_name : option->get_snames()) options += " -" + short_name;
      if (option->get_positional()) {
        for (const std::string& word : words_of(*option)) words += " " + word;
      }
    }
    if (command == &app) {
      for (const auto& [other, unused] : commands) words += other.empty() ? "" : " " + other;
    }
    out << "    " << (name.empty() ? "''" : name) << ")\n"
        << "      case $word in\n"
        << "        -*) words='" << (options.empty() ? "" : options.substr(1)) << "' ;;\n"
        << "        *) words='" << (words.empty() ? "" : words.substr(1)) << "' ;;\n"
        << "      esac ;;\n";
  }
  out << "  esac\n"
      << "  COMPREPLY=($(compgen -W \"$words\" -- \"$word\"))\n"
      << "}\n"
      << "complete -o default -F _palpa palpa\n";
  return out.str();
}

}  // namespace palpa::app
