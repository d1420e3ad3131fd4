// Stand-in for Force Dimension's libdhd and libdrd with two omega.3, or others of its
// devices by their wrist: watchdog, limits of force and torque, brakes, status, and faults.
#include "tests/devices/dhd_stand_in.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <mutex>
#include <thread>

namespace {

using Clock = std::chrono::steady_clock;
using palpa::test::DhdSeen;
using palpa::test::DhdStandIn;
using What = DhdStandIn::What;

constexpr double most_n = 12.0;
constexpr double most_nm = 0.3;

struct Omega {
  bool is_there = true, has_power = true, is_initialized = true, freezes = false, lies = false, refuses = false;
  bool is_open = false, is_enabled = false, is_off_by_button = false, holds_by_speed = false, brakes = false;
  int off_cause = 0;
  bool is_touched = false;
  unsigned buttons = 0;
  int wrist = 0;
  bool wrist_lies = false;
  std::array<double, 3> place{}, speed{}, force{}, torque{};
  std::array<std::array<double, 3>, 3> turn{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  std::chrono::microseconds watchdog{0};
  Clock::time_point fed{};

  void look_at_watchdog() {
    if (watchdog.count() == 0 || !is_enabled || Clock::now() - fed <= watchdog) return;
    is_enabled = false;
    off_cause = 3;
  }
  bool makes_force() {
    look_at_watchdog();
    return is_there && has_power && is_open && is_enabled && !brakes && !holds_by_speed && !is_off_by_button;
  }
};

std::mutex mutex;
std::array<Omega, DhdStandIn::devices> omegas;

/// By index in the list of connected devices, which closes up when a device goes.
Omega* at(int index) {
  for (Omega& omega : omegas)
    if (omega.is_there && index-- == 0) return &omega;
  return nullptr;
}
int id_of(const Omega* omega) { return omega == nullptr ? -1 : static_cast<int>(omega - omegas.data()); }
/// An open device has a handle already.
int opened(Omega* omega) {
  if (omega == nullptr) return -1;
  if (!omega->is_open) omega->force = omega->torque = {};
  omega->is_open = true;
#ifndef WITHOUT_OPEN_SERIAL
  omega->is_touched = true;
#endif
  return id_of(omega);
}

Omega* of(char id) {
  const auto n = static_cast<std::size_t>(id);
  return n < omegas.size() && omegas[n].is_there && omegas[n].is_open ? &omegas[n] : nullptr;
}

/// A call of the exchange: -1 after the device is gone.
template <class Do>
int call(char id, Do what) {
  bool freezes = false;
  {
    const std::lock_guard lock(mutex);
    Omega* omega = of(id);
    if (omega == nullptr) return -1;
    freezes = omega->freezes;
  }
  if (freezes) std::this_thread::sleep_for(std::chrono::milliseconds(100));
  const std::lock_guard lock(mutex);
  Omega* omega = of(id);
  return omega == nullptr ? -1 : what(*omega);
}

DhdSeen* seen() {
  static DhdSeen* const shared = []() -> DhdSeen* {
    const char* file = std::getenv("PALPA_TESTS_DHD_SEEN");
    const int descriptor = file == nullptr ? -1 : ::open(file, O_RDWR | O_CLOEXEC);
    if (descriptor < 0) return nullptr;
    void* const memory = ::mmap(nullptr, sizeof(DhdSeen), PROT_READ | PROT_WRITE, MAP_SHARED, descriptor, 0);
    ::close(descriptor);
    return memory == MAP_FAILED ? nullptr : static_cast<DhdSeen*>(memory);
  }();
  return shared;
}

/// A command of force and torque, each kept within its limit.
int pushed(Omega& omega, const std::array<double, 3>& force, const std::array<double, 3>& torque) {
  omega.force = omega.torque = {};
  if (omega.refuses) return -1;
  omega.look_at_watchdog();
  omega.is_touched = true;
  omega.fed = Clock::now();
  omega.force = force;
  omega.torque = torque;
  const auto is_cut = [](std::array<double, 3>& vector, double most) {
    const double size = std::hypot(vector[0], vector[1], vector[2]);
    if (size <= most) return false;
    for (double& component : vector) component *= most / size;
    return true;
  };
  const bool cut_force = is_cut(omega.force, most_n), cut_torque = is_cut(omega.torque, most_nm);
  return cut_force || cut_torque ? 2 : 0;
}

void reset(int device) {
  const std::lock_guard lock(mutex);
  omegas[static_cast<std::size_t>(device)] = {};
}
void hold(int device, const double place_m[3], const double speed_m_per_s[3]) {
  const std::lock_guard lock(mutex);
  Omega& omega = omegas[static_cast<std::size_t>(device)];
  std::copy_n(place_m, 3, omega.place.begin());
  std::copy_n(speed_m_per_s, 3, omega.speed.begin());
}
void turn(int device, const double rows[3][3]) {
  const std::lock_guard lock(mutex);
  for (std::size_t row = 0; row < 3; ++row)
    std::copy_n(rows[row], 3, omegas[static_cast<std::size_t>(device)].turn[row].begin());
}
void force_n(int device, double made_n[3]) {
  const std::lock_guard lock(mutex);
  Omega& omega = omegas[static_cast<std::size_t>(device)];
  const bool makes = omega.makes_force();
  for (std::size_t axis = 0; axis < 3; ++axis) made_n[axis] = makes ? omega.force[axis] : 0.0;
}
void torque_nm(int device, double made_nm[3]) {
  const std::lock_guard lock(mutex);
  Omega& omega = omegas[static_cast<std::size_t>(device)];
  const bool makes = omega.makes_force() && omega.wrist == 2;
  for (std::size_t axis = 0; axis < 3; ++axis) made_nm[axis] = makes ? omega.torque[axis] : 0.0;
}
void set(int device, What what, int value) {
  const std::lock_guard lock(mutex);
  Omega& omega = omegas[static_cast<std::size_t>(device)];
  const bool on = value != 0;
  switch (what) {
    case What::there:
      omega.is_there = on;
      if (!on) omega.is_open = omega.is_enabled = false;
      return;
    case What::power: omega.has_power = on; return;
    case What::initialized: omega.is_initialized = on; return;
    case What::off_button: omega.is_off_by_button = on; return;
    case What::speed_brake:
      omega.holds_by_speed = on;
      if (on) omega.is_enabled = false;
      if (on) omega.off_cause = 2;
      return;
    case What::freezes: omega.freezes = on; return;
    case What::lies: omega.lies = on; return;
    case What::refuses: omega.refuses = on; return;
    case What::buttons: omega.buttons = static_cast<unsigned>(value); return;
    case What::wrist: omega.wrist = value; return;
    case What::wrist_lies: omega.wrist_lies = on; return;
  }
}
bool is_touched(int device) {
  const std::lock_guard lock(mutex);
  return omegas[static_cast<std::size_t>(device)].is_touched;
}
bool brakes(int device) {
  const std::lock_guard lock(mutex);
  return omegas[static_cast<std::size_t>(device)].brakes;
}

}  // namespace

extern "C" {

extern const DhdStandIn dhd_stand_in;
const DhdStandIn dhd_stand_in{reset, hold, turn, force_n, torque_nm, set, brakes, is_touched};

int dhdGetDeviceCount() {
  const std::lock_guard lock(mutex);
  return static_cast<int>(std::count_if(omegas.begin(), omegas.end(), [](const Omega& omega) { return omega.is_there; }));
}
int dhdOpenID(char index) {
  const std::lock_guard lock(mutex);
  return opened(at(index));
}
int dhdClose(char id) {
  const std::lock_guard lock(mutex);
  if (Omega* omega = of(id)) omega->is_open = omega->is_enabled = false;
  return 0;
}
int dhdGetPosition(double* x, double* y, double* z, char id) {
  return call(id, [&](Omega& omega) {
    if (const DhdSeen* shared = seen(); shared != nullptr && &omega == &omegas[0])
      std::copy_n(shared->place_m, 3, omega.place.begin());
    *x = omega.lies ? std::numeric_limits<double>::quiet_NaN() : omega.place[0];
    *y = omega.place[1];
    *z = omega.place[2];
    return 0;
  });
}
int dhdGetLinearVelocity(double* x, double* y, double* z, char id) {
  return call(id, [&](Omega& omega) {
    *x = omega.speed[0];
    *y = omega.speed[1];
    *z = omega.speed[2];
    return 1;  // the time guard: the data are fresh enough
  });
}
#ifndef WITHOUT_SET_FORCE
int dhdSetForce(double x, double y, double z, char id) {
  return call(id, [&](Omega& omega) {
    if (DhdSeen* shared = seen(); shared != nullptr && &omega == &omegas[0]) {
      const double word[3] = {x, y, z};
      std::copy_n(word, 3, shared->last_word_n);
    }
    return pushed(omega, {x, y, z}, {});
  });
}
#endif
int dhdEnableForce(unsigned char on, char id) {
  return call(id, [&](Omega& omega) {
    omega.is_touched = true;
    omega.is_enabled = on != 0 && !omega.holds_by_speed;
    omega.fed = Clock::now();
    if (omega.is_enabled) omega.off_cause = 0;
    return 0;
  });
}
int dhdGetStatus(int* status, char id) {
  return call(id, [&](Omega& omega) {
    std::fill_n(status, 16, 0);
    status[0] = omega.has_power;
    status[1] = 1;
    status[2] = 1;
    status[3] = !omega.is_initialized;
    status[5] = omega.makes_force();
    status[6] = omega.brakes || omega.holds_by_speed;
    status[14] = omega.is_off_by_button ? 1 : omega.off_cause;
    return 0;
  });
}
const char* dhdGetSystemName(char id) {
  const std::lock_guard lock(mutex);
  const Omega* omega = of(id);
  const int wrist = omega != nullptr ? omega->wrist : 0;
  return wrist == 2 ? "sigma.7 right" : wrist == 1 ? "omega.6 right" : "omega.3";
}
#ifndef WITHOUT_EXTRAS
bool dhdHasWrist(char id) {
  const std::lock_guard lock(mutex);
  const Omega* omega = of(id);
  return omega != nullptr && omega->wrist > 0;
}
bool dhdHasActiveWrist(char id) {
  const std::lock_guard lock(mutex);
  const Omega* omega = of(id);
  return omega != nullptr && omega->wrist == 2;
}
int dhdGetOrientationFrame(double rows[3][3], char id) {
  return call(id, [&](Omega& omega) {
    for (std::size_t row = 0; row < 3; ++row) std::copy_n(omega.turn[row].begin(), 3, rows[row]);
    if (omega.wrist == 0 || omega.wrist_lies) std::fill_n(rows[1], 3, 0.0);
    return 0;
  });
}
int dhdSetForceAndTorqueAndGripperForce(double x, double y, double z, double about_x, double about_y, double about_z, double,
                                        char id) {
  return call(id, [&](Omega& omega) { return pushed(omega, {x, y, z}, {about_x, about_y, about_z}); });
}
int dhdGetSerialNumber(unsigned short* number, char id) {
  return call(id, [&](Omega& omega) {
    *number = static_cast<unsigned short>(4711 + id_of(&omega));
    return 0;
  });
}
#ifndef WITHOUT_OPEN_SERIAL
int dhdOpenSerial(int number) {
  const std::lock_guard lock(mutex);
  const auto n = static_cast<std::size_t>(number - 4711);
  return n < omegas.size() && omegas[n].is_there ? opened(&omegas[n]) : -1;
}
#endif
unsigned dhdGetButtonMask(char id) {
  const std::lock_guard lock(mutex);
  const Omega* omega = of(id);
  return omega != nullptr ? omega->buttons : 0;
}
int dhdSetBrakes(int on, char id) {
  return call(id, [&](Omega& omega) {
    omega.is_touched = true;
    omega.brakes = on != 0;
    return 0;
  });
}
int dhdSetWatchdog(unsigned char steps, char id) {
  return call(id, [&](Omega& omega) {
    omega.is_touched = true;
    omega.watchdog = std::chrono::microseconds(125) * steps;
    return 0;
  });
}
int dhdEnableExpertMode() { return 0; }
int dhdDisableExpertMode() { return 0; }
bool drdIsInitialized(char id) {
  const std::lock_guard lock(mutex);
  const Omega* omega = of(id);
  return omega != nullptr && omega->is_initialized;
}
int drdAutoInit(char id) {
  return call(id, [&](Omega& omega) {
    omega.is_initialized = true;
    return 0;
  });
}
int drdStop(bool, char) { return 0; }
#endif
}
