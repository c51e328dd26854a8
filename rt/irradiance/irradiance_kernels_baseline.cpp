#define SIDERAY_LANES lanes_baseline
#define SIDERAY_LANES_NAME "baseline"
#define SIDERAY_LANE_COUNT 4
#include "rt/irradiance/irradiance_kernels_body.h"
