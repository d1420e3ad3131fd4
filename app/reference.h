// The man page and the shell's completion, made from the command line's own description.
#pragma once

#include <string>

namespace CLI {
class App;
}

namespace palpa::app {

/// palpa(1), in roff.
std::string man_page(const CLI::App& app);
/// The completion of bash for all commands, their options and the words that these take.
std::string bash_completion(const CLI::App& app);

}  // namespace palpa::app
