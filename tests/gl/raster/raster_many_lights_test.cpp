// More lights than uniform blocks hold: the picture is the sum of those with a few of them each, shadow maps included.
#include "gl/raster/raster_scene_builder.h"

namespace sideray::gl::tests {
namespace {

std::vector<sideray_light> lights_above(size_t count) {
  std::vector<sideray_light> lights(count);
  for (size_t i = 0; i < count; ++i) {
    sideray_light& light = lights[i];
    light.size = sizeof(light);
    light.type = i % 3 == 0 ? SIDERAY_LIGHT_SPOT : i % 3 == 1 ? SIDERAY_LIGHT_POINT : SIDERAY_LIGHT_DIRECTIONAL;
    light.position[0] = static_cast<double>(i % 64) / 16.0 - 2.0;
    light.position[1] = static_cast<double>(i / 64) / 16.0 - 2.0;
    light.position[2] = 3.0;
    light.direction[0] = 0.1f * static_cast<float>(i % 5);
    light.direction[2] = -1.0f;
    light.outer_cone = 0.7f;
    const float share = (i % 3 == 2 ? 2.0f : 20.0f) / static_cast<float>(count);
    for (float& c : light.intensity) c = share * (0.5f + static_cast<float>(i % 7) / 7.0f);
  }
  return lights;
}

struct RasterManyLights : RasterTest {
  void SetUp() override {
    width = 24;
    height = 16;
    RasterTest::SetUp();
  }

  std::vector<glm::vec4> picture(const std::vector<sideray_light>& lights, bool shadows) {
    SceneBuilder builder;
    const uint32_t white = builder.material(plain_material());
    builder.quad(white, {0, 0, 0}, 3, 1);
    builder.quad(white, {0.3, 0.2, 1.0}, 0.4, 2);
    builder.scene.set_lights(lights.data(), lights.size());
    draw_opaque(builder.commit(), camera_at({0, 0, 4}), shadows);
    return rasterizer->read_color();
  }

  void expect_sum(size_t count, size_t groups, bool shadows) {
    const std::vector<sideray_light> all = lights_above(count);
    const std::vector<glm::vec4> whole = picture(all, shadows);
    std::vector<glm::vec3> sum(whole.size(), glm::vec3(0));
    for (size_t g = 0; g < groups; ++g) {
      const auto begin = all.begin() + static_cast<ptrdiff_t>(g * count / groups);
      const auto end = all.begin() + static_cast<ptrdiff_t>((g + 1) * count / groups);
      const std::vector<glm::vec4> part = picture({begin, end}, shadows);
      for (size_t i = 0; i < sum.size(); ++i) sum[i] += glm::vec3(part[i]);
    }
    float brightest = 0.0f;
    for (size_t i = 0; i < sum.size(); ++i)
      for (int c = 0; c < 3; ++c) {
        // The pictures are of halfs.
        ASSERT_NEAR(whole[i][c], sum[i][c], 2e-3f * std::max(sum[i][c], 0.05f)) << i;
        brightest = std::max(brightest, whole[i][c]);
      }
    EXPECT_GT(brightest, 0.1f);
  }
};

TEST_F(RasterManyLights, three_hundred_add_up) {
  expect_sum(300, 3, false);
}

TEST_F(RasterManyLights, four_thousand_add_up) {
  expect_sum(4096, 16, false);
}

// Few enough that each has a map as large alone as together.
TEST_F(RasterManyLights, shadow_maps_work_beside_lights_without) {
  std::vector<sideray_light> lights = lights_above(3);
  const std::vector<glm::vec4> few = picture(lights, true);
  lights.resize(300, lights[0]);
  for (size_t i = 3; i < lights.size(); ++i)
    for (float& c : lights[i].intensity) c = 0.0f;
  EXPECT_EQ(picture(lights, true), few);
  lights.resize(3);
  EXPECT_EQ(picture(lights, true), few) << "back to blocks";
}

}  // namespace
}  // namespace sideray::gl::tests
