#include "rt/surfaces/shade_kernels.h"

#include "rt/base/choose_kernels.h"

namespace sideray::rt {

SIDERAY_CHOOSE_KERNELS(ShadeKernels, shade_kernels)

}  // namespace sideray::rt
