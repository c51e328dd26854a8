// Gives filter functions access to Embree's packets, to read hits and to accept or reject them. Only intersector.cpp
// uses it. Each packet belongs to one thread.
#pragma once

#include <bit>
#include <cstdint>
#include <glm/glm.hpp>

#if defined(__SSE2__)
#include <xmmintrin.h>
#endif

#include "rt/embree/embree.h"
#include "rt/embree/layer_collector.h"

namespace sideray::rt {

// Returns a mask whose bit i is set where valid[i] is -1.
inline uint32_t lanes_of(const int* valid, uint32_t width) {
  uint32_t bits = 0, i = 0;
#if defined(__SSE2__)
  for (; i + 4 <= width; i += 4)
    bits |= static_cast<uint32_t>(_mm_movemask_ps(_mm_loadu_ps(reinterpret_cast<const float*>(valid + i)))) << i;
#endif
  for (; i < width; ++i) bits |= static_cast<uint32_t>(valid[i] == -1) << i;
  return bits;
}

// Wraps the packet that Embree passes to a filter. By Embree's protocol valid = 0 rejects a hit and keeps the ray's
// end; a filter that leaves valid and writes tfar sets a new end. Embree's packet is as wide as ours, because ours is
// native.
template <unsigned N>
struct FilterPacket {
  const RTCFilterFunctionNArguments& a;

  uint32_t lanes() const { return lanes_of(a.valid, N); }
  int& valid(uint32_t i) const { return a.valid[i]; }
  float& t_far(uint32_t i) const { return RTCRayN_tfar(a.ray, N, i); }
  uint32_t ray(uint32_t i) const { return RTCRayN_id(a.ray, N, i); }
  uint32_t instance(uint32_t i) const { return RTCHitN_instID(a.hit, N, i, 0); }
  uint32_t primitive(uint32_t i) const { return RTCHitN_primID(a.hit, N, i); }
  Candidate candidate(uint32_t i) const { return {t_far(i), instance(i), primitive(i)}; }

  // Tests Embree's normal in object space, with a margin: near the silhouette the recomputation decides.
  bool surely_back(uint32_t i) const {
    const glm::vec3 n(RTCHitN_Ng_x(a.hit, N, i), RTCHitN_Ng_y(a.hit, N, i), RTCHitN_Ng_z(a.hit, N, i));
    const glm::vec3 d(RTCRayN_dir_x(a.ray, N, i), RTCRayN_dir_y(a.ray, N, i), RTCRayN_dir_z(a.ray, N, i));
    const float s = glm::dot(n, d);
    return s > 0.0f && s * s > 1e-4f * glm::dot(n, n) * glm::dot(d, d);
  }
};

// Calls `keep(packet, lane)` for each hit; false rejects the hit.
template <unsigned N, typename Keep>
void for_each_hit(const RTCFilterFunctionNArguments& arguments, Keep keep) {
  const FilterPacket<N> packet{arguments};
  for (uint32_t lanes = packet.lanes(); lanes != 0; lanes &= lanes - 1) {
    const auto i = static_cast<uint32_t>(std::countr_zero(lanes));
    if (!keep(packet, i)) packet.valid(i) = 0;
  }
}

}  // namespace sideray::rt
