// Draws whole pictures by rays, exact and unlimited. The backend's thread.
#pragma once

#include "bridge/drawing/picture_job.h"

namespace sideray::bridge {

// Times the drawing itself, without a warm-up: it takes long enough, and the next frame reuses none of it.
void draw_reference(const PictureJob& job, Picture& picture);

}  // namespace sideray::bridge
