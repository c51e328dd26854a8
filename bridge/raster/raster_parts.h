// Holds the rasterizer and the service that draw a frame together. GL thread.
#pragma once

#include "bridge/drawing/picture_job.h"
#include "bridge/service/service.h"
#include "gl/rasterizer.h"

namespace sideray::bridge {

struct RasterParts {
  gl::Rasterizer& rasterizer;
  Service* service;  // null where the service traces nothing
};

// Waits until a frame's jobs (SIDERAY_JOB_*) are uploaded. Throws Failure, CANCELLED where the picture is cancelled.
inline void wait_for(Service& service, const PictureJob& job, sideray_ticket ticket, uint32_t jobs) {
  constexpr int32_t slice_ms = 5;
  while (!service.wait(ticket, jobs, slice_ms))
    if (job.cancelled) service.cancel(ticket);
}

}  // namespace sideray::bridge
