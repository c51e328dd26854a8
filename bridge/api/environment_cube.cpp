#include "bridge/api/environment_cube.h"

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "elementary/functions.h"
#include "model/failure.h"

namespace sideray::bridge {
namespace {

constexpr uint32_t largest_side = 4096, largest_width = 8192;
constexpr uint32_t samples = 3;  // along each side of a texel of the lat-long picture

struct FacePoint {
  int face;
  double s, t;  // 0..1
};

// Returns which face a direction hits, and where: table 8.19 of the OpenGL 4.5 specification.
FacePoint face_point(const glm::dvec3& d) {
  const glm::dvec3 a = glm::abs(d);
  const int axis = a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
  const bool negative = d[axis] < 0.0;
  double s = 0, t = 0;
  if (axis == 0) s = negative ? d.z : -d.z, t = -d.y;
  if (axis == 1) s = d.x, t = negative ? -d.z : d.z;
  if (axis == 2) s = negative ? -d.x : d.x, t = -d.y;
  return {2 * axis + negative, 0.5 * (s / a[axis] + 1.0), 0.5 * (t / a[axis] + 1.0)};
}

// Returns the direction of a point of a face, the inverse of face_point(); the point may lie beyond the face's edges.
glm::dvec3 direction_of(int face, double s, double t) {
  const double u = 2.0 * s - 1.0, v = 2.0 * t - 1.0;
  switch (face) {
    case 0: return {1, -v, -u};
    case 1: return {-1, -v, u};
    case 2: return {u, 1, v};
    case 3: return {u, -1, -v};
    case 4: return {u, -v, 1};
    default: return {-u, -v, -1};
  }
}

class Cube {
 public:
  Cube(uint32_t side, const float* const faces[6]) : side_(static_cast<int>(side)), faces_(faces) {}

  // Filters bilinearly across edges: beyond an edge come the texels of the neighbouring face.
  glm::dvec3 sample(const glm::dvec3& d) const {
    const FacePoint p = face_point(d);
    const double x = p.s * side_ - 0.5, y = p.t * side_ - 0.5, i = std::floor(x), j = std::floor(y);
    const auto row = [&](int below) {
      const int column = static_cast<int>(i), line = static_cast<int>(j) + below;
      return glm::mix(texel(p.face, column, line), texel(p.face, column + 1, line), x - i);
    };
    return glm::mix(row(0), row(1), y - j);
  }

 private:
  glm::dvec3 texel(int face, int x, int y) const {
    if (std::min(x, y) >= 0 && std::max(x, y) < side_) return stored(face, x, y);
    const FacePoint beside = face_point(direction_of(face, (x + 0.5) / side_, (y + 0.5) / side_));
    const auto at = [&](double s) { return std::clamp(static_cast<int>(s * side_), 0, side_ - 1); };
    return stored(beside.face, at(beside.s), at(beside.t));
  }
  // Returns a texel; one that is not finite is black, as in every environment.
  glm::dvec3 stored(int face, int x, int y) const {
    const float* rgb = faces_[face] + 3 * (static_cast<size_t>(y) * static_cast<size_t>(side_) + static_cast<size_t>(x));
    glm::dvec3 value(0);
    for (int c = 0; c < 3; ++c) value[c] = std::isfinite(rgb[c]) ? static_cast<double>(rgb[c]) : 0.0;
    return value;
  }

  int side_;
  const float* const* faces_;
};

glm::dmat3 checked_rotation(const float* cube_from_world) {
  if (!cube_from_world) return glm::dmat3(1.0);
  const glm::dmat3 m(glm::make_mat3(cube_from_world));
  const glm::dmat3 off = glm::transpose(m) * m - glm::dmat3(1.0);
  for (int c = 0; c < 3; ++c)
    if (!(glm::length(off[c]) < 1e-3))
      fail(SIDERAY_INVALID_ARGUMENT, "environment cube_from_world: its columns are not orthonormal; give a rotation");
  return m;
}

void check_faces(uint32_t side, const float* const faces[6]) {
  if (side < 1 || side > largest_side)
    fail(SIDERAY_INVALID_ARGUMENT, "environment cube of {0}x{0} pixels; give 1 to {1} a side", side, largest_side);
  for (int i = 0; i < 6; ++i)
    if (!faces[i])
      fail(SIDERAY_INVALID_ARGUMENT, "environment cube: face {} is NULL; give +X, -X, +Y, -Y, +Z and -Z", i);
}

glm::dvec3 world_direction(double u, double v) {
  const double azimuth = (u - 0.5) * glm::two_pi<double>(), polar = v * glm::pi<double>();
  return {elementary::sin(polar) * elementary::sin(azimuth), elementary::cos(polar), -elementary::sin(polar) * elementary::cos(azimuth)};
}

}  // namespace

LatLong lat_long_of_cube(uint32_t side, const float* const faces[6], const float* cube_from_world) {
  check_faces(side, faces);
  const glm::dmat3 turned = checked_rotation(cube_from_world);
  const Cube cube(side, faces);
  const uint32_t width = std::clamp(4 * side, 4u, largest_width), height = width / 2;
  LatLong picture{width, height, std::vector<float>(size_t{3} * width * height)};
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      glm::dvec3 sum(0);
      for (uint32_t k = 0; k < samples * samples; ++k) {
        const double u = (x + (k % samples + 0.5) / samples) / width, v = (y + (k / samples + 0.5) / samples) / height;
        sum += cube.sample(turned * world_direction(u, v));
      }
      for (int c = 0; c < 3; ++c)
        picture.rgb[3 * (size_t{y} * width + x) + static_cast<size_t>(c)] =
            static_cast<float>(sum[c] / double{samples * samples});
    }
  return picture;
}

}  // namespace sideray::bridge
