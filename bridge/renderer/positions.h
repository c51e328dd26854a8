// Draws the camera positions of a picture, one frame each, and averages them. The backend's thread.
#pragma once

#include "bridge/drawing/picture_job.h"

namespace sideray::bridge {

// Adds colour, additional outputs, counters, and those times that need no fence between stages.
void draw_positions(PictureJob& job, FrameTimer& timer, Picture& picture);

}  // namespace sideray::bridge
