// Light adds up: with thousands of lights a picture is the sum of those with a few of them each.
#include <gtest/gtest.h>

#include "model/failure.h"
#include "rt/tracer_scene.h"

namespace sideray::rt::test {
namespace {

constexpr uint32_t size = 6;

std::vector<sideray_light> lights_above(size_t count) {
  std::vector<sideray_light> lights;
  for (size_t i = 0; i < count; ++i) {
    const auto x = static_cast<float>(i % 64), z = static_cast<float>(i / 64);
    sideray_light light = point_light({x / 16.0f - 2.0f, 3.0f, z / 16.0f - 2.0f}, 40.0f / static_cast<float>(count));
    for (float& c : light.intensity) c *= 0.5f + static_cast<float>(i % 7) / 7.0f;
    lights.push_back(light);
  }
  return lights;
}

struct Pictures {
  std::vector<glm::vec4> reference;
  std::vector<glm::vec3> layers;
};

// A floor seen from above through a pane, both lit; a bar between them and the lights casts shadows.
Pictures pictures_of(const std::vector<sideray_light>& lights) {
  TestScene scene;
  scene.quad({0, 0, 0}, {3, 0, 0}, {0, 0, -3}, plain_material());
  scene.quad({0, 1, 0}, {3, 0, 0}, {0, 0, -3}, blended({0.8f, 0.6f, 0.4f}, 0.5f));
  scene.quad({0.5f, 2, 0}, {0.4f, 0, 0}, {0, 0, -3}, plain_material());
  scene.lights(lights);
  Tracer tracer({.threads = 2, .isa = ""});
  tracer.set_scene(scene.commit());
  const TraceView view = perspective({0, 1.8, 1.5}, {0, 0, 0}, 1.2, 1.0);
  ReferenceRequest request;
  request.views = {view};
  request.width = request.height = size;
  request.light_samples = 1;
  ReferenceImage image;
  tracer.trace_reference(request, image);
  TestFrame frame(view, size, size, 1);
  LayerCache cache;
  tracer.trace_cache(frame.get(), cache);
  Pictures pictures{image.color, {}};
  for (size_t i = 0; i < size_t{size} * size; ++i) pictures.layers.push_back(rgb(cache.radiance, i));
  return pictures;
}

void expect_sum(size_t count, size_t groups) {
  const std::vector<sideray_light> all = lights_above(count);
  const Pictures whole = pictures_of(all);
  std::vector<glm::vec3> reference(size_t{size} * size, glm::vec3(0)), layers(reference);
  for (size_t g = 0; g < groups; ++g) {
    const auto begin = all.begin() + static_cast<ptrdiff_t>(g * count / groups);
    const auto end = all.begin() + static_cast<ptrdiff_t>((g + 1) * count / groups);
    const Pictures part = pictures_of({begin, end});
    for (size_t i = 0; i < reference.size(); ++i) {
      reference[i] += glm::vec3(part.reference[i]);
      layers[i] += part.layers[i];
    }
  }
  float brightest = 0.0f;
  for (size_t i = 0; i < reference.size(); ++i)
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(whole.reference[i][c], reference[i][c], 1e-4f * std::max(reference[i][c], 0.01f)) << i;
      EXPECT_NEAR(whole.layers[i][c], layers[i][c], 1e-3f * std::max(layers[i][c], 0.01f)) << i;  // halfs
      brightest = std::max(brightest, whole.reference[i][c]);
    }
  EXPECT_GT(brightest, 0.1f);
}

TEST(ManyLights, ThreeHundredAddUp) {
  expect_sum(300, 3);
}

TEST(ManyLights, FourThousandAddUp) {
  expect_sum(4096, 16);
}

TEST(ManyLights, MoreAreRefused) {
  model::Scene scene;
  const std::vector<sideray_light> lights = lights_above(4097);
  EXPECT_THROW(scene.set_lights(lights.data(), lights.size()), Failure);
}

}  // namespace
}  // namespace sideray::rt::test
