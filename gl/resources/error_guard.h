// Keeps the OpenGL errors of a host and of our own calls apart within its scope. One thread makes every call, with the
// context current.
#pragma once

#include <array>
#include <cstddef>

#include "gl/context/functions.h"

namespace sideray::gl {

// Takes an error that is pending at the beginning, which is the host's, and at the end raises one of the same kind
// again (a stack error becomes GL_INVALID_OPERATION; a debug callback is called once more). Errors of our own calls in
// between never reach the host. The error of a lost context is not raised again, since every call raises it anyway.
class ErrorGuard {
 public:
  explicit ErrorGuard(const Functions& gl);
  ~ErrorGuard();
  ErrorGuard(const ErrorGuard&) = delete;
  ErrorGuard& operator=(const ErrorGuard&) = delete;

  // Takes the errors that our calls have raised since the last time, and returns the first, or GL_CONTEXT_LOST if it is
  // among them. GL_NO_ERROR = none.
  GLenum take() const;
  // Takes errors in the same way, and throws Failure (OUT_OF_MEMORY, GL_FAILED) where there are any. `what` names the
  // failed operation in the message.
  void check(const char* what) const;

 private:
  static constexpr size_t kinds = 8;  // more different errors than OpenGL keeps
  const Functions& gl_;
  std::array<GLenum, kinds> pending_{};
};

// Throws Failure (OUT_OF_MEMORY, GL_FAILED) that says what `error` means and what to do.
[[noreturn]] void fail_with(const Functions& gl, GLenum error, const char* what);

}  // namespace sideray::gl
