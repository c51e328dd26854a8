#include "rt/ray_batches.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "rt/frame_pixels.h"
#include "rt/view_rays.h"

namespace sideray::rt {
namespace {

constexpr size_t rays_in_chunk = 1024;
constexpr int most_culled_surfaces = 256;  // back faces that a primary ray passes before it gives up
constexpr float farthest = 1e30f;
constexpr float infinity = std::numeric_limits<float>::infinity();

// Where a ray goes on behind a hit: at least the next float, so that it gets on.
float behind(const Hit& hit) {
  return std::nextafter(static_cast<float>(hit.distance), infinity);
}

void for_chunks(size_t count, Executor& executor, const std::function<void(size_t first, size_t size)>& work) {
  executor.run((count + rays_in_chunk - 1) / rays_in_chunk, [&](size_t chunk, uint32_t) {
    const size_t first = chunk * rays_in_chunk;
    work(first, std::min(rays_in_chunk, count - first));
  });
}

// The first surfaces that the rasterizer draws, which leaves out the backs of materials that are not double sided.
template <typename Write>
void trace_drawn_surfaces(const model::Snapshot& snapshot, const Intersector& intersector,
                          std::vector<PixelRequest> pixels, std::vector<Ray> rays, const Write& write) {
  std::vector<Hit> hits(rays.size());
  for (int pass = 0; pass < most_culled_surfaces && !pixels.empty(); ++pass) {
    intersector.nearest_opaque(rays, true, hits.data());
    size_t left = 0;
    for (size_t i = 0; i < pixels.size(); ++i) {
      const Hit& hit = hits[i];
      if (hit.instance == no_instance) continue;
      if (hit.front || !snapshot.materials[snapshot.instances[hit.instance].material].cull_back) {
        write(pixels[i], hit, rays[i]);
        continue;
      }
      pixels[left] = pixels[i], rays[left] = rays[i];
      rays[left++].t_near = behind(hit);
    }
    pixels.resize(left), rays.resize(left);
  }
}

sideray_hit public_hit(const model::Snapshot& snapshot, const Hit& hit) {
  sideray_hit out{};
  out.distance = std::numeric_limits<double>::infinity();
  if (hit.instance == no_instance) return out;
  const model::Instance& instance = snapshot.instances[hit.instance];
  const model::Mesh& mesh = *snapshot.meshes[instance.mesh];
  const glm::vec3 normal = geometric_normal(snapshot, hit);
  out.distance = hit.distance;
  out.normal[0] = normal.x, out.normal[1] = normal.y, out.normal[2] = normal.z;
  out.u = hit.u, out.v = hit.v;
  out.surface_id = instance.surface_id;
  out.instance = hit.instance + 1;
  out.primitive = mesh.source_primitive.empty() ? hit.primitive : mesh.source_primitive[hit.primitive];
  return out;
}

// Asked for one after another: of several opaque surfaces at exactly one distance the first is reported.
void trace_opaque(const model::Snapshot& snapshot, const Intersector& intersector, std::vector<Ray> rays,
                  uint32_t layers, sideray_hit* hits) {
  std::vector<Hit> found(rays.size());
  for (uint32_t k = 0; k < layers; ++k) {
    intersector.nearest_opaque(rays, false, found.data());
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
  intersector.nearest_layers(LayerSet::all_translucent, rays, layers, false, found.data(), counts.data());
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

PrimaryImage trace_primary_image(const ShadingScene& scene, const Intersector& intersector, Executor& executor,
                                 const TraceView& view, uint32_t width, uint32_t height) {
  const model::Snapshot& snapshot = *scene.snapshot;
  FrameRequest request;
  request.width = width, request.height = height;
  request.mask = SIDERAY_MASK_NONE;
  FramePixels frame;
  gather_pixels(request, executor, frame);
  const ViewRays view_rays(view, width, height);
  const size_t texels = size_t{width} * height;
  PrimaryImage image{std::vector<float>(texels, infinity), std::vector<glm::vec3>(texels, glm::vec3(0.0f)),
                     std::vector<glm::uvec2>(texels, glm::uvec2(0))};
  const auto write = [&](const PixelRequest& p, const Hit& hit, const Ray& ray) {
    const size_t texel = size_t{p.y} * width + p.x;
    image.distance[texel] = static_cast<float>(hit.distance);
    image.normal[texel] = surface_point(scene, hit, ray, view_rays.cone(p.x, p.y)).surface.normal;
    image.ids[texel] = {snapshot.instances[hit.instance].surface_id, hit.primitive + 1};
  };
  for_chunks(texels, executor, [&](size_t first, size_t count) {
    const auto begin = frame.pixels.begin() + static_cast<ptrdiff_t>(first);
    std::vector<PixelRequest> pixels(begin, begin + static_cast<ptrdiff_t>(count));
    std::vector<Ray> rays;
    for (const PixelRequest& p : pixels) rays.push_back(view_rays.ray(p.x, p.y));
    trace_drawn_surfaces(snapshot, intersector, std::move(pixels), std::move(rays), write);
  });
  return image;
}

void trace_ray_batch(const model::Snapshot& snapshot, const Intersector& intersector, Executor& executor,
                     sideray_ray_set set, std::span<const sideray_ray> rays, uint32_t layers, sideray_hit* hits) {
  for_chunks(rays.size(), executor, [&](size_t first, size_t count) {
    std::vector<Ray> batch;
    for (const sideray_ray& r : rays.subspan(first, count)) batch.push_back(ray_of(r));
    sideray_hit* out = hits + first * layers;
    if (set == SIDERAY_RAYS_OPAQUE)
      trace_opaque(snapshot, intersector, std::move(batch), layers, out);
    else
      trace_translucent(snapshot, intersector, batch, layers, out);
  });
}

}  // namespace sideray::rt
