#include "scenes/shapes.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>

namespace sideray::scenes {

uint32_t Shape::vertex(glm::vec3 p, glm::vec3 n, glm::vec2 uv) {
  mesh_.positions.insert(mesh_.positions.end(), {p.x, p.y, p.z});
  mesh_.normals.insert(mesh_.normals.end(), {n.x, n.y, n.z});
  mesh_.uv0.insert(mesh_.uv0.end(), {uv.x, uv.y});
  return static_cast<uint32_t>(mesh_.positions.size() / 3 - 1);
}

Shape& Shape::quad(glm::vec3 a, glm::vec3 b, glm::vec3 c, glm::vec3 d, glm::vec2 uv_scale) {
  const glm::vec3 n = glm::normalize(glm::cross(b - a, d - a));
  const uint32_t i = vertex(a, n, {0, uv_scale.y});
  vertex(b, n, uv_scale);
  vertex(c, n, {uv_scale.x, 0});
  vertex(d, n, {0, 0});
  for (const uint32_t k : {0u, 1u, 2u, 0u, 2u, 3u}) mesh_.indices.push_back(i + k);
  return *this;
}

Shape& Shape::box(glm::vec3 l, glm::vec3 h, float uv_per_unit) {
  const glm::vec3 s = (h - l) * uv_per_unit;
  quad({l.x, l.y, h.z}, {h.x, l.y, h.z}, {h.x, h.y, h.z}, {l.x, h.y, h.z}, {s.x, s.y});
  quad({h.x, l.y, l.z}, {l.x, l.y, l.z}, {l.x, h.y, l.z}, {h.x, h.y, l.z}, {s.x, s.y});
  quad({h.x, l.y, h.z}, {h.x, l.y, l.z}, {h.x, h.y, l.z}, {h.x, h.y, h.z}, {s.z, s.y});
  quad({l.x, l.y, l.z}, {l.x, l.y, h.z}, {l.x, h.y, h.z}, {l.x, h.y, l.z}, {s.z, s.y});
  quad({l.x, h.y, h.z}, {h.x, h.y, h.z}, {h.x, h.y, l.z}, {l.x, h.y, l.z}, {s.x, s.z});
  return quad({l.x, l.y, l.z}, {h.x, l.y, l.z}, {h.x, l.y, h.z}, {l.x, l.y, h.z}, {s.x, s.z});
}

Shape& Shape::lathe(glm::vec3 axis, const std::vector<glm::vec2>& profile, uint32_t segments, float crease_deg) {
  const float limit = std::cos(glm::radians(crease_deg));
  std::vector<glm::vec2> outward;  // of each profile edge: to the right of its direction
  for (size_t e = 0; e + 1 < profile.size(); ++e) {
    const glm::vec2 d = glm::normalize(profile[e + 1] - profile[e]);
    outward.emplace_back(d.y, -d.x);
  }
  const auto ring_normal = [&](size_t edge, bool at_end) {
    const size_t neighbour = at_end ? edge + 1 : edge - 1;
    if (neighbour >= outward.size() || glm::dot(outward[edge], outward[neighbour]) < limit) return outward[edge];
    return glm::normalize(outward[edge] + outward[neighbour]);
  };
  const auto spin = [&](float turn, glm::vec2 v) {
    const float angle = turn * glm::two_pi<float>();
    return glm::vec3(v.x * std::cos(angle), v.y, -v.x * std::sin(angle));
  };
  for (size_t e = 0; e + 1 < profile.size(); ++e) {
    const glm::vec2 n0 = ring_normal(e, false), n1 = ring_normal(e, true);
    const float v0 = 1.0f - static_cast<float>(e) / static_cast<float>(profile.size() - 1);
    const float v1 = 1.0f - static_cast<float>(e + 1) / static_cast<float>(profile.size() - 1);
    const uint32_t first = static_cast<uint32_t>(mesh_.positions.size() / 3);
    for (uint32_t s = 0; s <= segments; ++s) {
      // The last column repeats the first to the bit, so that the surface is watertight.
      const float turn = static_cast<float>(s % segments) / static_cast<float>(segments);
      const float u = static_cast<float>(s) / static_cast<float>(segments);
      vertex(axis + spin(turn, profile[e]), glm::normalize(spin(turn, n0)), {u, v0});
      vertex(axis + spin(turn, profile[e + 1]), glm::normalize(spin(turn, n1)), {u, v1});
    }
    for (uint32_t s = 0; s < segments; ++s) {
      const uint32_t a = first + 2 * s, b = a + 1, c = a + 2, d = a + 3;
      if (profile[e].x > 0.0f) mesh_.indices.insert(mesh_.indices.end(), {a, c, b});
      if (profile[e + 1].x > 0.0f) mesh_.indices.insert(mesh_.indices.end(), {b, c, d});
    }
  }
  return *this;
}

Shape& Shape::sphere(glm::vec3 center, float radius, uint32_t segments) {
  std::vector<glm::vec2> profile;
  const uint32_t rings = std::max(segments / 2, 2u);
  for (uint32_t i = 0; i <= rings; ++i) {
    const float a = glm::pi<float>() * static_cast<float>(i) / static_cast<float>(rings);
    const bool pole = i == 0 || i == rings;
    profile.emplace_back(pole ? 0.0f : radius * std::sin(a), -radius * std::cos(a));
  }
  return lathe(center, profile, segments, 180.0f);
}

Shape& Shape::cylinder(glm::vec3 base, float radius, float height, uint32_t segments) {
  return lathe(base, {{0, 0}, {radius, 0}, {radius, height}, {0, height}}, segments);
}

Mesh Shape::mesh(std::string name) const {
  Mesh mesh = mesh_;
  mesh.name = std::move(name);
  return mesh;
}

uint32_t ContentBuilder::mesh(const Shape& shape, const std::string& name) {
  content_.meshes.push_back(shape.mesh(name));
  return static_cast<uint32_t>(content_.meshes.size() - 1);
}

uint32_t ContentBuilder::material(const std::string& name, const sideray_material_desc& desc, RayTraced mark) {
  Material material;
  material.name = name;
  material.desc = desc;
  material.ray_traced = mark;
  content_.materials.push_back(std::move(material));
  return static_cast<uint32_t>(content_.materials.size() - 1);
}

uint32_t ContentBuilder::checker(const std::string& name, glm::u8vec3 a, glm::u8vec3 b, uint32_t cells) {
  constexpr uint32_t size = 256;
  Texture texture;
  texture.name = name;
  texture.width = texture.height = size;
  texture.srgb = true;
  texture.rgba.reserve(size_t{4} * size * size);
  for (uint32_t y = 0; y < size; ++y)
    for (uint32_t x = 0; x < size; ++x) {
      const bool odd = ((x * cells / size) + (y * cells / size)) % 2 != 0;
      const glm::u8vec3 c = odd ? b : a;
      texture.rgba.insert(texture.rgba.end(), {c.r, c.g, c.b, 255});
    }
  content_.textures.push_back(std::move(texture));
  return static_cast<uint32_t>(content_.textures.size());
}

void ContentBuilder::object(const std::string& name, uint32_t mesh, uint32_t material, glm::dvec3 position,
                            double yaw_deg) {
  Object object;
  object.name = name;
  object.mesh = mesh;
  object.material = material;
  const double c = std::cos(glm::radians(yaw_deg)), s = std::sin(glm::radians(yaw_deg));
  const double m[12] = {c, 0, -s, 0, 1, 0, s, 0, c, position.x, position.y, position.z};
  std::copy_n(m, 12, object.world_from_object);
  content_.objects.push_back(std::move(object));
}

sideray_light sun_light(glm::vec3 direction, glm::vec3 irradiance) {
  sideray_light light{};
  light.size = sizeof(light);
  light.type = SIDERAY_LIGHT_DIRECTIONAL;
  light.angular_diameter_deg = 0.53f;
  for (int i = 0; i < 3; ++i) light.direction[i] = direction[i], light.intensity[i] = irradiance[i];
  return light;
}

sideray_light point_light(glm::vec3 position, glm::vec3 intensity, float range) {
  sideray_light light{};
  light.size = sizeof(light);
  light.type = SIDERAY_LIGHT_POINT;
  light.range = range;
  light.direction[1] = -1.0f;
  for (int i = 0; i < 3; ++i) light.position[i] = double{position[i]}, light.intensity[i] = intensity[i];
  return light;
}

sideray_material_desc opaque_material(glm::vec3 color, float roughness) {
  sideray_material_desc d = sideray_material_defaults();
  for (int i = 0; i < 3; ++i) d.base_color[i] = color[i];
  d.roughness = roughness;
  return d;
}

sideray_material_desc glass_material(glm::vec3 tint, float roughness) {
  sideray_material_desc d = opaque_material(tint, roughness);
  d.transmission = 1.0f;
  d.double_sided = 1;
  return d;
}

}  // namespace sideray::scenes
