// Holds a frame's shaders, one a thread: the built-in model's, or the host's if the scene has one. One thread begins a
// frame; each tracing thread uses its own shader.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "rt/shading/hit_shader.h"
#include "rt/shading/host_shader.h"
#include "rt/shading/point_shader.h"

namespace sideray::rt {

// Provides each thread with its shader.
class ShaderSource {
 public:
  virtual ~ShaderSource() = default;
  // Returns the thread's shader, ready for a chunk.
  virtual PointShader& begin_chunk(uint32_t thread) = 0;
};

// Returns HitShading::bounces for a request.
template <typename Request>
std::optional<uint32_t> bounces_of(const Request& request) {
  return request.light_bounces ? std::optional<uint32_t>(request.position) : std::nullopt;
}

class FrameShaders final : public ShaderSource {
 public:
  // The caller keeps referenced objects alive for the frame.
  struct Frame {
    const ShadingScene& scene;
    const Intersector& intersector;
    HostCalls calls;
    HitShading shading;
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
