// Frames that rays draw without OpenGL, beside the rasterizer's in exact order.
#include <cmath>

#include "frame/frame.h"
#include "lab/metrics/metrics.h"
#include "scenes/builtin/builtin.h"

namespace sideray::tests {
namespace {

scenes::Image picture_of(const Frame& f) {
  scenes::Image image{f.width, f.height, {}, true};
  for (const char* name : {"R", "G", "B"})
    image.planes.push_back({name, scenes::Plane::Type::single, f.planes.at(name), {}});
  return image;
}

double flip_of(const Frame& test, const Frame& reference) {
  return lab::compare(picture_of(test), picture_of(reference)).metrics.flip.value();
}

Setup by_rays(Setup setup) {
  setup.gl = "none";
  return setup;
}

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

// Software OpenGL filters texels with eight bits: of a textured wall that nothing is before, it alone makes FLIP .013. The stack of `crossing` has more sheets than the rasterizer's layers.
TEST(RaysAlone, LookLikeTheRasterizer) {
  struct Case {
    const char* scene;
    double bound;
  };
  for (const Case& c : {Case{"empty", 0.01}, {"panes", 0.015}, {"crossing", 0.015}, {"solids", 0.015}, {"frosted", 0.01},
                        {"haze", 0.022}, {"smoke", 0.015}}) {
    const scenes::Content content = scenes::generate(c.scene, {});
    const double error = flip_of(render(content, by_rays(whole())), render(content, whole()));
    RecordProperty(c.scene, std::to_string(error));
    EXPECT_LT(error, c.bound) << c.scene;
  }
}

// Of lights and the sky: with masks, and with a ray to each light in place of a shadow map.
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

void expect_same_bits(const Frame& a, const Frame& b, const std::string& what) {
  for (const auto& [name, plane] : a.planes) EXPECT_EQ(plane, b.planes.at(name)) << what << ", " << name;
}

TEST(RaysAlone, HaveTheSameBitsForAnyNumberOfThreads) {
  for (const char* scene : {"solids", "smoke"}) {
    const scenes::Content content = scenes::generate(scene, {});
    tests::Setup setup = by_rays(whole());
    setup.width = 160, setup.height = 90;
    setup.threads = 1;
    const Frame one = render(content, setup);
    setup.threads = 2;
    expect_same_bits(one, render(content, setup), scene);
  }
}

TEST(RaysAlone, RefuseWhatNeedsOpenGL) {
  const scenes::Content content = scenes::generate("panes", {});
  const auto refused = [&](const tests::Setup& setup, const char* says) {
    try {
      render(content, by_rays(setup));
      ADD_FAILURE() << "drawn: " << says;
    } catch (const Error& error) {
      EXPECT_EQ(error.status, SIDERAY_UNSUPPORTED);
      EXPECT_NE(std::string(error.what()).find(says), std::string::npos) << error.what();
    }
  };
  refused(tests::Setup{.translucency = SIDERAY_TRANSLUCENCY_RASTER}, "translucency raster");
  refused(tests::Setup{.layers = 0}, "translucency raster");
  refused(tests::Setup{.aovs = SIDERAY_AOV_LAYERS}, "layers to show");
}

}  // namespace
}  // namespace sideray::tests
