// A live program on the library that is stopped: stopped_program DEVICE HOW.
#include <signal.h>
#include <stdlib.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <exception>
#include <functional>
#include <iostream>
#include <map>
#include <stdexcept>
#include <string>
#include <thread>

#include "palpa/data/analytic.h"
#include "palpa/device/blocked_signals.h"
#include "palpa/device/open_device.h"
#include "palpa/loop/loop.h"
#include "palpa/mode/modes.h"

namespace {

using namespace palpa;

std::atomic<bool> loop_crashes{false}, loop_throws{false};
volatile int* volatile nowhere = nullptr;

void crash() { *nowhere = 1; }

void end_by_own_handler(int number) {
  const MotorsAtRest motors_at_rest;
  ::signal(number, SIG_DFL);
  ::raise(number);
}

const std::map<std::string, std::function<void()>> hows{
    {"terminate", [] { std::terminate(); }},
    {"throw", [] { throw std::runtime_error("nobody catches this"); }},
    {"throw_in_a_thread", [] { std::thread([] { throw std::runtime_error("nobody catches this"); }).join(); }},
    {"throw_in_the_loop", [] { loop_throws = true; }},
    {"abort", [] { std::abort(); }},
    {"exit", [] { std::exit(3); }},
    {"quick_exit", [] { std::quick_exit(3); }},
    {"crash", crash},
    {"crash_in_a_thread", [] { std::thread(crash).join(); }},
    {"crash_in_the_loop", [] { loop_crashes = true; }},
    {"illegal", [] { __builtin_trap(); }},
    {"own_handler", [] {
       ::signal(SIGTERM, end_by_own_handler);
       ::raise(SIGTERM);
     }}};

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const std::string how = argv[2];
  Scene scene({.stiffness_n_per_m = 300});
  const FieldRef head = scene.add("head", head_phantom());
  scene.add("skin", SurfaceAndFriction{.field = head, .levels = {{.name = "skin", .value = -300, .strength_n = 1.5}}});
  const std::unique_ptr<Device> device = open_device(device_description(argv[1]), "/nowhere/devices.toml");
  LiveScene live(scene);
  LiveOptions options{.rate_hz = 200.0};  // late ticks of a busy machine are no fault then
  options.guard = guard_options_for(device->limits(), 3.0);
  LiveLoop loop(live, *device, options);
  const std::atomic<bool> stop{false};
  std::thread haptic;
  {
    const detail::BlockedSignals in_the_loop;
    haptic = std::thread([&] {
      loop.run(stop, [](const TickFrame&, const Session&) {
        if (loop_crashes) crash();
        if (loop_throws) throw std::runtime_error("nobody catches this");
      });
    });
  }
  char word = 0;
  if (::read(STDIN_FILENO, &word, 1) != 1) ::_exit(4);
  if (how == "forked_child_ends") {
    // The end of a child takes no force from the parent.
    const pid_t child = ::fork();
    if (child == 0) {
      ::raise(SIGTERM);
      ::_exit(0);
    }
    int status = 0;
    ::waitpid(child, &status, 0);
    std::puts(WIFSIGNALED(status) ? "ended" : "not ended");
    std::fflush(stdout);
  } else if (const auto found = hows.find(how); found != hows.end()) {
    found->second();
  }
  haptic.join();
}
