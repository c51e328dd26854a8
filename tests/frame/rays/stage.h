// Draws a scene repeatedly, with statistics and plan, for tests of rays that are saved.
#pragma once

#include <sideray/plan.h>

#include <string>
#include <vector>

#include "frame/frame.h"
#include "scenes/builtin/builtin.h"

namespace sideray::tests {

constexpr uint32_t stage_width = 64, stage_height = 36;

// One scene drawn again and again by one renderer.
class Stage {
 public:
  explicit Stage(const scenes::Content& content, uint32_t threads = 0) : renderer_(with_threads(threads)) {
    const scenes::Sky sky = scenes::sky();
    scene_.set_environment(sky.width, sky.height, sky.rgb.data(), 1.0f, 0.0f);
    camera_ = camera_of(content, {.width = stage_width, .height = stage_height});
    scenes::fill(scene_, content, scenes::select_ray_traced(content, "all", camera_, stage_width, stage_height));
  }

  struct Drawn {
    std::vector<float> rgb;
    sideray_render_stats stats;
    uint64_t rays() const { return stats.rays_primary + stats.rays_reflection + stats.rays_shadow; }
  };
  // Only counted pictures have statistics.
  Drawn draw(RenderOptions options, bool counted) {
    options.picture.width = stage_width;
    options.picture.height = stage_height;
    options.picture.repeats = counted ? 1 : 0;
    const Picture picture = renderer_.render(scene_, camera_, options).value();
    Drawn drawn{{}, picture.stats()};
    for (size_t i = 0; i < picture.channel_count(); ++i) {
      const sideray_channel channel = picture.channel(i);
      const std::string name = channel.name;
      if (name != "R" && name != "G" && name != "B") continue;
      const auto* values = static_cast<const float*>(channel.values);
      drawn.rgb.insert(drawn.rgb.end(), values, values + size_t{stage_width} * stage_height);
    }
    return drawn;
  }

  struct Planned {
    float ray_reuse;
    std::string reason;  // of the trace
  };
  Planned plan(const RenderOptions& options) const {
    const sideray_render_options given = options.c();
    sideray_plan* plan = nullptr;
    check([&](sideray_error* error) { return sideray_plan_create(scene_.get(), &given, &plan, error); });
    const Planned planned{sideray_plan_ray_reuse(plan), sideray_plan_pass_at(plan, SIDERAY_STAGE_TRACE)->reason};
    sideray_plan_release(plan);
    return planned;
  }
  Scene& scene() { return scene_; }

 private:
  static Renderer with_threads(uint32_t threads) {
    sideray_renderer_desc desc = sideray_renderer_defaults();
    desc.threads = threads;
    return Renderer::create(desc).value();
  }

  Renderer renderer_;
  Scene scene_ = Scene::create().value();
  sideray_camera camera_{};
};

}  // namespace sideray::tests
