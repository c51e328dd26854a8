// Adds the channels of ground truth to a picture: what is seen with glass, and what stands behind it. GL thread.
#pragma once

#include "bridge/renderer/picture_job.h"

namespace sideray::bridge {

// By rays of their own through the middle of each pixel, wherever the picture's samples lie; nothing without such a channel
// among the options.
void add_ground_truth(const PictureJob& job, Picture& picture);

}  // namespace sideray::bridge
