// What a tracer runs on. Plain values; any thread.
#pragma once

#include <cstdint>
#include <string>

namespace sideray::rt {

struct TracerConfig {
  uint32_t threads = 0;  // 0 = all
  std::string isa;       // "", "sse4.2", "avx2", "avx512"
};

}  // namespace sideray::rt
