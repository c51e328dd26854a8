#include "rt/embree/intersector_fixture.h"

#include <algorithm>
#include <array>
#include <glm/ext/matrix_transform.hpp>
#include <utility>

namespace sideray::rt::test {
namespace {

using Real = long double;
using Real3 = glm::vec<3, long double>;

float uniform(std::mt19937& random, float low, float high) {
  return std::uniform_real_distribution<float>(low, high)(random);
}

glm::vec3 uniform3(std::mt19937& random, float reach) {
  const float x = uniform(random, -reach, reach), y = uniform(random, -reach, reach);
  return {x, y, uniform(random, -reach, reach)};
}

glm::vec3 direction(std::mt19937& random) {
  for (;;) {
    const glm::vec3 d = uniform3(random, 1.0f);
    if (glm::length(d) > 0.1f && glm::length(d) < 1.0f) return glm::normalize(d);
  }
}

struct Triangle {
  Real3 p0, p1, p2;
};

Triangle placed(const model::Snapshot& s, const model::Instance& instance, glm::uvec3 t) {
  const model::Mesh& mesh = *s.meshes[instance.mesh];
  const auto place = [&](uint32_t vertex) {
    return Real3(instance.local_from_object * glm::vec4(mesh.positions[vertex], 1.0f));
  };
  return {place(t.x), place(t.y), place(t.z)};
}

// Signed volumes of the ray with the three edges: another method than the one under test.
struct Crossing {
  Real t, w0, w1, w2, facing;  // facing: normal . direction, over their lengths
  bool hit, near_edge;
};

Crossing cross_triangle(const Triangle& triangle, const Ray& ray) {
  const Real3 o(ray.origin), d(ray.direction);
  const Real3 a = triangle.p0 - o, b = triangle.p1 - o, c = triangle.p2 - o;
  Real w0 = glm::dot(d, glm::cross(c, b)), w1 = glm::dot(d, glm::cross(a, c)), w2 = glm::dot(d, glm::cross(b, a));
  const Real sum = w0 + w1 + w2;
  Crossing x{};
  if (sum == 0) return x;
  w0 /= sum, w1 /= sum, w2 /= sum;
  const Real3 n = glm::cross(triangle.p1 - triangle.p0, triangle.p2 - triangle.p0);
  x.t = glm::dot(n, a) / glm::dot(n, d);
  x.w0 = w0, x.w1 = w1, x.w2 = w2;
  x.facing = glm::dot(n, d) / (glm::length(n) * glm::length(d));
  const Real least = std::min({w0, w1, w2});
  x.hit = least >= 0;
  x.near_edge = std::abs(least) < Real(1e-4) || (std::abs(x.facing) < Real(1e-4) && least > Real(-0.1));
  return x;
}

// Nearest-filtered, repeating textures only.
bool discarded(const model::Snapshot& s, const model::Instance& instance, glm::uvec3 t, const Crossing& x,
               bool& near_texel_edge) {
  const sideray_material_desc& desc = s.materials[instance.material].desc;
  if (desc.base_color_texture.texture == 0) return false;
  const model::Mesh& mesh = *s.meshes[instance.mesh];
  const model::Texture::Level& level = s.textures[desc.base_color_texture.texture - 1]->levels[0];
  std::array<size_t, 2> texel{};
  const std::array<uint32_t, 2> size{level.width, level.height};
  for (int i = 0; i < 2; ++i) {
    const Real st = x.w0 * Real(mesh.uv0[t.x][i]) + x.w1 * Real(mesh.uv0[t.y][i]) + x.w2 * Real(mesh.uv0[t.z][i]);
    const Real position = (st - std::floor(st)) * Real(size[static_cast<size_t>(i)]);
    near_texel_edge |= std::abs(position - std::round(position)) < Real(1e-3);
    texel[static_cast<size_t>(i)] = static_cast<size_t>(position) % size[static_cast<size_t>(i)];
  }
  const auto alpha = static_cast<float>(level.rgba[4 * (texel[1] * level.width + texel[0]) + 3]) / 255.0f;
  return alpha < (desc.alpha_mode == SIDERAY_MASK ? desc.alpha_cutoff : 1.0f / 255.0f);
}

void add_crossings(const model::Snapshot& s, uint32_t index, const Ray& ray, bool translucent, BruteResult& result) {
  const model::Instance& instance = s.instances[index];
  const model::Material& material = s.materials[instance.material];
  if (material.translucent != translucent) return;
  const model::Mesh& mesh = *s.meshes[instance.mesh];
  for (uint32_t i = 0; i < mesh.triangles.size(); ++i) {
    const Crossing x = cross_triangle(placed(s, instance, mesh.triangles[i]), ray);
    const Real slack = Real(1e-4) * (1 + std::abs(x.t));
    const Real t_near(ray.t_near), t_far(ray.t_far);
    if (x.t < t_near - slack || x.t > t_far + slack) continue;
    const bool near_end = (t_near > 0 && x.t < t_near + slack) || x.t > t_far - slack;
    if (x.near_edge || (x.hit && near_end)) result.ambiguous = true;
    if (!x.hit || x.t < t_near || x.t > t_far) continue;
    const bool front = (x.facing < 0) != instance.mirrored;
    if (translucent && material.cull_back && !front) continue;
    if (discarded(s, instance, mesh.triangles[i], x, result.ambiguous)) continue;
    result.hits.push_back({static_cast<double>(x.t), index, i, front});
  }
}

}  // namespace

const glm::mat4x3 SceneBuilder::identity{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {0, 0, 0}};

uint32_t SceneBuilder::add_mesh(std::vector<glm::vec3> positions, std::vector<glm::uvec3> triangles) {
  auto mesh = std::make_shared<model::Mesh>();
  for (const glm::vec3& p : positions) {
    mesh->bounds.add(p);
    mesh->uv0.emplace_back(p.x, p.y);
  }
  mesh->uv1 = mesh->uv0;
  mesh->normals.assign(positions.size(), glm::vec3(0, 0, 1));
  mesh->tangents.assign(positions.size(), glm::vec4(0));
  mesh->colors.assign(positions.size(), glm::vec4(1));
  mesh->positions = std::move(positions);
  mesh->triangles = std::move(triangles);
  snapshot->meshes.push_back(std::move(mesh));
  return static_cast<uint32_t>(snapshot->meshes.size() - 1);
}

uint32_t SceneBuilder::add_mesh(std::vector<glm::vec3> positions) {
  std::vector<glm::uvec3> triangles;
  for (uint32_t i = 0; i + 2 < positions.size(); i += 3) triangles.emplace_back(i, i + 1, i + 2);
  return add_mesh(std::move(positions), std::move(triangles));
}

uint32_t SceneBuilder::add_texture(uint32_t width, uint32_t height, const std::vector<uint8_t>& alpha) {
  auto texture = std::make_shared<model::Texture>();
  model::Texture::Level level{width, height, {}};
  for (const uint8_t a : alpha) level.rgba.insert(level.rgba.end(), {255, 255, 255, a});
  texture->levels.push_back(std::move(level));
  texture->minimum_alpha = *std::min_element(alpha.begin(), alpha.end());
  snapshot->textures.push_back(std::move(texture));
  return static_cast<uint32_t>(snapshot->textures.size());
}

model::Material& SceneBuilder::add_material(bool translucent) {
  model::Material material{};
  std::fill_n(material.desc.base_color, 4, 1.0f);
  material.desc.alpha_mode = translucent ? SIDERAY_BLEND : SIDERAY_OPAQUE;
  material.desc.base_color_texture.filter = SIDERAY_NEAREST;
  material.desc.base_color_texture.texture_from_uv[0] = material.desc.base_color_texture.texture_from_uv[3] = 1.0f;
  material.desc.double_sided = 1;
  material.translucent = material.traceable = translucent;
  return snapshot->materials.emplace_back(material);
}

model::Instance& SceneBuilder::add_instance(uint32_t mesh, uint32_t material, const glm::mat4x3& local_from_object) {
  model::Instance instance{};
  instance.mesh = mesh, instance.material = material;
  instance.local_from_object = local_from_object;
  instance.mirrored = glm::determinant(glm::dmat3(glm::mat3(local_from_object))) < 0;
  instance.surface_id = static_cast<uint32_t>(snapshot->instances.size() + 1);
  instance.visibility = SIDERAY_VISIBLE_ALL;
  return snapshot->instances.emplace_back(instance);
}

std::vector<glm::vec3> square(float size, float z) {
  const glm::vec3 a(-size, -size, z), b(size, -size, z), c(size, size, z), d(-size, size, z);
  return {a, b, c, a, c, d};
}

std::vector<glm::vec3> triangle_soup(std::mt19937& random, size_t triangles, float size, float scale) {
  std::vector<glm::vec3> positions;
  for (size_t i = 0; i < triangles; ++i) {
    const glm::vec3 center = uniform3(random, 1.0f);
    for (int k = 0; k < 3; ++k) positions.push_back((center + uniform3(random, size)) / scale);
  }
  return positions;
}

glm::mat4x3 random_transform(std::mt19937& random, float scale, float reach, bool mirrored) {
  const glm::mat4 rotation = glm::rotate(glm::mat4(1.0f), uniform(random, -3.0f, 3.0f), direction(random));
  glm::mat4x3 m(rotation);
  for (int c = 0; c < 3; ++c) m[c] *= scale * uniform(random, 0.7f, 1.4f);
  if (mirrored) m[1] = -m[1];
  m[3] = uniform3(random, reach);
  return m;
}

SceneBuilder soup_scene(std::mt19937& random, size_t instances, size_t triangles, bool translucent) {
  SceneBuilder scene;
  scene.add_material(translucent);
  for (size_t i = 0; i < instances; ++i) {
    const float scale = std::pow(10.0f, uniform(random, -3.0f, 3.0f));
    const uint32_t mesh = scene.add_mesh(triangle_soup(random, triangles, 0.5f, scale));
    scene.add_instance(mesh, 0, random_transform(random, scale, 1.0f, i % 2 == 1));
  }
  return scene;
}

std::vector<Ray> random_rays(std::mt19937& random, size_t count) {
  std::vector<Ray> rays;
  for (size_t i = 0; i < count; ++i) {
    const glm::vec3 origin = 5.0f * direction(random), target = uniform3(random, 1.0f);
    // Of any length: distances count in it.
    rays.push_back({origin, 0.0f, (target - origin) * uniform(random, 0.01f, 2.0f), INFINITY});
  }
  return rays;
}

BruteResult brute_force(const model::Snapshot& snapshot, const Ray& ray, bool translucent) {
  BruteResult result{};
  for (uint32_t i = 0; i < snapshot.instances.size(); ++i) add_crossings(snapshot, i, ray, translucent, result);
  std::sort(result.hits.begin(), result.hits.end(),
            [](const BruteHit& a, const BruteHit& b) { return a.distance < b.distance; });
  for (size_t i = 1; i < result.hits.size(); ++i)
    result.ambiguous |= result.hits[i].distance - result.hits[i - 1].distance < 1e-6 * result.hits[i].distance;
  return result;
}

bool same_bits(const Hit& a, const Hit& b) {
  return a.distance == b.distance && a.u == b.u && a.v == b.v && a.instance == b.instance &&
         a.primitive == b.primitive && a.front == b.front;
}

std::vector<std::vector<Hit>> layers_of(const Intersector& intersector, const std::vector<Ray>& rays, uint32_t layers,
                                        bool coherent, LayerSet set) {
  std::vector<Hit> hits(rays.size() * layers);
  std::vector<uint32_t> counts(rays.size());
  intersector.nearest_layers(set, rays, {.layers = layers, .coherent = coherent}, hits.data(), counts.data());
  std::vector<std::vector<Hit>> result;
  for (size_t i = 0; i < rays.size(); ++i)
    result.emplace_back(hits.begin() + static_cast<std::ptrdiff_t>(i * layers),
                        hits.begin() + static_cast<std::ptrdiff_t>(i * layers + counts[i]));
  return result;
}

}  // namespace sideray::rt::test
