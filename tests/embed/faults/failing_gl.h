// Wraps OpenGL between the service and the driver: counts objects, and fails as told. One at a time; test support.
#pragma once

#include <cstdint>
#include <map>
#include <set>
#include <string>

#include "gl/context/context.h"

namespace sideray::tests {

class FailingGl {
 public:
  enum class Failure {
    none,
    allocation,  // the n-th call that takes memory: GL_OUT_OF_MEMORY, and nothing is allocated
    mapping,     // the n-th glMapBufferRange returns NULL, with GL_OUT_OF_MEMORY
    name,        // the n-th glGen* or glCreateProgram gives no name
    fence,       // the n-th glFenceSync gives none
    waiting,     // the n-th glClientWaitSync: GL_WAIT_FAILED, with GL_INVALID_VALUE
    never,       // no fence is ever reached
    lost         // from the n-th call of any of the above on, every call is without effect: GL_CONTEXT_LOST
  };

  explicit FailingGl(gl::Context& context);
  ~FailingGl();
  FailingGl(const FailingGl&) = delete;
  FailingGl& operator=(const FailingGl&) = delete;

  static void* get_proc_address(void* user, const char* name);
  // Fails the n-th from now on, counted from 1.
  void fail(Failure failure, int n = 1);
  bool has_failed() const { return failed_; }
  void forbid_calls(bool forbidden) { forbidden_ = forbidden; }

  // Returns the number of existing objects of all kinds, with fences.
  size_t alive_count() const;
  int forbidden_calls() const { return forbidden_calls_; }
  int unknown_deletions() const { return unknown_deletions_; }

  // Used by the wrappers of entry points.
  bool strikes(Failure failure);
  bool is_lost() const { return lost_; }
  void raise(uint32_t error) { pending_ = pending_ == 0 ? error : pending_; }
  uint32_t take_error();
  void note_call() { forbidden_calls_ += forbidden_; }
  gl::Context& context() const { return context_; }
  std::map<std::string, std::set<uint64_t>> alive_;
  int unknown_deletions_ = 0;

 private:
  gl::Context& context_;
  Failure failure_ = Failure::none;
  int countdown_ = 0;
  bool failed_ = false, lost_ = false, forbidden_ = false;
  int forbidden_calls_ = 0;
  uint32_t pending_ = 0;
};

}  // namespace sideray::tests
