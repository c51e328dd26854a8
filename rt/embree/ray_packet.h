// Fills Embree's packets with rays, and leaves out rays on which Embree would abort. Only intersector.cpp uses it. Each
// packet belongs to one thread.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <span>

#include "rt/embree/embree.h"
#include "rt/embree/layer_collector.h"
#include "rt/embree/top_level.h"

namespace sideray::rt {

inline float largest_component(glm::vec3 v) {
  return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

// Returns a power of two that brings a very long or very short direction into the range that Embree handles; 1 for
// ordinary ones.
inline float direction_scale(float size) {
  if (size > 0x1p-10f && size < 0x1p10f) return 1.0f;
  return std::ldexp(1.0f, std::clamp(-std::ilogb(size), -126, 126));
}

inline float larger(float a, float b) {
  return a > b ? a : b;
}

inline constexpr Ray harmless_ray{{0.0f, 0.0f, 0.0f}, 1.0f, {0.0f, 0.0f, 1.0f}, -1.0f};
inline constexpr float absolute_margin = 1e-5f;  // like relative_margin, but as a share of the coordinates in the
                                                 // computation
inline constexpr float largest_t_near = 1e30f;   // Embree's arithmetic overflows beyond it; no vertex is that far

template <unsigned N>
class RayPacket {
 public:
  using Types = embree::Packet<N>;

  explicit RayPacket(uint32_t mask) {
    for (uint32_t i = 0; i < N; ++i) {
      RTCRayN_time(ray_n(), N, i) = 0.0f;
      RTCRayN_mask(ray_n(), N, i) = mask;
      RTCRayN_id(ray_n(), N, i) = i;
      RTCRayN_flags(ray_n(), N, i) = 0;
    }
  }

  // Takes up to N rays and prepares those whose bit is in `wanted`; returns the bits of the rays to trace. `widen`:
  // lets Embree report everything that may, within its rounding, lie between the rays' ends.
  uint32_t set(std::span<const Ray> rays, uint32_t wanted, const TopLevel& top, bool widen) {
    const auto ray = [&](uint32_t i) -> const Ray& { return i < rays.size() ? rays[i] : harmless_ray; };
    if constexpr (N % 4 == 0)
      for (uint32_t i = 0; i < N; i += 4) write_four(i, {&ray(i), &ray(i + 1), &ray(i + 2), &ray(i + 3)});
    else
      for (uint32_t i = 0; i < N; ++i) write(i, ray(i).origin, ray(i).direction, ray(i).t_near, ray(i).t_far);
    return finish([&](uint32_t i) { return rays[i]; }, wanted, top, widen);
  }

  // Does the same for up to N rays, starting with the one at `first`.
  uint32_t set(const RayColumns& rays, size_t first, const TopLevel& top, bool widen) {
    const auto count = static_cast<uint32_t>(std::min<size_t>(N, rays.count - first));
    RTCRayN* r = ray_n();
    float* const to[] = {&RTCRayN_org_x(r, N, 0), &RTCRayN_org_y(r, N, 0), &RTCRayN_org_z(r, N, 0),
                         &RTCRayN_tnear(r, N, 0), &RTCRayN_dir_x(r, N, 0), &RTCRayN_dir_y(r, N, 0),
                         &RTCRayN_dir_z(r, N, 0), &RTCRayN_tfar(r, N, 0)};
    const float* const from[] = {rays.origin[0],    rays.origin[1],    rays.origin[2],    rays.t_near,
                                 rays.direction[0], rays.direction[1], rays.direction[2], rays.t_far};
    for (int k = 0; k < 8; ++k) {
      if (count == N)
        std::copy_n(from[k] + first, N, to[k]);
      else
        std::copy_n(from[k] + first, count, to[k]);
    }
    for (uint32_t i = count; i < N; ++i)
      write(i, harmless_ray.origin, harmless_ray.direction, harmless_ray.t_near, harmless_ray.t_far);
    return finish([&](uint32_t i) { return rays[first + i]; }, (1u << count) - 1u, top, widen);
  }

  void intersect(RTCScene scene, embree::Query& query, bool coherent, RTCFilterFunctionN filter) {
    for (uint32_t i = 0; i < N; ++i) {
      RTCHitN_geomID(hit_n(), N, i) = RTC_INVALID_GEOMETRY_ID;
      RTCHitN_instID(hit_n(), N, i, 0) = RTC_INVALID_GEOMETRY_ID;
    }
    embree::IntersectArguments arguments(query, coherent, filter);
    Types::intersect(valid.data(), scene, arguments, &packet);
  }

  void occluded(RTCScene scene, embree::Query& query, bool coherent, RTCFilterFunctionN filter) {
    embree::OccludedArguments arguments(query, coherent, filter);
    Types::occluded(valid.data(), scene, arguments, &packet.ray);
  }

  float t_far(uint32_t lane) { return RTCRayN_tfar(ray_n(), N, lane); }

  // Copies the origins as set; directions and distances are ours times a power of two.
  void copy_rays(CandidateBlock& block) {
    static_assert(N <= CandidateBlock::size);
    for (int c = 0; c < 3; ++c) std::copy_n(origin_[c], N, block.origin[c]);
    std::copy_n(&RTCRayN_dir_x(ray_n(), N, 0), N, block.direction[0]);
    std::copy_n(&RTCRayN_dir_y(ray_n(), N, 0), N, block.direction[1]);
    std::copy_n(&RTCRayN_dir_z(ray_n(), N, 0), N, block.direction[2]);
  }

  // How the lanes were set:
  std::array<float, N> distance_of_unit;  // our distance for Embree's t = 1: a power of two
  std::array<float, N> margin;            // of Embree's t if widened: the part that does not grow with the distance
  std::array<float, N> back;              // if widened: how far before the origin Embree's ray starts, in its t
  std::array<float, N> begin;             // if widened: a hit with this t or less may lie before the ray's start
  std::array<float, N> end;               // if widened: a hit with this t or more may lie behind the ray's end

 private:
  RTCRayN* ray_n() { return reinterpret_cast<RTCRayN*>(&packet.ray); }
  RTCHitN* hit_n() { return reinterpret_cast<RTCHitN*>(&packet.hit); }

  // Finishes the lanes that were written; ray_of(lane) returns the original ray.
  template <typename RayOf>
  uint32_t finish(const RayOf& ray_of, uint32_t wanted, const TopLevel& top, bool widen) {
    alignas(64) std::array<int, N> plain;
    examine(top, widen, plain);
    uint32_t odd = 0;
    for (uint32_t i = 0; i < N; ++i) {
      odd |= static_cast<uint32_t>(plain[i] == 0) << i;
      valid[i] = -static_cast<int>(wanted >> i & 1u);
    }
    odd &= wanted;
    for (uint32_t bits = odd; bits != 0; bits &= bits - 1) {
      const auto i = static_cast<uint32_t>(std::countr_zero(bits));
      if (!set_odd(i, ray_of(i), top, widen)) wanted &= ~(1u << i);
    }
    constexpr uint32_t all = (1u << N) - 1u;
    for (uint32_t bits = ~wanted & all; bits != 0; bits &= bits - 1)
      clear(static_cast<uint32_t>(std::countr_zero(bits)));
    return wanted;
  }

  void write(uint32_t lane, glm::vec3 origin, glm::vec3 direction, float t_near, float t_far) {
    RTCRayN* r = ray_n();
    RTCRayN_org_x(r, N, lane) = origin.x;
    RTCRayN_org_y(r, N, lane) = origin.y;
    RTCRayN_org_z(r, N, lane) = origin.z;
    RTCRayN_tnear(r, N, lane) = t_near;
    RTCRayN_dir_x(r, N, lane) = direction.x;
    RTCRayN_dir_y(r, N, lane) = direction.y;
    RTCRayN_dir_z(r, N, lane) = direction.z;
    RTCRayN_tfar(r, N, lane) = t_far;
  }

  using Four = float __attribute__((vector_size(16)));

  // Transposes four numbers of each of four rays into rows that are N numbers apart.
  static void transpose(const std::array<const float*, 4>& from, const std::array<float*, 4>& to) {
    Four a, b, c, d;
    std::memcpy(&a, from[0], sizeof(Four));
    std::memcpy(&b, from[1], sizeof(Four));
    std::memcpy(&c, from[2], sizeof(Four));
    std::memcpy(&d, from[3], sizeof(Four));
    const Four ab0 = __builtin_shufflevector(a, b, 0, 4, 1, 5), ab1 = __builtin_shufflevector(a, b, 2, 6, 3, 7);
    const Four cd0 = __builtin_shufflevector(c, d, 0, 4, 1, 5), cd1 = __builtin_shufflevector(c, d, 2, 6, 3, 7);
    const Four rows[] = {
        __builtin_shufflevector(ab0, cd0, 0, 1, 4, 5), __builtin_shufflevector(ab0, cd0, 2, 3, 6, 7),
        __builtin_shufflevector(ab1, cd1, 0, 1, 4, 5), __builtin_shufflevector(ab1, cd1, 2, 3, 6, 7)};
    for (size_t k = 0; k < 4; ++k) std::memcpy(to[k], &rows[k], sizeof(Four));
  }

  // Writes lanes `lane` to `lane` + 3.
  void write_four(uint32_t lane, const std::array<const Ray*, 4>& rays) {
    static_assert(sizeof(Ray) == 8 * sizeof(float) && offsetof(Ray, direction) == 4 * sizeof(float));
    RTCRayN* r = ray_n();
    transpose({&rays[0]->origin.x, &rays[1]->origin.x, &rays[2]->origin.x, &rays[3]->origin.x},
              {&RTCRayN_org_x(r, N, lane), &RTCRayN_org_y(r, N, lane), &RTCRayN_org_z(r, N, lane),
               &RTCRayN_tnear(r, N, lane)});
    transpose({&rays[0]->direction.x, &rays[1]->direction.x, &rays[2]->direction.x, &rays[3]->direction.x},
              {&RTCRayN_dir_x(r, N, lane), &RTCRayN_dir_y(r, N, lane), &RTCRayN_dir_z(r, N, lane),
               &RTCRayN_tfar(r, N, lane)});
  }

  // Finds the valid rays of ordinary length and finishes them, without branches, as a vector loop.
  void examine(const TopLevel& top, bool widen, std::array<int, N>& plain) {
    float* const t_near = &RTCRayN_tnear(ray_n(), N, 0);
    float* const t_far = &RTCRayN_tfar(ray_n(), N, 0);
    float* const o = &RTCRayN_org_x(ray_n(), N, 0);
    const float* const d = &RTCRayN_dir_x(ray_n(), N, 0);
    const float limit = top.origin_limit, magnitude = top.magnitude;
    const float absolute = widen ? absolute_margin : 0.0f, relative = widen ? relative_margin : 0.0f;
    for (uint32_t i = 0; i < N; ++i) {
      const float ox = o[i], oy = o[N + i], oz = o[2 * N + i], dx = d[i], dy = d[N + i], dz = d[2 * N + i];
      const float near = t_near[i], far = t_far[i];
      const float reach = larger(larger(std::abs(ox), std::abs(oy)), std::abs(oz));
      const float size = larger(larger(std::abs(dx), std::abs(dy)), std::abs(dz));
      // The sum is NaN if any component is NaN or infinite.
      const float sum = (ox + oy + oz + dx + dy + dz) * 0.0f;
      plain[i] = static_cast<int>(sum == 0.0f) & static_cast<int>(reach <= limit) & static_cast<int>(size > 0x1p-10f) &
                 static_cast<int>(size < 0x1p10f) & static_cast<int>(near >= 0.0f) & static_cast<int>(near < far) &
                 static_cast<int>(near < largest_t_near);
      margin[i] = absolute * (reach + magnitude) / size;
      distance_of_unit[i] = 1.0f;
      const float open = margin[i] + relative * near;
      // Embree accepts no negative t_near, so the origin is moved back until a hit at the original origin can be
      // reported.
      const float b = larger(0.0f, open - near);
      back[i] = b;
      origin_[0][i] = ox, origin_[1][i] = oy, origin_[2][i] = oz;
      o[i] = ox - dx * b, o[N + i] = oy - dy * b, o[2 * N + i] = oz - dz * b;
      t_near[i] = near - open + b;
      begin[i] = near + open + b;
      // The end is made finite, because 0 times an infinite end is NaN.
      const float finite_far = far < std::numeric_limits<float>::max() ? far : std::numeric_limits<float>::max();
      end[i] = far - (margin[i] + relative * finite_far) + b;
      t_far[i] = far + (margin[i] + relative * finite_far) + b;
    }
  }

  // Sets a ray whose direction is very long or short. Returns false if the ray is invalid and must be left out.
  bool set_odd(uint32_t lane, const Ray& ray, const TopLevel& top, bool widen) {
    const float reach = largest_component(ray.origin), size = largest_component(ray.direction);
    const float sum = ray.origin.x + ray.origin.y + ray.origin.z + ray.direction.x + ray.direction.y + ray.direction.z;
    const bool traceable =
        std::isfinite(sum) && reach <= top.origin_limit && size > 0.0f && ray.t_near >= 0.0f && ray.t_near < ray.t_far;
    if (!traceable) return false;
    const float scale = direction_scale(size);
    float t_near = ray.t_near / scale, t_far = ray.t_far / scale;
    margin[lane] = absolute_margin * (reach + top.magnitude) / (size * scale);
    distance_of_unit[lane] = scale;
    back[lane] = 0.0f;
    if (widen) {
      const float open = margin[lane] + relative_margin * t_near;
      const float b = std::max(0.0f, open - t_near);
      back[lane] = b;
      begin[lane] = t_near + open + b;
      t_near = t_near - open + b;
      end[lane] = t_far - (margin[lane] + relative_margin * std::min(t_far, std::numeric_limits<float>::max())) + b;
      t_far += margin[lane] + relative_margin * t_far + b;
    }
    if (!(t_near < largest_t_near)) return false;
    const glm::vec3 direction = ray.direction * scale;
    for (int c = 0; c < 3; ++c) origin_[c][lane] = ray.origin[c];
    write(lane, ray.origin - direction * back[lane], direction, t_near, t_far);
    return true;
  }

  // Clears a lane, so that its ray hits nothing even if Embree ignores `valid`.
  void clear(uint32_t lane) {
    write(lane, harmless_ray.origin, harmless_ray.direction, harmless_ray.t_near, harmless_ray.t_far);
    valid[lane] = 0;
    distance_of_unit[lane] = 1.0f;
    margin[lane] = begin[lane] = end[lane] = back[lane] = 0.0f;
    for (int c = 0; c < 3; ++c) origin_[c][lane] = harmless_ray.origin[c];
  }

  alignas(64) typename Types::RayHit packet;
  alignas(64) std::array<int, N> valid;
  alignas(64) float origin_[3][N];  // of the rays as given
};

}  // namespace sideray::rt
