#include "rt/scene/traced_scene.h"

#include <span>
#include <utility>

#include "model/failure.h"
#include "model/stopwatch.h"
#include "rt/light/emitters.h"
#include "rt/poses/particle_quads.h"
#include "rt/surfaces/media.h"

namespace sideray::rt {

TracedScene::TracedScene(const TracerConfig& config) : executor_(config.threads), intersector_(config.isa) {}

void TracedScene::set_scene(std::shared_ptr<const model::Snapshot> snapshot) {
  if (scene_ && committed_ == snapshot && !stale_) return;
  take(std::move(snapshot));
}

void TracedScene::set_foliage(const FoliageOptions& options) {
  if (options == options_) return;  // without a write, because tracers that share the scene may call this at the same
                                    // time
  options_ = options;
  stale_ = options != taken_;
}

void TracedScene::take(std::shared_ptr<const model::Snapshot> snapshot) {
  const Stopwatch watch;
  const bool keeps_poses = scene_ && snapshot == committed_ && options_.poses == taken_.poses;
  const bool culls_anew =
      cull_.update(*snapshot, options_.cull_angle_deg, options_.eye, executor_, options_.cull);
  if (!keeps_poses || culls_anew) {
    // If something below throws, there is no scene, and the next call builds it again.
    scene_.reset();
    committed_ = snapshot;
    stale_ = true;
    quads_height_ = 0;
    if (!keeps_poses) posed_ = foliage_.pose(snapshot, options_, executor_);
    const SceneUpdate update{keeps_poses ? std::span<const PosedMesh>() : foliage_.posed(), cull_.culled(),
                             &executor_};
    executor_.inside([&] { intersector_.set_scene(posed_, update); });
    light(posed_);
  }
  taken_ = options_;
  stale_ = false;
  update_ms_ = watch.ms();
}

void TracedScene::set_glass_shadows(bool on) {
  if (std::exchange(glass_shadows_, on) != on && scene_) light(scene_->snapshot);
}

void TracedScene::light(const std::shared_ptr<const model::Snapshot>& snapshot) {
  auto scene = glass_shadows_ ? lit_scene(snapshot) : std::make_unique<ShadingScene>(snapshot);
  if (!emitters_ || !emitters_->serves(*snapshot)) emitters_ = std::make_shared<const EmittersWhenUsed>(snapshot);
  scene->emitters = emitters_;
  scene_ = std::move(scene);
}

const std::vector<uint8_t>& TracedScene::culled() {
  shading();
  return cull_.culled();
}

const ShadingScene& TracedScene::shading() {
  if (stale_ && committed_) take(committed_);
  if (!scene_)
    fail(SIDERAY_INVALID_ARGUMENT, "trace: the scene has no commit yet; call sideray_scene_commit first");
  return *scene_;
}

void TracedScene::place_sprites(const TraceView& view, uint32_t height) {
  if (!has_sprites(*shading().snapshot)) return;
  const bool placed = quads_height_ == height && quads_view_.clip_from_local == view.clip_from_local &&
                      quads_view_.local_from_clip == view.local_from_clip;
  if (placed) return;
  const auto derived = with_sprite_quads(*posed_, view, height);
  executor_.inside([&] { intersector_.set_scene(derived, {.posed = {}, .culled = cull_.culled()}); });
  light(derived);
  quads_view_ = view;
  quads_height_ = height;
}

const EnvironmentSampler& TracedScene::environment() {
  const std::shared_ptr<const model::Environment>& wanted = shading().snapshot->environment;
  if (!environment_ || environment_->environment() != wanted)
    environment_ = std::make_unique<const EnvironmentSampler>(wanted);
  return *environment_;
}

const SkyDirections& TracedScene::sky() {
  const std::shared_ptr<const model::Environment>& wanted = shading().snapshot->environment;
  if (!sky_ || sky_->environment() != wanted) sky_ = std::make_unique<const SkyDirections>(wanted);
  return *sky_;
}

}  // namespace sideray::rt
