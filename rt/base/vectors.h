// Compiles plain loops for several instruction sets, of which the widest is chosen when the program starts. Without
// fused multiply-add (cmake/SiderayLayer.cmake) the bits are the same.
#pragma once

// Clang is left out: callers in other files do not find the symbol that clang 14 gives such a function.
#if defined(__x86_64__) && !defined(__clang__) && !defined(__SANITIZE_THREAD__)
#define SIDERAY_VECTORS __attribute__((target_clones("avx512f", "avx2", "default")))
// Functions that such a function calls must be inlined into it.
#define SIDERAY_INLINE __attribute__((always_inline)) inline
#else
#define SIDERAY_VECTORS
#define SIDERAY_INLINE inline
#endif
