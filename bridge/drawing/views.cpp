#include "bridge/drawing/views.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "model/failure.h"

namespace sideray::bridge {

namespace {

// Throws Failure for a scaled or sheared camera: its matrices exceed the range of floats, or have no inverse, long
// before its own numbers exceed that of doubles.
void check_pose(const double* m) {
  constexpr double largest = 1e15, tolerance = 1e-3;
  for (int i = 0; i < 12; ++i)
    if (!std::isfinite(m[i])) fail(SIDERAY_INVALID_ARGUMENT, "camera: world_from_camera is not finite");
  for (int a = 0; a < 3; ++a)
    for (int b = a; b < 3; ++b) {
      const double dot = m[3 * a] * m[3 * b] + m[3 * a + 1] * m[3 * b + 1] + m[3 * a + 2] * m[3 * b + 2];
      if (!(std::abs(dot - (a == b ? 1.0 : 0.0)) <= tolerance))
        fail(SIDERAY_INVALID_ARGUMENT,
             "camera: world_from_camera is no rotation: the product of its columns {} and {} is {} instead of {}; make "
             "its first three columns unit vectors at right angles",
             a, b, dot, a == b ? 1 : 0);
    }
  for (int i = 9; i < 12; ++i)
    if (std::abs(m[i]) > largest)
      fail(SIDERAY_INVALID_ARGUMENT, "camera: its position holds {}; give at most 1e15", m[i]);
}

}  // namespace

void check_camera(const sideray_camera& c) {
  check_pose(c.world_from_camera);
  if (!(c.z_near > 0.0f) || !std::isfinite(c.z_near))
    fail(SIDERAY_INVALID_ARGUMENT, "camera z_near {}: give a finite distance above 0", c.z_near);
  if (!(c.z_far == 0.0f || c.z_far > c.z_near) || (c.orthographic && c.z_far == 0.0f))
    fail(SIDERAY_INVALID_ARGUMENT, "camera z_far {}: give more than z_near{}", c.z_far,
         c.orthographic ? "" : ", or 0 for infinite");
  if (!c.orthographic && !(c.yfov > 1e-4f && c.yfov < 3.13f))
    fail(SIDERAY_INVALID_ARGUMENT, "camera yfov {}: give radians between 0 and pi", c.yfov);
  if (c.orthographic && !(c.half_height > 0.0f && std::isfinite(c.half_height)))
    fail(SIDERAY_INVALID_ARGUMENT, "camera half_height {}: give a finite height above 0", c.half_height);
  if (!(c.fx_per_fy == 0.0f || (c.fx_per_fy >= 1e-3f && c.fx_per_fy <= 1e3f)))
    fail(SIDERAY_INVALID_ARGUMENT, "camera fx_per_fy {}: give 0.001 to 1000, or 0 for square pixels", c.fx_per_fy);
  if (!(std::abs(c.shift_x) <= 100.0f && std::abs(c.shift_y) <= 100.0f))
    fail(SIDERAY_INVALID_ARGUMENT, "camera shift ({}, {}): give -100 to 100 widths and heights of the picture", c.shift_x,
         c.shift_y);
}

// Returns point i + 1 of the Halton sequence in bases 2 and 3 (Halton 1964).
glm::vec2 sample_jitter(uint32_t i, uint32_t samples) {
  if (samples <= 1) return glm::vec2(0);
  const auto radical_inverse = [](uint32_t n, uint32_t base) {
    double result = 0;
    double digit = 1.0 / base;
    for (; n > 0; n /= base) {
      result += (n % base) * digit;
      digit /= base;
    }
    return result;
  };
  return {static_cast<float>(radical_inverse(i + 1, 2) - 0.5), static_cast<float>(radical_inverse(i + 1, 3) - 0.5)};
}

sideray_view world_view(const gl::RasterView& view, glm::dvec3 origin) {
  sideray_view result{};
  const glm::dmat4 clip_from_world = glm::translate(view.clip_from_local, -origin);
  const glm::dmat4 world_from_clip = glm::translate(glm::dmat4(1.0), origin) * view.local_from_clip;
  std::copy_n(glm::value_ptr(clip_from_world), 16, result.clip_from_world);
  std::copy_n(glm::value_ptr(world_from_clip), 16, result.world_from_clip);
  result.reversed_depth = view.reversed_depth;
  result.zero_to_one_depth = view.zero_to_one_depth;
  return result;
}

}  // namespace sideray::bridge
