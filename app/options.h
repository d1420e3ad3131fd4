// What the lines of several commands have in common.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "palpa/base/new_file.h"
#include "palpa/file/read_volume.h"

namespace palpa::app {

/// Splits `PATH=VALUE`. Throws LoadError. \param example  of the right form, for the message
std::pair<std::string, std::string> split_set(const std::string& text, const std::string& example);
/// The settings of a scene, as `SceneOptions` has them. Throws LoadError.
std::vector<std::pair<std::string, std::string>> split_sets(const std::vector<std::string>& sets);

/// An option that may be given several times, with one value each.
template <class T>
CLI::Option* add_repeated(CLI::App* command, const std::string& name, std::vector<T>& values, const std::string& sentence) {
  return command->add_option(name, values, sentence)->allow_extra_args(false);
}

void add_plugins(CLI::App* command, std::vector<std::filesystem::path>& plugins);
void add_force(CLI::App* command, bool& force);
detail::Existing existing(bool force);
void add_reader(CLI::App* command, ReadOptions& read);
void add_device(CLI::App* command, std::string& device);

/// The folder of a trace, which may also be named by a file in it, because that is what a shell completes.
std::filesystem::path trace_folder(const std::filesystem::path& named);

/// How a file is read: what a scene's [volume] would say.
struct HowToRead {
  std::vector<std::string> sets;
  std::vector<std::filesystem::path> partners;
};
void add_how_to_read(CLI::App* command, HowToRead& how);
/// The request without the file itself: `files` holds only its partners. Throws LoadError.
VolumeRequest request_of(const HowToRead& how);

}  // namespace palpa::app
