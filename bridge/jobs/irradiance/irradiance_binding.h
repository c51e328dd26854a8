// Gives a host's program the irradiance of a frame, where it asks for it by the snippet's sideray_irradiance(). GL thread.
#pragma once

#include <cstdint>

#include "bridge/jobs/irradiance/irradiance_job.h"
#include "gl/context/functions.h"

namespace sideray::bridge {

// The unit is one of those that sideray_service_bind() sets, counted from its first_unit.
inline constexpr uint32_t irradiance_unit = 10;
bool reads_irradiance(const gl::Functions& gl, uint32_t program);

// `program` is in use. The unit is bound only where the program has the sampler. Without outputs the answer is black. The active
// unit is the caller's to put back.
void bind_irradiance(const gl::Functions& gl, uint32_t program, uint32_t first_unit, const IrradianceJob& job);

}  // namespace sideray::bridge
