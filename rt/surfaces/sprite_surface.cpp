#include "rt/surfaces/sprite_surface.h"

#include <algorithm>
#include <cmath>

#include "model/particles.h"
#include "rt/textures/sprite_texel.h"

namespace sideray::rt {

SurfacePoint sprite_point(const model::Snapshot& snapshot, const Hit& hit, const Ray& ray, Cone cone) {
  const QuadPlace place = quad_place(snapshot, hit);
  const glm::vec3* corners = &place.mesh.positions[place.vertex];
  const glm::vec3 toward_viewer = glm::normalize(glm::cross(corners[1] - corners[0], corners[3] - corners[0]));
  const float along_axis = std::abs(glm::dot(ray.direction, toward_viewer));
  const float gap = (ray.t_far - static_cast<float>(hit.distance)) * along_axis;
  const glm::vec3 center = place.sprite.position;
  SurfacePoint point{};
  point.hit = hit;
  point.blend = static_cast<int>(place.desc.blend_mode);
  point.to_eye = point.geometric_normal = place.mesh.normals[place.vertex];
  point.surface = shading::sr_sprite(place.color, point.to_eye, place.desc.lit != 0,
                                     shading::sr_soft_fade(gap, place.desc.soft_distance), point.blend);
  if (snapshot.fixed) {  // fixed function: no additive texture, one side is lit
    point.surface.coat_normal = glm::vec3(0.0f);
    point.surface.metallic = 1.0f;
  }
  point.blended = shading::sr_blend(point.surface, point.to_eye, point.blend);
  // The whole sprite is lit as its centre is.
  point.position = center;
  point.offset = 0x1p-20f * std::max({std::abs(center.x), std::abs(center.y), std::abs(center.z)});
  point.cone = {cone.width + cone.spread * static_cast<float>(hit.distance), cone.spread};
  return point;
}

}  // namespace sideray::rt
