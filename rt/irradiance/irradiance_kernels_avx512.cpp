#define SIDERAY_LANES lanes_avx512
#define SIDERAY_LANES_NAME "avx512"
#define SIDERAY_LANE_COUNT 16
#include "rt/irradiance/irradiance_kernels_body.h"
