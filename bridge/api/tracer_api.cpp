// sideray_tracer_*: plain memory in, plain memory out.
#include <chrono>
#include <cmath>
#include <utility>
#include <vector>

#include "bridge/api/border.h"
#include "bridge/base/handles.h"

using sideray::fail;
using sideray::bridge::guarded;
using sideray::bridge::init_struct;
using sideray::bridge::read_element;
using sideray::bridge::read_struct;
using sideray::bridge::require;
using sideray::bridge::require_stride;

sideray_tracer::sideray_tracer(sideray_scene* traced_scene, const sideray::rt::TracerConfig& config)
    : scene(traced_scene), tracer(config) {
  sideray_scene_retain(scene);
}

sideray_tracer::sideray_tracer(sideray_tracer& other)
    : scene(other.scene), tracer(sideray::rt::Tracer::SceneOf{other.tracer}), snapshot(other.snapshot) {
  sideray_scene_retain(scene);
}

sideray_tracer::~sideray_tracer() {
  sideray_scene_release(scene);
}

std::shared_ptr<const sideray::model::Snapshot> sideray_tracer::committed() const {
  auto commit = scene->scene.snapshot();
  if (!commit) fail(SIDERAY_INVALID_ARGUMENT, "scene: nothing is committed; call sideray_scene_commit first");
  return commit;
}

std::unique_lock<sideray::bridge::TracerTurn> sideray_tracer::take_turn_in_call() {
  constexpr std::chrono::milliseconds slice(1);
  std::unique_lock lock(turn, std::try_to_lock);
  while (!lock.owns_lock())
    shading.serve_until(std::chrono::steady_clock::now() + slice, [&] { return lock.try_lock(); });
  return lock;
}

void sideray_tracer::wake() {
  turn.wake();
  shading.wake();
}

void sideray_tracer::use(std::shared_ptr<const sideray::model::Snapshot> commit) {
  if (commit == snapshot) return;
  tracer.set_scene(commit);
  snapshot = std::move(commit);
}

void sideray_tracer_init(sideray_tracer_desc* out, size_t size) {
  init_struct(out, size, sideray_tracer_desc{});
}

sideray_status sideray_tracer_create(sideray_scene* scene, const sideray_tracer_desc* desc, sideray_tracer** tracer,
                                     sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    require(tracer, "tracer result");
    const sideray_tracer_desc read = read_struct(desc, "tracer description", sideray_tracer_init);
    *tracer = new sideray_tracer(scene, {read.threads, read.isa ? read.isa : ""});
  });
}

void sideray_tracer_retain(sideray_tracer* tracer) {
  if (tracer) ++tracer->references;
}

void sideray_tracer_release(sideray_tracer* tracer) {
  if (tracer && --tracer->references == 0) delete tracer;
}

namespace {

bool finite(const sideray_ray& ray) {
  double sum = double{ray.t_near};
  for (int k = 0; k < 3; ++k) sum += ray.origin[k] + double{ray.direction[k]};
  return std::isfinite(sum) && !std::isnan(ray.t_far);
}

void init_batch(sideray_ray_batch* out, size_t size) {
  init_struct(out, size, sideray_ray_batch_defaults());
}

void check_batch(const sideray_ray_batch& batch) {
  require(batch.rays, "rays");
  require(batch.hits, "hits");
  require_stride<sideray_ray>(batch.ray_stride_bytes, "rays");
  require_stride<sideray_hit>(batch.hit_stride_bytes, "hits");
  if (batch.layers < 1 || batch.layers > 64)
    fail(SIDERAY_INVALID_ARGUMENT, "layers {}: out of range; give 1 to 64", batch.layers);
  if (batch.set != SIDERAY_RAYS_OPAQUE && batch.set != SIDERAY_RAYS_TRANSLUCENT)
    fail(SIDERAY_INVALID_ARGUMENT, "ray set {}: unknown; give a sideray_ray_set", static_cast<int>(batch.set));
}

std::vector<sideray_ray> read_rays(const sideray_ray_batch& batch) {
  std::vector<sideray_ray> rays(batch.count);
  for (size_t i = 0; i < batch.count; ++i) {
    rays[i] = read_element(batch.rays, batch.ray_stride_bytes, i);
    if (!finite(rays[i]) || rays[i].t_near < 0.0f)
      fail(SIDERAY_INVALID_ARGUMENT, "ray {}: not finite, or t_near is negative; give finite origins and directions",
           i);
  }
  return rays;
}

// Traces rays in world space. Takes the tracer's turn.
void trace(sideray_tracer& tracer, const sideray_ray_batch& batch, std::vector<sideray_ray> rays, sideray_hit* hits) {
  const auto lock = tracer.take_turn_in_call();
  tracer.use(tracer.committed());
  const glm::dvec3 origin = tracer.snapshot->origin;
  for (sideray_ray& ray : rays)
    for (int k = 0; k < 3; ++k) ray.origin[k] -= origin[k];
  tracer.tracer.trace_rays(batch.set, rays, batch.layers, hits);
}

}  // namespace

sideray_status sideray_tracer_trace_rays(sideray_tracer* tracer, const sideray_ray_batch* batch,
                                         sideray_error* error) {
  return guarded(error, [&] {
    require(tracer, "tracer");
    const sideray_ray_batch read = read_struct(batch, "ray batch", init_batch);
    if (read.count == 0) return;
    check_batch(read);
    std::vector<sideray_ray> rays = read_rays(read);
    if (read.hit_stride_bytes == sizeof(sideray_hit)) return trace(*tracer, read, std::move(rays), read.hits);
    std::vector<sideray_hit> hits(read.count * read.layers);
    trace(*tracer, read, std::move(rays), hits.data());
    for (size_t i = 0; i < hits.size(); ++i)
      sideray::bridge::write_element(read.hits, read.hit_stride_bytes, i, hits[i]);
  });
}
