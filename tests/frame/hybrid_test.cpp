// Tests the promises of hybrid translucency on whole frames.
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "frame/frame.h"
#include "gl/context/context.h"
#include "lab/metrics/metrics.h"
#include "model/failure.h"
#include "scenes/builtin/builtin.h"

namespace sideray::tests {
namespace {

scenes::Content panes(int count, double gap = 0.2) {
  return scenes::generate("panes", {{"count", std::to_string(count)}, {"gap", std::to_string(gap)}});
}

Frame raytraced_unlimited(const scenes::Content& content, Setup setup) {
  setup.translucency = SIDERAY_TRANSLUCENCY_RAYTRACED;
  setup.layers = 0;
  return render(content, setup);
}

scenes::Image image_of(const Frame& f) {
  scenes::Image image{f.width, f.height, {}, true};
  for (const char* name : {"R", "G", "B"})
    image.planes.push_back({name, scenes::Plane::Type::single, f.planes.at(name), {}});
  return image;
}

double flip(const Frame& test, const Frame& reference) {
  return lab::compare(image_of(test), image_of(reference)).metrics.flip.value();
}

// Returns the share of pixels of which every channel is within `tolerance` of the reference.
double agreeing_share(const Frame& test, const Frame& reference, float tolerance) {
  const std::vector<float> a = test.rgb(), b = reference.rgb();
  size_t good = 0;
  for (size_t p = 0; p < a.size(); p += 3) {
    bool close = true;
    for (size_t c = p; c < p + 3; ++c) close &= std::abs(a[c] - b[c]) <= tolerance * std::max(std::abs(b[c]), 1e-3f);
    good += close;
  }
  return static_cast<double>(good) / static_cast<double>(a.size() / 3);
}

void expect_equals_ray_order(const scenes::Content& content, Setup setup) {
  const Frame hybrid = render(content, setup), truth = raytraced_unlimited(content, setup);
  EXPECT_LT(flip(hybrid, truth), 0.005);
  EXPECT_GE(agreeing_share(hybrid, truth, 2e-3f), 0.999);
}

TEST(Hybrid, EqualsUnlimitedRayTracingOnPanes) {
  expect_equals_ray_order(panes(6), {.layers = 8});
}

TEST(Hybrid, EqualsUnlimitedRayTracingOnARealAsset) {
  SIDERAY_ASSET_OR_SKIP(path, "SubpassBuilding/subpass_scene_transparent.gltf");
  expect_equals_ray_order(scenes::load(path), {.layers = 8});
}

TEST(Hybrid, WithoutLayersIsRasterBitForBit) {
  const Frame hybrid = render(panes(4), {.layers = 0});
  const Frame raster = render(panes(4), {.translucency = SIDERAY_TRANSLUCENCY_RASTER});
  EXPECT_EQ(hybrid.planes, raster.planes);
}

TEST(Hybrid, LayersChangeThePicture) {
  const Frame hybrid = render(panes(4), {.layers = 4});
  const Frame raster = render(panes(4), {.translucency = SIDERAY_TRANSLUCENCY_RASTER});
  EXPECT_LT(agreeing_share(hybrid, raster, 2e-3f), 0.9);
}

// With fewer layers than panes hybrid keeps every pane, with raster shading for deep ones. Ray tracing loses them: the
// wall behind shows through with (1 - a)^N instead of (1 - a)^count.
TEST(Hybrid, NothingDisappearsBeyondTheLayers) {
  const Frame truth = raytraced_unlimited(panes(6), {});
  const Frame hybrid = render(panes(6), {.layers = 2});
  const Frame limited = render(panes(6), {.translucency = SIDERAY_TRANSLUCENCY_RAYTRACED, .layers = 2});
  const double hybrid_error = flip(hybrid, truth), limited_error = flip(limited, truth);
  EXPECT_LT(hybrid_error, 0.5 * limited_error) << "hybrid " << hybrid_error << ", ray traced " << limited_error;
}

TEST(Mask, StencilAndNoneGiveTheSamePicture) {
  const Frame stencil = render(panes(4), {.mask = SIDERAY_STENCIL_MASK});
  const Frame none = render(panes(4), {.mask = SIDERAY_NO_MASK});
  EXPECT_EQ(stencil.planes, none.planes);
}

TEST(Mask, CountDiffersOnlyWhereItIsNotTheNumberOfLayers) {
  const Frame stencil = render(panes(4), {.layers = 8, .mask = SIDERAY_STENCIL_MASK, .aovs = SIDERAY_AOV_LAYERS});
  const Frame count = render(panes(4), {.layers = 8,
                                        .mask = SIDERAY_COUNT_MASK,
                                        .aovs = SIDERAY_AOV_LAYERS | SIDERAY_AOV_MASK,
                                        .whole_pixels = false});
  size_t masked = 0, miscounted = 0;
  for (size_t i = 0; i < count.planes.at("R").size(); ++i) {
    uint32_t found = 0;
    for (int k = 0; k < 8; ++k) found += stencil.planes.at("layer" + std::to_string(k) + ".distance")[i] > 0;
    const uint32_t counted = count.uint_planes.at("mask.count")[i];
    masked += counted > 0;
    miscounted += counted != found;
    if (counted != found) continue;
    for (const char* channel : {"R", "G", "B"})
      ASSERT_EQ(count.planes.at(channel)[i], stencil.planes.at(channel)[i]) << "pixel " << i << " " << channel;
  }
  ASSERT_GT(masked, 0u);
  EXPECT_LE(static_cast<double>(miscounted) / static_cast<double>(masked), 0.005);
  EXPECT_LT(flip(count, stencil), 0.001);
}

TEST(Mask, CountSurvivesManyLayers) {
  const Frame frame = render(panes(20, 0.01), {.aovs = SIDERAY_AOV_MASK});
  const auto& counts = frame.uint_planes.at("mask.count");
  EXPECT_EQ(*std::max_element(counts.begin(), counts.end()), 20u);
}

TEST(Mask, CountAovIsACountInEveryMode) {
  for (const tests::Setup& setup :
       {tests::Setup{.translucency = SIDERAY_TRANSLUCENCY_RASTER, .aovs = SIDERAY_AOV_MASK},
        tests::Setup{.translucency = SIDERAY_TRANSLUCENCY_RAYTRACED, .aovs = SIDERAY_AOV_MASK},
        tests::Setup{.mask = SIDERAY_STENCIL_MASK, .aovs = SIDERAY_AOV_MASK},
        tests::Setup{.mask = SIDERAY_NO_MASK, .aovs = SIDERAY_AOV_MASK}}) {
    const auto counts = render(panes(4), setup).uint_planes.at("mask.count");
    EXPECT_EQ(*std::max_element(counts.begin(), counts.end()), 4u);
  }
}

// At a distance rays must read textured alpha at the rasterizer's mip level, or they miss surfaces in the mask.
TEST(Counters, TexturedAlphaKeepsThemToo) {
  SIDERAY_ASSET_OR_SKIP(path, "TreeLowPoly/TreeLowPoly.gltf");
  const sideray_render_stats s = render(scenes::load(path), {.layers = 8, .repeats = 1}).stats;
  EXPECT_LE(s.layers_found, s.layers_requested);
  EXPECT_LE(s.layers_matched, s.layers_found);
  EXPECT_LE(static_cast<double>(s.traversals_wasted), 0.02 * static_cast<double>(s.rays_primary));
  EXPECT_LE(static_cast<double>(s.rays_primary), 1.02 * static_cast<double>(s.pixels_masked));
}

TEST(Counters, KeepTheirBounds) {
  for (const uint32_t layers : {1u, 2u, 4u, 8u}) {
    const sideray_render_stats s = render(panes(4), {.layers = layers, .repeats = 1}).stats;
    EXPECT_GT(s.pixels_masked, 0u);
    EXPECT_LE(s.layers_found, s.layers_requested);
    EXPECT_LE(static_cast<double>(s.rays_primary), 1.02 * static_cast<double>(s.pixels_masked));
    EXPECT_LE(static_cast<double>(s.traversals_wasted), 0.02 * static_cast<double>(s.rays_primary));
    EXPECT_EQ(s.layers_requested, s.pixels_masked * std::min(layers, 4u));
    // Every fragment of a traced object either took a layer or had none left for it.
    EXPECT_LE(s.layers_matched, s.layers_found);
    EXPECT_GE(static_cast<double>(s.layers_matched), 0.999 * static_cast<double>(s.layers_found));
  }
}

// Fragments of whole pixels are not drawn, but their surfaces are in the picture.
TEST(Counters, CountFragmentsOfWholePixelsAsMatched) {
  const sideray_render_stats whole = render(panes(4), {.layers = 4, .repeats = 1}).stats;
  const sideray_render_stats drawn = render(panes(4), {.layers = 4, .repeats = 1, .whole_pixels = false}).stats;
  EXPECT_EQ(whole.layers_matched + whole.layers_missed, drawn.layers_matched + drawn.layers_missed);
  EXPECT_LE(whole.layers_missed, drawn.layers_missed);
  EXPECT_EQ(whole.layers_found, drawn.layers_found);
}

TEST(SameBits, ForAnyThreadCountAndRun) {
  const Frame one = render(panes(4), {.threads = 1}), two = render(panes(4), {.threads = 2});
  const Frame again = render(panes(4), {.threads = 2});
  EXPECT_EQ(one.planes, two.planes);
  EXPECT_EQ(two.planes, again.planes);
}

// Returns OpenGL's renderer for `choice`; "" where there is none.
std::string renderer_of(const std::string& choice) {
  try {
    return gl::Context::create(choice, "")->info().renderer;
  } catch (const Failure&) {
    return "";
  }
}

TEST(SameBits, OnEglAndOsmesa) {
  const std::string egl = renderer_of("egl"), osmesa = renderer_of("osmesa");
  const char* required = std::getenv("SIDERAY_REQUIRE_CONTEXTS");
  const bool promised = std::string(required ? required : "").find("osmesa") != std::string::npos;
  if (osmesa.empty() && promised) FAIL() << "required context \"osmesa\" is not available here";
  if (osmesa.empty()) GTEST_SKIP() << "no OSMesa on this machine";
  if (egl != osmesa) GTEST_SKIP() << "two drivers, which round differently: " << egl << " and " << osmesa;
  EXPECT_EQ(render(panes(3), {.gl = "egl"}).planes, render(panes(3), {.gl = "osmesa"}).planes);
}

}  // namespace
}  // namespace sideray::tests
