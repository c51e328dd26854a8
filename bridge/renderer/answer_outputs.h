// Adds channels for the answers of rays that pixels show, and their age (SIDERAY_AOV_ANSWERS). The backend's thread.
#pragma once

#include "bridge/drawing/picture_job.h"
#include "bridge/picture/picture.h"

namespace sideray::bridge {

// Adds answer.* of the last frame, where options request them.
void add_answers(const PictureJob& job, Picture& picture);

}  // namespace sideray::bridge
