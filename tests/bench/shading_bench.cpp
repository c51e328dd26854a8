// Measures shading of hits without rays: from the hit to its surface (with and without textures), the lights, emission
// and environment. Items are hits; scalar/* is the same shading model on single numbers.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <random>
#include <vector>

#include "model/scene.h"
#include "rt/surfaces/surface_batch.h"
#include "rt/textures/environment_lookup.h"

namespace sideray::rt {
namespace {

constexpr size_t hit_count = 512;  // as in the tracer
constexpr uint32_t texture_size = 1024;

sideray_material_desc material() {
  sideray_material_desc m{};
  m.size = sizeof(m);
  for (float& c : m.base_color) c = 0.8f;
  m.metallic = 0.2f, m.roughness = 0.6f;
  m.normal_scale = m.occlusion_strength = 1.0f;
  m.alpha_mode = SIDERAY_BLEND, m.double_sided = 1;
  m.ior = 1.5f, m.specular = 1.0f, m.transmission = 0.5f, m.attenuation_distance = INFINITY;
  for (int c = 0; c < 3; ++c) m.attenuation_color[c] = m.specular_color[c] = 1.0f, m.emissive[c] = 0.1f;
  return m;
}

struct Setup {
  std::shared_ptr<const model::Snapshot> snapshot;
  std::vector<Hit> hits;
  std::vector<Ray> rays;
};

// Gives a scene the fixed function, with a light for each of `lights` and highlights.
void make_fixed(model::Scene& scene, uint32_t material, const std::vector<sideray_light>& lights) {
  model::FixedDesc model{};
  model.desc.local_viewer = 1;
  for (const sideray_light& from : lights) {
    sideray_fixed_light light{};
    light.size = sizeof(light), light.spot_cutoff_deg = 180, light.casts_shadows = 1;
    std::copy_n(from.position, 3, light.position);
    light.position[3] = 1, light.constant_attenuation = 1, light.linear_attenuation = 0.1f;
    for (int c = 0; c < 3; ++c) light.ambient[c] = 0.1f, light.diffuse[c] = light.specular[c] = 0.5f;
    model.lights.push_back(light);
  }
  scene.set_fixed_function(&model);
  sideray_fixed_material m{};
  m.size = sizeof(m), m.shininess = 20;
  for (int c = 0; c < 3; ++c) m.ambient[c] = m.diffuse[c] = 0.5f, m.specular[c] = 0.3f, m.reflectance[c] = 0.1f;
  scene.set_fixed_material(material, &m);
}

// Makes hits all over a grid of small triangles, seen from above. `lobes` adds coat and sheen.
Setup make_setup(int textures, int lights, bool lobes, bool fixed = false) {
  model::Scene scene;
  std::mt19937 random(1);
  std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
  sideray_material_desc m = material();
  if (lobes) m.clearcoat = 0.5f, m.clearcoat_roughness = 0.1f, m.sheen_color[0] = 0.5f, m.sheen_roughness = 0.5f;
  std::vector<uint8_t> texels(size_t{4} * texture_size * texture_size);
  for (uint8_t& t : texels) t = static_cast<uint8_t>(random());
  sideray_texture_slot* slots[] = {&m.base_color_texture, &m.normal_texture, &m.metallic_roughness_texture,
                                   &m.occlusion_texture, &m.emissive_texture};
  for (int i = 0; i < textures; ++i) {
    const bool color = i == 0 || i == 4;
    const sideray_texture packed = m.metallic_roughness_texture.texture;  // with occlusion
    *slots[i] = {0, 0, SIDERAY_REPEAT, SIDERAY_REPEAT, SIDERAY_TRILINEAR, {1, 0, 0, 1, 0, 0}};
    slots[i]->texture = i == 3 ? packed
                               : scene.add_texture(texture_size, texture_size,
                                                   color ? SIDERAY_RGBA8_SRGB : SIDERAY_RGBA8, texels.data());
  }
  constexpr uint32_t cells = 64;
  std::vector<glm::vec3> positions;
  std::vector<glm::vec2> uv;
  std::vector<uint32_t> indices;
  for (uint32_t y = 0; y <= cells; ++y)
    for (uint32_t x = 0; x <= cells; ++x) {
      uv.emplace_back(glm::vec2(x, y) / static_cast<float>(cells));
      positions.emplace_back(uv.back().x * 4 - 2, uv.back().y * 4 - 2, 0.1f * unit(random));
    }
  for (uint32_t y = 0; y < cells; ++y)
    for (uint32_t x = 0; x < cells; ++x) {
      const uint32_t a = y * (cells + 1) + x, b = a + cells + 1;
      indices.insert(indices.end(), {a, a + 1, b + 1, a, b + 1, b});
    }
  sideray_mesh_desc mesh{};
  mesh.size = sizeof(mesh);
  mesh.vertex_count = static_cast<uint32_t>(positions.size());
  mesh.index_count = static_cast<uint32_t>(indices.size());
  mesh.indices = indices.data();
  mesh.positions = {&positions[0].x, 0};
  mesh.uv0 = {&uv[0].x, 0};
  sideray_instance_desc instance{};
  instance.mesh = scene.add_mesh(mesh, nullptr), instance.material = scene.add_material(m);
  instance.surface_id = 1, instance.visibility = SIDERAY_VISIBLE_ALL;
  for (int c = 0; c < 3; ++c) instance.world_from_object[3 * c + c] = 1.0;
  scene.add_instances(&instance, 1);
  std::vector<sideray_light> all(static_cast<size_t>(lights));
  for (sideray_light& l : all) {
    l.size = sizeof(l), l.type = SIDERAY_LIGHT_POINT;
    for (int c = 0; c < 3; ++c) l.position[c] = 3.0 * static_cast<double>(unit(random)), l.intensity[c] = 10.0f;
    l.position[2] = 3.0;
  }
  scene.set_lights(all.data(), all.size());
  const std::vector<glm::vec3> sky(64 * 32, glm::vec3(0.4f, 0.5f, 0.6f));
  scene.set_environment(64, 32, &sky[0].x, 1.0f, 0.0f);
  if (fixed) make_fixed(scene, instance.material, all);
  scene.commit();
  Setup s{scene.snapshot(), {}, {}};
  const glm::vec3 eye(0, 0, 4);
  for (size_t i = 0; i < hit_count; ++i) {
    // Hits a row of triangles, as neighbouring pixels do.
    Hit h{};
    h.primitive = static_cast<uint32_t>(i * 7 % (2 * cells * cells)), h.front = true;
    h.u = 0.3f, h.v = 0.3f;
    const model::Mesh& grid = *s.snapshot->meshes[0];
    const glm::vec3 d = grid.positions[grid.triangles[h.primitive].x] - eye;
    h.distance = static_cast<double>(glm::length(d));
    s.hits.push_back(h);
    s.rays.push_back({eye, 0.0f, glm::normalize(d), 1e30f});
  }
  return s;
}

constexpr Cone cone{0.0f, 0.003f};

std::vector<SurfacePoint> points_of(const ShadingScene& scene, const Setup& s) {
  std::vector<SurfacePoint> points;
  for (size_t i = 0; i < s.hits.size(); ++i) points.push_back(surface_point(scene, s.hits[i], s.rays[i], cone));
  return points;
}

void count_hits(benchmark::State& state) {
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(hit_count));
}

// Measures the step from hits to surfaces; the argument is the number of textures.
void surface(benchmark::State& state) {
  const Setup s = make_setup(static_cast<int>(state.range(0)), 1, false);
  const ShadingScene scene(s.snapshot);
  for (auto _ : state) benchmark::DoNotOptimize(points_of(scene, s));
  count_hits(state);
}

// Measures the same in SIMD lanes.
void surfaces(benchmark::State& state, const char* isa) {
  const Setup s = make_setup(static_cast<int>(state.range(0)), 1, false);
  const ShadingScene scene(s.snapshot);
  std::vector<HitPlace> places;
  for (size_t i = 0; i < s.hits.size(); ++i) places.push_back({&s.hits[i], &s.rays[i], cone});
  std::vector<SurfacePoint> points;
  for (auto _ : state) {
    points.clear();
    append_surfaces(scene, shade_kernels(isa), places, points);
    benchmark::DoNotOptimize(points.data());
  }
  count_hits(state);
}

// The argument is the number of lights.
void scalar(benchmark::State& state, bool lobes) {
  const Setup s = make_setup(0, static_cast<int>(state.range(0)), lobes);
  const ShadingScene scene(s.snapshot);
  const model::Environment& environment = *s.snapshot->environment;
  const std::vector<SurfacePoint> points = points_of(scene, s);
  std::vector<glm::vec3> radiance(points.size());
  for (auto _ : state) {
    for (size_t i = 0; i < points.size(); ++i) {
      const SurfacePoint& p = points[i];
      const shading::SrSurface& f = p.surface;
      glm::vec3 sum = shading::sr_emitted(f);
      for (const shading::SrLight& light : scene.lights) {
        const shading::SrIncidence in = shading::sr_incidence(light, p.position);
        if (!shading::sr_faces(f, in.to_light)) continue;
        sum += shading::sr_reflect_light(f, p.to_eye, in.to_light) * in.irradiance;
      }
      const glm::vec3 mirror = glm::reflect(-p.to_eye, f.normal);
      const glm::vec3 specular = environment_specular(environment, mirror, f.roughness);
      const glm::vec3 coat =
          lobes ? environment_specular(environment, glm::reflect(-p.to_eye, f.coat_normal), f.coat_roughness)
                : glm::vec3(0.0f);
      radiance[i] =
          sum + shading::sr_environment(
                    f, std::abs(glm::dot(f.normal, p.to_eye)), {environment_irradiance(environment, f.normal), glm::vec3(0.0f), specular, coat});
    }
    benchmark::DoNotOptimize(radiance.data());
    benchmark::ClobberMemory();
  }
  count_hits(state);
}

void batched(benchmark::State& state, const char* isa, bool lobes) {
  const Setup s = make_setup(0, static_cast<int>(state.range(0)), lobes);
  const ShadingScene scene(s.snapshot);
  const std::vector<SurfacePoint> points = points_of(scene, s);
  std::vector<glm::vec3> radiance(points.size());
  SurfaceBatch batch;
  batch.begin(scene, isa);
  for (auto _ : state) {
    batch.load(points);
    batch.reflect_environment();
    batch.finish(radiance.data());
    for (const shading::SrLight& light : scene.lights) {
      size_t first = 0;
      for (const LightBlock& block : batch.light(light)) {
        for (size_t i = 0; i < block_size; ++i)
          if (block.reached >> i & 1u) radiance[first + i] += vector_at(block.gain, i);
        first += block_size;
      }
    }
    benchmark::DoNotOptimize(radiance.data());
    benchmark::ClobberMemory();
  }
  count_hits(state);
}

// Measures the shading of hits without rays, by the built-in model or by the fixed function.
void whole(benchmark::State& state, bool fixed) {
  const Setup s = make_setup(1, static_cast<int>(state.range(0)), false, fixed);
  const ShadingScene scene(s.snapshot);
  std::vector<HitPlace> places;
  for (size_t i = 0; i < s.hits.size(); ++i) places.push_back({&s.hits[i], &s.rays[i], cone});
  std::vector<glm::vec3> radiance(s.hits.size());
  SurfaceBatch batch;
  batch.begin(scene, "avx2");
  for (auto _ : state) {
    batch.load(places);
    batch.reflect_environment();
    batch.finish_unblocked(radiance.data());
    benchmark::DoNotOptimize(radiance.data());
    benchmark::ClobberMemory();
  }
  count_hits(state);
}

// Measures lights alone, without the environment.
void lights_scalar(benchmark::State& state) {
  const Setup s = make_setup(0, static_cast<int>(state.range(0)), false);
  const ShadingScene scene(s.snapshot);
  const std::vector<SurfacePoint> points = points_of(scene, s);
  std::vector<glm::vec3> radiance(points.size());
  for (auto _ : state) {
    for (size_t i = 0; i < points.size(); ++i) {
      const SurfacePoint& p = points[i];
      radiance[i] = glm::vec3(0.0f);
      for (const shading::SrLight& light : scene.lights) {
        const shading::SrIncidence in = shading::sr_incidence(light, p.position);
        if (!shading::sr_faces(p.surface, in.to_light)) continue;
        radiance[i] += shading::sr_reflect_light(p.surface, p.to_eye, in.to_light) * in.irradiance;
      }
    }
    benchmark::DoNotOptimize(radiance.data());
    benchmark::ClobberMemory();
  }
  count_hits(state);
}

BENCHMARK(surface)->Arg(0)->Arg(1)->Arg(3)->Arg(5);
BENCHMARK_CAPTURE(surfaces, baseline, "")->Arg(0)->Arg(1)->Arg(3)->Arg(5);
BENCHMARK_CAPTURE(surfaces, avx2, "avx2")->Arg(0)->Arg(1)->Arg(3)->Arg(5);
BENCHMARK_CAPTURE(surfaces, avx512, "avx512")->Arg(0)->Arg(1)->Arg(3)->Arg(5);
BENCHMARK_CAPTURE(whole, built_in, false)->Arg(1)->Arg(3)->Arg(8);
BENCHMARK_CAPTURE(whole, fixed_function, true)->Arg(1)->Arg(3)->Arg(8);
BENCHMARK(lights_scalar)->Arg(1)->Arg(3)->Arg(8);
BENCHMARK_CAPTURE(scalar, plain, false)->Arg(1)->Arg(3)->Arg(8);
BENCHMARK_CAPTURE(scalar, lobes, true)->Arg(1)->Arg(3)->Arg(8);
BENCHMARK_CAPTURE(batched, plain_baseline, "", false)->Arg(1)->Arg(3)->Arg(8);
BENCHMARK_CAPTURE(batched, plain_avx2, "avx2", false)->Arg(1)->Arg(3)->Arg(8);
BENCHMARK_CAPTURE(batched, plain_avx512, "avx512", false)->Arg(1)->Arg(3)->Arg(8);
BENCHMARK_CAPTURE(batched, lobes_baseline, "", true)->Arg(1)->Arg(3)->Arg(8);
BENCHMARK_CAPTURE(batched, lobes_avx2, "avx2", true)->Arg(1)->Arg(3)->Arg(8);
BENCHMARK_CAPTURE(batched, lobes_avx512, "avx512", true)->Arg(1)->Arg(3)->Arg(8);

}  // namespace
}  // namespace sideray::rt
