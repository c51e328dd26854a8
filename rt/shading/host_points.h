// Asks a host's shader about batches of points: what it is told, what it says, on which thread it runs. Holds scratch
// memory: one object per thread.
#pragma once

#include <atomic>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "rt/embree/intersector.h"
#include "rt/shading/shading_queue.h"
#include "rt/surfaces/surface.h"

namespace sideray::rt {

// Thrown where the shader is not asked any more: the frame was cancelled, or its time is over.
struct ShadingGivenUp {
  bool cancelled;
};

// When and where the shader runs.
struct HostCalls {
  ShadingQueue* queue;  // null: here and now
  const std::atomic<bool>* cancelled;
  Deadline deadline;
};

// Of a FrameRequest or another.
template <typename Request>
HostCalls host_calls(const Request& request) {
  return {request.shading_queue, request.cancelled, request.deadline};
}

class HostPoints {
 public:
  // All kept by the caller. `shadows` off: no shadow rays.
  void begin(const ShadingScene& scene, const Intersector& intersector, const HostCalls& calls, bool shadows);

  struct Kind {
    uint32_t bounce;
    bool translucent, shadows;
  };
  // Throws ShadingGivenUp.
  void ask(std::span<const SurfacePoint> points, Kind kind, std::vector<HostAnswer>& answers);

  uint64_t rays_shadow = 0, asked = 0, not_finite = 0;  // since begin()

 private:
  void find_lights(std::span<const SurfacePoint> points, bool shadows);
  void find_light(std::span<const SurfacePoint> points, const shading::SrLight& light, uint32_t bit, bool trace);
  void describe(const SurfacePoint& point, size_t i, const Kind& kind);
  void call(size_t count);
  HostAnswer answer(const SurfacePoint& point, const sideray_shading_result& result);

  const ShadingScene* scene_ = nullptr;
  const Intersector* intersector_ = nullptr;
  HostCalls calls_{};
  bool shadows_ = true;
  std::vector<sideray_shading_point> points_;
  std::vector<sideray_shading_result> results_;
  std::vector<uint32_t> lights_;  // sideray_shading_point::lights
  std::vector<Ray> rays_;
  std::vector<uint32_t> of_points_;
  std::vector<uint8_t> blocked_;
};

}  // namespace sideray::rt
