// The culling of casters against what it promises: nothing between a light and a point that is seen is left out.
#include "gl/scene/shadow_casters.h"

#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>
#include <random>

namespace sideray::gl::shadow_casters_test {
namespace {

struct Numbers {
  std::mt19937 random{7};
  float in(float low, float high) { return low + (high - low) * static_cast<float>(random() >> 8) * 0x1p-24f; }
  glm::vec3 point(const model::Bounds& b) {
    return {in(b.minimum.x, b.maximum.x), in(b.minimum.y, b.maximum.y), in(b.minimum.z, b.maximum.z)};
  }
};

model::Bounds box(glm::vec3 minimum, glm::vec3 maximum) {
  model::Bounds bounds;
  bounds.add(minimum);
  bounds.add(maximum);
  return bounds;
}

const model::Bounds room = box(glm::vec3(-10), glm::vec3(10));

model::Light light_at(sideray_light_type type, glm::vec3 position, float range) {
  model::Light light{};
  light.type = type;
  light.position = position;
  light.direction = {0, -1, 0};
  light.intensity = glm::vec3(1);
  light.range = range;
  light.cos_outer = -1.0f;
  return light;
}

glm::dmat4 view_from(glm::dvec3 eye, glm::dvec3 target) {
  return glm::perspective(0.9, 1.5, 0.1, 100.0) * glm::lookAt(eye, target, glm::dvec3(0, 1, 0));
}

bool is_seen(const glm::dmat4& clip_from_local, glm::vec3 p) {
  const glm::dvec4 clip = clip_from_local * glm::dvec4(p, 1.0);
  return clip.w > 0 && std::abs(clip.x) < clip.w && std::abs(clip.y) < clip.w;
}

TEST(ShadowCasters, nothing_between_a_light_and_a_seen_point_is_left_out) {
  Numbers numbers;
  const LightShadow shadow;  // its texels have no size, so that no slack hides a mistake
  int checked = 0, left_out = 0;
  for (int scene = 0; scene < 400; ++scene) {
    const bool directional = scene % 4 == 0;
    model::Light light = light_at(directional ? SIDERAY_LIGHT_DIRECTIONAL : SIDERAY_LIGHT_POINT, numbers.point(room),
                                  scene % 3 == 0 ? numbers.in(1, 15) : 0.0f);
    light.direction = glm::normalize(numbers.point(room));
    const glm::dmat4 clip_from_local = view_from(numbers.point(room), numbers.point(room));
    const ShadowCasters casters(light, shadow, make_receivers(clip_from_local, room));
    for (int i = 0; i < 200; ++i) {
      const glm::vec3 seen = numbers.point(room);
      if (!is_seen(clip_from_local, seen)) continue;
      if (!directional && light.range > 0 && glm::length(seen - light.position) > light.range) continue;
      const glm::vec3 from = directional ? seen - 30.0f * light.direction : light.position;
      const glm::vec3 between = glm::mix(from, seen, numbers.in(0, 0.999f));
      const glm::vec3 low(numbers.in(0, 1)), high(numbers.in(0, 1));
      EXPECT_TRUE(casters.may_matter(box(between - low, between + high))) << "scene " << scene;
      ++checked;
      const glm::vec3 elsewhere = numbers.point(room);
      left_out += !casters.may_matter(box(elsewhere, elsewhere + glm::vec3(0.5f)));
    }
  }
  EXPECT_GT(checked, 2000);
  EXPECT_GT(left_out, checked / 4) << "it would be no culling";
}

// The eye at the origin looks along -z.
TEST(ShadowCasters, what_lies_off_every_way_to_what_is_seen_is_left_out) {
  const Receivers receivers = make_receivers(view_from({0, 0, 0}, {0, 0, -1}), room);
  const model::Bounds behind = box({-1, -1, 4}, {1, 1, 5}), ahead = box({-1, -1, -5}, {1, 1, -4});
  const ShadowCasters lamp(light_at(SIDERAY_LIGHT_POINT, {0, 0, 1}, 0), {}, receivers);
  EXPECT_FALSE(lamp.may_matter(behind));
  EXPECT_TRUE(lamp.may_matter(ahead));
  const ShadowCasters from_behind(light_at(SIDERAY_LIGHT_POINT, {0, 0, 8}, 0), {}, receivers);
  EXPECT_TRUE(from_behind.may_matter(behind));
  const ShadowCasters candle(light_at(SIDERAY_LIGHT_POINT, {0, 0, 1}, 3), {}, receivers);
  EXPECT_FALSE(candle.may_matter(ahead)) << "out of range";
  const ShadowCasters sun(light_at(SIDERAY_LIGHT_DIRECTIONAL, {0, 0, 0}, 0), {}, receivers);
  EXPECT_TRUE(sun.may_matter(box({-1, 20, -5}, {1, 21, -4}))) << "above what is seen, and the sun above it";
  EXPECT_FALSE(sun.may_matter(box({-1, -21, -5}, {1, -20, -4}))) << "below the floor";
}

}  // namespace
}  // namespace sideray::gl::shadow_casters_test
