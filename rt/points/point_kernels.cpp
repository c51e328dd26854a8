#include "rt/points/point_kernels.h"

#include "rt/base/choose_kernels.h"

namespace sideray::rt {

SIDERAY_CHOOSE_KERNELS(PointKernels, point_kernels)

}  // namespace sideray::rt
