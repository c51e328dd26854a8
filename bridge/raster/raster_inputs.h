// Makes the inputs that the renderer submits to the service for a frame. GL thread.
#pragma once

#include "bridge/raster/raster_parts.h"

namespace sideray::bridge {

// Returns the inputs of a frame whose opaque surfaces are drawn.
FrameInputs raster_inputs(const RasterParts& parts, const PictureJob& job, const FramePosition& position);

}  // namespace sideray::bridge
