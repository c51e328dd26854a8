// Counts OpenGL calls by wrapping each entry point that the library uses. Entry points without a wrapper are null, so
// that calling one crashes. One thread.
#pragma once

#include <cstdint>

#include "gl/context/functions.h"

namespace sideray::tests {

struct CallCounts {
  uint64_t calls = 0;    // of any entry point but glClientWaitSync
  uint64_t objects = 0;  // that Gen* and Create* made
  CallCounts operator-(const CallCounts& b) const { return {calls - b.calls, objects - b.objects}; }
};

CallCounts call_counts();
// Returns whether this thread is inside an OpenGL call, where allocations are the driver's.
bool in_driver();

// Wraps the entry points of a context. Wrappers call the context for which this was last called.
void count_calls(gl::Functions& functions);

}  // namespace sideray::tests
