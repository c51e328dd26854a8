// Draws the camera positions of a picture, one frame each, and averages them. GL thread.
#pragma once

#include "bridge/renderer/picture_job.h"

namespace sideray::bridge {

// Adds colour, additional outputs and, where the timer times stages, counters.
void draw_positions(PictureJob& job, FrameTimer& timer, Picture& picture);

}  // namespace sideray::bridge
