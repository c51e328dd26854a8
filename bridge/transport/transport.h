// Chooses how a frame's bytes move between the GPU and memory. GL thread.
#pragma once

#include <memory>

#include "bridge/transport/depth_packer.h"
#include "bridge/transport/readback.h"
#include "gl/context/functions.h"
#include "rt/base/executor.h"

namespace sideray::bridge {

// Persistent: through buffers that stay mapped. Otherwise depth is mapped again each frame, and the driver reads texels
// directly.
struct Transport {
  bool persistent_readback = false, persistent_upload = false;
  std::unique_ptr<DepthPacker> packer;  // null: the driver packs depth with stencil
};

// Measures every way to read back and to upload at the size of the request, and returns the fastest of each. Waits for
// the GPU several times. Without buffer_storage there is only one way. A way whose bytes differ from the driver's own
// copy is not used. The environment variable SIDERAY_TRANSPORT pins a way (copy, persistent, packed), or prints the
// measurements (report). Needs guards over the pixel transfer state, framebuffers and the active unit's textures.
// Throws Failure (INVALID_ARGUMENT, UNSUPPORTED, OUT_OF_MEMORY).
Transport choose_transport(const gl::Functions& gl, const ReadbackRequest& request, rt::Executor& copiers);

}  // namespace sideray::bridge
