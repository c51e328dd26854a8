#include "rt/reference/ray_batches.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "rt/base/view_rays.h"
#include "rt/layers/frame_pixels.h"

namespace sideray::rt {
namespace {

constexpr size_t rays_in_chunk = 1024;
constexpr float infinity = std::numeric_limits<float>::infinity();

// Returns where a ray continues behind a hit: at least at the next float, so that it advances.
float behind(const Hit& hit) {
  return std::nextafter(static_cast<float>(hit.distance), infinity);
}

void for_chunks(size_t count, Executor& executor, const std::function<void(size_t first, size_t size)>& work) {
  executor.run((count + rays_in_chunk - 1) / rays_in_chunk, [&](size_t chunk, uint32_t) {
    const size_t first = chunk * rays_in_chunk;
    work(first, std::min(rays_in_chunk, count - first));
  });
}

sideray_hit public_hit(const model::Snapshot& snapshot, const Hit& hit) {
  sideray_hit out{};
  out.distance = std::numeric_limits<double>::infinity();
  if (hit.instance == no_instance) return out;
  const model::Instance& instance = snapshot.instances[hit.instance];
  const model::Mesh& mesh = *snapshot.meshes[instance.mesh];
  const glm::vec3 normal = geometric_normal(snapshot, hit);
  out.distance = hit.distance;
  for (int c = 0; c < 3; ++c) out.normal[c] = normal[c];
  out.u = hit.u;
  out.v = hit.v;
  out.surface_id = instance.surface_id;
  out.instance = snapshot.instance_names[hit.instance].name;
  out.primitive = mesh.source_primitive.empty() ? hit.primitive : mesh.source_primitive[hit.primitive];
  return out;
}

// Traces one surface after another. Of several opaque surfaces at exactly one distance it reports the first. hits[i *
// layers + k] is the k-th surface of ray i, here and below.
void trace_opaque(const model::Snapshot& snapshot, const Intersector& intersector, std::vector<Ray> rays,
                  uint32_t layers, sideray_hit* hits) {
  std::vector<Hit> found(rays.size());
  for (uint32_t k = 0; k < layers; ++k) {
    intersector.nearest_opaque(rays, {}, found.data());
    for (size_t i = 0; i < rays.size(); ++i) {
      hits[i * layers + k] = public_hit(snapshot, found[i]);
      rays[i].t_near = found[i].instance == no_instance ? farthest : behind(found[i]);
    }
  }
}

void trace_translucent(const model::Snapshot& snapshot, const Intersector& intersector, std::span<const Ray> rays,
                       uint32_t layers, sideray_hit* hits) {
  std::vector<Hit> found(rays.size() * layers);
  std::vector<uint32_t> counts(rays.size());
  intersector.nearest_layers(LayerSet::all_translucent, rays, {.layers = layers}, found.data(), counts.data());
  for (size_t i = 0; i < rays.size(); ++i)
    for (uint32_t k = 0; k < layers; ++k) {
      Hit& hit = found[i * layers + k];
      if (k >= counts[i]) hit.instance = no_instance;
      hits[i * layers + k] = public_hit(snapshot, hit);
    }
}

Ray ray_of(const sideray_ray& r) {
  return {glm::vec3(glm::dvec3(r.origin[0], r.origin[1], r.origin[2])), r.t_near,
          glm::vec3(r.direction[0], r.direction[1], r.direction[2]), std::min(r.t_far, farthest)};
}

}  // namespace

void trace_drawn_surfaces(const Intersector& intersector, const AlphaCone& cone, std::span<const Ray> rays, std::vector<Hit>& hits) {
  hits.resize(rays.size());
  intersector.nearest_opaque(rays, {.set = OpaqueSet::all, .coherent = true, .cone = cone, .cull = true}, hits.data());
}

namespace {

struct PixelHit {
  const PixelRequest& pixel;
  size_t texel;
  const Ray& ray;
  const Hit& hit;
};

// Calls met(hit) for every pixel that shows a surface.
template <typename Met>
void trace_pixels(const Intersector& intersector, Executor& executor, const ViewRays& view_rays, glm::uvec2 size,
                  const Met& met) {
  LayerRequest request;
  request.width = size.x, request.height = size.y;
  request.mask = SIDERAY_MASK_NONE;
  FramePixels frame;
  gather_pixels(request, {}, executor, frame);
  for_chunks(size_t{size.x} * size.y, executor, [&](size_t first, size_t count) {
    const std::span<const PixelRequest> pixels = std::span(frame.pixels).subspan(first, count);
    std::vector<Ray> rays;
    std::vector<Hit> hits;
    for (const PixelRequest& p : pixels) rays.push_back(view_rays.ray(p.x, p.y));
    trace_drawn_surfaces(intersector, view_rays.alpha_cone(), rays, hits);
    for (size_t i = 0; i < count; ++i)
      if (hits[i].instance != no_instance)
        met(PixelHit{pixels[i], size_t{pixels[i].y} * size.x + pixels[i].x, rays[i], hits[i]});
  });
}

}  // namespace

PrimaryImage trace_primary_image(const ShadingScene& scene, const Intersector& intersector, Executor& executor,
                                 const TraceView& view, uint32_t width, uint32_t height) {
  const ViewRays view_rays(view, width, height);
  const size_t texels = size_t{width} * height;
  PrimaryImage image{std::vector<float>(texels, infinity), std::vector<glm::vec3>(texels, glm::vec3(0.0f)),
                     std::vector<glm::uvec2>(texels, glm::uvec2(0))};
  trace_pixels(intersector, executor, view_rays, {width, height}, [&](const PixelHit& met) {
    const Cone cone = view_rays.cone(met.pixel.x, met.pixel.y);
    image.distance[met.texel] = static_cast<float>(met.hit.distance);
    image.normal[met.texel] = surface_point(scene, met.hit, met.ray, cone, &view_rays.steps()).surface.normal;
    image.ids[met.texel] = {scene.snapshot->instances[met.hit.instance].surface_id, met.hit.primitive + 1};
  });
  return image;
}

std::vector<OpaquePoint> trace_opaque_points(const ShadingScene& scene, const Intersector& intersector,
                                             Executor& executor, const TraceView& view, uint32_t width,
                                             uint32_t height) {
  std::vector<OpaquePoint> points(size_t{width} * height, {std::numeric_limits<double>::infinity(), glm::vec3(0.0f)});
  trace_pixels(intersector, executor, ViewRays(view, width, height), {width, height}, [&](const PixelHit& met) {
    points[met.texel] = {met.hit.distance, geometric_normal(*scene.snapshot, met.hit)};
  });
  return points;
}

void trace_ray_batch(const model::Snapshot& snapshot, const Intersector& intersector, Executor& executor,
                     const RayBatch& batch) {
  for_chunks(batch.rays.size(), executor, [&](size_t first, size_t count) {
    std::vector<Ray> rays;
    for (const sideray_ray& r : batch.rays.subspan(first, count)) rays.push_back(ray_of(r));
    sideray_hit* hits = batch.hits + first * batch.layers;
    if (batch.set == SIDERAY_RAYS_OPAQUE)
      trace_opaque(snapshot, intersector, std::move(rays), batch.layers, hits);
    else
      trace_translucent(snapshot, intersector, rays, batch.layers, hits);
  });
}

}  // namespace sideray::rt
