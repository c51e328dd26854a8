// One picture that is being drawn: what it is drawn with and from, all decided before its first frame. Frames, outputs
// and measurements are functions of it. GL thread.
#pragma once

#include <sideray/renderer.h>

#include <memory>

#include "bridge/base/handles.h"
#include "bridge/plan/frame_plan.h"
#include "bridge/renderer/frame_timer.h"
#include "bridge/picture/picture.h"
#include "bridge/renderer/sequence.h"
#include "bridge/service/service.h"
#include "gl/rasterizer.h"
#include "model/snapshot.h"

namespace sideray::bridge {

// A camera position within the pixel.
struct FramePosition {
  gl::RasterView view;
  uint32_t seed;
};

struct PictureJob {
  const gl::Functions& gl;
  gl::Rasterizer& rasterizer;
  Sequence& sequence;
  Service* service;        // null where the service traces nothing
  sideray_tracer* tracer;  // null where no ray is traced
  std::shared_ptr<const model::Snapshot> snapshot;
  const FramePlan plan;
  const sideray_camera camera;
  const RenderOptions options;
  bool has_frame = false;  // one was drawn: the next redraws it
  bool keeps_masks = false;  // and its masks stay

  gl::RasterView view_of(uint32_t sample) const {
    return rasterizer.make_view(camera, sequence.jitter(plan, sample));
  }
};

}  // namespace sideray::bridge
