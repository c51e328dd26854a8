// Compares the raster look without OpenGL with the rasterizer's in exact order, and tests layers without OpenGL.
#include <cmath>

#include "frame/rays/by_rays.h"
#include "scenes/builtin/builtin.h"

namespace sideray::tests {
namespace {

Setup raster_look() {
  Setup setup;
  setup.translucency = SIDERAY_TRANSLUCENCY_RASTER;
  setup.oit = SIDERAY_OIT_ABUFFER;
  setup.refraction = true;
  return setup;
}

// Most of the difference lies at edges and texels of opaque surfaces: without its glass `solids` has FLIP .017, `haze`
// .018. Maps tint a pane by all other panes of its texel, rays only by panes toward the light: `panes` differs by .0375
// and `crossing` by .0586.
TEST(RasterLookByRays, LooksLikeTheRasterizer) {
  struct Case {
    const char* scene;
    double bound;
  };
  for (const Case& c : {Case{"panes", 0.045}, {"crossing", 0.065}, {"solids", 0.02}, {"frosted", 0.01}, {"haze", 0.022},
                        {"smoke", 0.015}}) {
    const scenes::Content content = scenes::generate(c.scene, {});
    const double error = flip_of(render(content, by_rays(raster_look())), render(content, raster_look()));
    RecordProperty(c.scene, std::to_string(error));
    EXPECT_LT(error, c.bound) << c.scene;
  }
}

// Rough glass reads coarse mip levels, and dispersion separates red and blue from green.
TEST(RasterLookByRays, BendsAndBlursAsTheRasterizerDoes) {
  tests::Setup straight = by_rays(raster_look());
  straight.refraction = false;
  for (const scenes::Settings& given : {scenes::Settings{{"roughness", "0.4"}}, {{"dispersion", "5"}}, {{"ior", "2"}}}) {
    const scenes::Content content = scenes::generate("solids", given);
    const Frame raster = render(content, raster_look()), rays = render(content, by_rays(raster_look()));
    EXPECT_LT(flip_of(rays, raster), 0.02) << given.begin()->first;
    EXPECT_GT(flip_of(render(content, straight), raster), 0.05) << given.begin()->first;
  }
}

TEST(RasterLookByRays, IsThatOfHybridWithoutLayers) {
  const scenes::Content content = scenes::generate("solids", {});
  tests::Setup hybrid = by_rays(raster_look());
  hybrid.translucency = SIDERAY_TRANSLUCENCY_HYBRID;
  hybrid.layers = 0;
  expect_same_bits(render(content, by_rays(raster_look())), render(content, hybrid), "no layers");
}

TEST(RasterLookByRays, HasTheSameBitsForAnyNumberOfThreads) {
  expect_same_bits_for_any_threads(by_rays(raster_look()));
}

// Surfaces are in exact order; a refracting one is the last of its pixel, and holds everything behind it.
TEST(LayersByRays, AreThoseOfTheCache) {
  for (const char* scene : {"crossing", "solids"}) {
    tests::Setup setup;
    setup.refraction = true;
    setup.mask = SIDERAY_NO_MASK;
    setup.aovs = SIDERAY_AOV_LAYERS;
    const scenes::Content content = scenes::generate(scene, {});
    const Frame rays = render(content, by_rays(setup)), raster = render(content, setup);
    for (uint32_t layer = 0; layer < setup.layers; ++layer) {
      const std::string name = "layer" + std::to_string(layer);
      const std::vector<uint32_t>&a = rays.uint_planes.at(name + ".surface"), &b = raster.uint_planes.at(name + ".surface");
      const std::vector<float>&red = rays.planes.at(name + ".R"), &red_there = raster.planes.at(name + ".R");
      size_t surfaces = 0, colors = 0;
      for (size_t i = 0; i < a.size(); ++i) {
        surfaces += a[i] != b[i];
        colors += a[i] == b[i] && std::abs(red[i] - red_there[i]) > 0.02f + 0.05f * std::abs(red_there[i]);
      }
      EXPECT_LT(surfaces, a.size() / 200) << scene << ", " << name;
      EXPECT_LT(colors, a.size() / 50) << scene << ", " << name;
    }
  }
}

// The picture is the same with and without the output of layers.
TEST(LayersByRays, ChangeNothingElse) {
  const scenes::Content content = scenes::generate("solids", {});
  tests::Setup setup = by_rays({});
  const Frame alone = render(content, setup);
  setup.aovs = SIDERAY_AOV_LAYERS;
  const Frame shown = render(content, setup);
  for (const char* channel : {"R", "G", "B", "A"}) EXPECT_EQ(alone.planes.at(channel), shown.planes.at(channel));
}

// Without colours only traced channels are output.
TEST(LayersByRays, ComeWithoutColoursToo) {
  const scenes::Content content = scenes::generate("panes", {});
  Renderer renderer = renderer_by_rays();
  Scene scene = Scene::create().value();
  scenes::fill(scene, content, std::vector<bool>(content.objects.size(), true));
  RenderOptions options;
  options.picture.width = 32, options.picture.height = 18;
  options.picture.aovs = SIDERAY_AOV_LAYERS | SIDERAY_AOV_MASK;
  options.picture.without_color = 1;
  for (const sideray_translucency method : {SIDERAY_TRANSLUCENCY_HYBRID, SIDERAY_TRANSLUCENCY_RASTER}) {
    options.translucency->method = method;
    const Picture picture = renderer.render(scene, content.cameras.at(0).camera, options).value();
    bool has_layers = false, has_colors = false;
    for (size_t i = 0; i < picture.channel_count(); ++i) {
      has_layers |= std::string_view(picture.channel(i).name).starts_with("layer0");
      has_colors |= std::string_view(picture.channel(i).name) == "R";
    }
    EXPECT_EQ(has_layers, method == SIDERAY_TRANSLUCENCY_HYBRID);
    EXPECT_FALSE(has_colors);
  }
}

}  // namespace
}  // namespace sideray::tests
