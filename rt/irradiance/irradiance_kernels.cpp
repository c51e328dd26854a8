#include "rt/irradiance/irradiance_kernels.h"

#include <string_view>

namespace sideray::rt {

namespace lanes_baseline {
const IrradianceKernels& irradiance_kernels();
}
#if defined(__x86_64__)
namespace lanes_avx2 {
const IrradianceKernels& irradiance_kernels();
}
namespace lanes_avx512 {
const IrradianceKernels& irradiance_kernels();
}
#endif

const IrradianceKernels& irradiance_kernels(const char* isa) {
#if defined(__x86_64__)
  const std::string_view name(isa);
  if (name == "avx512") return lanes_avx512::irradiance_kernels();
  if (name == "avx2") return lanes_avx2::irradiance_kernels();
#else
  static_cast<void>(isa);
#endif
  return lanes_baseline::irradiance_kernels();
}

}  // namespace sideray::rt
