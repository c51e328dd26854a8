// Describes rays, and where they hit a snapshot. Plain values; any thread may use them.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>

namespace sideray::rt {

// A ray is finite, its direction has any length > 0, and 0 <= t_near. Hits lie in t_near <= t <= t_far; t_far may be
// infinite. A ray with t_far <= t_near hits nothing. Rays are validated here: an invalid one, or one that starts more
// than 1e18 units away in some object's space, never reaches Embree (Debian's build aborts on it) and hits nothing.
struct Ray {
  glm::vec3 origin;
  float t_near;
  glm::vec3 direction;
  float t_far;
};

// The length of a ray that ends nowhere: beyond it Embree's arithmetic overflows, and no vertex is that far.
inline constexpr float farthest = 1e30f;

// Refers to rays that are stored as one array per component.
struct RayColumns {
  const float *origin[3], *direction[3], *t_near, *t_far;
  size_t count;

  Ray operator[](size_t i) const {
    return {{origin[0][i], origin[1][i], origin[2][i]},
            t_near[i],
            {direction[0][i], direction[1][i], direction[2][i]},
            t_far[i]};
  }
};

// A hit is recomputed in double precision without fused contraction, so it does not depend on packet width or on
// Embree's rounding. `distance` is in lengths of the direction.
struct Hit {
  double distance;
  float u, v;                    // weights of the triangle's second and third vertex
  uint32_t instance, primitive;  // indices into the snapshot / its mesh's triangles
  bool front;                    // whether the geometric front face (mirroring regarded) was hit
};
inline constexpr uint32_t no_instance = 0xffffffffu;

// A pixel's footprint at distance t along its ray is width + spread * t wide; ray-cone texture lookup needs it.
struct Cone {
  float width = 0, spread = 0;
};

// Holds the steps from a pixel of a view to the next ones, in widths of the pixel's cone. A rasterizer measures
// footprints along them, which for oblique surfaces are up to half a mip level smaller than along the cone's diameters.
struct PixelSteps {
  glm::vec3 right, up;
};

// Holds the footprint by which many rays read alpha: a common cone. In a view it is that of one unit of depth along the
// unit `axis`, and textures are read by the pixel's steps; elsewhere `axis` is 0.
struct AlphaCone {
  AlphaCone() = default;
  AlphaCone(Cone common) : cone(common) {}
  AlphaCone(Cone at_depth, glm::vec3 view_axis, const PixelSteps& pixel) : cone(at_depth), axis(view_axis), steps(pixel) {}

  bool in_view() const { return axis != glm::vec3(0.0f); }
  float width_at(const Ray& ray, double distance) const {
    const float along = in_view() ? std::abs(glm::dot(ray.direction, axis)) : 1.0f;
    return cone.width + cone.spread * along * static_cast<float>(distance);
  }

  Cone cone;
  glm::vec3 axis{0.0f};
  PixelSteps steps{};
};

}  // namespace sideray::rt
