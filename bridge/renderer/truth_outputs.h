// Adds ground truth to a picture: the first surface, glass included, and what is behind it. The backend's thread.
#pragma once

#include "bridge/drawing/picture_job.h"

namespace sideray::bridge {

// Adds the channels of ground truth that the options request. Separate rays find them, through the centre of each
// pixel, wherever the picture's samples are.
void add_ground_truth(const PictureJob& job, Picture& picture);

}  // namespace sideray::bridge
