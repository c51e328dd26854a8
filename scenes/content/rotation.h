// Rotates with the same bits on every processor. glm::rotate and glm::slerp do not: they call libm. Any thread.
#pragma once

#include <cmath>
#include <glm/glm.hpp>

#include "elementary/functions.h"

namespace sideray::scenes {

// Returns `m` times the rotation by the angle, in radians, counter-clockwise about the axis, which has any length but
// 0.
template <typename T>
glm::mat<4, 4, T> rotated(const glm::mat<4, 4, T>& m, T angle, const glm::vec<3, T>& about) {
  const T c = elementary::cos(angle), s = elementary::sin(angle);
  const glm::vec<3, T> axis = glm::normalize(about), part = axis * (T(1) - c);
  const auto column = [&](int i, T x, T y, T z) {
    return m[0] * (part[i] * axis.x + x) + m[1] * (part[i] * axis.y + y) + m[2] * (part[i] * axis.z + z);
  };
  return {column(0, c, s * axis.z, -s * axis.y), column(1, -s * axis.z, c, s * axis.x),
          column(2, s * axis.y, -s * axis.x, c), m[3]};
}

// Returns the unit quaternion (x, y, z, w) at the share t of the shorter way between two unit quaternions (glTF 2.0,
// appendix C.4).
inline glm::dvec4 slerp(const glm::dvec4& from, const glm::dvec4& to, double t) {
  const double cosine = glm::dot(from, to);
  const glm::dvec4 end = cosine < 0.0 ? -to : to;
  // Between nearly equal quaternions the arc equals its chord, and its sine is too small a divisor.
  if (std::abs(cosine) > 1.0 - 0x1p-50) return from * (1.0 - t) + end * t;
  const double angle = elementary::acos(std::abs(cosine));
  return (from * elementary::sin((1.0 - t) * angle) + end * elementary::sin(t * angle)) * (1.0 / elementary::sin(angle));
}

}  // namespace sideray::scenes
