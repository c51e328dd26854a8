#include "gl/scene/shadow_plan.h"

#include <gtest/gtest.h>

#include <set>

namespace sideray::gl {
namespace {

model::Light light_of(sideray_light_type type) {
  model::Light light{};
  light.type = type;
  light.direction = {0, -1, 0};
  light.intensity = glm::vec3(1);
  light.cos_outer = 0.8f;
  return light;
}

std::vector<model::Bounds> one_caster() {
  model::Bounds bounds;
  bounds.add({-1, -3, -1});
  bounds.add({2, -1, 5});
  return {bounds};
}

TEST(ShadowPlan, many_lights_stay_within_memory_and_layers) {
  const std::vector<model::Light> lights(256, light_of(SIDERAY_LIGHT_POINT));
  const ShadowPlan plan = plan_shadow_maps(lights, one_caster(), {true, 2048, 16384});
  EXPECT_EQ(plan.local_layers, 256u * 6);
  EXPECT_LE(uint64_t{plan.local_size} * plan.local_size * plan.local_layers * 4, uint64_t{256} << 20);
  const ShadowPlan few = plan_shadow_maps(lights, one_caster(), {true, 256, 16384});
  EXPECT_EQ(few.local_layers, 42u * 6);
  EXPECT_EQ(few.lights[41].map, ShadowMap::faces);
  EXPECT_EQ(few.lights[42].map, ShadowMap::none);
}

TEST(ShadowPlan, nothing_that_casts_needs_no_map) {
  const ShadowPlan plan = plan_shadow_maps({light_of(SIDERAY_LIGHT_DIRECTIONAL)}, {}, {});
  EXPECT_EQ(plan.directional_layers + plan.local_layers, 0u);
  EXPECT_EQ(plan.lights[0].map, ShadowMap::none);
}

// Every corner of the caster falls inside the map, with a depth between the clip planes, nearer to the light = nearer.
TEST(ShadowPlan, maps_hold_their_casters) {
  const model::Bounds caster = one_caster()[0];
  for (const bool reversed : {false, true})
    for (const sideray_light_type type : {SIDERAY_LIGHT_DIRECTIONAL, SIDERAY_LIGHT_POINT}) {
      const ShadowPlan plan = plan_shadow_maps({light_of(type)}, {caster}, {reversed, 256, 16384});
      const LightShadow& shadow = plan.lights[0];
      EXPECT_EQ(shadow.clip_from_local.size(), type == SIDERAY_LIGHT_POINT ? 6u : 1u);
      for (int corner = 0; corner < 8; ++corner) {
        const glm::vec4 p((corner & 1) ? caster.maximum.x : caster.minimum.x,
                          (corner & 2) ? caster.maximum.y : caster.minimum.y,
                          (corner & 4) ? caster.maximum.z : caster.minimum.z, 1);
        int inside = 0;
        for (const glm::mat4& m : shadow.clip_from_local) {
          const glm::vec4 clip = m * p;
          if (clip.w <= 0 || std::abs(clip.x) > clip.w || std::abs(clip.y) > clip.w) continue;
          ++inside;
          EXPECT_GE(clip.z, reversed ? 0.0f : -clip.w);
          EXPECT_LE(clip.z, clip.w);
          const glm::vec4 nearer =
              m * (p + glm::vec4(type == SIDERAY_LIGHT_POINT ? -0.1f * glm::vec3(p) : glm::vec3(0, 0.1f, 0), 0));
          EXPECT_EQ(nearer.z / nearer.w > clip.z / clip.w, reversed);
        }
        EXPECT_GE(inside, 1);
      }
    }
}

}  // namespace
}  // namespace sideray::gl
