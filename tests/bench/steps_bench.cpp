// Compares steppers along a ray, for the first K layers of 16 stacked panes and of the bistro's first view at 640x360.
// multihit finds several layers in a traversal. retrace finds the same surfaces with a traversal for each layer, as the
// tracer does. raw_retrace is its lower bound: plain packets of Embree that start at the float behind the last hit,
// without filter and recomputation, so that they lose coplanar surfaces. Items are rays. For ratios:
//   bench_steps --benchmark_enable_random_interleaving=true --benchmark_repetitions=9
//               --benchmark_report_aggregates_only=true
#include <benchmark/benchmark.h>

#include <algorithm>
#include <cmath>
#include <glm/ext/matrix_clip_space.hpp>
#include <vector>

#include "bridge/base/handles.h"
#include "rt/base/view_rays.h"
#include "rt/embree/intersector.h"
#include "rt/embree/recompute.h"
#include "rt/layers/layer_steps.h"
#include "scenes/builtin/builtin.h"

namespace sideray::rt {
namespace {

constexpr uint32_t width = 640, height = 360;
constexpr size_t chunk_rays = 1024;  // as in the tracer

TraceView first_view(const scenes::Content& content) {
  const sideray_camera& camera = content.cameras.front().camera;
  glm::dmat4 world_from_camera(1.0);
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 3; ++r) world_from_camera[c][r] = camera.world_from_camera[3 * c + r];
  TraceView view;
  // Depth is reversed, in 0..1, so near and far are exchanged.
  view.clip_from_local =
      glm::perspectiveRH_ZO(double{camera.yfov}, double{width} / height, 1000.0, double{camera.z_near}) *
      glm::inverse(world_from_camera);
  view.local_from_clip = glm::inverse(view.clip_from_local);
  view.reversed_depth = view.zero_to_one_depth = true;
  return view;
}

struct Place {
  explicit Place(const scenes::Content& content) {
    Scene scene = Scene::create().value();
    scenes::fill(scene, content, std::vector<bool>(content.objects.size(), true));
    snapshot = scene.get()->scene.snapshot();
    intersector.set_scene(snapshot);
    const ViewRays view(first_view(content), width, height);
    for (uint32_t y = 0; y < height; y += 4)
      for (uint32_t x = 0; x < width; x += 4)
        for (uint32_t k = 0; k < 16; ++k) rays.push_back(view.ray(x + k % 4, y + k / 4));
  }
  // Calls trace(rays of a chunk) for all.
  template <typename Trace>
  void for_chunks(const Trace& trace) const {
    for (size_t first = 0; first < rays.size(); first += chunk_rays)
      trace(std::span(rays).subspan(first, std::min(chunk_rays, rays.size() - first)));
  }
  std::shared_ptr<const model::Snapshot> snapshot;
  std::vector<Ray> rays;
  Intersector intersector{""};
};

const Place& panes() {
  static const Place place(scenes::generate("panes", {{"count", "16"}, {"gap", "0.05"}}));
  return place;
}

const Place& bistro() {
  static const Place place(scenes::generate("bistro", {}));
  return place;
}

uint64_t sum(const std::vector<uint32_t>& counts) {
  uint64_t result = 0;
  for (const uint32_t n : counts) result += n;
  return result;
}

void report(benchmark::State& state, const Place& place, uint64_t found) {
  const auto items = state.iterations() * static_cast<int64_t>(place.rays.size());
  state.counters["layers_per_ray"] = static_cast<double>(found) / static_cast<double>(items);
  state.SetItemsProcessed(items);
}

void multihit(benchmark::State& state, const Place& (*at)()) {
  const Place& place = at();
  const auto layers = static_cast<uint32_t>(state.range(0));
  std::vector<Hit> hits(chunk_rays * layers);
  std::vector<uint32_t> counts(chunk_rays);
  uint64_t found = 0;
  for (auto _ : state)
    place.for_chunks([&](std::span<const Ray> rays) {
      counts.resize(rays.size());
      place.intersector.nearest_layers(LayerSet::visible_in_layers, rays, {.layers = layers, .coherent = true},
                                       hits.data(), counts.data());
      found += sum(counts);
    });
  report(state, place, found);
}

// Retraces in rounds as LayerTracer does, without its bookkeeping of events.
class Retracer {
 public:
  uint64_t trace(const Place& place, std::span<const Ray> rays, uint32_t layers) {
    rays_.assign(rays.begin(), rays.end());
    steps_.assign(rays.size(), {});
    for (LayerStep& step : steps_) step.last.instance = no_instance;
    active_.resize(rays.size());
    for (uint32_t i = 0; i < active_.size(); ++i) active_[i] = i;
    uint64_t found = 0;
    for (uint32_t round = 0; round < layers && !active_.empty(); ++round) found += trace_round(place);
    return found;
  }

 private:
  uint64_t trace_round(const Place& place) {
    uint32_t asked = 1;
    packed_.clear();
    for (const uint32_t i : active_) {
      asked = std::max(asked, layers_in_traversal(SIDERAY_STEP_RETRACE, steps_[i], 1));
      packed_.push_back(rays_[i]);
    }
    hits_.resize(active_.size() * asked);
    counts_.resize(active_.size());
    place.intersector.nearest_layers(LayerSet::visible_in_layers, packed_, {.layers = asked, .coherent = true},
                                     hits_.data(), counts_.data());
    size_t kept = 0;
    for (size_t i = 0; i < active_.size(); ++i) {
      const uint32_t ray = active_[i];
      if (take(place, {&hits_[i * asked], counts_[i]}, steps_[ray], rays_[ray])) active_[kept++] = ray;
    }
    active_.resize(kept);
    return kept;
  }

  static bool take(const Place& place, std::span<const Hit> hits, LayerStep& step, Ray& ray) {
    const auto id = [&](const Hit& hit) { return place.snapshot->instances[hit.instance].surface_id; };
    for (size_t k = 0; k < hits.size(); ++k) {
      if (step.last.instance != no_instance && !nearer(step.last, id(step.last), hits[k], id(hits[k]))) continue;
      step.last = hits[k];
      step_on(SIDERAY_STEP_RETRACE, hits.first(k + 1), step, ray);
      return true;
    }
    return false;
  }

  std::vector<Ray> rays_, packed_;
  std::vector<LayerStep> steps_;
  std::vector<uint32_t> active_, counts_;
  std::vector<Hit> hits_;
};

void retrace(benchmark::State& state, const Place& (*at)()) {
  const Place& place = at();
  const auto layers = static_cast<uint32_t>(state.range(0));
  Retracer retracer;
  uint64_t found = 0;
  for (auto _ : state)
    place.for_chunks([&](std::span<const Ray> rays) { found += retracer.trace(place, rays, layers); });
  report(state, place, found);
}

void raw_retrace(benchmark::State& state, const Place& (*at)()) {
  const Place& place = at();
  const auto layers = static_cast<uint32_t>(state.range(0));
  std::vector<Ray> active;
  std::vector<float> ends(chunk_rays);
  uint64_t found = 0;
  for (auto _ : state)
    place.for_chunks([&](std::span<const Ray> rays) {
      active.assign(rays.begin(), rays.end());
      for (uint32_t round = 0; round < layers && !active.empty(); ++round) {
        place.intersector.raw_intersect(LayerSet::visible_in_layers, active, true, ends.data());
        size_t kept = 0;
        for (size_t i = 0; i < active.size(); ++i) {
          if (ends[i] >= active[i].t_far) continue;
          active[kept] = active[i];
          active[kept++].t_near = std::nextafter(ends[i], INFINITY);
        }
        active.resize(kept);
        found += kept;
      }
    });
  report(state, place, found);
}

void arguments(benchmark::internal::Benchmark* b) {
  b->Arg(1)->Arg(2)->Arg(4)->Arg(8)->Unit(benchmark::kMillisecond);
}
BENCHMARK_CAPTURE(multihit, panes, panes)->Apply(arguments);
BENCHMARK_CAPTURE(retrace, panes, panes)->Apply(arguments);
BENCHMARK_CAPTURE(raw_retrace, panes, panes)->Apply(arguments);
BENCHMARK_CAPTURE(multihit, bistro, bistro)->Apply(arguments);
BENCHMARK_CAPTURE(retrace, bistro, bistro)->Apply(arguments);
BENCHMARK_CAPTURE(raw_retrace, bistro, bistro)->Apply(arguments);

}  // namespace
}  // namespace sideray::rt
