// Decides which processors the threads that we start may run on. Threads inherit that from the thread that starts them,
// and hosts pin their drawing thread to one; tracing threads must not share it. Any thread may call it.
#pragma once

#include <cstdint>

namespace sideray::rt {

// Returns how many processors this process may use: as when the library was loaded, whatever the calling thread has
// been pinned to since.
uint32_t cpu_count();

// Lets the calling thread run on all of them. Only our own threads call it.
void run_on_all_cpus();

}  // namespace sideray::rt
