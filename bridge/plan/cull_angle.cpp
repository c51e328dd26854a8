#include "bridge/plan/cull_angle.h"

#include <algorithm>

#include "elementary/functions.h"

namespace sideray::bridge {

// Scales the angle with the view, so that a culled instance covers the same share of the picture: at 30 degrees the
// default of 1 degree is 1/30 of the height. A view of 1 degree with the same angle would lose everything.
float cull_angle_deg(const sideray_camera& camera, float option_deg) {
  if (camera.orthographic) return 0.0f;  // in orthographic views distance does not change sizes
  constexpr double tan_15_degrees = 0.26794919243112270647;
  const double wider_x = std::max(1.0, double{camera.fx_per_fy});
  const double half_angle_tangent = elementary::tan(0.5 * double{camera.yfov}) / wider_x;
  return static_cast<float>(double{option_deg} * std::min(1.0, half_angle_tangent / tan_15_degrees));
}

}  // namespace sideray::bridge
