// The whole trace stage beside the traversal inside it: the bistro's first view at 1280x720, every pixel asked, one to
// eight layers. Items are primary rays of pixels; trace/k over traversal/k is the factor that shading costs.
#include <benchmark/benchmark.h>

#include <cstring>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <limits>
#include <vector>

#include "bridge/handles.h"
#include "rt/intersector.h"
#include "rt/tracer.h"
#include "rt/view_rays.h"
#include "scenes/builtin.h"

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
    // Reversed depth in 0..1: near and far change places.
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
  rt::Intersector intersector(1, "");
  intersector.set_scene(s.snapshot);
  const auto layers = static_cast<uint32_t>(state.range(0));
  std::vector<rt::Hit> hits(s.rays.size() * layers);
  std::vector<uint32_t> counts(s.rays.size());
  for (auto _ : state)
    intersector.nearest_layers(rt::LayerSet::visible_in_layers, s.rays, layers, true, hits.data(), counts.data());
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(s.rays.size()));
}

void trace(benchmark::State& state) {
  const Setup& s = setup();
  rt::Tracer tracer({.threads = 1, .isa = ""});
  tracer.set_scene(s.snapshot);
  rt::FrameRequest request;
  request.view = s.view;
  request.width = width;
  request.height = height;
  request.depth = {reinterpret_cast<const std::byte*>(s.depth.data()), width * sizeof(float), rt::DepthFormat::d32f};
  request.mask = SIDERAY_MASK_NONE;
  request.max_layers = static_cast<uint32_t>(state.range(0));
  rt::LayerCache cache;
  rt::TraceCounters counters;
  for (auto _ : state) counters = tracer.trace_cache(request, cache);
  state.SetItemsProcessed(state.iterations() * static_cast<int64_t>(s.rays.size()));
  const auto rays = counters.rays_primary + counters.rays_reflection + counters.rays_shadow;
  state.counters["rays"] = static_cast<double>(rays);
  state.counters["layers"] = static_cast<double>(counters.layers_found);
}

BENCHMARK(traversal)->Arg(1)->Arg(2)->Arg(4)->Arg(8)->Unit(benchmark::kMillisecond);
BENCHMARK(trace)->Arg(1)->Arg(2)->Arg(4)->Arg(8)->Unit(benchmark::kMillisecond);

}  // namespace
}  // namespace sideray
