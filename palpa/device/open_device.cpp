#include "palpa/device/open_device.h"

#include <dlfcn.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <sstream>
#include <utility>

#include "palpa/base/input_file.h"
#include "palpa/base/limits.h"
#include "palpa/base/load_error.h"
#include "palpa/base/new_file.h"
#include "palpa/base/own_files.h"
#include "palpa/base/toml_problem.h"
#include "palpa/base/wording.h"
#include "palpa/device/blocked_signals.h"
#include "palpa/device/described.h"
#include "palpa/device/hand.h"
#include "palpa/version.h"

namespace palpa {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view prefix = "palpa-device-";

std::vector<fs::path> shared_objects() {
  for (const fs::path& folder : own_files_folders()) {
    std::vector<fs::path> files;
    std::error_code none;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder, none)) {
      const std::string name = entry.path().filename().string();
      if (name.starts_with(prefix) && name.ends_with(".so")) files.push_back(entry.path());
    }
    std::sort(files.begin(), files.end());
    if (!files.empty()) return files;
  }
  return {};
}

const DeviceBackend* load(const fs::path& file) {
  void* const library = ::dlopen(file.c_str(), RTLD_NOW | RTLD_LOCAL);
  if (!library)
    throw LoadError(detail::one_line(file.string() + ": cannot be loaded (" + ::dlerror() + "); install palpa again"));
  const auto* const backend = static_cast<const DeviceBackend*>(::dlsym(library, "palpa_device_backend"));
  if (!backend || std::strcmp(backend->palpa_version, version) != 0)
    throw LoadError(file.string() + ": is not of this palpa, " + version + "; install palpa again");
  return backend;
}

// Keys of devices.toml. Limits may only be lowered; measurements replace the device's values.
struct Note {
  const char* key;
  std::optional<double> DeviceNotes::*of;
  double DeviceLimits::*limit;
  double most;
  bool lowers;
};
constexpr Note all_notes[] = {
    {"max_force_n", &DeviceNotes::max_force_n, &DeviceLimits::max_force_n, 100.0, true},
    {"continuous_force_n", &DeviceNotes::continuous_force_n, &DeviceLimits::continuous_force_n, 100.0, true},
    {"max_stiffness_n_per_m", &DeviceNotes::max_stiffness_n_per_m, &DeviceLimits::max_stiffness_n_per_m, 1e5, true},
    {"max_damping_ns_per_m", &DeviceNotes::max_damping_ns_per_m, &DeviceLimits::max_damping_ns_per_m, 100.0, true},
    {"max_torque_nm", &DeviceNotes::max_torque_nm, &DeviceLimits::max_torque_nm, 10.0, true},
    {"max_turn_stiffness_nm_per_rad", &DeviceNotes::max_turn_stiffness_nm_per_rad, &DeviceLimits::max_turn_stiffness_nm_per_rad,
     100.0, true},
    {"max_turn_damping_nms_per_rad", &DeviceNotes::max_turn_damping_nms_per_rad, &DeviceLimits::max_turn_damping_nms_per_rad,
     1.0, true},
    {"encoder_step_m", &DeviceNotes::encoder_step_m, &DeviceLimits::encoder_step_m, 0.01, false},
    {"damping_ns_per_m", &DeviceNotes::damping_ns_per_m, &DeviceLimits::damping_ns_per_m, 100.0, false},
};

std::string place_of(const fs::path& file, const toml::source_region& at) {
  return file.string() + ":" + std::to_string(at.begin.line) + ":" + std::to_string(at.begin.column) + ": ";
}

std::optional<toml::table> read(const fs::path& file) {
  const detail::InputFile opened(file);
  if (opened.why_not() == detail::NoInput::missing) return std::nullopt;
  const std::string text = detail::read_whole(opened, limit::notes_bytes, limit::notes_bytes.remedy);
  if (const auto problem = detail::problem_with_toml(text))
    throw LoadError(file.string() + ":" + std::to_string(problem->line) + ": " + problem->sentence);
  try {
    return toml::parse(text, file.string());
  } catch (const toml::parse_error& problem) {
    throw LoadError(detail::one_line(place_of(file, problem.source()) + std::string(problem.description()) +
                                     "; it holds tables like [inverse3] with lines like max_force_n = 2"));
  }
}

// Device with the user's notes: force and torque within the lowered limits.
class NotedDevice final : public Device {
 public:
  NotedDevice(std::unique_ptr<Device> device, const DeviceLimits& limits) : device_(std::move(device)), limits_(limits) {}
  std::string name() const override { return device_->name(); }
  DeviceLimits limits() const override { return limits_; }
  DeviceState read() noexcept override { return device_->read(); }
  bool write(const Vec3& force_n) noexcept override { return write(force_n, {}); }
  bool write(const Vec3& force_n, const Vec3& torque_nm) noexcept override {
    if (!is_finite(force_n) || !is_finite(torque_nm)) return device_->write({}, {});
    return device_->write(shortened(force_n, limits_.max_force_n), shortened(torque_nm, limits_.max_torque_nm));
  }
  bool brake(bool on) noexcept override { return device_->brake(on); }
  bool rests() const noexcept override { return device_->rests(); }

 private:
  std::unique_ptr<Device> device_;
  DeviceLimits limits_;
};

}  // namespace

DeviceDescription device_description(const std::string& text) {
  std::string_view rest = text;
  DeviceDescription description{.name = std::string(detail::next_word(rest)), .settings = {}};
  if (!detail::is_plain_word(description.name))
    throw LoadError("device: " + detail::in_quotes(description.name) + " is no name of a device; 'palpa devices' lists them");
  while (!rest.empty()) {
    const std::string_view word = detail::next_word(rest);
    const auto [key, value] = detail::key_and_value(word);
    if (key.empty() || key.size() == word.size())
      throw LoadError("device: " + detail::in_quotes(word) + " is no setting; write NAME,KEY=VALUE as in inverse3,port=10001");
    description.settings.emplace_back(key, value);
  }
  return description;
}

std::vector<const DeviceBackend*> device_backends() {
  static std::mutex mutex;
  static std::vector<const DeviceBackend*> backends;
  static bool is_loaded = false;
  const std::lock_guard lock(mutex);
  if (is_loaded) return backends;
  std::vector<const DeviceBackend*> found;
  for (const fs::path& file : shared_objects()) found.push_back(load(file));
  backends = std::move(found);
  is_loaded = true;
  return backends;
}

const DeviceBackend& device_backend(const std::string& name) {
  std::vector<std::string> names;
  for (const DeviceBackend* backend : device_backends()) {
    if (backend->name == name) return *backend;
    names.emplace_back(backend->name);
  }
  if (names.empty())
    throw LoadError("device " + name + ": this palpa was built without devices; build it with PALPA_DEVICES=ON");
  const bool is_model = std::ranges::any_of(device_presets(), [&](const DevicePlant& plant) { return plant.name == name; });
  if (is_model)
    throw LoadError("device: '" + name +
                    "' is a model of a device, for palpa check and palpa run --hand; device drivers: " + detail::joined(names));
  throw LoadError("device: no kind " + detail::in_quotes(name) + "; " + detail::suggestion(name, names));
}

fs::path device_notes_file() {
  if (const char* file = std::getenv("PALPA_DEVICES"); file && *file) return file;
  if (const char* folder = std::getenv("XDG_CONFIG_HOME"); folder && *folder)
    return fs::path(folder) / "palpa" / "devices.toml";
  if (const char* home = std::getenv("HOME"); home && *home) return fs::path(home) / ".config" / "palpa" / "devices.toml";
  return {};
}

DeviceNotes device_notes(const fs::path& file, const std::string& name) {
  DeviceNotes notes;
  const std::optional<toml::table> all = read(file);
  if (!all) return notes;
  const toml::node* const given = all->get(name);
  if (!given) return notes;
  const toml::table* const table = given->as_table();
  if (!table) throw LoadError(place_of(file, given->source()) + name + " is no table; write [" + name + "] and keys below it");
  for (const auto& [key, value] : *table) {
    const auto* const note = std::ranges::find_if(all_notes, [&](const Note& one) { return key.str() == one.key; });
    const std::string place = place_of(file, value.source());
    if (note == std::end(all_notes)) {
      std::vector<std::string> keys;
      for (const Note& one : all_notes) keys.emplace_back(one.key);
      throw LoadError(place + "unknown key " + detail::in_quotes(key.str()) + "; " + detail::suggestion(key.str(), keys));
    }
    const std::optional<double> number = value.is_number() ? value.value<double>() : std::nullopt;
    if (!number || !(*number >= 0.0 && *number <= note->most)) {
      throw LoadError(place + std::string(note->key) + " cannot be used; it is a number from 0 to " +
                      detail::toml_number(note->most));
    }
    notes.*note->of = number;
  }
  return notes;
}

void keep_device_notes(const fs::path& file, const std::string& name, const DeviceNotes& notes) {
  toml::table all = read(file).value_or(toml::table{});
  toml::table* table = all[name].as_table();
  if (!table) table = all.insert_or_assign(name, toml::table{}).first->second.as_table();
  for (const Note& note : all_notes) {
    if (notes.*note.of) table->insert_or_assign(note.key, *(notes.*note.of));
  }
  std::error_code error;
  fs::create_directories(file.parent_path(), error);
  std::ostringstream text;
  text << all << "\n";
  detail::write_whole(file, text.view(), detail::Existing::replaced);
}

DeviceLimits with_notes(const DeviceLimits& limits, const DeviceNotes& notes, const std::string& place) {
  DeviceLimits noted = limits;
  for (const Note& note : all_notes) {
    const std::optional<double>& value = notes.*note.of;
    if (!value) continue;
    if (note.lowers && *value > limits.*note.limit) {
      throw LoadError(place + ": " + note.key + " = " + detail::toml_number(*value) + " would raise the device's limit of " +
                      detail::toml_number(limits.*note.limit) + "; it may only lower it");
    }
    noted.*note.limit = *value;
  }
  return noted;
}

std::unique_ptr<Device> open_device(const DeviceDescription& description, const fs::path& notes_file) {
  const DeviceBackend& backend = device_backend(description.name);
  const DeviceNotes notes = device_notes(notes_file, description.name);
  std::unique_ptr<Device> device;
  {
    const detail::BlockedSignals on_threads_of_the_driver;
    device = backend.open(description.settings);
  }
  if (notes == DeviceNotes{}) return device;
  const DeviceLimits limits = with_notes(device->limits(), notes, notes_file.string() + ": [" + description.name + "]");
  return std::make_unique<NotedDevice>(std::move(device), limits);
}

}  // namespace palpa
