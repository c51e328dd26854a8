// Adds the additional outputs of a frame that was just drawn to its picture. The backend's thread.
#pragma once

#include "bridge/drawing/picture_job.h"

namespace sideray::bridge {

// Draws the mask once more where it has to be counted for its picture.
void add_aovs(const PictureJob& job, const gl::RasterView& view, Picture& picture);

}  // namespace sideray::bridge
