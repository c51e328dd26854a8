#include "rt/cache/layer_filter_kernels.h"

#include <string_view>

#include "rt/base/instruction_set.h"

namespace sideray::rt {

namespace lanes_baseline {
const LayerFilterKernels& layer_filter_kernels();
}
#if defined(__x86_64__)
namespace lanes_avx2 {
const LayerFilterKernels& layer_filter_kernels();
}
namespace lanes_avx512 {
const LayerFilterKernels& layer_filter_kernels();
}
#endif

const LayerFilterKernels& layer_filter_kernels(const char* isa) {
#if defined(__x86_64__)
  const std::string_view name(isa);
  if (name == "avx512") return lanes_avx512::layer_filter_kernels();
  if (name == "avx2") return lanes_avx2::layer_filter_kernels();
#else
  static_cast<void>(isa);
#endif
  return lanes_baseline::layer_filter_kernels();
}

const LayerFilterKernels& layer_filter_kernels() {
  return layer_filter_kernels(widest_instruction_set());
}

}  // namespace sideray::rt
