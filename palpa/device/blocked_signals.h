// Blocking of signals for threads.
#pragma once

#include <signal.h>

namespace palpa::detail {

/// Signals that a thread's fault raises in that thread. If blocked, the system ends the program at once, without its handlers.
inline constexpr int fault_signals[] = {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGTRAP, SIGSYS, SIGABRT};

/// Blocks all signals but those of its own faults for the calling thread, until the destructor. Threads created meanwhile have
/// them blocked for good: a handler, which may block, then never runs on a thread that others depend on.
class BlockedSignals {
 public:
  BlockedSignals() noexcept {
    sigset_t all;
    ::sigfillset(&all);
    for (const int number : fault_signals) ::sigdelset(&all, number);
    ::pthread_sigmask(SIG_SETMASK, &all, &before_);
  }
  ~BlockedSignals() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  BlockedSignals(const BlockedSignals&) = delete;
  BlockedSignals& operator=(const BlockedSignals&) = delete;

 private:
  sigset_t before_;
};

}  // namespace palpa::detail
