// The sky's light on opaque pixels by masks and by light that bounces: every lobe has its share of it.
#include <gtest/gtest.h>

#include <vector>

#include "rt/drawing/opaque_light.h"
#include "rt/tracer_scene.h"

namespace sideray::rt::opaque_light_test {
namespace {

using namespace test;

constexpr uint32_t side = 8;
constexpr uint16_t one_as_half = 0x3c00;

// What a wall of a material shows under a white sky of which a share is open, where nothing is thrown back.
glm::vec3 seen(const sideray_material_desc& material, uint8_t open) {
  TestScene scene;
  scene.quad({0, 0, 0}, {9, 0, 0}, {0, 9, 0}, material);
  scene.environment(glm::vec3(1.0f));
  Tracer tracer({1, ""});
  tracer.set_scene(scene.commit());
  const TraceView view = perspective({0.5, 0.3, 3}, {0, 0, 0}, 0.6, 1.0);
  OpaquePixels pixels;
  tracer.trace_opaque({.view = view, .width = side, .height = side}, pixels);
  OcclusionMasks masks;
  masks.width = masks.height = side;
  masks.open.assign(side * side, open);
  IrradianceImage bounced;
  bounced.width = bounced.height = side;
  for (uint32_t i = 0; i < side * side; ++i) bounced.light.insert(bounced.light.end(), {0, 0, 0, one_as_half});
  const OpaqueLightRequest request{.view = view, .pixels = &pixels, .masks = &masks, .sky = true, .bounced = &bounced};
  std::vector<glm::vec4> picture;
  tracer.light_opaque(request, picture);
  return glm::vec3(picture[side * side / 2]);
}

TEST(OpaqueLight, EveryLobeHasTheOpenShareOfTheSky) {
  sideray_material_desc plain = plain_material(), coated = plain, thin = plain, metal = plain;
  coated.clearcoat = 1.0f, coated.clearcoat_roughness = 0.5f;
  thin.diffuse_transmission = 0.7f;
  metal.metallic = 1.0f, metal.roughness = 0.5f;
  for (const sideray_material_desc& material : {plain, coated, thin, metal}) {
    const glm::vec3 all = seen(material, 255), some = seen(material, 51);
    EXPECT_GT(all.x, 0.3f);
    EXPECT_NEAR(some.x, 0.2f * all.x, 1e-4f);
    EXPECT_EQ(seen(material, 0), glm::vec3(0.0f));
  }
}

}  // namespace
}  // namespace sideray::rt::opaque_light_test
