// sideray_plan_*: what the offscreen tier would do.
#include "bridge/api/border.h"
#include "bridge/base/handles.h"
#include "bridge/plan/plan_description.h"

using sideray::bridge::guarded;
using sideray::bridge::require;
using sideray::bridge::require_struct;

struct sideray_plan {
  std::vector<sideray::bridge::PlannedPass> passes;
  std::vector<sideray::bridge::PlannedTexture> textures;
  sideray_plan_work work;
  uint32_t layers;
};

sideray_status sideray_plan_create(sideray_scene* scene, const sideray_render_options* options, sideray_plan** plan,
                                   sideray_error* error) {
  return guarded(error, [&] {
    require(scene, "scene");
    require_struct(options, "render options");
    require(plan, "plan result");
    sideray::bridge::check_options(*options);
    const auto snapshot = scene->scene.snapshot();
    if (!snapshot)
      sideray::fail(SIDERAY_INVALID_ARGUMENT, "scene: nothing is committed; call sideray_scene_commit first");
    const sideray::bridge::FramePlan frame = sideray::bridge::plan_frame(*snapshot, *options);
    auto made = std::make_unique<sideray_plan>();
    made->passes = planned_passes(*snapshot, *options, frame);
    made->textures = planned_textures(*snapshot, *options, frame);
    made->work = planned_work(*snapshot, *options, frame, made->textures);
    made->layers = frame.traces ? frame.layers : 0;
    *plan = made.release();
  });
}

void sideray_plan_release(sideray_plan* plan) {
  delete plan;
}

size_t sideray_plan_pass_count(const sideray_plan* plan) {
  return plan->passes.size();
}

sideray_plan_pass sideray_plan_pass_at(const sideray_plan* plan, size_t index) {
  if (index >= plan->passes.size()) return {};
  const sideray::bridge::PlannedPass& pass = plan->passes[index];
  return {pass.stage, pass.runs, pass.reason.c_str()};
}

uint32_t sideray_plan_layers(const sideray_plan* plan) {
  return plan->layers;
}

size_t sideray_plan_texture_count(const sideray_plan* plan) {
  return plan->textures.size();
}

sideray_plan_texture sideray_plan_texture_at(const sideray_plan* plan, size_t index) {
  if (index >= plan->textures.size()) return {};
  const sideray::bridge::PlannedTexture& t = plan->textures[index];
  return {t.name.c_str(), t.format, t.width, t.height, t.layers, t.bytes(), t.of_service};
}

sideray_plan_work sideray_plan_most_work(const sideray_plan* plan) {
  return plan->work;
}
