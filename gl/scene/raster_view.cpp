#include "gl/scene/raster_view.h"

#include <algorithm>
#include <cmath>

#include "elementary/functions.h"
#include "model/failure.h"

namespace sideray::gl {
namespace {

void check(const sideray_camera& c) {
  for (const double m : c.world_from_camera)
    if (!std::isfinite(m)) fail(SIDERAY_INVALID_ARGUMENT, "camera: its transform is not finite");
  if (!(c.z_near > 0.0f) || !std::isfinite(c.z_near))
    fail(SIDERAY_INVALID_ARGUMENT, "camera z_near {}: give a number above 0", c.z_near);
  const bool infinite = c.z_far == 0.0f && !c.orthographic;
  if (!infinite && !(c.z_far > c.z_near && std::isfinite(c.z_far)))
    fail(SIDERAY_INVALID_ARGUMENT, "camera z_far {}: give a number above z_near {}{}", c.z_far, c.z_near,
         c.orthographic ? "" : ", or 0 for none");
  if (c.orthographic ? !(c.half_height > 0.0f && std::isfinite(c.half_height)) : !(c.yfov > 0.0f && c.yfov < 3.1415f))
    fail(SIDERAY_INVALID_ARGUMENT, "camera {}: give {}", c.orthographic ? "half_height" : "yfov",
         c.orthographic ? "a number above 0" : "an angle above 0 and below pi");
}

// Returns p such that clip z = p.x * view z + p.y.
glm::dvec2 depth_row(const sideray_camera& c, bool reversed) {
  const double n = double{c.z_near}, f = double{c.z_far};
  if (c.orthographic) return reversed ? glm::dvec2(1, f) / (f - n) : glm::dvec2(-2, -(f + n)) / (f - n);
  if (c.z_far == 0.0f) return reversed ? glm::dvec2(0, n) : glm::dvec2(-1, -2 * n);
  return reversed ? glm::dvec2(n, n * f) / (f - n) : glm::dvec2(-(f + n), -2 * f * n) / (f - n);
}

}  // namespace

RasterView make_raster_view(const sideray_camera& camera, glm::vec2 jitter, const ViewTarget& target) {
  check(camera);
  RasterView view;
  view.reversed_depth = view.zero_to_one_depth = target.clip_control;
  view.orthographic = camera.orthographic != 0;
  view.z_near = camera.z_near;
  view.z_far = camera.z_far;
  view.half_height = camera.half_height;
  view.yfov = camera.yfov;
  view.fx_per_fy = camera.fx_per_fy > 0.0f ? camera.fx_per_fy : 1.0f;

  const double* m = camera.world_from_camera;
  const glm::dmat3 turn(m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8]);
  const glm::dvec3 position = glm::dvec3(m[9], m[10], m[11]) - target.origin;
  glm::dmat4 local_from_view(turn);
  local_from_view[3] = glm::dvec4(position, 1.0);
  const glm::dmat3 turn_back = glm::inverse(turn);
  view.view_from_local = glm::dmat4(turn_back);
  view.view_from_local[3] = glm::dvec4(-(turn_back * position), 1.0);
  view.eye = glm::vec3(position);
  view.forward = glm::vec3(-glm::normalize(turn[2]));

  const double aspect = double(target.width) / double(target.height);
  const double scale = 1.0 / (view.orthographic ? double{camera.half_height} : elementary::tan(0.5 * double{camera.yfov}));
  // Moves the content against the jitter, so that the pixel centre samples the point `jitter` away from it.
  const glm::dvec2 shift(-2.0 * double{jitter.x} / target.width, -2.0 * double{jitter.y} / target.height);
  view.jitter = shift;
  // The principal point, -1..1 with y up.
  const glm::dvec2 principal = shift + glm::dvec2(2.0 * double{camera.shift_x}, -2.0 * double{camera.shift_y});
  const glm::dvec2 depth = depth_row(camera, view.reversed_depth);
  glm::dmat4 clip_from_view(0.0);
  clip_from_view[0][0] = scale * double{view.fx_per_fy} / aspect;
  clip_from_view[1][1] = scale;
  clip_from_view[2][2] = depth.x;
  clip_from_view[3][2] = depth.y;
  if (view.orthographic) {
    clip_from_view[3][0] = principal.x;
    clip_from_view[3][1] = principal.y;
    clip_from_view[3][3] = 1.0;
  } else {
    clip_from_view[2][0] = -principal.x;
    clip_from_view[2][1] = -principal.y;
    clip_from_view[2][3] = -1.0;
  }
  view.clip_from_local = clip_from_view * view.view_from_local;
  view.local_from_clip = local_from_view * glm::inverse(clip_from_view);
  return view;
}

ViewRays make_view_rays(const RasterView& view) {
  const glm::dmat4 local_from_view = glm::inverse(view.view_from_local);
  const glm::dmat4 p = view.clip_from_local * local_from_view;
  const glm::dmat3 turn(local_from_view);
  const glm::dvec3 position(local_from_view[3]);
  const double ndc_scale = view.zero_to_one_depth ? 1.0 : 2.0, ndc_offset = view.zero_to_one_depth ? 0.0 : -1.0;
  ViewRays rays{};
  const glm::dvec3 x = turn[0] / p[0][0], y = turn[1] / p[1][1];
  if (view.orthographic) {
    rays.origin = glm::vec3(position - x * p[3][0] - y * p[3][1]);
    rays.origin_x = glm::vec3(x);
    rays.origin_y = glm::vec3(y);
    rays.ray = glm::vec3(-turn[2]);
    rays.along_from_depth = glm::vec2(-ndc_scale / p[2][2], (p[3][2] - ndc_offset) / p[2][2]);
  } else {
    rays.origin = glm::vec3(position);
    rays.ray = glm::vec3(-turn[2] + x * p[2][0] + y * p[2][1]);
    rays.ray_x = glm::vec3(x);
    rays.ray_y = glm::vec3(y);
    rays.along_from_depth = glm::vec2(ndc_scale / p[3][2], (ndc_offset + p[2][2]) / p[3][2]);
  }
  return rays;
}

bool is_too_small(const RasterView& view, uint32_t height, const model::Bounds& bounds) {
  constexpr float least_pixels = 0.5f;
  // A sphere covers more pixels along rows than along columns where fx is above fy; the larger count decides.
  const float diameter = 2.0f * bounds.radius(), pixels = static_cast<float>(height) * std::max(1.0f, view.fx_per_fy);
  if (view.orthographic) return diameter * pixels < least_pixels * 2.0f * view.half_height;
  const glm::vec3 offset = bounds.center() - view.eye;
  const float nearest = glm::dot(offset, view.forward) - bounds.radius();
  if (!(nearest > 0.0f)) return false;
  // Away from the picture's centre, perspective stretches a sphere by the distance over the depth.
  const float longest = diameter * glm::length(offset) * pixels;
  return longest < least_pixels * 2.0f * elementary::tan(0.5f * view.yfov) * nearest * nearest;
}

bool is_outside(const glm::mat4& clip_from_local, const model::Bounds& bounds) {
  if (bounds.empty()) return true;
  // Counts a corner as outside only beyond what rounding can change.
  constexpr float margin = 1e-4f;
  const glm::vec3 farthest = glm::max(glm::abs(bounds.minimum), glm::abs(bounds.maximum));
  const float rounding = 1e-5f * (farthest.x + farthest.y + farthest.z);
  int left = 0, right = 0, below = 0, above = 0, behind = 0;
  for (int corner = 0; corner < 8; ++corner) {
    const glm::vec4 p = clip_from_local * glm::vec4((corner & 1) ? bounds.maximum.x : bounds.minimum.x,
                                                    (corner & 2) ? bounds.maximum.y : bounds.minimum.y,
                                                    (corner & 4) ? bounds.maximum.z : bounds.minimum.z, 1.0f);
    const float slack = margin * (std::abs(p.x) + std::abs(p.y) + std::abs(p.w)) + rounding;
    left += p.x < -p.w - slack;
    right += p.x > p.w + slack;
    below += p.y < -p.w - slack;
    above += p.y > p.w + slack;
    behind += p.w < -slack;
  }
  return left == 8 || right == 8 || below == 8 || above == 8 || behind == 8;
}

}  // namespace sideray::gl
