// sideray_tracer_*: plain memory in, plain memory out.
#include <chrono>
#include <cmath>
#include <vector>

#include "bridge/api/border.h"
#include "bridge/base/handles.h"

using sideray::fail;
using sideray::bridge::guarded;
using sideray::bridge::require;
using sideray::bridge::require_struct;

sideray_tracer::sideray_tracer(sideray_scene* traced_scene, const sideray::rt::TracerConfig& config)
    : scene(traced_scene), tracer(config) {
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

sideray_tracer_desc sideray_tracer_defaults(void) {
  sideray_tracer_desc d{};
  d.size = sizeof(d);
  return d;
}

sideray_status sideray_tracer_create(sideray_scene* scene, const sideray_tracer_desc* desc, sideray_tracer** tracer,
                                     sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    require_struct(desc, "tracer description");
    require(tracer, "tracer result");
    *tracer = new sideray_tracer(scene, {desc->threads, desc->isa ? desc->isa : ""});
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

void check_rays(const sideray_ray* rays, size_t count) {
  for (size_t i = 0; i < count; ++i)
    if (!finite(rays[i]) || rays[i].t_near < 0.0f)
      fail(SIDERAY_INVALID_ARGUMENT, "ray {}: not finite, or t_near is negative; give finite origins and directions",
           i);
}

}  // namespace

sideray_status sideray_tracer_trace_rays(sideray_tracer* tracer, sideray_ray_set set, const sideray_ray* rays,
                                         size_t count, uint32_t layers, sideray_hit* hits, sideray_error* error) {
  return guarded(error, [&] {
    require(tracer, "tracer");
    if (count == 0) return;
    require(rays, "rays");
    require(hits, "hits");
    if (layers < 1 || layers > 64) fail(SIDERAY_INVALID_ARGUMENT, "layers {}: out of range; give 1 to 64", layers);
    if (set != SIDERAY_RAYS_OPAQUE && set != SIDERAY_RAYS_TRANSLUCENT)
      fail(SIDERAY_INVALID_ARGUMENT, "ray set {}: unknown; give a sideray_ray_set", static_cast<int>(set));
    check_rays(rays, count);
    const auto lock = tracer->take_turn_in_call();
    tracer->use(tracer->committed());
    const glm::dvec3 origin = tracer->snapshot->origin;
    std::vector<sideray_ray> local(rays, rays + count);
    for (sideray_ray& ray : local)
      for (int k = 0; k < 3; ++k) ray.origin[k] -= origin[k];
    tracer->tracer.trace_rays(set, local, layers, hits);
  });
}
