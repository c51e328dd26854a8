// Binds a frame's masks to a host's program that reads them by the snippet's sideray_shadow(), sideray_ao() or the
// functions for earlier frames. GL thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

#include "bridge/jobs/masks/mask_job.h"
#include "gl/context/functions.h"

namespace sideray::bridge {

// Counted from the first_unit of sideray_service_bind(), like its other units.
inline constexpr uint32_t shadow_unit = 3, ao_unit = 4, tint_unit = 7, mask_depth_unit = 8, mask_answer_unit = 9;
// Return whether the program reads tints, the masks' depth, and their answers.
bool reads_tints(const gl::Functions& gl, uint32_t program);
bool reads_mask_depth(const gl::Functions& gl, uint32_t program);
bool reads_mask_answers(const gl::Functions& gl, uint32_t program);

// `program` must be in use. Binds only units whose sampler it has. What the outputs lack reads as 1. The caller
// restores the active unit. `space_origin`: the origin of the program's positions.
void bind_masks(const gl::Functions& gl, uint32_t program, uint32_t first_unit, const MaskJob& job,
                glm::dvec3 space_origin);

}  // namespace sideray::bridge
