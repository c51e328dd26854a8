// Draws a frame of a picture by the rasterizer: opaque surfaces, results of rays, translucent surfaces. GL thread.
#pragma once

#include "bridge/raster/raster_parts.h"

namespace sideray::bridge {

FrameCounters draw_frame(const RasterParts& parts, PictureJob& job, const FramePosition& position, FrameTimer& timer,
                         Fragments fragments);

}  // namespace sideray::bridge
