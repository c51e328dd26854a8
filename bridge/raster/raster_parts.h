// The rasterizer and the service that draw a frame together. GL thread.
#pragma once

#include "bridge/drawing/picture_job.h"
#include "bridge/service/service.h"
#include "gl/rasterizer.h"

namespace sideray::bridge {

struct RasterParts {
  gl::Rasterizer& rasterizer;
  Service* service;  // null where the service traces nothing
};

}  // namespace sideray::bridge
