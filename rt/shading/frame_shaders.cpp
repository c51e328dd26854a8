#include "rt/shading/frame_shaders.h"

namespace sideray::rt {

PointShader& FrameShaders::begin_chunk(uint32_t thread) {
  Thread& own = threads_[thread];
  if (frame_->scene.snapshot->shader.shade) {
    own.host.begin(frame_->scene, frame_->intersector, frame_->calls, frame_->shading.shadows);
    return own.host;
  }
  own.model.begin(frame_->scene, frame_->intersector, frame_->shading);
  return own.model;
}

}  // namespace sideray::rt
