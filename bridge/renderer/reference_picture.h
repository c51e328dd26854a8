// Draws whole pictures by rays, exact and unlimited. The backend's thread.
#pragma once

#include "bridge/drawing/picture_job.h"

namespace sideray::bridge {

// Times it as it is drawn, without a warm-up: it takes long enough, and nothing of it is reused by the next frame.
void draw_reference(const PictureJob& job, Picture& picture);

}  // namespace sideray::bridge
