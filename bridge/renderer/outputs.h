// Adds the additional outputs of a frame that was just drawn to its picture. The backend's thread.
#pragma once

#include "bridge/drawing/picture_job.h"

namespace sideray::bridge {

// Draws the mask again where the picture shows counts.
void add_aovs(const PictureJob& job, const gl::RasterView& view, Picture& picture);

}  // namespace sideray::bridge
