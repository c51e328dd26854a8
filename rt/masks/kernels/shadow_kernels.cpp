#include "rt/masks/kernels/shadow_kernels.h"

#include "rt/base/choose_kernels.h"

namespace sideray::rt {

SIDERAY_CHOOSE_KERNELS(ShadowKernels, shadow_kernels)

}  // namespace sideray::rt
