#define SIDERAY_LANES lanes_baseline
#define SIDERAY_LANES_NAME "baseline"
#define SIDERAY_LANE_COUNT 4
#include "rt/masks/kernels/shadow_kernels_body.h"
