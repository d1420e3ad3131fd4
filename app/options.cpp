#include "app/options.h"

#include "palpa/base/load_error.h"
#include "palpa/scene/load_scene.h"

namespace palpa::app {

std::pair<std::string, std::string> split_set(const std::string& text, const std::string& example) {
  const std::size_t at = text.find('=');
  if (at == 0 || at == std::string::npos) {
    throw LoadError("--set " + text + ": is no setting; write " + example);
  }
  return {text.substr(0, at), text.substr(at + 1)};
}

std::vector<std::pair<std::string, std::string>> split_sets(const std::vector<std::string>& sets) {
  std::vector<std::pair<std::string, std::string>> settings;
  for (const std::string& set : sets) settings.push_back(split_set(set, "PATH=VALUE, as in coupling.stiffness_n_per_m=500"));
  return settings;
}

void add_plugins(CLI::App* command, std::vector<std::filesystem::path>& plugins) {
  add_repeated(command, "--plugin", plugins, "load modes from this shared library, which you trust")->type_name("FILE");
}

void add_part(CLI::App* command, std::string& part, const std::string& sentence) {
  command->add_option("--part", part, sentence + "; number and count, as in 3/64, or auto: by mpirun or Slurm")
      ->type_name("I/N");
}

void add_force(CLI::App* command, bool& force) {
  command->add_flag("--force", force, "replace files that have these names already");
}
detail::Existing existing(bool force) { return force ? detail::Existing::replaced : detail::Existing::refused; }

void add_reader(CLI::App* command, ReadOptions& read) {
  command->add_option("--reader", read.reader, "the program palpa-read, if it is not found by itself")->type_name("FILE");
}

void add_device(CLI::App* command, std::string& device) {
  command
      ->add_option("--device", device,
                   "the device that the hand holds: touch, omega, falcon, inverse3 or desktop, with values changed as in "
                   "touch,delay_ticks=2 (an ideal one: no mass, friction, encoder or delay)")
      ->type_name("DEVICE");
}

std::filesystem::path trace_folder(const std::filesystem::path& named) {
  std::error_code unknown;
  if (!std::filesystem::is_regular_file(named, unknown)) return named;
  const std::filesystem::path folder = std::filesystem::absolute(named).parent_path();
  return std::filesystem::exists(folder / "trace.toml", unknown) ? folder : named;
}

void add_how_to_read(CLI::App* command, HowToRead& how) {
  add_repeated(command, "--with", how.partners,
               "read this file with it, as a PLOT3D solution whose name is not that of its grid")
      ->type_name("FILE");
  add_repeated(command, "--set", how.sets,
               "read it as a scene would with this key of [volume], as in --set as=vector, --set length_unit=cm or, of bare "
               "numbers, --set type=int16 --set dims=[256,256,99]")
      ->type_name("KEY=VALUE");
}
VolumeRequest request_of(const HowToRead& how) {
  std::vector<std::pair<std::string, std::string>> keys;
  for (const std::string& set : how.sets) keys.push_back(split_set(set, "KEY=VALUE, as in length_unit=cm"));
  VolumeRequest request = how_to_read(keys);
  request.files = how.partners;
  return request;
}

}  // namespace palpa::app
