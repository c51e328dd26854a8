// The instruction sets whose kernels this machine can run, for tests that compare their bits.
#pragma once

#include <vector>

namespace sideray::rt::test {

// Returns Embree's names, the narrowest first.
inline std::vector<const char*> kernel_sets() {
  std::vector<const char*> names{"sse4.2"};
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) names.push_back("avx2");
  if (__builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512dq")) names.push_back("avx512");
#endif
  return names;
}

}  // namespace sideray::rt::test
