// Delays signals while the library works and while the driver swaps buffers: a handler of the program that calls OpenGL
// or Xlib would interrupt such a call and wait for it forever.
#pragma once

#include <signal.h>

namespace sideray::run {

class SignalsWait {
 public:
  SignalsWait() {
    sigset_t all;
    ::sigfillset(&all);
    // Signals of errors are not delayed.
    for (const int mistake : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGTRAP, SIGSYS}) ::sigdelset(&all, mistake);
    ::pthread_sigmask(SIG_BLOCK, &all, &before_);
  }
  ~SignalsWait() { ::pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  // Returns whether a signal is waiting. Then the driver must finish first: Mesa (22.3) waits forever for the threads
  // of a screen that is destroyed while they draw.
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
