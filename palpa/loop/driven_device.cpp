#include <pthread.h>
#include <signal.h>
#include <time.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <iterator>
#include <mutex>
#include <stdexcept>

#include "palpa/device/blocked_signals.h"
#include "palpa/loop/loop.h"

namespace palpa {

namespace {

// Largest number of driven devices. More: a longer search in a handler; fewer: one more device is refused.
constexpr std::size_t most_driven = 64;
// Time for a driver's thread to notice a stop. Longer: a program whose loop hangs stops later; shorter: a loop on a busy
// machine is cut off.
constexpr int longest_unseen_ms = 60;
// Time for all motors to release their force. Longer: a program with a silent device stops later; shorter: a busy machine's
// motors may still be on.
constexpr int longest_stop_ms = 250;
// Likewise after a loop has ended, before its device is abandoned.
constexpr int longest_end_ms = 20;

/// A driven device; `device` is null in a free slot. Read in signal handlers.
struct Place {
  std::atomic<Device*> device{nullptr};
  std::atomic<pthread_t> driver{};
  std::atomic<bool> is_seen{false};  // its driver has noticed the stop
};
std::array<Place, most_driven> places;
std::atomic<int> stops_under_way{0};  // stops in progress: motors rest while there are any
std::atomic<int> looks_under_way{0};  // accesses of handlers to devices in progress
std::atomic<pid_t> process{0};
static_assert(std::atomic<Device*>::is_always_lock_free && std::atomic<pthread_t>::is_always_lock_free &&
                  std::atomic<int>::is_always_lock_free && std::atomic<bool>::is_always_lock_free,
              "used in signal handlers");

constexpr int most_signals = 65;
std::mutex taking;
int driven = 0;                                          // number of devices; with `taking`
std::array<struct sigaction, most_signals> before_ours;  // with `taking`; read-only while handlers are installed
std::array<bool, most_signals> is_ours{};                // with `taking`; may be below a later handler

void wait_a_millisecond() noexcept {
  const timespec pause{.tv_sec = 0, .tv_nsec = 1'000'000};
  ::nanosleep(&pause, nullptr);
}

bool is_at_rest(const Place& place, int waited_ms) noexcept {
  const Device* const device = place.device.load();
  if (device == nullptr) return true;
  // The thread of a stopped driver writes no further force, and cannot notice the stop.
  const bool is_over = place.is_seen.load() || ::pthread_equal(place.driver.load(), ::pthread_self()) != 0;
  return (is_over || waited_ms >= longest_unseen_ms) && device->rests();
}

/// Default action of a signal: ends the program, or suspends it until SIGCONT.
void do_as_the_system(int number) noexcept {
  struct sigaction ours{};
  struct sigaction by_the_system{};
  by_the_system.sa_handler = SIG_DFL;
  ::sigaction(number, &by_the_system, &ours);
  ::raise(number);
  sigset_t only, before;
  ::sigemptyset(&only);
  ::sigaddset(&only, number);
  ::pthread_sigmask(SIG_UNBLOCK, &only, &before);
  // A suspended program resumes here.
  ::pthread_sigmask(SIG_SETMASK, &before, nullptr);
  ::sigaction(number, &ours, nullptr);
}

void on_stop(int number, siginfo_t* info, void* context) {
  const int error = errno;
  const MotorsAtRest stop;
  const struct sigaction& before = before_ours[static_cast<std::size_t>(number)];
  const bool has_flags = (before.sa_flags & SA_SIGINFO) != 0;
  if (has_flags) {
    before.sa_sigaction(number, info, context);
  } else if (before.sa_handler != SIG_DFL) {
    before.sa_handler(number);
  } else {
    do_as_the_system(number);
  }
  errno = error;
}

bool is_fault(int number) noexcept {
  return std::find(std::begin(detail::fault_signals), std::end(detail::fault_signals), number) !=
         std::end(detail::fault_signals);
}
/// Signals that cannot be handled, and signals that neither end nor suspend a program.
bool stops_nothing(int number) noexcept {
  for (const int other : {SIGKILL, SIGSTOP, SIGCONT, SIGCHLD, SIGURG, SIGWINCH})
    if (number == other) return true;
  return false;
}

/// Installs handlers: for faults before an existing handler, which runs second; for other signals only where there is none.
void take_signals() {
  struct sigaction action{};
  action.sa_sigaction = on_stop;
  action.sa_flags = SA_SIGINFO | SA_ONSTACK | SA_RESTART;
  ::sigfillset(&action.sa_mask);
  for (const int number : detail::fault_signals) ::sigdelset(&action.sa_mask, number);
  for (int number = 1; number < most_signals; ++number) {
    const auto n = static_cast<std::size_t>(number);
    struct sigaction now{};
    if (stops_nothing(number) || ::sigaction(number, nullptr, &now) != 0) continue;
    const bool has_handler = (now.sa_flags & SA_SIGINFO) != 0 || (now.sa_handler != SIG_DFL && now.sa_handler != SIG_IGN);
    const bool is_free = !has_handler && now.sa_handler == SIG_DFL;
    // A handler installed over ours calls ours: calling it from ours would recurse without end.
    if (!is_free && !(has_handler && is_fault(number) && !is_ours[n])) continue;
    before_ours[n] = now;
    is_ours[n] = ::sigaction(number, &action, nullptr) == 0;
  }
}

void give_signals_back() {
  for (int number = 1; number < most_signals; ++number) {
    const auto n = static_cast<std::size_t>(number);
    struct sigaction now{};
    if (!is_ours[n] || ::sigaction(number, nullptr, &now) != 0) continue;
    if ((now.sa_flags & SA_SIGINFO) == 0 || now.sa_sigaction != on_stop) continue;
    ::sigaction(number, &before_ours[n], nullptr);
    is_ours[n] = false;
  }
}

/// Permanent: threads that still run while the program ends give no force.
void rest_at_exit() { [[maybe_unused]] static const MotorsAtRest* const for_good = new MotorsAtRest; }

}  // namespace

DrivenDevice::DrivenDevice(Device& device) {
  const std::lock_guard lock(taking);
  static const bool is_registered_at_exit = std::atexit(rest_at_exit) == 0 && std::at_quick_exit(rest_at_exit) == 0;
  static_cast<void>(is_registered_at_exit);
  while (place_ < most_driven && places[place_].device != nullptr) ++place_;
  if (place_ == most_driven) throw std::runtime_error("device: 64 are driven by this program; end one of them");
  process = ::getpid();
  places[place_].driver = ::pthread_self();
  places[place_].is_seen = stops_under_way > 0;
  places[place_].device = &device;
  if (driven++ == 0) take_signals();
}

DrivenDevice::~DrivenDevice() {
  Place& place = places[place_];
  for (int waited_ms = 0; waited_ms < longest_end_ms && !place.device.load()->rests(); ++waited_ms) wait_a_millisecond();
  const std::lock_guard lock(taking);
  place.device = nullptr;
  while (looks_under_way > 0) wait_a_millisecond();  // for a handler that found the device before
  if (--driven == 0) give_signals_back();
}

bool DrivenDevice::has_to_rest() noexcept {
  if (stops_under_way.load(std::memory_order_relaxed) == 0) return false;
  places[place_].is_seen = true;
  return true;
}

MotorsAtRest::MotorsAtRest() noexcept : is_counted_(::getpid() == process.load()) {
  if (!is_counted_) return;
  if (stops_under_way.fetch_add(1) == 0)
    for (Place& place : places) place.is_seen = false;
  looks_under_way.fetch_add(1);
  for (int waited_ms = 0; waited_ms < longest_stop_ms; ++waited_ms) {
    if (std::all_of(places.begin(), places.end(), [&](const Place& place) { return is_at_rest(place, waited_ms); })) break;
    wait_a_millisecond();
  }
  looks_under_way.fetch_sub(1);
}

MotorsAtRest::~MotorsAtRest() {
  if (is_counted_) stops_under_way.fetch_sub(1);
}

}  // namespace palpa
