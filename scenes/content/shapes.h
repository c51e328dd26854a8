// Makes meshes of simple shapes for the built-in scenes. Front faces are counter-clockwise, normals unit. Any thread.
#pragma once

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <string>
#include <utility>
#include <vector>

#include "scenes/content/content.h"

namespace sideray::scenes {

// Appends shapes to one mesh with positions, normals and one uv set.
class Shape {
 public:
  // Adds a quad; a, b, c, d are counter-clockwise seen from the front; uv 0..uv_scale starts at a, and the image's top
  // left is at d.
  Shape& quad(glm::vec3 a, glm::vec3 b, glm::vec3 c, glm::vec3 d, glm::vec2 uv_scale = glm::vec2(1));
  Shape& box(glm::vec3 low, glm::vec3 high, float uv_per_unit = 1.0f);
  // Adds a solid of revolution about +Y through `axis`. Going up along the profile (radius, height), its left side is
  // outside. Edges that turn by less than `crease_deg` are smoothed. It is closed if the profile starts and ends at
  // radius 0.
  Shape& lathe(glm::vec3 axis, const std::vector<glm::vec2>& profile, uint32_t segments, float crease_deg = 40.0f);
  Shape& sphere(glm::vec3 center, float radius, uint32_t segments);
  Shape& cylinder(glm::vec3 base, float radius, float height, uint32_t segments);
  // Adds a closed box whose edges are cut at 45 degrees, so that they catch light. The image's u runs along the box's
  // longest side, as wood grain does.
  Shape& bevelled_box(glm::vec3 low, glm::vec3 high, float bevel, float uv_per_unit = 1.0f);
  // Adds a closed round bar along a smooth curve through `points`; its ends are flat.
  Shape& tube(const std::vector<glm::vec3>& points, float radius, uint32_t sides, uint32_t steps_per_point = 5);
  // Adds surface(u, v) for u and v in 0..1, in columns by rows of quads; the front is where d/du x d/dv points.
  Shape& sheet(uint32_t columns, uint32_t rows, const std::function<glm::vec3(float u, float v)>& surface,
               glm::vec2 uv_scale = glm::vec2(1));
  Shape& append(const Shape& other, const glm::mat4& to_here = glm::mat4(1.0f));
  // Sets texture coordinates from above: (x, z) times `per_unit`.
  Shape& uv_from_above(float per_unit);
  Mesh mesh(std::string name) const;
  bool empty() const { return mesh_.indices.empty(); }

 private:
  uint32_t vertex(glm::vec3 position, glm::vec3 normal, glm::vec2 uv);
  Mesh mesh_;
};

// Return a smooth curve through the points (Catmull and Rom), with `steps` pieces between neighbours. Points given
// twice are corners.
std::vector<glm::vec3> smooth_curve(const std::vector<glm::vec3>& points, uint32_t steps);
std::vector<glm::vec2> smooth_curve(const std::vector<glm::vec2>& points, uint32_t steps);

// Builds a Content; everything is referred to by index.
class ContentBuilder {
 public:
  explicit ContentBuilder(std::string name) { content_.name = std::move(name); }
  uint32_t mesh(const Shape& shape, const std::string& name) { return mesh(shape.mesh(name)); }
  uint32_t mesh(Mesh mesh);
  uint32_t material(const std::string& name, const sideray_material_desc& desc, RayTraced mark = RayTraced::by_default);
  // Returns the index + 1, as slots need it.
  uint32_t texture(Texture texture);
  // Adds a chequer of two colours (sRGB codes) with `cells` by `cells` tiles. Returns the index + 1, as slots need it.
  uint32_t checker(const std::string& name, glm::u8vec3 a, glm::u8vec3 b, uint32_t cells);
  void object(const std::string& name, uint32_t mesh, uint32_t material, glm::dvec3 position = glm::dvec3(0),
              double yaw_deg = 0);
  void object(const std::string& name, uint32_t mesh, uint32_t material, const glm::dmat4& world_from_object,
              uint32_t wind = 0, float wind_phase = 0);
  // Returns the index + 1, as objects need it.
  uint32_t wind(const sideray_wind_desc& desc);
  void light(const std::string& name, const sideray_light& light) { content_.lights.push_back({name, light}); }
  void camera(const std::string& name, const sideray_camera& camera) { content_.cameras.push_back({name, camera}); }
  // Adds a camera that moves by `travel` in `seconds` and then restarts: the only animation, with the same name.
  void dolly(const std::string& name, const sideray_camera& start, glm::dvec3 travel, double seconds);
  // Adds a particle system at `position`; `json` is as in extras.sideray.particles, with the texture given separately
  // (index + 1, 0 = none).
  void particles(const std::string& name, glm::dvec3 position, const std::string& json, uint32_t texture = 0);
  // Returns the finished content at time 0; meshes with normal maps get tangents.
  Content take();

 private:
  Content content_;
};

// Returns a directional light; `direction` has any length > 0.
sideray_light sun_light(glm::vec3 direction, glm::vec3 irradiance);
sideray_light point_light(glm::vec3 position, glm::vec3 intensity, float range);
// Makes a light in a cone of `half_angle_deg` about `direction`, fading toward its edge.
sideray_light spot_light(glm::vec3 position, glm::vec3 direction, glm::vec3 intensity, float range,
                         float half_angle_deg);

// Returns a material with this base colour (linear) and roughness.
sideray_material_desc opaque_material(glm::vec3 color, float roughness);
sideray_material_desc glass_material(glm::vec3 tint, float roughness);

}  // namespace sideray::scenes
