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

#include "palpa/device/mouse_hand.h"

namespace palpa {

namespace {

/// spacenavd's socket: a client sends its protocol version, gets it back, may then query, and gets eight numbers for each
/// event.
class SpaceMouseRig final : public Rig {
 public:
  SpaceMouseRig() {
    std::string name = (std::filesystem::temp_directory_path() / "palpa-spnav-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
    folder_ = name;
    ::setenv("SPNAV_SOCKET", path().c_str(), 1);
    start();
  }
  ~SpaceMouseRig() override {
    stop();
    std::filesystem::remove_all(folder_);
  }
  std::unique_ptr<Device> open() override { return opened("spacemouse", {}); }
  void hold(const Vec3& position_m, const Vec3&) override {
    deflection_ = position_m;
    if (is_there_) tell_motion(deflection_);
  }
  Vec3 force_n() override { return {}; }
  void press_button(int number, bool down) override {
    if (is_there_) tell({down ? 1 : 2, number, 0, 0, 0, 0, 0, 0});
  }
  void unplug() override { change(is_there_, false, own); }
  void plug() override { change(is_there_, true, own); }
  // Two devices of a model are indistinguishable: the other is of another model.
  void plug_another() override {
    change(is_another_there_, true, others);
    use_another();
  }
  void unplug_another() override { change(is_another_there_, false, others); }
  void use_another() override {
    tell_motion({-1, 1, 1});
    tell({1, 0, 0, 0, 0, 0, 0, 0});
  }
  bool is_another_touched() override { return false; }
  std::vector<Fault> ways_to_go() override {
    std::vector<Fault> ways = Rig::ways_to_go();
    ways.push_back({"spacenavd ends", [this] { stop(); }, [this] { start(); }});
    ways.push_back({"unplugged while spacenavd is away",
                    [this] {
                      stop();
                      is_there_ = false;
                      start();
                    },
                    [this] { plug(); }});
    return ways;
  }

 private:
  using Event = std::array<std::int32_t, 8>;
  struct Model {
    std::int32_t type, usb_vendor, usb_product;
  };
  static constexpr Model own{0x206, 0x256f, 0xc62e}, others{0x20a, 0x256f, 0xc631};
  static constexpr std::int32_t hello = 0x7faa5501, tag = 0x7faa0000;
  std::string path() const { return (folder_ / "spnav.sock").string(); }

  void start() {
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
  void stop() {
    ends_ = true;
    if (server_.joinable()) server_.join();
  }
  void change(std::atomic<bool>& is_there, bool there, const Model& model) {
    is_there = there;
    tell({3, there ? 0 : 1, 1, model.type, model.usb_vendor, model.usb_product, 0, 0});
  }
  /// Queries of the first SpaceMouse, and the sensitivity, which is always available.
  Event answered(Event question) const {
    const Model* model = is_there_ ? &own : is_another_there_ ? &others : nullptr;
    Event answer{question[0], 0, 0, 0, 0, 0, 0, 0};
    switch (question[0] - tag) {
      case 0x2004:
        if (model) answer[1] = model->usb_vendor, answer[2] = model->usb_product;
        break;
      case 0x2005:
        if (model) answer[1] = model->type;
        break;
      case 0x3001: answer[1] = 0x3f800000; return answer;
      default: break;
    }
    answer[7] = model ? 0 : -1;
    return answer;
  }

  void serve(int listener) {
    int client = -1;
    while (!ends_) {
      pollfd both[2] = {{.fd = listener, .events = POLLIN, .revents = 0}, {.fd = client, .events = POLLIN, .revents = 0}};
      if (::poll(both, 2, 5) <= 0) continue;
      if (both[0].revents != 0) {
        const std::lock_guard lock(mutex_);
        if (client >= 0) ::close(client);
        client = client_ = ::accept(listener, nullptr, nullptr);
        is_greeted_ = false;
        continue;
      }
      std::int32_t word = 0;
      Event question{};
      const ssize_t read = is_greeted_ ? ::read(client, question.data(), sizeof question) : ::read(client, &word, sizeof word);
      const std::lock_guard lock(mutex_);
      if (read <= 0) {
        ::close(client);
        client = client_ = -1;
        is_greeted_ = false;
      } else if (is_greeted_) {
        const Event answer = answered(question);
        [[maybe_unused]] const ssize_t written = ::send(client, answer.data(), sizeof answer, MSG_NOSIGNAL);
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
    for (int n = 0; n < 500; ++n) {
      {
        const std::lock_guard lock(mutex_);
        if (is_greeted_) {
          [[maybe_unused]] const ssize_t written = ::send(client_, event.data(), sizeof event, MSG_NOSIGNAL);
          return;
        }
      }
      if (ends_) return;
      ::usleep(1000);  // until the device has connected, if there is one
    }
  }
  // Pushed right, up and away from the user the ball's three numbers grow. In a message's order: our x, z with the vendor's
  // swapped sign.
  void tell_motion(const Vec3& deflection) {
    const auto counts = [](double share) { return static_cast<std::int32_t>(std::lround(350.0 * share)); };
    tell({0, counts(deflection.x), counts(deflection.y), counts(-deflection.z), 0, 0, 0, 16});
  }

  std::filesystem::path folder_;
  std::thread server_;
  std::atomic<bool> ends_{false};
  std::mutex mutex_;
  int client_ = -1;
  std::atomic<bool> is_greeted_{false};
  std::atomic<bool> is_there_{true}, is_another_there_{false};
  Vec3 deflection_;
};

class ControllerRig final : public ControllerRigBase {
 public:
  ControllerRig() {
    SDL_SetHint(SDL_HINT_JOYSTICK_ALLOW_BACKGROUND_EVENTS, "1");
    if (SDL_InitSubSystem(SDL_INIT_GAMECONTROLLER) != 0) throw std::runtime_error(SDL_GetError());
    plug();
  }
  ~ControllerRig() override {
    unplug();
    unplug_another();
    SDL_QuitSubSystem(SDL_INIT_GAMECONTROLLER);
  }
  std::unique_ptr<Device> open() override { return opened("controller", {}); }
  void hold(const Vec3& position_m, const Vec3&) override {
    deflection_ = position_m;
    if (joystick_ != nullptr) set(joystick_, deflection_);
  }
  Vec3 force_n() override { return {}; }
  void press_button(int number, bool down) override {
    if (joystick_ != nullptr) SDL_JoystickSetVirtualButton(joystick_, number, down ? 1 : 0);
  }
  void unplug() override { detach(joystick_); }
  void plug() override {
    joystick_ = attached(own_, name);
    set(joystick_, deflection_);
  }
  void plug_another() override {
    // Without serial numbers a second device of the model cannot be distinguished from the absent first.
    another_ = attached(anothers_, joystick_ != nullptr ? name : "another made-up controller");
    set(another_, {-1, 1, 1});
    SDL_JoystickSetVirtualButton(another_, 0, 1);
  }
  void unplug_another() override { detach(another_); }
  bool is_another_touched() override { return anothers_.told > 0; }
  Rumble rumble() override { return {own_.slow, own_.fast}; }

 private:
  struct Motors {
    std::atomic<double> slow{0.0}, fast{0.0};
    std::atomic<int> told{0};
  };
  static constexpr const char* name = "made-up controller";
  static SDL_Joystick* attached(Motors& motors, const char* called) {
    SDL_VirtualJoystickDesc made{};
    made.version = SDL_VIRTUAL_JOYSTICK_DESC_VERSION;
    made.type = SDL_JOYSTICK_TYPE_GAMECONTROLLER;
    made.naxes = SDL_CONTROLLER_AXIS_MAX;
    made.nbuttons = SDL_CONTROLLER_BUTTON_MAX;
    made.name = called;
    made.userdata = &motors;
    made.Rumble = [](void* self, Uint16 slow, Uint16 fast) {
      auto& told = *static_cast<Motors*>(self);
      told.slow = slow / 65535.0;
      told.fast = fast / 65535.0;
      ++told.told;
      return 0;
    };
    const int index = SDL_JoystickAttachVirtualEx(&made);
    SDL_Joystick* const joystick = index < 0 ? nullptr : SDL_JoystickOpen(index);
    if (joystick == nullptr) throw std::runtime_error(SDL_GetError());
    return joystick;
  }
  static void detach(SDL_Joystick*& joystick) {
    if (joystick == nullptr) return;
    const SDL_JoystickID id = SDL_JoystickInstanceID(joystick);
    SDL_JoystickClose(joystick);
    joystick = nullptr;
    for (int n = SDL_NumJoysticks() - 1; n >= 0; --n)
      if (SDL_JoystickGetDeviceInstanceID(n) == id) SDL_JoystickDetachVirtual(n);
  }
  // Sticks count to the right and towards the user; the right stick pushed up counts down.
  static void set(SDL_Joystick* joystick, const Vec3& deflection) {
    const auto counts = [](double share) { return static_cast<Sint16>(std::lround(32767.0 * share)); };
    SDL_JoystickSetVirtualAxis(joystick, SDL_CONTROLLER_AXIS_LEFTX, counts(deflection.x));
    SDL_JoystickSetVirtualAxis(joystick, SDL_CONTROLLER_AXIS_LEFTY, counts(deflection.z));
    SDL_JoystickSetVirtualAxis(joystick, SDL_CONTROLLER_AXIS_RIGHTY, counts(-deflection.y));
  }

  Motors own_, anothers_;
  SDL_Joystick *joystick_ = nullptr, *another_ = nullptr;
  Vec3 deflection_;
};

/// A window with a mouse: it sends motions while it has it, and one in vain after losing it.
class PointerRig final : public Rig {
 public:
  std::unique_ptr<Device> open() override {
    auto pointer = std::make_unique<Watched>(*this);
    pointer_ = pointer.get();
    pointer_->have_mouse(has_mouse_);
    return pointer;
  }
  void hold(const Vec3& position_m, const Vec3&) override {
    if (pointer_ != nullptr) pointer_->move(position_m);
  }
  Wrist wrist() const override { return Wrist::sensed; }
  void turn(const Turn& turn) override {
    if (pointer_ != nullptr) pointer_->turn(rotation_between_rad(turn_, turn));
    turn_ = turn;
  }
  Vec3 force_n() override { return {}; }
  void press_button(int number, bool down) override {
    buttons_ = down ? buttons_ | (1u << number) : buttons_ & ~(1u << number);
    if (pointer_ != nullptr) pointer_->press(buttons_);
  }
  void unplug() override { have(false); }
  void plug() override { have(true); }
  // A window has one mouse.
  void plug_another() override {}
  void unplug_another() override {}
  bool is_another_touched() override { return false; }
  std::vector<Fault> ways_to_go() override {
    return {{"another window has the mouse", [this] { unplug(); }, [this] { plug(); }}};
  }

 private:
  struct Watched final : Device {
    explicit Watched(PointerRig& its_rig) : rig(its_rig) {}
    ~Watched() override { rig.pointer_ = nullptr; }
    std::string name() const override { return pointer.name(); }
    DeviceLimits limits() const override { return pointer.limits(); }
    DeviceState read() noexcept override { return pointer.read(); }
    bool write(const Vec3& force_n) noexcept override { return pointer.write(force_n); }
    bool rests() const noexcept override { return pointer.rests(); }
    void have_mouse(bool is_had) { pointer.have_mouse(is_had); }
    void move(const Vec3& way_m) { pointer.move(way_m); }
    void turn(const Vec3& rotation_rad) { pointer.turn(rotation_rad); }
    void press(std::uint32_t buttons) { pointer.press(buttons); }
    PointerRig& rig;
    MouseHand pointer;
  };
  void have(bool is_had) {
    has_mouse_ = is_had;
    if (pointer_ == nullptr) return;
    pointer_->have_mouse(is_had);
    if (!is_had) pointer_->move({0.01, 0, 0});
  }

  Watched* pointer_ = nullptr;
  Turn turn_;
  bool has_mouse_ = true;
  std::uint32_t buttons_ = 0;
};

}  // namespace

std::unique_ptr<Rig> pointer_rig() { return std::make_unique<PointerRig>(); }
std::unique_ptr<Rig> spacemouse_rig() { return std::make_unique<SpaceMouseRig>(); }
std::unique_ptr<ControllerRigBase> controller_rig() { return std::make_unique<ControllerRig>(); }

}  // namespace palpa
