// Gives a host's program the masks of a frame, if it reads them by the snippet's sideray_shadow(), sideray_ao() or the
// functions for earlier frames. GL thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>

#include "bridge/jobs/masks/mask_job.h"
#include "gl/context/functions.h"

namespace sideray::bridge {

// Of those that sideray_service_bind() sets, from its first_unit on.
inline constexpr uint32_t shadow_unit = 3, ao_unit = 4, tint_unit = 7, mask_depth_unit = 8, mask_answer_unit = 9;
// Return whether the program reads tints, the depth of masks, and which of them are answered.
bool reads_tints(const gl::Functions& gl, uint32_t program);
bool reads_mask_depth(const gl::Functions& gl, uint32_t program);
bool reads_mask_answers(const gl::Functions& gl, uint32_t program);

// `program` is in use. Only units whose sampler it has are bound. Whatever the outputs lack answers 1. The caller
// restores the active unit. `space_origin`: where the program's positions are measured from.
void bind_masks(const gl::Functions& gl, uint32_t program, uint32_t first_unit, const MaskJob& job,
                glm::dvec3 space_origin);

}  // namespace sideray::bridge
