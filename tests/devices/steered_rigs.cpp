#include "tests/devices/steered_rigs.h"

#include <SDL.h>
#include <poll.h>
#include <stdlib.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <mutex>
#include <stdexcept>
#include <thread>

#include "palpa/device/open_device.h"

namespace palpa {

namespace {

/// spacenavd's socket: whoever connects says which protocol it knows, is told the same, and then gets eight numbers for each
/// event.
class SpaceMouseRig final : public Rig {
 public:
  SpaceMouseRig() {
    std::string name = (std::filesystem::temp_directory_path() / "palpa-spnav-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
    folder_ = name;
    ::setenv("SPNAV_SOCKET", path().c_str(), 1);
    plug();
  }
  ~SpaceMouseRig() override {
    unplug();
    std::filesystem::remove_all(folder_);
  }
  std::unique_ptr<Device> open() override { return device_backend("spacemouse").open({}); }
  void hold(const Vec3& position_m, const Vec3&) override {
    deflection_ = position_m;
    tell_motion();
  }
  Vec3 force_n() override { return {}; }
  void press_button(int number, bool down) override { tell({down ? 1 : 2, number, 0, 0, 0, 0, 0, 0}); }
  void unplug() override {
    ends_ = true;
    if (server_.joinable()) server_.join();
  }
  void plug() override {
    ends_ = false;
    sockaddr_un address{};
    address.sun_family = AF_UNIX;
    std::strncpy(address.sun_path, path().c_str(), sizeof address.sun_path - 1);
    ::unlink(address.sun_path);
    const int listener = ::socket(AF_UNIX, SOCK_STREAM, 0);
    if (::bind(listener, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0 || ::listen(listener, 4) != 0)
      throw std::runtime_error("the stand-in for spacenavd cannot listen");
    server_ = std::thread([this, listener] { serve(listener); });
  }

 private:
  using Event = std::array<std::int32_t, 8>;
  static constexpr std::int32_t hello = 0x7faa5501;
  std::string path() const { return (folder_ / "spnav.sock").string(); }

  void serve(int listener) {
    int client = -1;
    while (!ends_) {
      pollfd both[2] = {{.fd = listener, .events = POLLIN, .revents = 0}, {.fd = client, .events = POLLIN, .revents = 0}};
      if (::poll(both, 2, 5) <= 0) continue;
      if (both[0].revents != 0) {
        const std::lock_guard lock(mutex_);
        if (client >= 0) ::close(client);
        client = client_ = ::accept(listener, nullptr, nullptr);
        continue;
      }
      std::int32_t word = 0;
      const ssize_t read = ::read(client, &word, sizeof word);
      const std::lock_guard lock(mutex_);
      if (read <= 0) {
        ::close(client);
        client = client_ = -1;
      } else if (word == hello) {
        [[maybe_unused]] const ssize_t written = ::write(client, &word, sizeof word);
        is_greeted_ = true;
      }
    }
    const std::lock_guard lock(mutex_);
    if (client >= 0) ::close(client);
    client_ = -1;
    is_greeted_ = false;
    ::close(listener);
    ::unlink(path().c_str());
  }
  void tell(const Event& event) {
    for (int n = 0; n < 2000; ++n) {
      {
        const std::lock_guard lock(mutex_);
        if (is_greeted_) {
          [[maybe_unused]] const ssize_t written = ::send(client_, event.data(), sizeof event, MSG_NOSIGNAL);
          return;
        }
      }
      ::usleep(1000);  // until the device has connected
    }
  }
  // Pushed right, up and away from the user the ball's three numbers grow. In its order of a message: x, z of ours swapped in
  // sign by the vendor.
  void tell_motion() {
    const auto counts = [](double share) { return static_cast<std::int32_t>(std::lround(350.0 * share)); };
    tell({0, counts(deflection_.x), counts(deflection_.y), counts(-deflection_.z), 0, 0, 0, 16});
  }

  std::filesystem::path folder_;
  std::thread server_;
  std::atomic<bool> ends_{false};
  std::mutex mutex_;
  int client_ = -1;
  bool is_greeted_ = false;
  Vec3 deflection_;
};

/// A joystick that SDL makes up.
class ControllerRig final : public ControllerRigBase {
 public:
  ControllerRig() {
    SDL_SetHint(SDL_HINT_JOYSTICK_ALLOW_BACKGROUND_EVENTS, "1");
    if (SDL_InitSubSystem(SDL_INIT_GAMECONTROLLER) != 0) throw std::runtime_error(SDL_GetError());
    plug();
  }
  ~ControllerRig() override {
    unplug();
    SDL_QuitSubSystem(SDL_INIT_GAMECONTROLLER);
  }
  std::unique_ptr<Device> open() override { return device_backend("controller").open({}); }
  void hold(const Vec3& position_m, const Vec3&) override {
    deflection_ = position_m;
    set();
  }
  Vec3 force_n() override { return {}; }
  void press_button(int number, bool down) override { SDL_JoystickSetVirtualButton(joystick_, number, down ? 1 : 0); }
  void unplug() override {
    if (joystick_ != nullptr) SDL_JoystickClose(joystick_);
    joystick_ = nullptr;
    for (int n = SDL_NumJoysticks() - 1; n >= 0; --n)
      if (SDL_JoystickIsVirtual(n) == SDL_TRUE) SDL_JoystickDetachVirtual(n);
  }
  void plug() override {
    SDL_VirtualJoystickDesc made{};
    made.version = SDL_VIRTUAL_JOYSTICK_DESC_VERSION;
    made.type = SDL_JOYSTICK_TYPE_GAMECONTROLLER;
    made.naxes = SDL_CONTROLLER_AXIS_MAX;
    made.nbuttons = SDL_CONTROLLER_BUTTON_MAX;
    made.name = "made-up controller";
    made.userdata = this;
    made.Rumble = [](void* self, Uint16 slow, Uint16 fast) {
      auto& rig = *static_cast<ControllerRig*>(self);
      rig.slow_ = slow / 65535.0;
      rig.fast_ = fast / 65535.0;
      return 0;
    };
    const int index = SDL_JoystickAttachVirtualEx(&made);
    joystick_ = index < 0 ? nullptr : SDL_JoystickOpen(index);
    if (joystick_ == nullptr) throw std::runtime_error(SDL_GetError());
    set();
  }
  Rumble rumble() override { return {slow_, fast_}; }

 private:
  // Sticks count to the right and towards the user; pushed up the right one counts down.
  void set() {
    const auto counts = [](double share) { return static_cast<Sint16>(std::lround(32767.0 * share)); };
    SDL_JoystickSetVirtualAxis(joystick_, SDL_CONTROLLER_AXIS_LEFTX, counts(deflection_.x));
    SDL_JoystickSetVirtualAxis(joystick_, SDL_CONTROLLER_AXIS_LEFTY, counts(deflection_.z));
    SDL_JoystickSetVirtualAxis(joystick_, SDL_CONTROLLER_AXIS_RIGHTY, counts(-deflection_.y));
  }

  SDL_Joystick* joystick_ = nullptr;
  Vec3 deflection_;
  std::atomic<double> slow_{0.0}, fast_{0.0};
};

}  // namespace

std::unique_ptr<Rig> spacemouse_rig() { return std::make_unique<SpaceMouseRig>(); }
std::unique_ptr<ControllerRigBase> controller_rig() { return std::make_unique<ControllerRig>(); }

}  // namespace palpa
