// Passes batches of points to a host's shader, calls it on the thread where it must run, and reads its results. It has
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

// Says where the shader runs and when it stops.
struct HostCalls {
  ShadingQueue* queue;  // null: at once, on the calling thread
  const std::atomic<bool>* cancelled;
};

// Takes these settings from a request.
template <typename Request>
HostCalls host_calls(const Request& request) {
  return {request.shading_queue, request.cancelled};
}

// Converts an array of structs to the struct size that the host was compiled with. If sizes agree, it uses the
// library's array itself.
template <typename T>
class HostArray {
 public:
  // Returns `ours` in the host's layout; members that only the host's struct has are 0.
  T* laid_out(std::vector<T>& ours, size_t stride_bytes) {
    if (stride_bytes == sizeof(T)) return ours.data();
    words_.assign((ours.size() * stride_bytes + sizeof(uint64_t) - 1) / sizeof(uint64_t), 0);
    auto* bytes = reinterpret_cast<std::byte*>(words_.data());
    for (size_t i = 0; i < ours.size(); ++i)
      std::memcpy(bytes + i * stride_bytes, &ours[i], std::min(stride_bytes, sizeof(T)));
    return reinterpret_cast<T*>(bytes);
  }
  // Copies back what the host has written; members that the host's struct lacks are unchanged.
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
  // The caller keeps all arguments alive. `shadows` false: no shadow rays.
  void begin(const ShadingScene& scene, const Intersector& intersector, const HostCalls& calls, bool shadows);

  struct Kind {
    uint32_t bounce;
    bool translucent, shadows;
  };
  // Calls the shader for the points. After the frame is cancelled or late it sets `end`, calls no shader any more, and
  // returns black answers.
  void ask(std::span<const SurfacePoint> points, Kind kind, std::vector<HostAnswer>& answers);

  uint64_t rays_shadow = 0, asked = 0, not_finite = 0;  // since begin(), like `end`
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
  std::vector<float> tints_;      // sideray_shading_point::tints of each point, if the scene tints light; else empty
  std::vector<uint8_t> tinted_;   // by point
};

}  // namespace sideray::rt
