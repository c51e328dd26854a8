#include "rt/cache/layer_filter_kernels.h"

#include "rt/base/choose_kernels.h"

namespace sideray::rt {

SIDERAY_CHOOSE_KERNELS(LayerFilterKernels, layer_filter_kernels)

}  // namespace sideray::rt
