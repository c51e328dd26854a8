// Signals wait while the library works and while the driver swaps: a handler of the program that calls OpenGL or Xlib would find
// them in the midst of a call, and wait for that for ever.
#pragma once

#include <signal.h>

namespace sideray::run {

class SignalsWait {
 public:
  SignalsWait() {
    sigset_t all;
    ::sigfillset(&all);
    // Those of mistakes come at once.
    for (const int mistake : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGTRAP, SIGSYS}) ::sigdelset(&all, mistake);
    ::pthread_sigmask(SIG_BLOCK, &all, &before_);
  }
  ~SignalsWait() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  // Whether one has come meanwhile. Then the driver has to finish first: Mesa (22.3) waits for ever for the threads of a screen that
  // is destroyed while they draw.
  bool has_one() const {
    sigset_t waiting;
    ::sigpending(&waiting);
    for (int number = 1; number < NSIG; ++number)
      if (::sigismember(&waiting, number) == 1 && ::sigismember(&before_, number) == 0) return true;
    return false;
  }
  SignalsWait(const SignalsWait&) = delete;
  SignalsWait& operator=(const SignalsWait&) = delete;

 private:
  sigset_t before_;
};

}  // namespace sideray::run
