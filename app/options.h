// Options that several commands share.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include "palpa/base/new_file.h"
#include "palpa/file/read_volume.h"
#include "palpa/file/work_part.h"

namespace palpa::app {

/// Splits `PATH=VALUE`. Throws LoadError. \param example  correct form, for the message
std::pair<std::string, std::string> split_set(const std::string& text, const std::string& example);
/// Settings of a scene, for `SceneOptions`. Throws LoadError.
std::vector<std::pair<std::string, std::string>> split_sets(const std::vector<std::string>& sets);

/// Repeatable option with one value each.
template <class T>
CLI::Option* add_repeated(CLI::App* command, const std::string& name, std::vector<T>& values, const std::string& sentence) {
  return command->add_option(name, values, sentence)->allow_extra_args(false);
}

void add_plugins(CLI::App* command, std::vector<std::filesystem::path>& plugins);
/// Part of a job, for `work_part`.
void add_part(CLI::App* command, std::string& part, const std::string& sentence);
void add_force(CLI::App* command, bool& force);
detail::Existing existing(bool force);
void add_reader(CLI::App* command, ReadOptions& read);
void add_device(CLI::App* command, std::string& device);

struct FarArguments;
/// Options of data on another machine. \param needed  text of --data-at
void add_data_at(CLI::App* command, FarArguments& far, const std::string& needed);
/// Throws LoadError if another option needs --data-at, which is not given.
void check_data_at(const FarArguments& far, const std::string& command);

/// Folder of a trace, also from a file in it, because shells complete files.
std::filesystem::path trace_folder(const std::filesystem::path& named);

/// Options of reading a file, as in a scene's [volume].
struct HowToRead {
  std::vector<std::string> sets;
  std::vector<std::filesystem::path> partners;
};
void add_how_to_read(CLI::App* command, HowToRead& how);
/// Request without the file itself: `files` holds only its partners. Throws LoadError.
VolumeRequest request_of(const HowToRead& how);

}  // namespace palpa::app
