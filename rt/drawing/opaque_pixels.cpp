#include "rt/drawing/opaque_pixels.h"

#include <limits>

#include "rt/base/view_rays.h"
#include "rt/drawing/thin_pixels.h"
#include "rt/drawing/view_tile.h"
#include "rt/surfaces/surface_batch.h"

namespace sideray::rt {
namespace {

struct SurfaceWorker {
  ViewTile tile;
  std::vector<Hit> hits, layers;
  std::vector<uint32_t> counts;
  std::vector<HitPlace> places;
  std::vector<size_t> texels;  // of `places`
  std::vector<Hit> named;      // thin hits of `places`, renamed to their records
  std::vector<SurfacePoint> points;
  Counters counters;
};

float depth_of(const ViewRays& view, const OpaqueRequest& r, glm::uvec2 pixel, double distance) {
  return stored_depth(r.view, view.window_depth(view.pixel(pixel.x, pixel.y), distance));
}

// Lists the tile's pixels that show a surface; `hits` has one entry for each of its pixels.
void list_places(const ViewTile& tile, const Hit* hits, uint32_t width, const model::Snapshot& snapshot,
                 SurfaceWorker& w) {
  w.places.clear();
  w.texels.clear();
  w.named.assign(hits, hits + tile.pixels.size());
  for (size_t i = 0; i < tile.pixels.size(); ++i) {
    const size_t texel = size_t{tile.pixels[i].y} * width + tile.pixels[i].x;
    if (hits[i].instance == no_instance) continue;
    w.named[i].instance = record_of(hits[i], snapshot);
    w.places.push_back({&w.named[i], &tile.rays[i], tile.cones[i]});
    w.texels.push_back(texel);
  }
}

// Keeps only the places on lines and points.
void keep_thin(const OpaquePixels& pixels, SurfaceWorker& w) {
  size_t kept = 0;
  for (size_t i = 0; i < w.places.size(); ++i) {
    if (!is_thin(pixels.hits[w.texels[i]])) continue;
    w.places[kept] = w.places[i];
    w.texels[kept++] = w.texels[i];
  }
  w.places.resize(kept);
  w.texels.resize(kept);
}

void make_points(const ShadingScene& scene, const Intersector& intersector, const ViewRays& view, SurfaceWorker& w) {
  if (w.points.size() < w.places.size()) w.points.resize(w.places.size());
  make_surfaces(scene, shade_kernels(intersector.isa().c_str()), w.places, w.points.data(), &view.steps());
}

glm::vec4 normal_roughness(const SurfacePoint& point) {
  return {point.surface.normal, point.surface.roughness};
}

class SurfacePass {
 public:
  SurfacePass(const OpaqueRequest& request, TracedScene& scene, OpaquePixels& pixels)
      : request_(request),
        scene_(scene.shading()),
        intersector_(scene.intersector()),
        view_(request.view, request.width, request.height),
        pixels_(pixels) {}

  void trace(size_t index, SurfaceWorker& w) {
    ViewTile& tile = w.tile;
    tile.aim(view_, request_.width, request_.height, index);
    w.hits.resize(tile.rays.size());
    const OpaqueSearch search{.set = OpaqueSet::all, .coherent = true, .cone = view_.alpha_cone(), .cull = true};
    intersector_.nearest_opaque(tile.rays, search, w.hits.data());
    w.counters.rays_primary += tile.rays.size();
    if (request_.normals) store_normals(w);
    for (size_t i = 0; i < tile.pixels.size(); ++i) {
      const glm::uvec2 p = tile.pixels[i];
      const size_t texel = size_t{p.y} * request_.width + p.x;
      const Hit& hit = w.hits[i];
      const bool seen = hit.instance != no_instance;
      pixels_.hits[texel] = hit;
      pixels_.depths[texel] = seen ? depth_of(view_, request_, p, hit.distance) : static_cast<float>(view_.far_depth());
    }
  }

  // The pixels' hits already include lines and points.
  void store_thin_normals(size_t index, SurfaceWorker& w) const {
    w.tile.aim(view_, request_.width, request_.height, index);
    w.hits.clear();
    for (const glm::uvec2 p : w.tile.pixels) w.hits.push_back(pixels_.hits[size_t{p.y} * request_.width + p.x]);
    list_places(w.tile, w.hits.data(), request_.width, *scene_.snapshot, w);
    keep_thin(pixels_, w);
    store_listed(w);
  }

 private:
  void store_normals(SurfaceWorker& w) const {
    list_places(w.tile, w.hits.data(), request_.width, *scene_.snapshot, w);
    store_listed(w);
  }

  void store_listed(SurfaceWorker& w) const {
    make_points(scene_, intersector_, view_, w);
    for (size_t i = 0; i < w.places.size(); ++i) pixels_.normals[w.texels[i]] = normal_roughness(w.points[i]);
  }

  const OpaqueRequest& request_;
  const ShadingScene& scene_;
  const Intersector& intersector_;
  ViewRays view_;
  OpaquePixels& pixels_;
};

}  // namespace

float stored_depth(const TraceView& view, double window_depth) {
  constexpr float least = std::numeric_limits<float>::min(), most = 1.0f - 0x1p-24f;
  const auto depth = static_cast<float>(window_depth);
  return view.reversed_depth ? std::clamp(depth, least, 1.0f) : std::clamp(depth, 0.0f, most);
}

Counters trace_opaque_pixels(const OpaqueRequest& request, TracedScene& scene, OpaquePixels& pixels) {
  const size_t count = size_t{request.width} * request.height;
  pixels.width = request.width;
  pixels.height = request.height;
  pixels.depths.resize(count);
  pixels.hits.resize(count);
  pixels.normals.assign(request.normals ? count : 0, glm::vec4(0.0f));
  SurfacePass pass(request, scene, pixels);
  std::vector<SurfaceWorker> workers(scene.executor().threads());
  scene.executor().run(ViewTile::tiles_in(request.width, request.height),
                       [&](size_t tile, uint32_t thread) { pass.trace(tile, workers[thread]); });
  draw_thin(request, scene.shading(), pixels);
  if (request.normals && !scene.shading().snapshot->thin.empty())
    scene.executor().run(ViewTile::tiles_in(request.width, request.height),
                         [&](size_t tile, uint32_t thread) { pass.store_thin_normals(tile, workers[thread]); });
  Counters counters;
  for (const SurfaceWorker& worker : workers) counters += worker.counters;
  return counters;
}

std::vector<glm::uvec2> ids_of(const OpaquePixels& pixels, TracedScene& scene) {
  const model::Snapshot& snapshot = *scene.shading().snapshot;
  std::vector<glm::uvec2> ids(pixels.hits.size(), glm::uvec2(0));
  for (size_t i = 0; i < ids.size(); ++i) {
    const Hit& hit = pixels.hits[i];
    if (hit.instance == no_instance) continue;
    const model::Instance& instance =
        is_thin(hit) ? snapshot.thin[hit.instance & ~thin_instance] : snapshot.instances[hit.instance];
    ids[i] = {instance.surface_id, hit.primitive + 1};
  }
  return ids;
}

OpaqueMaterials materials_of(const OpaqueRequest& request, const OpaquePixels& pixels, TracedScene& scene) {
  const size_t count = size_t{request.width} * request.height;
  OpaqueMaterials result{std::vector<glm::vec4>(count, glm::vec4(0.0f)), std::vector<glm::vec4>(count, glm::vec4(0.0f)),
                         ids_of(pixels, scene)};
  const ShadingScene& shading = scene.shading();
  const ViewRays view(request.view, request.width, request.height);
  std::vector<SurfaceWorker> workers(scene.executor().threads());
  scene.executor().run(ViewTile::tiles_in(request.width, request.height), [&](size_t index, uint32_t thread) {
    SurfaceWorker& w = workers[thread];
    w.tile.aim(view, request.width, request.height, index);
    w.hits.clear();
    for (const glm::uvec2 p : w.tile.pixels) w.hits.push_back(pixels.hits[size_t{p.y} * request.width + p.x]);
    list_places(w.tile, w.hits.data(), request.width, *shading.snapshot, w);
    make_points(shading, scene.intersector(), view, w);
    for (size_t i = 0; i < w.places.size(); ++i) {
      const SurfacePoint& point = w.points[i];
      result.albedo_metallic[w.texels[i]] = {point.surface.albedo, point.surface.metallic};
      result.normal_roughness[w.texels[i]] = normal_roughness(point);
    }
  });
  return result;
}

std::vector<uint8_t> count_translucent(const OpaqueRequest& request, const OpaquePixels& pixels, bool sprites, uint32_t most,
                                       TracedScene& scene) {
  if (sprites) scene.place_sprites(request.view, request.height);
  std::vector<uint8_t> result(pixels.hits.size(), 0);
  const Intersector& intersector = scene.intersector();
  const LayerSet set = sprites ? LayerSet::with_sprites : LayerSet::all_translucent;
  if (!intersector.has_translucent(set)) return result;
  const ViewRays view(request.view, request.width, request.height);
  std::vector<SurfaceWorker> workers(scene.executor().threads());
  scene.executor().run(ViewTile::tiles_in(request.width, request.height), [&](size_t index, uint32_t thread) {
    SurfaceWorker& w = workers[thread];
    w.tile.aim(view, request.width, request.height, index);
    w.counts.resize(w.tile.rays.size());
    w.layers.resize(w.tile.rays.size() * most);
    for (size_t i = 0; i < w.tile.pixels.size(); ++i) {
      const Hit& hit = pixels.hits[size_t{w.tile.pixels[i].y} * request.width + w.tile.pixels[i].x];
      if (hit.instance != no_instance) w.tile.rays[i].t_far = static_cast<float>(hit.distance);
    }
    intersector.nearest_layers(set, w.tile.rays,
                               {.layers = most, .coherent = true, .cone = view.alpha_cone()},
                               w.layers.data(), w.counts.data());
    for (size_t i = 0; i < w.tile.pixels.size(); ++i)
      result[size_t{w.tile.pixels[i].y} * request.width + w.tile.pixels[i].x] = static_cast<uint8_t>(w.counts[i]);
  });
  return result;
}

}  // namespace sideray::rt
