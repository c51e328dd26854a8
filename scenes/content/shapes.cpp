#include "scenes/content/shapes.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_inverse.hpp>

#include "elementary/functions.h"
#include "scenes/content/animation.h"

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
  const float limit = elementary::cos(glm::radians(crease_deg));
  std::vector<glm::vec2> outward;  // normal of each profile edge, to the right of its direction
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
    return glm::vec3(v.x * elementary::cos(angle), v.y, -v.x * elementary::sin(angle));
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
    profile.emplace_back(pole ? 0.0f : radius * elementary::sin(a), -radius * elementary::cos(a));
  }
  return lathe(center, profile, segments, 180.0f);
}

Shape& Shape::cylinder(glm::vec3 base, float radius, float height, uint32_t segments) {
  return lathe(base, {{0, 0}, {radius, 0}, {radius, height}, {0, height}}, segments);
}

Shape& Shape::bevelled_box(glm::vec3 low, glm::vec3 high, float bevel, float uv_per_unit) {
  const glm::vec3 middle = 0.5f * (low + high), half = 0.5f * (high - low), flat = half - bevel;
  const auto at = [&](glm::vec3 sign, int axis) {  // the corner `sign` of the face that looks along `axis`
    glm::vec3 p = flat;
    p[axis] = half[axis];
    return middle + sign * p;
  };
  const glm::vec3 size = high - low;
  const int longest = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
  const auto face = [&](glm::vec3 a, glm::vec3 b, glm::vec3 c, glm::vec3 d) {
    const glm::vec3 n = glm::normalize(glm::cross(b - a, d - a));
    uint32_t first = 0;
    for (const glm::vec3 p : {a, b, c, d}) {
      const float across = p[(longest + 1) % 3] + p[(longest + 2) % 3];
      const uint32_t i = vertex(p, n, glm::vec2(p[longest], across) * uv_per_unit);
      if (p == a) first = i;
    }
    for (const uint32_t k : {0u, 1u, 2u, 0u, 2u, 3u}) mesh_.indices.push_back(first + k);
  };
  for (int axis = 0; axis < 3; ++axis) {
    const int u = (axis + 1) % 3, v = (axis + 2) % 3;
    for (const float side : {-1.0f, 1.0f}) {
      const auto sign = [&](float along_u, float along_v) {
        glm::vec3 s(0);
        s[axis] = side, s[u] = along_u * side, s[v] = along_v;
        return s;
      };
      face(at(sign(-1, -1), axis), at(sign(1, -1), axis), at(sign(1, 1), axis), at(sign(-1, 1), axis));
      // The bevels along `axis`, between the faces u and v.
      glm::vec3 from(-1), to(-1);
      from[u] = to[u] = side, from[v] = to[v] = 1.0f;
      to[axis] = 1.0f;
      if (side > 0) std::swap(from, to);
      face(at(from, u), at(to, u), at(to, v), at(from, v));
      from[v] = to[v] = -1.0f;
      face(at(to, u), at(from, u), at(from, v), at(to, v));
    }
  }
  for (int corner = 0; corner < 8; ++corner) {
    const glm::vec3 s(corner & 1 ? 1 : -1, corner & 2 ? 1 : -1, corner & 4 ? 1 : -1);
    const bool right_handed = s.x * s.y * s.z > 0;
    const glm::vec3 p[3] = {at(s, 0), at(s, right_handed ? 1 : 2), at(s, right_handed ? 2 : 1)};
    const uint32_t i = vertex(p[0], glm::normalize(s), {});
    vertex(p[1], glm::normalize(s), {0.01f, 0}), vertex(p[2], glm::normalize(s), {0, 0.01f});
    mesh_.indices.insert(mesh_.indices.end(), {i, i + 1, i + 2});
  }
  return *this;
}

Shape& Shape::tube(const std::vector<glm::vec3>& points, float radius, uint32_t sides, uint32_t steps_per_point) {
  const std::vector<glm::vec3> path = smooth_curve(points, steps_per_point);
  glm::vec3 across(0);
  const auto ahead_at = [&](size_t i) {
    return glm::normalize(path[std::min(i + 1, path.size() - 1)] - path[i > 0 ? i - 1 : 0]);
  };
  float travelled = 0;
  const uint32_t first = static_cast<uint32_t>(mesh_.positions.size() / 3), columns = sides + 1;
  for (size_t i = 0; i < path.size(); ++i) {
    const glm::vec3 ahead = ahead_at(i);
    if (i == 0) across = std::abs(ahead.y) < 0.9f ? glm::vec3(0, 1, 0) : glm::vec3(1, 0, 0);
    across = glm::normalize(across - ahead * glm::dot(across, ahead));  // carried along without twisting
    if (i > 0) travelled += glm::length(path[i] - path[i - 1]);
    for (uint32_t s = 0; s <= sides; ++s) {
      const float angle = glm::two_pi<float>() * static_cast<float>(s % sides) / static_cast<float>(sides);
      const glm::vec3 n = across * elementary::cos(angle) + glm::cross(ahead, across) * elementary::sin(angle);
      vertex(path[i] + radius * n, n, {travelled * 2.0f, static_cast<float>(s) / static_cast<float>(sides)});
    }
  }
  for (uint32_t i = 0; i + 1 < path.size(); ++i)
    for (uint32_t s = 0; s < sides; ++s) {
      const uint32_t a = first + i * columns + s, b = a + 1, c = a + columns, d = c + 1;
      mesh_.indices.insert(mesh_.indices.end(), {a, b, c, b, d, c});
    }
  for (const bool at_end : {false, true}) {
    const uint32_t ring = first + (at_end ? static_cast<uint32_t>(path.size() - 1) * columns : 0);
    const glm::vec3 n = at_end ? ahead_at(path.size() - 1) : -ahead_at(0);
    const uint32_t centre = vertex(at_end ? path.back() : path.front(), n, {});
    for (uint32_t s = 0; s <= sides; ++s) {
      const float* p = &mesh_.positions[3 * size_t{ring + s}];
      vertex({p[0], p[1], p[2]}, n, {0.1f, static_cast<float>(s)});
    }
    for (uint32_t s = 0; s < sides; ++s) {
      const uint32_t a = centre + 1 + s;
      if (at_end)
        mesh_.indices.insert(mesh_.indices.end(), {centre, a, a + 1});
      else
        mesh_.indices.insert(mesh_.indices.end(), {centre, a + 1, a});
    }
  }
  return *this;
}

Shape& Shape::sheet(uint32_t columns, uint32_t rows, const std::function<glm::vec3(float u, float v)>& surface,
                    glm::vec2 uv_scale) {
  const uint32_t first = static_cast<uint32_t>(mesh_.positions.size() / 3);
  constexpr float step = 1e-3f;
  for (uint32_t r = 0; r <= rows; ++r)
    for (uint32_t c = 0; c <= columns; ++c) {
      const float u = static_cast<float>(c) / static_cast<float>(columns);
      const float v = static_cast<float>(r) / static_cast<float>(rows);
      const glm::vec3 along_u = surface(std::min(u + step, 1.0f), v) - surface(std::max(u - step, 0.0f), v);
      const glm::vec3 along_v = surface(u, std::min(v + step, 1.0f)) - surface(u, std::max(v - step, 0.0f));
      vertex(surface(u, v), glm::normalize(glm::cross(along_u, along_v)), glm::vec2(u, 1.0f - v) * uv_scale);
    }
  for (uint32_t r = 0; r < rows; ++r)
    for (uint32_t c = 0; c < columns; ++c) {
      const uint32_t a = first + r * (columns + 1) + c, b = a + 1, d = a + columns + 1;
      mesh_.indices.insert(mesh_.indices.end(), {a, b, d, b, d + 1, d});
    }
  return *this;
}

Shape& Shape::append(const Shape& other, const glm::mat4& to_here) {
  const uint32_t first = static_cast<uint32_t>(mesh_.positions.size() / 3);
  const glm::mat3 normals_to_here = glm::inverseTranspose(glm::mat3(to_here));
  const Mesh& from = other.mesh_;
  for (size_t i = 0; i < from.positions.size() / 3; ++i) {
    const float *p = &from.positions[3 * i], *n = &from.normals[3 * i], *uv = &from.uv0[2 * i];
    vertex(glm::vec3(to_here * glm::vec4(p[0], p[1], p[2], 1)),
           glm::normalize(normals_to_here * glm::vec3(n[0], n[1], n[2])), {uv[0], uv[1]});
  }
  for (const uint32_t index : from.indices) mesh_.indices.push_back(first + index);
  return *this;
}

Shape& Shape::uv_from_above(float per_unit) {
  for (size_t i = 0; i < mesh_.positions.size() / 3; ++i) {
    mesh_.uv0[2 * i] = mesh_.positions[3 * i] * per_unit;
    mesh_.uv0[2 * i + 1] = mesh_.positions[3 * i + 2] * per_unit;
  }
  return *this;
}

namespace {

template <typename Point>
std::vector<Point> curve_through(const std::vector<Point>& points, uint32_t steps) {
  std::vector<Point> curve;
  for (size_t i = 0; i + 1 < points.size(); ++i) {
    const Point b = points[i], c = points[i + 1];
    if (b == c) continue;
    // Beyond a corner or an end the curve is continued straight.
    const Point a = i > 0 && points[i - 1] != b ? points[i - 1] : b + (b - c);
    const Point d = i + 2 < points.size() && points[i + 2] != c ? points[i + 2] : c + (c - b);
    for (uint32_t k = 0; k < steps; ++k) {
      const float t = static_cast<float>(k) / static_cast<float>(steps);
      curve.push_back(0.5f * (2.0f * b + t * (c - a) + t * t * (2.0f * a - 5.0f * b + 4.0f * c - d) +
                              t * t * t * (3.0f * (b - c) + d - a)));
    }
  }
  curve.push_back(points.back());
  return curve;
}

}  // namespace

std::vector<glm::vec3> smooth_curve(const std::vector<glm::vec3>& points, uint32_t steps) {
  return curve_through(points, steps);
}

std::vector<glm::vec2> smooth_curve(const std::vector<glm::vec2>& points, uint32_t steps) {
  return curve_through(points, steps);
}

Mesh Shape::mesh(std::string name) const {
  Mesh mesh = mesh_;
  mesh.name = std::move(name);
  return mesh;
}

namespace {

// Adds tangents from uv gradients, whose bitangents point up the image, against v. Where uvs are degenerate they are
// arbitrary.
void add_tangents(Mesh& mesh) {
  const auto at3 = [](const std::vector<float>& v, size_t i) {
    return glm::vec3(v[3 * i], v[3 * i + 1], v[3 * i + 2]);
  };
  const size_t count = mesh.positions.size() / 3;
  std::vector<glm::vec3> along_u(count, glm::vec3(0)), along_v(count, glm::vec3(0));
  for (size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
    const uint32_t *t = &mesh.indices[i], a = t[0], b = t[1], c = t[2];
    const auto uv = [&](uint32_t k) { return glm::vec2(mesh.uv0[2 * size_t{k}], mesh.uv0[2 * size_t{k} + 1]); };
    const glm::vec3 p = at3(mesh.positions, b) - at3(mesh.positions, a),
                    q = at3(mesh.positions, c) - at3(mesh.positions, a);
    const glm::vec2 s = uv(b) - uv(a), r = uv(c) - uv(a);
    const float side = s.x * r.y - s.y * r.x < 0.0f ? -1.0f : 1.0f;
    for (const uint32_t k : {a, b, c}) {
      along_u[k] += side * (p * r.y - q * s.y);
      along_v[k] += side * (q * s.x - p * r.x);
    }
  }
  mesh.tangents.reserve(4 * count);
  for (size_t i = 0; i < count; ++i) {
    const glm::vec3 n = at3(mesh.normals, i);
    glm::vec3 t = along_u[i] - n * glm::dot(n, along_u[i]);
    if (glm::length(t) < 1e-12f) t = glm::cross(n, std::abs(n.y) < 0.9f ? glm::vec3(0, 1, 0) : glm::vec3(1, 0, 0));
    t = glm::normalize(t);
    const float sign = glm::dot(glm::cross(n, t), along_v[i]) > 0.0f ? -1.0f : 1.0f;
    mesh.tangents.insert(mesh.tangents.end(), {t.x, t.y, t.z, sign});
  }
}

}  // namespace

void ContentBuilder::dolly(const std::string& name, const sideray_camera& start, glm::dvec3 travel, double seconds) {
  const double* m = start.world_from_camera;
  const glm::dvec3 from(m[9], m[10], m[11]), to = from + travel;
  auto rig = std::make_shared<Rig>();
  RigNode& node = rig->nodes.emplace_back();
  node.is_animated = node.moves = true;
  node.rest.translation = from;
  node.rest.rotation = glm::normalize(glm::quat_cast(glm::dmat3(m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8])));
  Channel channel;
  channel.period_s = seconds;
  channel.times = {0.0f, static_cast<float>(seconds)};
  for (const glm::dvec3& key : {from, to})
    for (int c = 0; c < 3; ++c) channel.values.push_back(static_cast<float>(key[c]));
  rig->channels.push_back(std::move(channel));
  rig->cameras.push_back({.index = static_cast<uint32_t>(content_.cameras.size()), .node = 0});
  camera(name, start);
  content_.animations.push_back({name, seconds});
  content_.rig = std::move(rig);
  pose(content_, 0.0);
}

Content ContentBuilder::take() {
  for (const Object& object : content_.objects) {
    Mesh& mesh = content_.meshes[object.mesh];
    if (content_.materials[object.material].desc.normal_texture.texture != 0 && mesh.tangents.empty())
      add_tangents(mesh);
  }
  simulate(content_, 0);
  return std::move(content_);
}

uint32_t ContentBuilder::mesh(Mesh mesh) {
  content_.meshes.push_back(std::move(mesh));
  return static_cast<uint32_t>(content_.meshes.size() - 1);
}

uint32_t ContentBuilder::wind(const sideray_wind_desc& desc) {
  content_.winds.push_back(desc);
  return static_cast<uint32_t>(content_.winds.size());
}

uint32_t ContentBuilder::material(const std::string& name, const sideray_material_desc& desc, RayTraced mark) {
  Material material;
  material.name = name;
  material.desc = desc;
  material.ray_traced = mark;
  content_.materials.push_back(std::move(material));
  return static_cast<uint32_t>(content_.materials.size() - 1);
}

void ContentBuilder::particles(const std::string& name, glm::dvec3 position, const std::string& json,
                               uint32_t texture) {
  Emitter emitter{};
  emitter.node = name;
  emitter.json = json;
  emitter.particles = parse_particles(content_.name, name, json, content_.warnings);
  emitter.texture = texture;
  for (int i = 0; i < 3; ++i) emitter.world_from_node[4 * i] = 1, emitter.world_from_node[9 + i] = position[i];
  content_.emitters.push_back(std::move(emitter));
}

uint32_t ContentBuilder::texture(Texture texture) {
  content_.textures.push_back(std::move(texture));
  return static_cast<uint32_t>(content_.textures.size());
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
  return this->texture(std::move(texture));
}

void ContentBuilder::object(const std::string& name, uint32_t mesh, uint32_t material, glm::dvec3 position,
                            double yaw_deg) {
  Object object;
  object.name = name;
  object.mesh = mesh;
  object.material = material;
  const double c = elementary::cos(glm::radians(yaw_deg)), s = elementary::sin(glm::radians(yaw_deg));
  const double m[12] = {c, 0, -s, 0, 1, 0, s, 0, c, position.x, position.y, position.z};
  std::copy_n(m, 12, object.world_from_object);
  content_.objects.push_back(std::move(object));
}

void ContentBuilder::object(const std::string& name, uint32_t mesh, uint32_t material,
                            const glm::dmat4& world_from_object, uint32_t wind, float wind_phase) {
  Object object;
  object.wind = wind;
  object.wind_phase = wind_phase;
  object.name = name;
  object.mesh = mesh;
  object.material = material;
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 3; ++r) object.world_from_object[3 * c + r] = world_from_object[c][r];
  content_.objects.push_back(std::move(object));
}

sideray_light sun_light(glm::vec3 direction, glm::vec3 irradiance) {
  sideray_light light{};
  light.size = sizeof(light);
  light.type = SIDERAY_LIGHT_DIRECTIONAL;
  light.angular_diameter_deg = 0.53f;
  // Files do not keep the length: a unit vector is read back with the same bits.
  const glm::vec3 unit(glm::normalize(glm::dvec3(direction)));
  for (int i = 0; i < 3; ++i) light.direction[i] = unit[i], light.intensity[i] = irradiance[i];
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

sideray_light spot_light(glm::vec3 position, glm::vec3 direction, glm::vec3 intensity, float range,
                         float half_angle_deg) {
  sideray_light light = point_light(position, intensity, range);
  light.type = SIDERAY_LIGHT_SPOT;
  const glm::vec3 along = glm::normalize(direction);
  for (int i = 0; i < 3; ++i) light.direction[i] = along[i];
  light.outer_cone = glm::radians(half_angle_deg);
  light.inner_cone = 0.4f * light.outer_cone;
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
