#include "bridge/base/local_view.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "model/failure.h"

namespace sideray::bridge {
namespace {

// Returns the direction in which clip w, the depth of the perspective division, grows.
glm::dvec3 depth_axis(const rt::TraceView& view) {
  const glm::dmat4& m = view.clip_from_local;
  return glm::normalize(glm::dvec3(m[0].w, m[1].w, m[2].w));
}

// Returns the matrix from (x, y, 1) of a pixel to `a` x + `b` y + `c`, where x and y run -1..1 over the picture.
glm::mat3 from_pixel(glm::dvec3 a, glm::dvec3 b, glm::dvec3 c, uint32_t width, uint32_t height) {
  const glm::dvec3 x = a * (2.0 / width), y = b * (2.0 / height);
  return {glm::vec3(x), glm::vec3(y), glm::vec3(c - a - b + 0.5 * (x + y))};
}

}  // namespace

void check_view(const sideray_view& view) {
  for (int i = 0; i < 16; ++i)
    if (!std::isfinite(view.clip_from_world[i]) || !std::isfinite(view.world_from_clip[i]))
      fail(SIDERAY_INVALID_ARGUMENT, "view: matrix entry {} is not finite; give the camera's matrices", i);
  const glm::dmat4 product = glm::make_mat4(view.clip_from_world) * glm::make_mat4(view.world_from_clip);
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 4; ++r)
      if (std::abs(product[c][r] - (c == r ? 1.0 : 0.0)) > 1e-3)
        fail(SIDERAY_INVALID_ARGUMENT,
             "view: world_from_clip is not the inverse of clip_from_world (entry {},{} of the "
             "product is {}); invert in double precision",
             r, c, product[c][r]);
}

sideray_view view_of_matrices(const double* projection, const double* modelview) {
  for (int i = 0; i < 16; ++i)
    if (!std::isfinite(projection[i]) || !std::isfinite(modelview[i]))
      fail(SIDERAY_INVALID_ARGUMENT, "view: matrix entry {} is not finite; give the camera's matrices", i);
  if (modelview[3] != 0.0 || modelview[7] != 0.0 || modelview[11] != 0.0 || modelview[15] == 0.0)
    fail(SIDERAY_INVALID_ARGUMENT, "view modelview: its last row is not 0, 0, 0, 1, so that it is transposed, or not the "
                                   "matrix of a camera; entries 12 to 14 hold what it moves by");
  const bool perspective = std::abs(projection[11]) == 1.0 && projection[15] == 0.0;
  const bool parallel = projection[11] == 0.0 && projection[15] != 0.0;
  if (projection[3] != 0.0 || projection[7] != 0.0 || !(perspective || parallel))
    fail(SIDERAY_INVALID_ARGUMENT, "view projection: its last row says neither a perspective nor a parallel view, so that it "
                                   "is transposed, or already multiplied by another; a perspective has -1 or 1 in entry 11");
  const glm::dmat4 clip_from_world = glm::make_mat4(projection) * glm::make_mat4(modelview);
  const glm::dmat4 inverse = glm::inverse(clip_from_world);
  sideray_view view{};
  std::copy_n(glm::value_ptr(clip_from_world), 16, view.clip_from_world);
  std::copy_n(glm::value_ptr(inverse), 16, view.world_from_clip);
  check_view(view);
  return view;
}

rt::TraceView local_view(const sideray_view& view, glm::dvec3 origin) {
  return {.clip_from_local = glm::translate(glm::make_mat4(view.clip_from_world), origin),
          .local_from_clip = glm::translate(glm::dmat4(1.0), -origin) * glm::make_mat4(view.world_from_clip),
          .reversed_depth = view.reversed_depth != 0,
          .zero_to_one_depth = view.zero_to_one_depth != 0};
}

SnippetView snippet_view(const sideray_view& view, uint32_t width, uint32_t height, glm::dvec3 origin) {
  const rt::TraceView local = local_view(view, origin);
  const glm::dmat4& m = local.local_from_clip;
  const double near_z = view.reversed_depth ? 1.0 : (view.zero_to_one_depth ? 0.0 : -1.0);
  const double far_z = view.reversed_depth ? (view.zero_to_one_depth ? 0.0 : -1.0) : 1.0;
  // Every view ray passes the eye, where clip x = y = w = 0: the third column of the inverse.
  const glm::dvec4 column = m[2];
  if (std::abs(column.w) > 1e-12 * glm::length(glm::dvec3(column))) {
    const glm::dvec3 eye = glm::dvec3(column) / column.w;
    const double sign = column.w * near_z + m[3].w < 0.0 ? -1.0 : 1.0;
    const auto ray = [&](int i) { return sign * (glm::dvec3(m[i]) - eye * m[i].w); };
    return {glm::vec4(glm::vec3(eye), 1.0f), glm::vec4(glm::vec3(depth_axis(local)), 0.0f),
            from_pixel(ray(0), ray(1), ray(3), width, height), glm::mat4(local.clip_from_local)};
  }
  const glm::dvec4 near_point = m * glm::dvec4(0, 0, near_z, 1);
  const glm::dvec4 far_point = m * glm::dvec4(0, 0, far_z, 1);
  const glm::dvec3 start = glm::dvec3(near_point) / near_point.w;
  const glm::dvec3 direction = glm::normalize(glm::dvec3(far_point) / far_point.w - start);
  return {glm::vec4(glm::vec3(direction), 0.0f),
          glm::vec4(glm::vec3(direction), static_cast<float>(-glm::dot(direction, start))),
          from_pixel(glm::dvec3(m[0]) / near_point.w, glm::dvec3(m[1]) / near_point.w, start, width, height),
          glm::mat4(local.clip_from_local)};
}

}  // namespace sideray::bridge
