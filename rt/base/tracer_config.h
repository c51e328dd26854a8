// The threads and the instruction set that a tracer uses. Plain values; any thread.
#pragma once

#include <cstdint>
#include <string>

namespace sideray::rt {

struct TracerConfig {
  uint32_t threads = 0;  // 0 = all
  std::string isa;       // "", "sse4.2", "avx2", "avx512"
};

}  // namespace sideray::rt
