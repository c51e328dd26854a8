// Draws whole pictures by rays, exact and unlimited. GL thread.
#pragma once

#include "bridge/renderer/picture_job.h"

namespace sideray::bridge {

// Times it as it is drawn, without a warm-up: it takes long enough, and nothing of it is kept from frame to frame.
void draw_reference(const PictureJob& job, Picture& picture);

}  // namespace sideray::bridge
