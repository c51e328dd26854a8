#include "gl/scene/shadow_plan.h"

#include <gtest/gtest.h>

#include <set>

#include "elementary/functions.h"
#include "gl/scene/tint_maps.h"

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

TEST(ShadowPlan, a_spot_of_sixty_degrees_has_one_map) {
  model::Light light = light_of(SIDERAY_LIGHT_SPOT);
  light.cos_outer = elementary::cos(glm::radians(60.0f));
  EXPECT_EQ(plan_shadow_maps({light}, one_caster(), {}).lights[0].map, ShadowMap::frustum);
  light.cos_outer = elementary::cos(glm::radians(61.0f));
  EXPECT_EQ(plan_shadow_maps({light}, one_caster(), {}).lights[0].map, ShadowMap::faces);
}

// Shadow rays end at the light's sphere: maps lack what lies well inside, and have all that lies outside.
TEST(ShadowPlan, maps_begin_inside_the_lights_sphere) {
  constexpr float radius = 0.5f;
  for (const sideray_light_type type : {SIDERAY_LIGHT_POINT, SIDERAY_LIGHT_SPOT}) {
    model::Light light = light_of(type);
    light.radius = radius;
    const glm::mat4 down_clip = [&] {
      const ShadowPlan plan = plan_shadow_maps({light}, one_caster(), {true, 256, 16384});
      const std::vector<glm::mat4>& all = plan.lights[0].clip_from_local;
      return all.size() == 1 ? all[0] : all[3];
    }();
    const auto is_in_front = [&](glm::vec3 p) {
      const glm::vec4 clip = down_clip * glm::vec4(p, 1);
      return clip.z > clip.w;
    };
    EXPECT_TRUE(is_in_front({0, -0.5f * radius, 0}));
    for (const float slope : {0.0f, type == SIDERAY_LIGHT_POINT ? 1.0f : 0.52f})
      EXPECT_FALSE(is_in_front(radius * glm::normalize(glm::vec3(slope, -1, slope)))) << slope;
  }
}

TEST(TintMaps, many_layers_have_smaller_sides) {
  EXPECT_EQ(TintMaps::side_of(1024, 32), 512u);
  for (const uint32_t layers : {33u, 48u, 2048u}) {
    const uint64_t side = TintMaps::side_of(1024, layers);
    EXPECT_GE(side, 64u);
    EXPECT_LE(side * side * layers * 8, uint64_t{64} << 20);
  }
}

}  // namespace
}  // namespace sideray::gl
