// Sets the threads and the instruction set of a tracer. Plain values; any thread.
#pragma once

#include <cstdint>
#include <string>

namespace sideray::rt {

struct TracerConfig {
  uint32_t threads = 0;  // 0 = cpu_count()
  std::string isa;       // "", "sse4.2", "avx2", "avx512"
};

}  // namespace sideray::rt
