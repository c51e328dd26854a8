#include "rt/layers/layer_check.h"

#include <algorithm>
#include <bit>
#include <cmath>

#include "model/failure.h"
#include "rt/layers/frame_pixels.h"
#include "rt/layers/layer_tracer.h"

namespace sideray::rt {
namespace {

constexpr size_t pixels_in_check = 1024;

class NoShader final : public PointShader {
 public:
  void shade(std::span<const SurfacePoint> points, glm::vec3* radiance) override {
    std::fill_n(radiance, points.size(), glm::vec3(0.0f));
  }
  void shade_opaque(std::span<const SurfacePoint> points, glm::vec3* radiance) override { shade(points, radiance); }
  glm::vec3 surroundings(glm::vec3, float) const override { return glm::vec3(0.0f); }
};

// Holds the surfaces of each pixel of a chunk.
using ChunkSurfaces = std::vector<std::vector<glm::uvec2>>;

class TruthSink final : public LayerSink {
 public:
  TruthSink(const model::Snapshot& snapshot, ChunkSurfaces& surfaces) : snapshot_(snapshot), surfaces_(surfaces) {}
  void begin(std::span<const PixelRequest> pixels) override { surfaces_.assign(pixels.size(), {}); }
  bool meet(uint32_t, const SurfacePoint&, const RayHit&, glm::vec3&) override { return true; }
  void add(uint32_t pixel, uint32_t, const Hit& hit, const glm::vec3*, glm::vec3) override {
    surfaces_[pixel].emplace_back(std::bit_cast<uint32_t>(static_cast<float>(hit.distance)),
                                  snapshot_.instances[hit.instance].surface_id);
  }
  bool finished(uint32_t) const override { return false; }
  void end(std::span<const PixelRequest>) override {}

 private:
  const model::Snapshot& snapshot_;
  ChunkSurfaces& surfaces_;
};

CacheRequest to_the_last_surface(CacheRequest request) {
  if (request.mask == SIDERAY_MASK_COUNT) request.mask = SIDERAY_MASK_STENCIL;  // a count would limit the layers
  request.max_layers = 0;
  request.step = SIDERAY_STEP_MULTIHIT;
  request.cache_rate = SIDERAY_RATE_FULL;
  return request;
}

std::span<const PixelRequest> chunk_of(const FramePixels& frame, size_t chunk) {
  const size_t first = chunk * pixels_in_check;
  return std::span(frame.pixels).subspan(first, std::min(pixels_in_check, frame.pixels.size() - first));
}

// Sorts the surfaces of chunks, which are in the tracer's order, by texel.
LayerTruth in_rows(const CacheRequest& request, const FramePixels& frame, const std::vector<ChunkSurfaces>& chunks) {
  const size_t texels = size_t{request.width} * request.height;
  std::vector<const std::vector<glm::uvec2>*> at(texels, nullptr);
  for (size_t chunk = 0; chunk < chunks.size(); ++chunk) {
    const std::span<const PixelRequest> pixels = chunk_of(frame, chunk);
    for (size_t i = 0; i < pixels.size(); ++i)
      at[size_t{pixels[i].y} * request.width + pixels[i].x] = &chunks[chunk][i];
  }
  LayerTruth truth{request.width, request.height, {}, {}};
  truth.first.reserve(texels + 1);
  for (const std::vector<glm::uvec2>* surfaces : at) {
    truth.first.push_back(static_cast<uint32_t>(truth.surfaces.size()));
    if (surfaces) truth.surfaces.insert(truth.surfaces.end(), surfaces->begin(), surfaces->end());
  }
  truth.first.push_back(static_cast<uint32_t>(truth.surfaces.size()));
  return truth;
}

}  // namespace

LayerTruth trace_layer_truth(const CacheRequest& request, TracedScene& scene) {
  const CacheRequest all = to_the_last_surface(request);
  FramePixels frame;
  const ShadingScene& shading = scene.shading();
  gather_pixels(all, selection_of(all), scene.executor(), frame);
  const ViewRays view(all.view, all.width, all.height);
  const FrameContext context{.request = &all,
                             .cache = &all,
                             .view = &view,
                             .scene = &shading,
                             .intersector = &scene.intersector(),
                             .set = LayerSet::visible_in_layers};
  std::vector<ChunkSurfaces> chunks((frame.pixels.size() + pixels_in_check - 1) / pixels_in_check);
  scene.executor().run(chunks.size(), [&](size_t chunk, uint32_t) {
    LayerTracer tracer;
    NoShader shader;
    TruthSink sink(*shading.snapshot, chunks[chunk]);
    Counters uncounted;
    tracer.trace(context, chunk_of(frame, chunk), shader, sink, uncounted);
  });
  return in_rows(all, frame, chunks);
}

uint64_t count_duplicated(const LayerCache& cache, const LayerTruth& truth) {
  const size_t plane = size_t{cache.width} * cache.height;
  if (truth.first.size() != plane + 1) fail(SIDERAY_INTERNAL, "check: the true layers are another frame's");
  uint64_t duplicated = 0;
  std::vector<bool> taken;
  for (size_t pixel = 0; pixel < plane; ++pixel) {
    const std::span surfaces =
        std::span(truth.surfaces).subspan(truth.first[pixel], truth.first[pixel + 1] - truth.first[pixel]);
    taken.assign(surfaces.size(), false);
    for (uint32_t k = 0; k < cache.layers; ++k) {
      const size_t texel = k * plane + pixel;
      if (cache.distance[texel] == 0.0f) break;
      size_t best = surfaces.size();
      float least = 0.0f;
      for (size_t i = 0; i < surfaces.size(); ++i) {
        if (surfaces[i].y != cache.surface_id[texel]) continue;
        const float off = std::abs(std::bit_cast<float>(surfaces[i].x) - std::abs(cache.distance[texel]));
        // Among coplanar surfaces it prefers one that no other layer has taken.
        if (best < surfaces.size() && (off > least || (off == least && !taken[best]))) continue;
        best = i;
        least = off;
      }
      if (best == surfaces.size()) continue;
      duplicated += taken[best] ? 1 : 0;
      taken[best] = true;
    }
  }
  return duplicated;
}

}  // namespace sideray::rt
