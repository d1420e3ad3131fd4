// palpa-device-igtl.so: a tracker as a hand without motors, by a server of OpenIGTLink (PLUS, 3D Slicer, a maker's program).
#include <algorithm>
#include <string>

#include "devices/igtl_link.h"
#include "palpa/base/load_error.h"
#include "palpa/base/wording.h"
#include "palpa/device/backend.h"
#include "palpa/device/described.h"
#include "palpa/version.h"

namespace palpa::igtl {
namespace {

constexpr std::uint16_t usual_port = 18944;
// Of an arm's reach about the origin. Larger: a hand that is simulated in its place wanders off; smaller: unused reach.
constexpr double workspace_radius_m = 0.3;
// No motors to protect: the force is shown alone.
constexpr double most_n = 10.0;
// Timeout of the first pose. Longer: a hidden tracker blocks longer; shorter: a slow one is refused.
constexpr double first_pose_s = 2.0;
constexpr const char* how_to_get = "start the tracker's program, as PlusServer, or in 3D Slicer a connector that is a server";

std::vector<DeviceSetting> settings() {
  return {
      {"name", "device name of the tracker's TRANSFORM, as Stylus; without it the first that comes"},
      {"host", "address of the machine with the tracker's server; without it 127.0.0.1"},
      {"port", "of the server, 1 to 65535; without it 18944"},
      {"zero",
       "ras: the hand frame's origin is that of the tracker's RAS frame; here: it is where the tracker is first; without it "
       "ras"},
      {"remote", "yes: the host may be another machine, whose positions then come late and unprotected; without it no"}};
}

[[noreturn]] void refuse(const std::string& what) { throw LoadError(detail::one_line("device igtl: " + what)); }

struct Wanted {
  Service service;
  std::string name;
  bool here = false;
};

Wanted wanted(const DeviceSettings& given) {
  Wanted out;
  std::string host = "127.0.0.1";
  std::uint16_t port = usual_port;
  bool may_be_remote = false;
  for (const auto& [key, value] : given) {
    const auto is_choice = [&](const char* a, const char* b) {
      if (value != a && value != b) refuse(key + '=' + detail::in_quotes(value) + " is not known; give " + a + " or " + b);
      return value == a;
    };
    if (key == "name") {
      if (value.empty() || value.size() > Head{}.name.size())
        refuse("name=" + detail::in_quotes(value) + " cannot be; give 1 to 20 letters");
      out.name = value;
    } else if (key == "host") {
      host = value;
    } else if (key == "port") {
      if (!detail::read_number(value, port) || port == 0)
        refuse("port=" + detail::in_quotes(value) + " is no port; give 1 to 65535");
    } else if (key == "zero") {
      out.here = is_choice("here", "ras");
    } else if (key == "remote") {
      may_be_remote = is_choice("yes", "no");
    } else {
      refuse("it has no setting " + detail::in_quotes(key) + "; known are name, host, port, zero and remote");
    }
  }
  const std::optional<Service> service = service_at(host, port);
  if (!service) refuse("host=" + detail::in_quotes(host) + " is no address; give its digits, as 127.0.0.1 or ::1");
  if (!may_be_remote && !service->is_loopback)
    refuse("host=" + detail::in_quotes(host) +
           " is another machine, and nothing keeps others from changing positions on their way; give remote=yes if you trust "
           "all that is between");
  out.service = *service;
  return out;
}

bool is_describable(const std::string& name) {
  return !name.empty() &&
         std::ranges::all_of(name, [](char c) { return c > ' ' && c <= '~' && c != ',' && c != '\'' && c != '"'; });
}

std::string description_of(const std::string& name, const DeviceSettings& given) {
  std::string out = "igtl,name=" + name;
  for (const auto& [key, value] : given)
    if (key != "name") out += ',' + key + '=' + value;
  return out;
}

DeviceSearch search(const DeviceSettings& given) {
  const Wanted want = wanted(given);
  const std::optional<std::vector<std::string>> names = names_at(want.service);
  if (!names) return {.found = {}, .missing = {"no OpenIGTLink server answers at " + want.service.words + "; " + how_to_get}};
  DeviceSearch out;
  for (const std::string& name : *names) {
    if ((!want.name.empty() && name != want.name) || !is_describable(name)) continue;
    out.found.push_back(
        {description_of(name, given), "the tracker " + name + ", at the OpenIGTLink server on " + want.service.words});
  }
  if (out.found.empty())
    out.missing.push_back(detail::one_line("the OpenIGTLink server at " + want.service.words + " sends no TRANSFORM" +
                                           (want.name.empty() ? std::string() : " of " + want.name) +
                                           "; show the tracker to its camera"));
  return out;
}

class Tracker final : public Device {
 public:
  explicit Tracker(const Wanted& want) : link_(want.service, want.name, want.here) {
    if (link_.wait(first_pose_s)) return;
    const std::vector<std::string> others = link_.names();
    if (others.empty()) {
      const DeviceState state = link_.read();
      refuse(std::string(state.fault != nullptr ? state.fault : "no pose came") + ", at " + want.service.words + "; " +
             how_to_get);
    }
    refuse("no transform of " + detail::in_quotes(want.name) + " comes from " + want.service.words + "; it sends " +
           detail::joined(others));
  }
  std::string name() const override { return "tracker " + link_.name(); }
  DeviceLimits limits() const override {
    return {.max_force_n = most_n, .has_motors = false, .workspace_radius_m = workspace_radius_m, .senses_turn = true};
  }
  DeviceState read() noexcept override { return link_.read(); }
  bool write(const Vec3&) noexcept override { return true; }
  bool rests() const noexcept override { return true; }

 private:
  TrackerLink link_;
};

std::unique_ptr<Device> open(const DeviceSettings& given) { return std::make_unique<Tracker>(wanted(given)); }

}  // namespace
}  // namespace palpa::igtl

extern "C" __attribute__((visibility("default"))) const palpa::DeviceBackend palpa_device_backend;
const palpa::DeviceBackend palpa_device_backend{
    palpa::version,
    "igtl",
    "tracker of an OpenIGTLink server, as PLUS or 3D Slicer: position and orientation, without force",
    "RAS: x to the patient's right, y to the front, z to the head",
    palpa::igtl::settings,
    palpa::igtl::search,
    palpa::igtl::open};
