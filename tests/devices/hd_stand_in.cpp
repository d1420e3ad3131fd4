// Stand-in for 3D Systems' libHD with two Touch: callback thread at 1 kHz, polled errors, warm motors, inkwell, and faults.
#include "tests/devices/hd_stand_in.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstring>
#include <mutex>
#include <thread>
#include <vector>

namespace {

using Clock = std::chrono::steady_clock;
using palpa::test::HdStandIn;
using What = HdStandIn::What;

constexpr unsigned nobody = 0xFFFFFFFF;
constexpr double most_n = 3.3;
// Frames must be this frequent, or the driver releases the motors.
constexpr auto rest_after = std::chrono::milliseconds(20);

struct Touch {
  bool is_there = true, is_calibrated = true, stalls = false, is_open = false, has_output = false, is_touched = false;
  int error = 0, buttons = 0, freedoms = 6;
  double temperature = 0.2;
  std::array<double, 3> place{}, speed{}, asked{}, made{};
  std::array<double, 16> transform{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
  Clock::time_point framed{};
};
struct Callback {
  unsigned long id;
  unsigned (*function)(void*);
  void* with;
  unsigned device;
};

std::recursive_mutex mutex;
std::array<Touch, HdStandIn::devices> touches;
std::vector<Callback> callbacks;
unsigned long last_id = 0;
std::atomic<bool> runs{false};
std::thread servo;
thread_local unsigned current = nobody;
thread_local unsigned error = 0;

Touch* now() { return current < touches.size() ? &touches[current] : nullptr; }

void serve() {
  while (runs) {
    const Clock::time_point next = Clock::now() + std::chrono::milliseconds(1);
    {
      const std::lock_guard lock(mutex);
      for (const Callback& callback : std::vector<Callback>(callbacks)) {
        if (touches[callback.device].stalls) continue;
        current = callback.device;
        callback.function(callback.with);
      }
    }
    std::this_thread::sleep_until(next);
  }
}

void reset(int device) {
  const std::lock_guard lock(mutex);
  touches[static_cast<std::size_t>(device)] = {};
}
void hold(int device, const double place_mm[3], const double speed_mm_per_s[3]) {
  const std::lock_guard lock(mutex);
  Touch& touch = touches[static_cast<std::size_t>(device)];
  std::copy_n(place_mm, 3, touch.place.begin());
  std::copy_n(speed_mm_per_s, 3, touch.speed.begin());
}
void turn(int device, const double transform[16]) {
  const std::lock_guard lock(mutex);
  std::copy_n(transform, 16, touches[static_cast<std::size_t>(device)].transform.begin());
}
void force_n(int device, double made_n[3]) {
  const std::lock_guard lock(mutex);
  const Touch& touch = touches[static_cast<std::size_t>(device)];
  const bool makes =
      touch.is_there && touch.is_open && touch.has_output && touch.error == 0 && Clock::now() - touch.framed < rest_after;
  for (std::size_t axis = 0; axis < 3; ++axis) made_n[axis] = makes ? touch.made[axis] : 0.0;
}
void set(int device, What what, int value) {
  const std::lock_guard lock(mutex);
  Touch& touch = touches[static_cast<std::size_t>(device)];
  switch (what) {
    case What::there: touch.is_there = value != 0; return;
    case What::calibrated: touch.is_calibrated = value != 0; return;
    case What::error: touch.error = value; return;
    case What::warm: touch.temperature = value / 100.0; return;
    case What::stalls: touch.stalls = value != 0; return;
    case What::buttons: touch.buttons = value; return;
    case What::freedoms: touch.freedoms = value; return;
  }
}

bool is_touched(int device) {
  const std::lock_guard lock(mutex);
  return touches[static_cast<std::size_t>(device)].is_touched;
}

}  // namespace

extern "C" {

extern const HdStandIn hd_stand_in;
const HdStandIn hd_stand_in{reset, hold, turn, force_n, set, is_touched};

struct HDErrorInfo {
  unsigned code;
  int internal;
  unsigned handle;
};

unsigned hdInitDevice(const char* name) {
  const std::lock_guard lock(mutex);
  const unsigned device = name == nullptr                    ? (touches[0].is_there ? 0 : 1)
                          : std::strcmp(name, "first") == 0  ? 0
                          : std::strcmp(name, "second") == 0 ? 1
                                                             : nobody;
  if (device == nobody || !touches[device].is_there || touches[device].is_open) {
    error = 0x0302;
    return nobody;
  }
  touches[device].is_open = true;
  touches[device].made = {};
  current = device;
  return device;
}
void hdDisableDevice(unsigned device) {
  const std::lock_guard lock(mutex);
  if (device < touches.size()) touches[device].is_open = touches[device].has_output = false;
}
void hdMakeCurrentDevice(unsigned device) { current = device; }
void hdEnable(unsigned what) {
  const std::lock_guard lock(mutex);
  if (Touch* touch = now(); touch != nullptr && what == 0x4000) touch->has_output = touch->is_touched = true;
}
void hdStartScheduler() {
  if (!runs.exchange(true)) servo = std::thread(serve);
}
void hdStopScheduler() {
  if (runs.exchange(false)) servo.join();
}
unsigned long hdScheduleAsynchronous(unsigned (*function)(void*), void* with, unsigned short) {
  const std::lock_guard lock(mutex);
  callbacks.push_back({++last_id, function, with, current});
  return last_id;
}
#ifndef WITHOUT_UNSCHEDULE
void hdUnschedule(unsigned long id) {
  const std::lock_guard lock(mutex);
  std::erase_if(callbacks, [&](const Callback& callback) { return callback.id == id; });
}
#endif
void hdBeginFrame(unsigned device) {
  current = device;
  const std::lock_guard lock(mutex);
  if (Touch* touch = now()) touch->asked = {};
}
void hdEndFrame(unsigned device) {
  const std::lock_guard lock(mutex);
  current = device;
  Touch* touch = now();
  if (touch == nullptr) return;
  if (!touch->is_there) {
    error = 0x0302;
    return;
  }
  touch->framed = Clock::now();
  if (touch->error != 0) {
    error = static_cast<unsigned>(touch->error);
    touch->made = {};
    return;
  }
  touch->made = touch->asked;
  const double size = std::hypot(touch->made[0], touch->made[1], touch->made[2]);
  if (size > most_n)
    for (double& component : touch->made) component *= most_n / size;
}
void hdGetDoublev(unsigned what, double* values) {
  const std::lock_guard lock(mutex);
  const Touch* touch = now();
  if (touch == nullptr) return;
  switch (what) {
    case 0x2050: std::copy(touch->place.begin(), touch->place.end(), values); return;
    case 0x2051: std::copy(touch->speed.begin(), touch->speed.end(), values); return;
    case 0x2052:
      std::copy(touch->transform.begin(), touch->transform.end(), values);
      std::copy(touch->place.begin(), touch->place.end(), values + 12);
      return;
    case 0x2550: {
      const double box[6] = {-210, -110, -85, 210, 205, 130};
      std::copy_n(box, 6, values);
      return;
    }
    case 0x2602: values[0] = 0.5; return;
    case 0x2603: values[0] = most_n; return;
    case 0x2604: values[0] = 0.88; return;
    case 0x2605: std::fill_n(values, 6, touch->temperature); return;
    case 0x2609: values[0] = 0.003; return;
    default: error = 0x0100;
  }
}
void hdGetIntegerv(unsigned what, int* values) {
  const std::lock_guard lock(mutex);
  const Touch* touch = now();
  if (touch == nullptr) return;
  if (what == 0x2000) *values = touch->buttons;
  if (what == 0x2553) *values = touch->freedoms;
}
void hdSetDoublev(unsigned what, const double* values) {
  const std::lock_guard lock(mutex);
  Touch* touch = now();
  if (touch == nullptr || what != 0x2700) return;
  std::copy_n(values, 3, touch->asked.begin());
  touch->is_touched = true;
}
const char* hdGetString(unsigned what) {
  const Touch* touch = now();
  if (touch == nullptr) return nullptr;
  return what == 0x2501 ? "Touch" : what == 0x2504 ? (touch == &touches[0] ? "first's number" : "second's number") : "";
}
HDErrorInfo hdGetError() {
  const HDErrorInfo info{error, 0, current};
  error = 0;
  return info;
}
unsigned hdCheckCalibration() {
  const std::lock_guard lock(mutex);
  const Touch* touch = now();
  return touch == nullptr || touch->is_calibrated ? 0x5000 : 0x5002;
}
void hdUpdateCalibration(unsigned) {}
}
