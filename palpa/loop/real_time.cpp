#include <pthread.h>
#include <sched.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>

#include "palpa/loop/loop.h"

namespace palpa {

namespace {
// Above a desktop's threads, below the kernel's own of 50 and more, so that interrupts are served. Higher: may delay a driver
// with the device's response; lower: other real-time programs (sound) go first.
constexpr int wanted_priority = 40;
// Part of the stack that is touched before the first tick [bytes]. Less: a page fault when a tick first goes as deep; more:
// memory.
constexpr std::size_t stack_bytes = 256 << 10;
}  // namespace

RealTimeThread::RealTimeThread() {
  sched_param parameters{};
  ::pthread_getschedparam(::pthread_self(), &policy_, &parameters);
  priority_ = parameters.sched_priority;
  parameters.sched_priority = wanted_priority;
  has_priority_ = ::pthread_setschedparam(::pthread_self(), SCHED_FIFO, &parameters) == 0;
  if (!has_priority_) {
    refused_.push_back(
        "this user has no real-time priority, so other programs may delay a tick; add the line "
        "'@audio - rtprio 40' to /etc/security/limits.d/palpa.conf, join the group audio, and log in again");
  }
  // Under a limit, mlockall succeeds and every allocation beyond it fails later: used only without a limit.
  rlimit limit{};
  const bool unlimited = ::getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY;
  has_memory_ = unlimited && ::mlockall(MCL_CURRENT | MCL_FUTURE | MCL_ONFAULT) == 0;
  if (!has_memory_) {
    refused_.push_back(
        "this user cannot lock memory, so it may be swapped out; add the line '@audio - memlock unlimited' to "
        "/etc/security/limits.d/palpa.conf, join the group audio, and log in again");
  }
  ::prctl(PR_SET_TIMERSLACK, 1UL);  // 50 µs by default
  volatile char stack[stack_bytes];
  for (std::size_t i = 0; i < sizeof stack; i += 1024) stack[i] = 0;
}

RealTimeThread::~RealTimeThread() {
  const sched_param parameters{.sched_priority = priority_};
  if (has_priority_) ::pthread_setschedparam(::pthread_self(), policy_, &parameters);
  if (has_memory_) ::munlockall();
  ::prctl(PR_SET_TIMERSLACK, 0UL);
}

}  // namespace palpa
