// Adds the channels of ground truth to a picture: what is seen with glass, and what stands behind it. The backend's thread.
#pragma once

#include "bridge/drawing/picture_job.h"

namespace sideray::bridge {

// Adds the channels of ground truth that the options ask for, none where they ask for none. Rays of their own find them,
// through the middle of each pixel, wherever the picture's samples lie.
void add_ground_truth(const PictureJob& job, Picture& picture);

}  // namespace sideray::bridge
