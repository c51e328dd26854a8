// Names the light that a frame's masks and irradiance give its layers. Thread: the worker's.
#pragma once

#include "bridge/base/frame_inputs.h"
#include "rt/irradiance/irradiance_request.h"
#include "rt/light/seen_light.h"
#include "rt/masks/mask_request.h"

namespace sideray::bridge {

// Returns the light at the frame's opaque pixels, of results that were traced before its layers; empty where the frame
// does not request both.
inline rt::PixelLight pixel_light(const FrameInputs& in, const rt::OcclusionMasks& masks, const rt::IrradianceImage& irradiance) {
  if (!in.irradiance || !in.masks || in.masks->ao_rays == 0) return {};
  const size_t pixels = static_cast<size_t>(in.source.width) * static_cast<size_t>(in.source.height);
  if (masks.open.size() != pixels || irradiance.light.size() != 4 * pixels) return {};
  return {irradiance.light, masks.open};
}

}  // namespace sideray::bridge
