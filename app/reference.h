// Man page and shell completion, made from the command line's own description.
#pragma once

#include <filesystem>
#include <string>

namespace CLI {
class App;
}

namespace palpa::app {

/// palpa(1), in roff.
std::string man_page(const CLI::App& app);
/// Completion of bash for all commands, their options and values.
std::string bash_completion(const CLI::App& app);
/// Settings for `--set` in this scene: one PATH= or PATH=VALUE per line; settings common to all scenes if it is unreadable.
std::string settings_of(const std::filesystem::path& scene);

}  // namespace palpa::app
