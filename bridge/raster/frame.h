// Draws one frame of a picture by the rasterizer: the opaque surfaces, what rays find, then what is translucent. GL thread.
#pragma once

#include "bridge/raster/raster_parts.h"

namespace sideray::bridge {

FrameCounters draw_frame(const RasterParts& parts, PictureJob& job, const FramePosition& position, FrameTimer& timer,
                         Fragments fragments);

}  // namespace sideray::bridge
