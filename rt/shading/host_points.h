// Describes batches of points to a host's shader, calls it on the thread where it runs, and takes its answers. Holds
// scratch memory: one object per thread.
#pragma once

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "rt/base/trace_end.h"
#include "rt/embree/intersector.h"
#include "rt/shading/shading_queue.h"
#include "rt/light/straight_light.h"
#include "rt/surfaces/surface.h"

namespace sideray::rt {

// Says when and where the shader runs.
struct HostCalls {
  ShadingQueue* queue;  // null: at once, on the calling thread
  const std::atomic<bool>* cancelled;
};

// Takes the settings of the calls from a request.
template <typename Request>
HostCalls host_calls(const Request& request) {
  return {request.shading_queue, request.cancelled};
}

// Lays out an array of structs as far apart as the host was compiled with; uses the library's own memory where both
// agree.
template <typename T>
class HostArray {
 public:
  // Returns `ours` as the host reads it; members that only the host's struct has are 0.
  T* laid_out(std::vector<T>& ours, size_t stride_bytes) {
    if (stride_bytes == sizeof(T)) return ours.data();
    words_.assign((ours.size() * stride_bytes + sizeof(uint64_t) - 1) / sizeof(uint64_t), 0);
    auto* bytes = reinterpret_cast<std::byte*>(words_.data());
    for (size_t i = 0; i < ours.size(); ++i)
      std::memcpy(bytes + i * stride_bytes, &ours[i], std::min(stride_bytes, sizeof(T)));
    return reinterpret_cast<T*>(bytes);
  }
  // Takes back what the host has written; members that the host's struct lacks stay as they were.
  void read_back(std::vector<T>& ours, size_t stride_bytes) const {
    if (stride_bytes == sizeof(T)) return;
    const auto* bytes = reinterpret_cast<const std::byte*>(words_.data());
    for (size_t i = 0; i < ours.size(); ++i)
      std::memcpy(static_cast<void*>(&ours[i]), bytes + i * stride_bytes, std::min(stride_bytes, sizeof(T)));
  }

 private:
  static_assert(alignof(T) <= alignof(uint64_t));
  std::vector<uint64_t> words_;
};

class HostPoints {
 public:
  // The caller keeps all arguments. `shadows` off: no shadow rays.
  void begin(const ShadingScene& scene, const Intersector& intersector, const HostCalls& calls, bool shadows);

  struct Kind {
    uint32_t bounce;
    bool translucent, shadows;
  };
  // Once the frame is cancelled or its time is over, `end` says so, the shader is not asked any longer, and the answers
  // are black.
  void ask(std::span<const SurfacePoint> points, Kind kind, std::vector<HostAnswer>& answers);

  uint64_t rays_shadow = 0, asked = 0, not_finite = 0;  // since begin(), as the next
  TraceEnd end = TraceEnd::complete;

 private:
  void find_lights(std::span<const SurfacePoint> points, bool shadows);
  void find_light(std::span<const SurfacePoint> points, const shading::SrLight& light, uint32_t bit, bool trace);
  void pass_glass(uint32_t bit);
  void describe(const SurfacePoint& point, size_t i, const Kind& kind);
  bool is_cancelled() const;
  bool call();
  HostAnswer answer(const SurfacePoint& point, const sideray_shading_result& result);

  const ShadingScene* scene_ = nullptr;
  const Intersector* intersector_ = nullptr;
  HostCalls calls_{};
  bool shadows_ = true;
  std::vector<sideray_shading_point> points_;
  std::vector<sideray_shading_result> results_;
  HostArray<sideray_shading_point> host_points_;
  HostArray<sideray_shading_result> host_results_;
  std::vector<uint32_t> lights_;  // sideray_shading_point::lights
  std::vector<Ray> rays_;
  std::vector<uint32_t> of_points_;
  std::vector<uint8_t> blocked_;
  StraightLight straight_;
  std::vector<Ray> free_;
  std::vector<uint32_t> of_free_;
  std::vector<float> tints_;      // sideray_shading_point::tints of each point, where the scene tints light; else empty
  std::vector<uint8_t> tinted_;   // of each point
};

}  // namespace sideray::rt
