// What pixels of a picture show of the rays, and how old it is (SIDERAY_AOV_ANSWERS). The backend's thread.
#pragma once

#include "bridge/drawing/picture_job.h"
#include "bridge/picture/picture.h"

namespace sideray::bridge {

// Adds answer.* of the frame that was drawn last, where options ask for them.
void add_answers(const PictureJob& job, Picture& picture);

}  // namespace sideray::bridge
