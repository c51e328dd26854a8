#include "rt/irradiance/irradiance_kernels.h"

#include "rt/base/choose_kernels.h"

namespace sideray::rt {

SIDERAY_CHOOSE_KERNELS(IrradianceKernels, irradiance_kernels)

}  // namespace sideray::rt
