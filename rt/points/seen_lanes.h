// Turns depth values into distances, a part of rt/points/point_lanes.cpp. Operations have the same order as in
// rt/base/view_rays.cpp.
#pragma once

#include "rt/points/double_lanes.h"
#include "rt/points/point_kernels.h"

namespace sideray::rt::SIDERAY_LANES {

constexpr double nothing = __builtin_inf();
constexpr double farthest_point = 1e30;

SIDERAY_LANE Doubles3 every(const double (&v)[3]) {
  return {every(v[0]), every(v[1]), every(v[2])};
}
SIDERAY_LANE Doubles3 load_doubles(const double (&planes)[3][seen_rows * seen_stride], int at) {
  return {load_doubles(planes[0] + at), load_doubles(planes[1] + at), load_doubles(planes[2] + at)};
}
SIDERAY_LANE Doubles3 load_widened(const float (&planes)[3][seen_rows * seen_stride], int at) {
  NarrowVector v[3];
  for (int i = 0; i < 3; ++i) __builtin_memcpy(&v[i], planes[i] + at, sizeof(v[i]));
  return {widened(v[0]), widened(v[1]), widened(v[2])};
}

// Returns the distance along the rays for a window depth.
SIDERAY_LANE DoubleVector distance_at(const PointView& view, DoubleVector depth, DoubleVector pixel_w,
                                      DoubleVector length) {
  const DoubleVector z = view.zero_to_one ? depth : 2.0 * depth - 1.0;
  const DoubleVector w = view.sign * (pixel_w + view.w_z * z + view.w_one);
  return w * farthest_point > length ? length / w : every(nothing);
}

// Returns twice the largest difference between the stored depth and the one that the rasterizer computed.
SIDERAY_LANE DoubleVector depth_step(const PointView& view, DoubleVector depth) {
  if (view.step > 0.0) return every(view.step);
  using Bits = int32_t __attribute__((vector_size(sizeof(NarrowVector))));
  const NarrowVector stored = narrowed(depth), zero{};
  const NarrowVector f = zero < stored ? stored : zero;
  const NarrowVector next = __builtin_bit_cast(NarrowVector, __builtin_bit_cast(Bits, f) + 1);
  const DoubleVector ulp = widened(next) - widened(f);
  return view.zero_to_one ? ulp : greater(ulp, every(0x1p-24));
}

void see_row(const PointView& view, const double* depth, double x, double y, int row, SeenPixels& seen) {
  const bool inner = row >= seen_border && row < seen_border + point_tile_size;
  const double ndc_y = (y + 0.5) * view.pixel_y - 1.0;
  const Doubles3 from_y{every(ndc_y * view.along_y[0]), every(ndc_y * view.along_y[1]), every(ndc_y * view.along_y[2])};
  const Doubles3 center = every(view.center), along_x = every(view.along_x);
  const Doubles3 eye{every(static_cast<double>(view.eye[0])), every(static_cast<double>(view.eye[1])),
                     every(static_cast<double>(view.eye[2]))};
  for (int i = 0; i < seen_stride; i += double_count) {
    const int at = row * seen_stride + i;
    DoubleVector column;
    for (int k = 0; k < double_count; ++k) column[k] = static_cast<double>(i + k);
    const DoubleVector ndc_x = (x + column + 0.5) * view.pixel_x - 1.0;
    const Doubles3 ray = center + along_x * ndc_x + from_y;
    const DoubleVector length = root(dot(ray, ray)), pixel_w = view.w_x * ndc_x + view.w_y * ndc_y;
    const Doubles3 unit = ray * (1.0 / length);
    const NarrowVector direction[3] = {narrowed(unit.x), narrowed(unit.y), narrowed(unit.z)};
    for (int k = 0; k < 3; ++k) __builtin_memcpy(seen.direction[k] + at, &direction[k], sizeof(NarrowVector));
    const DoubleVector stored = load_doubles(depth + i);
    const DoubleVector distance = stored < 0.0 ? every(nothing) : distance_at(view, stored, pixel_w, length);
    const Doubles3 drawn =
        eye + Doubles3{widened(direction[0]), widened(direction[1]), widened(direction[2])} * distance;
    store_doubles(seen.distance + at, distance);
    store_doubles(seen.inverse + at, 1.0 / distance);
    store_doubles(seen.w + at, length / distance);
    store_doubles(seen.drawn[0] + at, drawn.x);
    store_doubles(seen.drawn[1] + at, drawn.y);
    store_doubles(seen.drawn[2] + at, drawn.z);
    if (!inner) continue;
    const DoubleVector off = view.half_steps * (0.5 * depth_step(view, stored));
    const DoubleVector nearer = stored + (view.reversed ? off : -off);
    const DoubleVector inside = lesser(greater(nearer, every(0.0)), every(1.0));
    const DoubleVector end = distance_at(view, inside, pixel_w, length) - 0x1p-21 * distance;
    const DoubleVector finite = lesser(greater(end, every(0.0)), every(farthest_point));
    store_doubles(seen.off + at, distance - widened(narrowed(finite)));
  }
}

}  // namespace sideray::rt::SIDERAY_LANES
