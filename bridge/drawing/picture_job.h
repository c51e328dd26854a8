// Holds a picture that is being drawn: its inputs and its plan, fixed before its first frame. Frames, outputs and
// measurements are functions of it. The backend's thread.
#pragma once

#include <sideray/renderer.h>

#include <atomic>
#include <memory>

#include "bridge/base/handles.h"
#include "bridge/drawing/backend.h"
#include "bridge/drawing/frame_timer.h"
#include "bridge/drawing/sequence.h"
#include "bridge/picture/picture.h"
#include "bridge/plan/frame_plan.h"
#include "model/failure.h"
#include "model/snapshot.h"

namespace sideray::bridge {

struct PictureJob {
  Backend& backend;
  Sequence& sequence;
  sideray_tracer* tracer;  // null where no ray is traced
  std::shared_ptr<const model::Snapshot> snapshot;
  const FramePlan plan;
  const sideray_camera camera;
  const RenderOptions options;
  const std::atomic<bool>& cancelled;  // set by another thread
  bool has_frame = false;  // a frame was drawn; the next one repeats it, to time it
  bool keeps_masks = false;  // the repetition reuses the masks

  gl::RasterView view_of(uint32_t sample) const {
    return backend.make_view(camera, sequence.jitter(plan, sample));
  }
  // Throws Failure (CANCELLED). After a cancellation the last frames may be incomplete.
  void require_wanted() const {
    if (cancelled) fail(SIDERAY_CANCELLED, "picture: cancelled");
  }
};

}  // namespace sideray::bridge
