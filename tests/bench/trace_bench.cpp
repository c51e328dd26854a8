// Measures the whole trace stage and the traversal inside it: the bistro's first view at 1280x720, all pixels traced,
// one to eight layers. Items are primary rays; trace/k divided by traversal/k is the factor of shading. Parts:
// surfaces/k interpolates and reads textures at the layers, lanes/k computes their light, shade/k does both with
// reflections but without shadow rays, shade_shadowed/k does everything. The rest of trace/k is primary rays, sorting
// and output. raw_frames is the time in raw frames (docs/cli.md), which are measured too.
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cstring>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <limits>
#include <vector>

#include "bridge/base/handles.h"
#include "model/stopwatch.h"
#include "rt/base/view_rays.h"
#include "rt/embree/intersector.h"
#include "rt/shading/hit_shader.h"
#include "rt/tracer.h"
#include "scenes/builtin/builtin.h"

namespace sideray {
namespace {

constexpr uint32_t width = 1280, height = 720;

struct Setup {
  std::shared_ptr<const model::Snapshot> snapshot;
  rt::TraceView view;
  std::vector<float> depth = std::vector<float>(width * height, 0.0f);  // reversed: nothing opaque in front
  std::vector<rt::Ray> rays;                                            // in 4x4 blocks
};

const Setup& setup() {
  static const Setup built = [] {
    Setup s;
    const scenes::Content content = scenes::generate("bistro", {});
    Scene scene = Scene::create().value();
    scenes::fill(scene, content, std::vector<bool>(content.objects.size(), true));
    s.snapshot = scene.get()->scene.snapshot();
    const sideray_camera& camera = content.cameras.front().camera;
    glm::dmat4 world_from_camera(1.0);
    for (int c = 0; c < 4; ++c)
      for (int r = 0; r < 3; ++r) world_from_camera[c][r] = camera.world_from_camera[3 * c + r];
    // Depth is reversed, in 0..1, so near and far are exchanged.
    const glm::dmat4 clip_from_camera =
        glm::perspectiveRH_ZO(double{camera.yfov}, double{width} / height, 1000.0, double{camera.z_near});
    s.view.clip_from_local = clip_from_camera * glm::inverse(world_from_camera);
    s.view.local_from_clip = glm::inverse(s.view.clip_from_local);
    s.view.reversed_depth = s.view.zero_to_one_depth = true;
    const rt::ViewRays rays(s.view, width, height);
    for (uint32_t y = 0; y < height; y += 4)
      for (uint32_t x = 0; x < width; x += 4)
        for (uint32_t k = 0; k < 16; ++k) s.rays.push_back(rays.ray(x + k % 4, y + k / 4));
    return s;
  }();
  return built;
}

void traversal(benchmark::State& state) {
  const Setup& s = setup();
  rt::Intersector intersector("");
  intersector.set_scene(s.snapshot);
  const auto layers = static_cast<uint32_t>(state.range(0));
  std::vector<rt::Hit> hits(s.rays.size() * layers);
  std::vector<uint32_t> counts(s.rays.size());
  for (auto _ : state)
    intersector.nearest_layers(rt::LayerSet::visible_in_layers, s.rays, {.layers = layers, .coherent = true},
                               hits.data(), counts.data());
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(s.rays.size()));
}

void trace(benchmark::State& state) {
  const Setup& s = setup();
  rt::Tracer tracer({.threads = 1, .isa = ""});
  tracer.set_scene(s.snapshot);
  rt::CacheRequest request;
  request.view = s.view;
  request.width = width;
  request.height = height;
  request.depth = {reinterpret_cast<const std::byte*>(s.depth.data()), width * sizeof(float), rt::DepthFormat::d32f};
  request.mask = SIDERAY_MASK_NONE;
  request.denoise = 0;
  request.max_layers = static_cast<uint32_t>(state.range(0));
  rt::LayerCache cache;
  rt::Counters counters;
  const Stopwatch watch;
  for (auto _ : state) counters = tracer.trace_cache(request, cache);
  const double ms = watch.ms() / static_cast<double>(state.iterations());
  const rt::RawFrame raw =
      tracer.time_raw_frame({.view = s.view, .width = width, .height = height, .most_flat = uint64_t{1} << 22});
  state.counters["raw_ms"] = raw.ms;
  state.counters["raw_frames"] = ms / raw.ms;
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(s.rays.size()));
  const auto rays = counters.rays_primary + counters.rays_reflection + counters.rays_shadow;
  state.counters["rays"] = static_cast<double>(rays);
  state.counters["layers"] = static_cast<double>(counters.layers_found);
}

constexpr size_t batch = 512;  // hits, as in the tracer

struct Layers {
  std::vector<rt::Hit> hits;
  std::vector<rt::Ray> rays;
};

Layers found_layers(const rt::Intersector& intersector, uint32_t layers) {
  const Setup& s = setup();
  std::vector<rt::Hit> hits(s.rays.size() * layers);
  std::vector<uint32_t> counts(s.rays.size());
  intersector.nearest_layers(rt::LayerSet::visible_in_layers, s.rays, {.layers = layers, .coherent = true}, hits.data(),
                             counts.data());
  Layers found;
  for (size_t i = 0; i < s.rays.size(); ++i)
    for (uint32_t k = 0; k < counts[i]; ++k) {
      found.hits.push_back(hits[i * layers + k]);
      found.rays.push_back(s.rays[i]);
    }
  return found;
}

// Calls `use` with every batch of surfaces.
template <typename Use>
void each_batch(const rt::ShadingScene& scene, const Layers& layers, const Use& use) {
  const rt::Cone cone = rt::ViewRays(setup().view, width, height).cone(width / 2, height / 2);
  std::vector<rt::SurfacePoint> points;
  for (size_t first = 0; first < layers.hits.size(); first += batch) {
    points.clear();
    for (size_t i = first; i < std::min(first + batch, layers.hits.size()); ++i)
      points.push_back(surface_point(scene, layers.hits[i], layers.rays[i], cone));
    use(points);
  }
}

enum class Part { surfaces, lanes, shade, shade_shadowed };

void part_of_trace(benchmark::State& state, Part part) {
  const Setup& s = setup();
  rt::Intersector intersector("");
  intersector.set_scene(s.snapshot);
  const rt::ShadingScene scene(s.snapshot);
  const Layers layers = found_layers(intersector, static_cast<uint32_t>(state.range(0)));
  rt::SurfaceBatch lanes;
  lanes.begin(scene, intersector.isa());
  rt::HitShader shader;
  shader.begin(scene, intersector, {.shadows = part == Part::shade_shadowed});
  std::vector<glm::vec3> radiance(batch);
  std::vector<std::vector<rt::SurfacePoint>> kept;
  if (part != Part::surfaces)
    each_batch(scene, layers, [&](const std::vector<rt::SurfacePoint>& points) { kept.push_back(points); });
  for (auto _ : state) {
    if (part == Part::surfaces)
      each_batch(scene, layers, [](const auto& points) { benchmark::DoNotOptimize(points.data()); });
    for (const std::vector<rt::SurfacePoint>& points : kept) {
      if (part == Part::lanes) {
        lanes.load(points);
        lanes.finish(radiance.data());
        for (const shading::SrLight& light : scene.lights) benchmark::DoNotOptimize(lanes.light(light).data());
      } else {
        shader.shade(points, radiance.data());
      }
    }
    benchmark::ClobberMemory();
  }
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(layers.hits.size()));
  state.counters["lights"] = static_cast<double>(scene.lights.size());
}

BENCHMARK_CAPTURE(part_of_trace, surfaces, Part::surfaces)->Arg(1)->Arg(8)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(part_of_trace, lanes, Part::lanes)->Arg(1)->Arg(8)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(part_of_trace, shade, Part::shade)->Arg(1)->Arg(8)->Unit(benchmark::kMillisecond);
BENCHMARK_CAPTURE(part_of_trace, shade_shadowed, Part::shade_shadowed)->Arg(1)->Arg(8)->Unit(benchmark::kMillisecond);
BENCHMARK(traversal)->Arg(1)->Arg(2)->Arg(4)->Arg(8)->Unit(benchmark::kMillisecond);
BENCHMARK(trace)->Arg(1)->Arg(2)->Arg(4)->Arg(8)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace sideray
