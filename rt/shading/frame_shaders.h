// The shaders that a frame's chunks are shaded with, one a thread: the built-in model's, or the host's where the scene
// has one. One thread begins a frame; each tracing thread takes its own.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "rt/shading/hit_shader.h"
#include "rt/shading/host_shader.h"
#include "rt/shading/point_shader.h"

namespace sideray::rt {

// Gives a thread its shader.
class ShaderSource {
 public:
  virtual ~ShaderSource() = default;
  // The thread's shader, begun anew.
  virtual PointShader& begin_chunk(uint32_t thread) = 0;
};

class FrameShaders final : public ShaderSource {
 public:
  // The caller keeps what it refers to for the frame.
  struct Frame {
    const ShadingScene& scene;
    const Intersector& intersector;
    HostCalls calls;
    bool shadows;
    bool tells_rough;  // rough reflections are returned apart
    float error;       // LayerRequest::ray_reuse
    glm::vec3 viewer = {0, 0, 1};  // way_to_viewer()
    bool bounces = false;          // LayerRequest::light_bounces
  };
  explicit FrameShaders(uint32_t threads) : threads_(threads) {}
  void begin_frame(const Frame& frame) { frame_.emplace(frame); }
  PointShader& begin_chunk(uint32_t thread) override;

 private:
  struct Thread {
    HitShader model;
    HostShader host;
  };
  std::vector<Thread> threads_;
  std::optional<Frame> frame_;
};

}  // namespace sideray::rt
