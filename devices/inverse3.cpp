// palpa-device-inverse3.so: Haply's Inverse3, by its Inverse Service. The service is a separate program with an open protocol:
// nothing of the vendor's is linked.
#include <algorithm>
#include <boost/asio/ip/address.hpp>
#include <sstream>

#include "devices/inverse3_link.h"
#include "palpa/base/load_error.h"
#include "palpa/device/backend.h"
#include "palpa/device/described.h"
#include "palpa/version.h"

namespace palpa::inverse3 {
namespace {

using boost::asio::ip::tcp;

constexpr std::uint16_t service_port = 10001;
// Timeout of the first states after the device was found. Longer: a silent service blocks longer; shorter: a busy service is
// refused.
constexpr double first_state_s = 2.0;
constexpr const char* how_to_get =
    "it comes with Haply's Inverse SDK (docs.haply.co) and is started by 'sudo systemctl start haply-inverse-service'";

std::vector<DeviceSetting> settings() {
  return {{"id", "the device's id, as 049D; without it the first that the service lists"},
          {"host", "address of the machine with the Inverse Service; without it 127.0.0.1"},
          {"port", "of the service, 1 to 65535; without it 10001"},
          {"force",
           "what a force is called in messages: vector (service 3.5 and later), values (before), auto (by the service's "
           "version); without it auto"},
          {"grip", "id of the grip that is the handle; without it the first with an orientation"},
          {"profile", "name of the session for the service; without it palpa:palpa"},
          {"remote", "yes: the host may be another machine, whose forces then come late and unprotected; without it no"}};
}

[[noreturn]] void refuse(const std::string& what) { throw LoadError("device inverse3: " + what); }

/// Untrusted text, for use in a sentence.
std::string in_quotes(std::string_view text) {
  constexpr std::size_t longest = 60;  // longer texts would hide the sentence
  std::string out = "'";
  for (const char c : text.substr(0, longest)) out += c >= ' ' && c <= '~' ? c : '?';
  return out + (text.size() > longest ? "…'" : "'");
}

boost::asio::ip::address address_of(const std::string& host) {
  if (host == "localhost") return boost::asio::ip::address_v4::loopback();
  boost::system::error_code error;
  const auto address = boost::asio::ip::make_address(host, error);
  if (error) refuse("host=" + in_quotes(host) + " is no address; give its digits, as 127.0.0.1 or ::1");
  return address;
}

std::string plain(const std::string& key, const std::string& value) {
  if (!is_plain(value))
    refuse(key + '=' + in_quotes(value) + " cannot be; give 1 to 64 letters, digits, '_', '-', '.' and ':'");
  return value;
}

std::optional<ForceWord> force_word(const std::string& value) {
  if (value == "vector") return ForceWord::vector;
  if (value == "values") return ForceWord::values;
  if (value != "auto") refuse("force=" + in_quotes(value) + " is not known; give auto, vector or values");
  return std::nullopt;
}

LinkOptions wanted(const DeviceSettings& given) {
  LinkOptions out{.service = {boost::asio::ip::address_v4::loopback(), service_port}, .exchange = {.profile = "palpa:palpa"}};
  bool may_be_remote = false;
  for (const auto& [key, value] : given) {
    if (key == "id") {
      out.exchange.device_id = plain(key, value);
    } else if (key == "host") {
      out.service.address(address_of(value));
    } else if (key == "port") {
      std::uint16_t port = 0;
      if (!detail::read_number(value, port) || port == 0) refuse("port=" + in_quotes(value) + " is no port; give 1 to 65535");
      out.service.port(port);
    } else if (key == "force") {
      out.exchange.word = force_word(value);
    } else if (key == "grip") {
      out.exchange.grip_id = plain(key, value);
    } else if (key == "profile") {
      out.exchange.profile = plain(key, value);
    } else if (key == "remote") {
      if (value != "yes" && value != "no") refuse("remote=" + in_quotes(value) + " is not known; give yes or no");
      may_be_remote = value == "yes";
    } else {
      refuse("it has no setting " + in_quotes(key) + "; known are id, host, port, force, grip, profile and remote");
    }
  }
  if (!may_be_remote && !out.service.address().is_loopback())
    refuse("host=" + in_quotes(out.service.address().to_string()) +
           " is another machine, and nothing keeps others from changing forces on their way; give remote=yes if you trust all "
           "that "
           "is between, or run palpa there");
  return out;
}

std::string place_of(const tcp::endpoint& service) {
  std::ostringstream place;
  place << service;
  return place.str();
}

/// Settings in the description of a device, without defaults.
std::string description_of(const std::string& device_id, const tcp::endpoint& service) {
  std::string out = "inverse3,id=" + device_id;
  const auto address = service.address();
  if (address != boost::asio::ip::address_v4::loopback()) out += ",host=" + address.to_string();
  if (service.port() != service_port) out += ",port=" + std::to_string(service.port());
  if (!address.is_loopback()) out += ",remote=yes";
  return out;
}

DeviceSearch search(const DeviceSettings& given) {
  const LinkOptions want = wanted(given);
  const std::string place = place_of(want.service);
  const std::optional<ServiceView> view = look(want.service);
  if (!view) return {.found = {}, .missing = {"the Inverse Service does not answer at " + place + "; " + how_to_get}};
  DeviceSearch out;
  for (const std::string& id : view->device_ids) {
    if (!want.exchange.device_id.empty() && id != want.exchange.device_id) continue;
    out.found.push_back({description_of(id, want.service), "Haply Inverse3 " + id + ", at the Inverse Service on " + place});
  }
  if (out.found.empty())
    out.missing.push_back("the Inverse Service at " + place + " has no Inverse3" +
                          (want.exchange.device_id.empty() ? "" : ' ' + want.exchange.device_id) +
                          "; plug it in and switch on its power supply");
  return out;
}

std::string chosen_id(const LinkOptions& want) {
  const std::string place = place_of(want.service);
  const std::optional<ServiceView> view = look(want.service);
  if (!view) refuse("the Inverse Service does not answer at " + place + "; " + how_to_get);
  const auto has_grip = [&] {
    return std::ranges::any_of(view->grips, [&](const ServiceGrip& grip) { return grip.device_id == want.exchange.grip_id; });
  };
  if (!want.exchange.grip_id.empty() && !has_grip())
    refuse("the Inverse Service at " + place + " has no grip with grip=" + want.exchange.grip_id +
           "; switch it on, or leave it out");
  if (view->device_ids.empty())
    refuse("the Inverse Service at " + place + " has no Inverse3; plug one in and switch on its power supply");
  if (want.exchange.device_id.empty()) return view->device_ids.front();
  std::string known;
  for (const std::string& id : view->device_ids) {
    if (id == want.exchange.device_id) return id;
    known += (known.empty() ? "" : ", ") + id;
  }
  refuse("the Inverse Service at " + place + " has no Inverse3 with id=" + want.exchange.device_id + "; it has " + known);
}

class Inverse3 final : public Device {
 public:
  explicit Inverse3(const LinkOptions& options) : link_(options), device_id_(options.exchange.device_id) {
    const bool is_there = link_.wait(first_state_s);
    const DeviceState state = link_.read();
    senses_turn_ = state.turn.has_value();
    if (is_there) return;
    const char* const fault = state.fault;
    refuse(std::string(fault != nullptr ? fault : "the service does not answer") + "; restart it, or look at its log");
  }
  std::string name() const override { return "Haply Inverse3 " + device_id_; }
  DeviceLimits limits() const override {
    DeviceLimits limits = device_limits;
    limits.senses_turn = senses_turn_;
    return limits;
  }
  DeviceState read() noexcept override { return link_.read(); }
  bool write(const Vec3& force_n) noexcept override { return link_.write(force_n); }
  bool rests() const noexcept override { return link_.rests(); }

 private:
  Link link_;
  std::string device_id_;
  bool senses_turn_ = false;  // a grip with an orientation was there when it was opened
};

std::unique_ptr<Device> open(const DeviceSettings& given) {
  LinkOptions options = wanted(given);
  options.exchange.device_id = chosen_id(options);
  return std::make_unique<Inverse3>(options);
}

}  // namespace
}  // namespace palpa::inverse3

extern "C" __attribute__((visibility("default"))) const palpa::DeviceBackend palpa_device_backend;
const palpa::DeviceBackend palpa_device_backend{palpa::version,
                                                "inverse3",
                                                "Haply Inverse3, Inverse3x and minVerse, by the Inverse Service",
                                                "x to the right, y away from the user, z up",
                                                palpa::inverse3::settings,
                                                palpa::inverse3::search,
                                                palpa::inverse3::open};
