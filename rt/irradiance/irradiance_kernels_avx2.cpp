#define SIDERAY_LANES lanes_avx2
#define SIDERAY_LANES_NAME "avx2"
#define SIDERAY_LANE_COUNT 8
#include "rt/irradiance/irradiance_kernels_body.h"
