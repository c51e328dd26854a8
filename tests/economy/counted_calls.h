// Counts OpenGL calls by putting a function of its own before each entry point that the library uses; an entry point
// that is missing here is null, and calling it ends the program. One thread.
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
// Whether this thread is inside an OpenGL call: what the driver allocates there is its own affair.
bool in_driver();

// The entry points stay those of the one context that this was last called for.
void count_calls(gl::Functions& functions);

}  // namespace sideray::tests
