// The man page and the shell's completion, made from the command line's own description.
#pragma once

#include <filesystem>
#include <string>

namespace CLI {
class App;
}

namespace palpa::app {

/// palpa(1), in roff.
std::string man_page(const CLI::App& app);
/// The completion of bash for all commands, their options and what these take.
std::string bash_completion(const CLI::App& app);
/// What `--set` takes in this scene, for that completion: one PATH= or PATH=VALUE a line. For a scene that cannot be read: what
/// all scenes take.
std::string settings_of(const std::filesystem::path& scene);

}  // namespace palpa::app
