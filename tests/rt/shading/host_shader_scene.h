// A shader of the host made of a function of one point, and frames that ask it. Test support.
#pragma once

#include <cmath>
#include <functional>
#include <glm/glm.hpp>
#include <mutex>
#include <set>
#include <thread>
#include <vector>

#include "rt/tracer_scene.h"

namespace sideray::rt::test {

using Point = sideray_shading_point;
using Result = sideray_shading_result;

inline constexpr float half_rounding = 1.0f / 1024;
inline constexpr double fov = 0.8;
inline constexpr uint32_t size = 24;

// A shader of the host from a function of one point.
struct Shader {
  std::function<void(const Point&, Result&)> shade;
  std::mutex mutex{};
  std::vector<Point> points{};
  std::set<std::thread::id> threads{};

  static void call(void* user, const Point* points, size_t count, Result* results) {
    auto& shader = *static_cast<Shader*>(user);
    for (size_t i = 0; i < count; ++i) shader.shade(points[i], results[i]);
    const std::lock_guard lock(shader.mutex);
    shader.points.insert(shader.points.end(), points, points + count);
    shader.threads.insert(std::this_thread::get_id());
  }
  sideray_shader_desc desc() {
    sideray_shader_desc d{};
    d.point_stride_bytes = sizeof(sideray_shading_point);
    d.result_stride_bytes = sizeof(sideray_shading_result);
    d.size = sizeof(d);
    d.shade = call, d.user = this;
    d.radiance_scale = 1.0f;
    return d;
  }
};

inline void set(float (&to)[3], glm::vec3 from) {
  to[0] = from.x, to[1] = from.y, to[2] = from.z;
}

inline glm::vec3 vec3(const float (&v)[3]) {
  return {v[0], v[1], v[2]};
}

inline glm::dvec3 dvec3(const double (&v)[3]) {
  return {v[0], v[1], v[2]};
}

inline glm::dvec3 direction_of(uint32_t x, uint32_t y) {
  const double half = std::tan(0.5 * fov);
  return glm::normalize(glm::dvec3(((x + 0.5) * 2 / size - 1) * half, ((y + 0.5) * 2 / size - 1) * half, -1));
}

inline TestFrame frame_of(uint32_t layers) {
  return TestFrame(perspective({0, 0, 0}, {0, 0, -1}, fov, 1.0), size, size, layers);
}

inline LayerCache cache_of(TestScene& scene, Shader& shader,
                           const std::function<void(sideray_shader_desc&)>& change = {}, uint32_t threads = 2,
                           Counters* counters = nullptr) {
  sideray_shader_desc desc = shader.desc();
  if (change) change(desc);
  scene.scene.set_shader(&desc);
  Tracer tracer({.threads = threads, .isa = ""});
  tracer.set_scene(scene.commit());
  TestFrame frame = frame_of(2);
  LayerCache cache;
  const Counters counted = tracer.trace_cache(frame.get(), cache);
  if (counters) *counters = counted;
  return cache;
}

}  // namespace sideray::rt::test
