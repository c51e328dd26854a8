#include "rt/surfaces/shade_kernels.h"

#include <string_view>

namespace sideray::rt {

namespace lanes_baseline {
const ShadeKernels& kernels();
}
#if defined(__x86_64__)
namespace lanes_avx2 {
const ShadeKernels& kernels();
}
namespace lanes_avx512 {
const ShadeKernels& kernels();
}
#endif

const ShadeKernels& shade_kernels(const char* isa) {
#if defined(__x86_64__)
  const std::string_view name(isa);
  if (name == "avx512") return lanes_avx512::kernels();
  if (name == "avx2") return lanes_avx2::kernels();
#else
  static_cast<void>(isa);
#endif
  return lanes_baseline::kernels();
}

}  // namespace sideray::rt
