#include "rt/points/point_kernels.h"

#include <string_view>

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
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
    return point_kernels("avx512");
  if (__builtin_cpu_supports("avx2")) return point_kernels("avx2");
#endif
  return point_kernels("baseline");
}

}  // namespace sideray::rt
