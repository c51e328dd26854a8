// Holds the committed scene for all kinds of tracing: acceleration structures, poses, sprites that face the view, and
// the threads. One call at a time; results stay valid until the next call that changes them.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "model/snapshot.h"
#include "rt/base/executor.h"
#include "rt/base/tracer_config.h"
#include "rt/base/view.h"
#include "rt/embree/intersector.h"
#include "rt/poses/angle_cull.h"
#include "rt/poses/foliage.h"
#include "rt/surfaces/surface.h"
#include "rt/textures/environment_sampler.h"
#include "rt/textures/sky_directions.h"

namespace sideray::rt {

class TracedScene {
 public:
  explicit TracedScene(const TracerConfig& config);

  // As Tracer's functions of the same names.
  void set_scene(std::shared_ptr<const model::Snapshot> snapshot);
  void set_foliage(const FoliageOptions& options);
  void set_glass_shadows(bool on);
  const FoliageOptions& foliage() const { return options_; }
  const std::vector<uint8_t>& culled();
  double update_ms() const { return update_ms_; }

  // Returns the scene in its current poses, after updating it. Throws Failure if nothing is committed.
  const ShadingScene& shading();
  // Returns the scene as committed, without poses.
  const std::shared_ptr<const model::Snapshot>& committed() const { return committed_; }
  // Builds the sprites' quads for a view. They stay until another view or scene; other rays do not hit them.
  void place_sprites(const TraceView& view, uint32_t height);
  // Is made on first use, because most tracers never need it.
  const EnvironmentSampler& environment();
  // Is made on first use too.
  const SkyDirections& sky();

  Executor& executor() { return executor_; }
  const Intersector& intersector() const { return intersector_; }

 private:
  void take(std::shared_ptr<const model::Snapshot> snapshot);
  void light(const std::shared_ptr<const model::Snapshot>& snapshot);  // makes scene_

  Executor executor_;
  Intersector intersector_;
  std::shared_ptr<const model::Snapshot> committed_;
  FoliageOptions options_, taken_;  // as requested, and as in the acceleration structures
  bool stale_ = false;              // they differ
  bool glass_shadows_ = true;
  Foliage foliage_;
  AngleCull cull_;
  std::shared_ptr<const model::Snapshot> posed_;  // the committed scene in the foliage's poses
  std::unique_ptr<const ShadingScene> scene_;     // of posed_, or of posed_ with quads
  TraceView quads_view_{};                        // the view that the quads face
  uint32_t quads_height_ = 0;                     // 0 = no quads
  std::shared_ptr<const EmittersWhenUsed> emitters_;
  std::unique_ptr<const EnvironmentSampler> environment_;
  std::unique_ptr<const SkyDirections> sky_;
  double update_ms_ = 0.0;
};

}  // namespace sideray::rt
