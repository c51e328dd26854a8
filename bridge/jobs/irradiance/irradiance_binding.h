// Binds a frame's irradiance to a host's program that reads it by the snippet's sideray_irradiance(). GL thread.
#pragma once

#include <cstdint>

#include "bridge/jobs/irradiance/irradiance_job.h"
#include "gl/context/functions.h"

namespace sideray::bridge {

// Counted from the first_unit of sideray_service_bind(), like its other units.
inline constexpr uint32_t irradiance_unit = 10;
bool reads_irradiance(const gl::Functions& gl, uint32_t program);

// `program` must be in use. Binds the unit only where the program has the sampler; without outputs the answer is black.
// The caller restores the active unit.
void bind_irradiance(const gl::Functions& gl, uint32_t program, uint32_t first_unit, const IrradianceJob& job);

}  // namespace sideray::bridge
