#include "rt/points/point_kernels.h"

#include <string_view>

#include "rt/base/instruction_set.h"

namespace sideray::rt {

namespace lanes_baseline {
const PointKernels& point_kernels();
}
#if defined(__x86_64__)
namespace lanes_avx2 {
const PointKernels& point_kernels();
}
namespace lanes_avx512 {
const PointKernels& point_kernels();
}
#endif

const PointKernels& point_kernels(const char* isa) {
#if defined(__x86_64__)
  const std::string_view name(isa);
  if (name == "avx512") return lanes_avx512::point_kernels();
  if (name == "avx2") return lanes_avx2::point_kernels();
#else
  static_cast<void>(isa);
#endif
  return lanes_baseline::point_kernels();
}

const PointKernels& point_kernels() {
  return point_kernels(widest_instruction_set());
}

}  // namespace sideray::rt
