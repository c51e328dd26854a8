// Chooses at run time among kernels that were compiled once for each instruction set. Only kernels' .cpp include it.
#pragma once

#include <string_view>

#include "rt/base/instruction_set.h"

#if defined(__x86_64__)
// Defines NAME(isa): returns the TYPE from the namespace named after the instruction set; null selects the widest.
#define SIDERAY_CHOOSE_KERNELS(TYPE, NAME)                                              \
  namespace lanes_baseline { const TYPE& NAME(); }                                      \
  namespace lanes_avx2 { const TYPE& NAME(); }                                          \
  namespace lanes_avx512 { const TYPE& NAME(); }                                        \
  const TYPE& NAME(const char* isa) {                                                   \
    const std::string_view chosen = isa != nullptr ? isa : widest_instruction_set();    \
    if (chosen == "avx512") return lanes_avx512::NAME();                                \
    return chosen == "avx2" ? lanes_avx2::NAME() : lanes_baseline::NAME();              \
  }
#else
#define SIDERAY_CHOOSE_KERNELS(TYPE, NAME)                                              \
  namespace lanes_baseline { const TYPE& NAME(); }                                      \
  const TYPE& NAME(const char*) { return lanes_baseline::NAME(); }
#endif
