// sideray_plan_*, sideray_material_is_translucent: what the offscreen renderer would do.
#include "bridge/api/border.h"
#include "bridge/base/handles.h"
#include "bridge/options/check_options.h"
#include "bridge/plan/cull_angle.h"
#include "bridge/plan/plan_description.h"
#include "bridge/plan/rays_alone.h"
#include "bridge/picture/stages.h"
#include "model/material.h"

using sideray::bridge::guarded;
using sideray::bridge::require;
using sideray::bridge::RenderOptions;

// Holds what the public interface points at; the texts are in `described_passes` and `described_textures`.
struct sideray_plan {
  std::vector<sideray::bridge::PlannedPass> described_passes;
  std::vector<sideray::bridge::PlannedTexture> described_textures;
  std::vector<sideray_plan_pass> passes;
  std::vector<sideray_plan_texture> textures;
  sideray_plan_work work;
  uint32_t layers;
  float ray_reuse;
  bool ao, bounce, reflections;
};

namespace {

std::shared_ptr<const sideray::model::Snapshot> committed(sideray_scene* scene) {
  require(scene, "scene");
  auto snapshot = scene->scene.snapshot();
  if (!snapshot)
    sideray::fail(SIDERAY_INVALID_ARGUMENT, "scene: nothing is committed; call sideray_scene_commit first");
  return snapshot;
}

template <typename T>
const T* at(const std::vector<T>& list, size_t index) {
  return index < list.size() ? &list[index] : nullptr;
}

void point_at_descriptions(sideray_plan& plan) {
  for (const sideray::bridge::PlannedPass& pass : plan.described_passes)
    plan.passes.push_back({pass.stage, sideray::bridge::stage_name(pass.stage), pass.runs, pass.reason.c_str()});
  for (const sideray::bridge::PlannedTexture& t : plan.described_textures)
    plan.textures.push_back({t.name.c_str(), t.format, t.width, t.height, t.layers, t.bytes(), t.of_service});
}

sideray_status create(sideray_scene* scene, const sideray_render_options* options, sideray::bridge::Drawing drawing,
                      sideray_plan** plan, sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    const RenderOptions read = sideray::bridge::read_render_options(options);
    require(plan, "plan result");
    sideray::bridge::check_options(read);
    if (drawing == sideray::bridge::Drawing::rays) sideray::bridge::check_rays_alone(read);
    const auto snapshot = committed(scene);
    const sideray::bridge::FramePlan frame = sideray::bridge::plan_frame(*snapshot, read, drawing);
    auto made = std::make_unique<sideray_plan>();
    made->described_passes = planned_passes(*snapshot, read, frame);
    made->described_textures = planned_textures(*snapshot, read, frame);
    made->work = planned_work(*snapshot, read, frame, made->described_textures);
    made->layers = frame.traces ? frame.layers.max_layers : 0;
    made->ray_reuse = frame.layers.ray_reuse;
    made->ao = frame.masks.ao_rays != 0;
    made->bounce = frame.bounces;
    made->reflections = frame.reflects;
    point_at_descriptions(*made);
    *plan = made.release();
  });
}

}  // namespace

sideray_status sideray_plan_create(sideray_scene* scene, const sideray_render_options* options, sideray_plan** plan,
                                   sideray_error* error) {
  return create(scene, options, sideray::bridge::Drawing::raster, plan, error);
}

sideray_status sideray_plan_create_without_gl(sideray_scene* scene, const sideray_render_options* options,
                                              sideray_plan** plan, sideray_error* error) {
  return create(scene, options, sideray::bridge::Drawing::rays, plan, error);
}

void sideray_plan_release(sideray_plan* plan) {
  delete plan;
}

size_t sideray_plan_pass_count(const sideray_plan* plan) {
  return plan->passes.size();
}

const sideray_plan_pass* sideray_plan_pass_at(const sideray_plan* plan, size_t index) {
  return at(plan->passes, index);
}

uint32_t sideray_plan_layers(const sideray_plan* plan) {
  return plan->layers;
}

float sideray_plan_ray_reuse(const sideray_plan* plan) {
  return plan->ray_reuse;
}

int32_t sideray_plan_ao(const sideray_plan* plan) {
  return plan->ao;
}

int32_t sideray_plan_bounce(const sideray_plan* plan) {
  return plan->bounce;
}

int32_t sideray_plan_reflections(const sideray_plan* plan) {
  return plan->reflections;
}

size_t sideray_plan_texture_count(const sideray_plan* plan) {
  return plan->textures.size();
}

const sideray_plan_texture* sideray_plan_texture_at(const sideray_plan* plan, size_t index) {
  return at(plan->textures, index);
}

const sideray_plan_work* sideray_plan_most_work(const sideray_plan* plan) {
  return &plan->work;
}

sideray_status sideray_plan_scene(sideray_scene* scene, sideray_scene_facts* facts, sideray_error* error) {
  return guarded(error, [&] {
    const auto snapshot = committed(scene);
    sideray::bridge::write_struct(facts, sideray::bridge::scene_facts(*snapshot), "scene facts");
  });
}

float sideray_plan_cull_angle(const sideray_camera* camera, float cull_angle_deg) {
  return camera ? sideray::bridge::cull_angle_deg(*camera, cull_angle_deg) : cull_angle_deg;
}

int32_t sideray_material_is_translucent(const sideray_material_desc* material) {
  return material && sideray::model::is_translucent(*material);
}
