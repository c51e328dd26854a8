// Compares the layer search with plain packets of Embree through the same scene: 640x360 primary rays in 4x4 tiles onto
// a few hundred instanced spheres and panes of glass. Items are rays; compare items_per_second with raw/*.
#include <benchmark/benchmark.h>

#include <cmath>
#include <glm/ext/matrix_transform.hpp>
#include <map>
#include <numbers>
#include <numeric>
#include <random>
#include <vector>

#include "model/scene.h"
#include "rt/embree/intersector.h"

namespace sideray::rt {
namespace {

constexpr int width = 640, height = 360;

struct Geometry {
  std::vector<glm::vec3> positions;
  std::vector<uint32_t> indices;
};

Geometry sphere(uint32_t rings, uint32_t segments) {
  Geometry g;
  for (uint32_t r = 0; r <= rings; ++r) {
    const float theta = std::numbers::pi_v<float> * static_cast<float>(r) / static_cast<float>(rings);
    for (uint32_t s = 0; s <= segments; ++s) {
      const float phi = 2.0f * std::numbers::pi_v<float> * static_cast<float>(s) / static_cast<float>(segments);
      g.positions.emplace_back(std::sin(theta) * std::cos(phi), std::cos(theta), -std::sin(theta) * std::sin(phi));
    }
  }
  for (uint32_t r = 0; r < rings; ++r)
    for (uint32_t s = 0; s < segments; ++s) {
      const uint32_t a = r * (segments + 1) + s, b = a + segments + 1;
      g.indices.insert(g.indices.end(), {a, b, a + 1, a + 1, b, b + 1});
    }
  return g;
}

Geometry pane() {
  return {{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}, {0, 1, 2, 0, 2, 3}};
}

sideray_mesh add(model::Scene& scene, const Geometry& g) {
  sideray_mesh_desc desc{};
  desc.size = sizeof(desc);
  desc.vertex_count = static_cast<uint32_t>(g.positions.size());
  desc.index_count = static_cast<uint32_t>(g.indices.size());
  desc.indices = g.indices.data();
  desc.positions = {&g.positions[0].x, 0};
  return scene.add_mesh(desc, nullptr);
}

std::shared_ptr<const model::Snapshot> glass_scene(bool double_sided) {
  model::Scene scene;
  const sideray_mesh meshes[] = {add(scene, sphere(24, 48)), add(scene, pane())};
  sideray_material_desc glass{};
  glass.size = sizeof(glass);
  for (float& c : glass.base_color) c = 1.0f;
  glass.alpha_mode = SIDERAY_BLEND;
  glass.double_sided = double_sided;
  glass.transmission = 0.9f;
  glass.ior = 1.5f;
  glass.attenuation_distance = INFINITY;
  const sideray_material material = scene.add_material(glass);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  std::vector<sideray_instance_desc> instances;
  for (uint32_t i = 0; i < 400; ++i) {
    const double angle = 3.0 * uniform(random), x = uniform(random), y = uniform(random), z = uniform(random);
    glm::dmat4 m = glm::translate(glm::dmat4(1.0), glm::dvec3(9.0 * x, 5.0 * y, 9.0 * z));
    m = glm::rotate(m, angle, glm::normalize(glm::dvec3(y, 1.0, x)));
    m = glm::scale(m, glm::dvec3(0.6 + 0.3 * uniform(random)));
    sideray_instance_desc d{};
    d.mesh = meshes[i % 2], d.material = material, d.surface_id = i + 1, d.visibility = SIDERAY_VISIBLE_ALL;
    for (int c = 0; c < 4; ++c)
      for (int r = 0; r < 3; ++r) d.world_from_object[3 * c + r] = m[c][r];
    instances.push_back(d);
  }
  scene.add_instances(instances.data(), instances.size());
  scene.commit();
  return scene.snapshot();
}

// Chunks of 32x32 pixels in 4x4 order, as in the tracer; pixels outside the picture are traced too.
constexpr int chunk_size = 32, chunk_rays = chunk_size * chunk_size;

std::vector<Ray> primary_rays() {
  std::vector<Ray> rays;
  for (int chunk_y = 0; chunk_y < height; chunk_y += chunk_size)
    for (int chunk_x = 0; chunk_x < width; chunk_x += chunk_size)
      for (int i = 0; i < chunk_rays; ++i) {
        const int tile = i / 16, pixel = i % 16;
        const float x = static_cast<float>(chunk_x + tile % 8 * 4 + pixel % 4) + 0.5f;
        const float y = static_cast<float>(chunk_y + tile / 8 * 4 + pixel / 4) + 0.5f;
        const glm::vec3 d((x - 0.5f * width) / height, (y - 0.5f * height) / height, -2.0f);
        rays.push_back({{0.0f, 0.0f, 20.0f}, 0.0f, glm::normalize(d), INFINITY});
      }
  return rays;
}

const Intersector& intersector(bool double_sided) {
  static std::map<bool, Intersector> all;
  const auto [entry, fresh] = all.try_emplace(double_sided, "");
  if (fresh) entry->second.set_scene(glass_scene(double_sided));
  return entry->second;
}

void raw(benchmark::State& state) {
  const Intersector& tracer = intersector(true);
  const std::vector<Ray> rays = primary_rays();
  std::vector<float> t_far(chunk_rays);
  for (auto _ : state) {
    for (size_t first = 0; first < rays.size(); first += chunk_rays)
      tracer.raw_intersect(LayerSet::visible_in_layers, {rays.data() + first, chunk_rays}, true, t_far.data());
    benchmark::DoNotOptimize(t_far.data());
  }
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(rays.size()));
}

void layers(benchmark::State& state, bool double_sided) {
  const Intersector& tracer = intersector(double_sided);
  const std::vector<Ray> rays = primary_rays();
  const auto most = static_cast<uint32_t>(state.range(0));
  std::vector<Hit> hits(size_t{chunk_rays} * most);
  std::vector<uint32_t> counts(chunk_rays);
  uint64_t found = 0;
  for (auto _ : state) {
    for (size_t first = 0; first < rays.size(); first += chunk_rays) {
      tracer.nearest_layers(LayerSet::visible_in_layers, {rays.data() + first, chunk_rays},
                            {.layers = most, .coherent = true}, hits.data(), counts.data());
      found = std::accumulate(counts.begin(), counts.end(), found);
    }
  }
  const auto items = state.iterations() * static_cast<int64_t>(rays.size());
  state.counters["layers_per_ray"] = static_cast<double>(found) / static_cast<double>(items);
  state.SetItemsProcessed(items);
}

BENCHMARK(raw)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(layers, double_sided, true)->Arg(1)->Arg(2)->Arg(4)->Arg(8)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(layers, front_only, false)->Arg(1)->Arg(2)->Arg(4)->Arg(8)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace sideray::rt
