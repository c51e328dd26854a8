// Names the widest instruction set for which lane kernels are compiled and that this machine has. Any thread may call
// it.
#pragma once

namespace sideray::rt {

// Returns "avx512", "avx2" or "baseline".
inline const char* widest_instruction_set() {
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
    return "avx512";
  if (__builtin_cpu_supports("avx2")) return "avx2";
#endif
  return "baseline";
}

}  // namespace sideray::rt
