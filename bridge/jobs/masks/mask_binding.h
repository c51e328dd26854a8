// Gives a host's program the masks of a frame, where it asks for them by the snippet's sideray_shadow() or
// sideray_ao(). GL thread.
#pragma once

#include <sideray/sideray.h>

#include <cstdint>

#include "gl/context/functions.h"

namespace sideray::bridge {

inline constexpr uint32_t tint_unit = 7;  // of those that sideray_service_bind() sets
// Returns whether the program reads tints.
bool reads_tints(const gl::Functions& gl, uint32_t program);

// `program` is in use. Only units whose sampler it has are bound: first_unit for the shadow masks, first_unit + 1 for
// ambient occlusion, tint_unit for what is left of colours. Whatever the outputs lack answers 1. The active unit is the caller's to put back.
void bind_masks(const gl::Functions& gl, uint32_t program, uint32_t first_unit, uint32_t tint_unit,
                const sideray_mask_outputs& outputs);

}  // namespace sideray::bridge
