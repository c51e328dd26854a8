// Decides which processors our threads may run on. A thread inherits the affinity of the thread that starts it, and
// hosts pin their drawing thread to one processor, which tracing threads must not share. Any thread may call it.
#pragma once

#include <cstdint>

namespace sideray::rt {

// Returns how many processors this process could use when the library was loaded, whatever the calling thread has been
// pinned to since.
uint32_t cpu_count();

// Lets the calling thread run on all these processors. Only our own threads call it.
void run_on_all_cpus();

}  // namespace sideray::rt
