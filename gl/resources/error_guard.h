// Keeps a host's OpenGL errors and our own apart within its scope. One thread makes every call, with the context
// current.
#pragma once

#include <array>
#include <cstddef>

#include "gl/context/functions.h"

namespace sideray::gl {

// An error that is pending at the beginning is the host's: it is taken away, and put back at the end by causing an
// error of the same kind (a stack error comes back as GL_INVALID_OPERATION; a debug callback is called once more).
// Errors that our calls raise in between are ours: they never get out. A lost context raises its error at every call,
// so that one is not put back.
class ErrorGuard {
 public:
  explicit ErrorGuard(const Functions& gl);
  ~ErrorGuard();
  ErrorGuard(const ErrorGuard&) = delete;
  ErrorGuard& operator=(const ErrorGuard&) = delete;

  // Takes the errors that our calls have raised since the last time, and returns the first of them, GL_CONTEXT_LOST
  // before all others. GL_NO_ERROR = none.
  GLenum take() const;
  // Takes errors likewise, and throws Failure (OUT_OF_MEMORY, GL_FAILED) where there are any. `what` names what failed,
  // for the message.
  void check(const char* what) const;

 private:
  static constexpr size_t kinds = 8;  // more different errors than OpenGL keeps
  const Functions& gl_;
  std::array<GLenum, kinds> pending_{};
};

// Throws Failure (OUT_OF_MEMORY, GL_FAILED) that says what `error` means and what to do.
[[noreturn]] void fail_with(const Functions& gl, GLenum error, const char* what);

}  // namespace sideray::gl
