// Keeps a host's OpenGL errors and our own apart within its scope. Needs the context current in every call, on one
// thread.
#pragma once

#include <array>
#include <cstddef>

#include "gl/context/functions.h"

namespace sideray::gl {

// An error that is pending at the beginning is the host's: it is taken away, and put back at the end by causing an
// error of the same kind (a stack error comes back as GL_INVALID_OPERATION; a debug callback is told once more). What
// our calls raise in between is ours: it never gets out. A lost context raises its error at every call, so that one is
// not put back.
class ErrorGuard {
 public:
  explicit ErrorGuard(const Functions& gl);
  ~ErrorGuard();
  ErrorGuard(const ErrorGuard&) = delete;
  ErrorGuard& operator=(const ErrorGuard&) = delete;

  // Takes what our calls have raised since the last time: the first of it, GL_CONTEXT_LOST before all others.
  // GL_NO_ERROR = nothing.
  GLenum take() const;
  // The same; throws Failure (OUT_OF_MEMORY, GL_FAILED) where there is something. `what`: who failed, for the message.
  void check(const char* what) const;

 private:
  static constexpr size_t kinds = 8;  // more different errors than OpenGL keeps
  const Functions& gl_;
  std::array<GLenum, kinds> pending_{};
};

// Throws Failure (OUT_OF_MEMORY, GL_FAILED) that says what `error` means and what to do.
[[noreturn]] void fail_with(const Functions& gl, GLenum error, const char* what);

}  // namespace sideray::gl
