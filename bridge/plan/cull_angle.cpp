#include "bridge/plan/cull_angle.h"

#include <algorithm>

#include "elementary/functions.h"

namespace sideray::bridge {

// An instance covers as much of the picture as its angle is of the view's: at 30 degrees the option's default, 1
// degree, is 1/30 of the height. A view of 1 degree that went by the same angle would lose everything.
float cull_angle_deg(const sideray_camera& camera, float option_deg) {
  if (camera.orthographic) return 0.0f;  // nothing looks smaller for being far
  constexpr double tan_15_degrees = 0.26794919243112270647;
  const double wider_x = std::max(1.0, double{camera.fx_per_fy});
  const double half_angle_tangent = elementary::tan(0.5 * double{camera.yfov}) / wider_x;
  return static_cast<float>(double{option_deg} * std::min(1.0, half_angle_tangent / tan_15_degrees));
}

}  // namespace sideray::bridge
