#include "rt/masks/kernels/shadow_kernels.h"

#include <string_view>

#include "rt/base/instruction_set.h"

namespace sideray::rt {

namespace lanes_baseline {
const ShadowKernels& shadow_kernels();
}
#if defined(__x86_64__)
namespace lanes_avx2 {
const ShadowKernels& shadow_kernels();
}
namespace lanes_avx512 {
const ShadowKernels& shadow_kernels();
}
#endif

const ShadowKernels& shadow_kernels(const char* isa) {
#if defined(__x86_64__)
  const std::string_view name(isa);
  if (name == "avx512") return lanes_avx512::shadow_kernels();
  if (name == "avx2") return lanes_avx2::shadow_kernels();
#else
  static_cast<void>(isa);
#endif
  return lanes_baseline::shadow_kernels();
}

const ShadowKernels& shadow_kernels() {
  return shadow_kernels(widest_instruction_set());
}

}  // namespace sideray::rt
