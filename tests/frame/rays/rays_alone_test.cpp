// Compares frames drawn by rays without OpenGL with the rasterizer's in exact order.
#include <cmath>

#include "frame/rays/by_rays.h"
#include "scenes/builtin/builtin.h"

namespace sideray::tests {
namespace {

// Everything that the defaults of the program turn on.
Setup whole() {
  Setup setup;
  setup.shadows = SIDERAY_SHADOWS_EXACT;
  setup.oit = SIDERAY_OIT_ABUFFER;
  setup.ao = true;
  setup.reflections = true;
  setup.refraction = true;
  setup.denoise = true;
  setup.ray_reuse = 0x1p-6f;
  setup.layers = 8;
  return setup;
}

// The stack of `crossing` has more sheets than the rasterizer's layers.
TEST(RaysAlone, LookLikeTheRasterizer) {
  struct Case {
    const char* scene;
    double bound;
  };
  for (const Case& c : {Case{"empty", 0.01}, {"panes", 0.01}, {"crossing", 0.012}, {"solids", 0.01}, {"frosted", 0.01},
                        {"haze", 0.01}, {"smoke", 0.01}}) {
    const scenes::Content content = scenes::generate(c.scene, {});
    const double error = flip_of(render(content, by_rays(whole())), render(content, whole()));
    RecordProperty(c.scene, std::to_string(error));
    EXPECT_LT(error, c.bound) << c.scene;
  }
}

// Tests lights and the sky, with masks, and with a ray to each light instead of a shadow map.
TEST(RaysAlone, LightOpaqueSurfacesAsTheRasterizerDoes) {
  const scenes::Content content = scenes::generate("empty", {});
  for (const sideray_shadows shadows : {SIDERAY_SHADOWS_OFF, SIDERAY_SHADOWS_MAP, SIDERAY_SHADOWS_EXACT}) {
    tests::Setup setup;
    setup.translucency = SIDERAY_TRANSLUCENCY_OFF;
    setup.shadows = shadows;
    EXPECT_LT(flip_of(render(content, by_rays(setup)), render(content, setup)), 0.01) << "shadows " << shadows;
  }
}

TEST(RaysAlone, FindTheSurfacesOfTheRasterizer) {
  tests::Setup setup = whole();
  setup.translucency = SIDERAY_TRANSLUCENCY_RAYTRACED;  // every surface counts
  setup.layers = 0;
  setup.aovs = SIDERAY_AOV_Z | SIDERAY_AOV_NORMAL | SIDERAY_AOV_ID | SIDERAY_AOV_MASK;
  const scenes::Content content = scenes::generate("crossing", {});
  const Frame rays = render(content, by_rays(setup)), raster = render(content, setup);
  size_t ids = 0, depths = 0, normals = 0, counts = 0;
  const size_t pixels = raster.planes.at("Z").size();
  for (size_t i = 0; i < pixels; ++i) {
    const bool same = rays.uint_planes.at("id.surface")[i] == raster.uint_planes.at("id.surface")[i] &&
                      rays.uint_planes.at("id.primitive")[i] == raster.uint_planes.at("id.primitive")[i];
    ids += !same;
    counts += rays.uint_planes.at("mask.count")[i] != raster.uint_planes.at("mask.count")[i];
    if (!same) continue;
    const float z = raster.planes.at("Z")[i];
    depths += std::isfinite(z) && std::abs(rays.planes.at("Z")[i] - z) > 1e-3f * z;
    normals += std::abs(rays.planes.at("N.X")[i] - raster.planes.at("N.X")[i]) > 0.01f;
  }
  EXPECT_LT(ids, pixels / 500);
  EXPECT_LT(depths, pixels / 500);
  EXPECT_LT(normals, pixels / 200);
  EXPECT_LT(counts, pixels / 100);  // of sheets that are seen along their edges
}

// Normals are turned toward the eye at silhouettes, where interpolation turns them away.
TEST(RaysAlone, HaveTheNormalsOfTheRasterizer) {
  tests::Setup setup;
  setup.shadows = SIDERAY_SHADOWS_OFF;
  setup.aovs = SIDERAY_AOV_NORMAL | SIDERAY_AOV_ID;
  const scenes::Content content = scenes::generate("empty", {});
  const Frame rays = render(content, by_rays(setup)), raster = render(content, setup);
  for (size_t i = 0; i < raster.planes.at("N.X").size(); ++i) {
    if (rays.uint_planes.at("id.primitive")[i] != raster.uint_planes.at("id.primitive")[i]) continue;
    for (const char* channel : {"N.X", "N.Y", "N.Z"})
      ASSERT_NEAR(rays.planes.at(channel)[i], raster.planes.at(channel)[i], 0.002f) << channel << " at " << i;
  }
}

TEST(RaysAlone, HaveTheSameBitsForAnyNumberOfThreads) {
  expect_same_bits_for_any_threads(by_rays(whole()));
}

// Layers are compared with fragments, and there are none.
TEST(RaysAlone, CheckNoLayers) {
  RenderOptions options;
  options.picture.width = options.picture.height = 16;
  options.translucency->check = 1;
  Renderer renderer = renderer_by_rays();
  const scenes::Content content = scenes::generate("panes", {});
  Scene scene = Scene::create().value();
  scenes::fill(scene, content, std::vector<bool>(content.objects.size(), true));
  const auto picture = renderer.render(scene, content.cameras.at(0).camera, options);
  ASSERT_FALSE(picture);
  EXPECT_EQ(picture.error().status, SIDERAY_UNSUPPORTED);
  EXPECT_NE(std::string(picture.error().message).find("checked against fragments"), std::string::npos);
}

// Draws scenes with the same depth but different shadows by one renderer.
TEST(RaysAlone, KeepNothingOfAnotherScene) {
  scenes::Content content = scenes::generate("empty", {});
  RenderOptions options;
  options.picture.width = 64, options.picture.height = 36;
  options.shadows->method = SIDERAY_SHADOWS_EXACT;
  options.picture.denoise = 0;
  const sideray_camera camera = camera_of(content, {});
  const auto picture_by = [&](Renderer& renderer, Scene& scene) {
    const Picture picture = renderer.render(scene, camera, options).value();
    const auto* red = static_cast<const float*>(picture.channel(0).values);
    return std::vector<float>(red, red + 64 * 36);
  };
  const auto scene_of = [&](bool shadows) {
    Scene scene = Scene::create().value();
    scenes::fill(scene, content, std::vector<bool>(content.objects.size(), true));
    for (size_t i = 0; i < content.objects.size() && !shadows; ++i)
      scene.set_visibility(static_cast<sideray_instance>(i + 1), 0);
    scene.commit();
    return scene;
  };
  Scene dark = scene_of(true), bright = scene_of(false);
  Renderer both = renderer_by_rays(), fresh = renderer_by_rays();
  const std::vector<float> first = picture_by(both, dark), second = picture_by(both, bright);
  EXPECT_NE(first, second);
  EXPECT_EQ(second, picture_by(fresh, bright));
  EXPECT_EQ(first, picture_by(both, dark));
}

}  // namespace
}  // namespace sideray::tests
