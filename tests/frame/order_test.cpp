// Tests orders of translucent fragments on whole frames of crossing panes and of strips that overlap in a ring.
#include <algorithm>
#include <cmath>

#include "frame/frame.h"
#include "scenes/builtin/builtin.h"

namespace sideray::tests {
namespace {

scenes::Content crossing() {
  return scenes::generate("crossing", {{"panes", "4"}, {"strips", "5"}, {"layers", "3"}});
}

// Returns the share of pixels of which any channel, alpha included, has a relative error above `tolerance`.
double differing_share(const Frame& test, const Frame& truth, float tolerance) {
  const size_t pixels = truth.planes.at("R").size();
  size_t differing = 0;
  for (size_t i = 0; i < pixels; ++i) {
    bool differs = false;
    for (const char* name : {"R", "G", "B", "A"}) {
      const float a = test.planes.at(name)[i], b = truth.planes.at(name)[i];
      differs |= std::abs(a - b) > tolerance * std::max(std::abs(b), 1e-2f);
    }
    differing += differs;
  }
  return static_cast<double>(differing) / static_cast<double>(pixels);
}

Setup with(sideray_oit oit, sideray_translucency translucency) {
  Setup setup;
  setup.translucency = translucency;
  setup.layers = 8;
  setup.oit = oit;
  setup.whole_pixels = false;  // their order is that of rays whatever the fragments' is
  return setup;
}

// No sorted list of objects is right here, and every layer is ray traced, so that the order along rays is right. Rays
// and fragments differ along edges, and where two panes cross within a pixel.
TEST(Order, HybridIsUnlimitedRayTracingWhereSortedIsNot) {
  const scenes::Content content = crossing();
  const Frame truth = render(content, {.translucency = SIDERAY_TRANSLUCENCY_RAYTRACED, .layers = 0});
  EXPECT_GT(differing_share(render(content, with(SIDERAY_OIT_SORTED, SIDERAY_TRANSLUCENCY_HYBRID)), truth, 2e-2f),
            0.05);
  for (const sideray_oit oit : {SIDERAY_OIT_ABUFFER, SIDERAY_OIT_PEEL})
    EXPECT_LT(differing_share(render(content, with(oit, SIDERAY_TRANSLUCENCY_HYBRID)), truth, 1e-2f), 0.005)
        << "oit " << oit;
}

// Every layer is cached here: fragments are drawn only where a ray passes close to an edge.
TEST(Order, WholePixelsAreInTheOrderOfRays) {
  const scenes::Content content = crossing();
  const Frame truth = render(content, {.translucency = SIDERAY_TRANSLUCENCY_RAYTRACED, .layers = 0});
  tests::Setup setup = with(SIDERAY_OIT_SORTED, SIDERAY_TRANSLUCENCY_HYBRID);
  const double of_fragments = differing_share(render(content, setup), truth, 1e-2f);
  setup.whole_pixels = true;
  EXPECT_LT(differing_share(render(content, setup), truth, 1e-2f), 0.25 * of_fragments);
  setup.oit = SIDERAY_OIT_ABUFFER;
  EXPECT_LT(differing_share(render(content, setup), truth, 1e-2f), 0.005);
}

// In pixels with a sprite, or with more surfaces than the cache holds, fragments are blended as before.
TEST(Order, WholePixelsLeaveTheOthersAlone) {
  const scenes::Content panes = scenes::generate("panes", {{"count", "5"}});
  tests::Setup setup = with(SIDERAY_OIT_SORTED, SIDERAY_TRANSLUCENCY_HYBRID);
  setup.layers = 4;
  setup.aovs = SIDERAY_AOV_MASK;
  const Frame fragments = render(panes, setup);
  setup.whole_pixels = true;
  const Frame whole = render(panes, setup);
  size_t with_five = 0;
  for (size_t i = 0; i < whole.planes.at("R").size(); ++i) {
    if (whole.uint_planes.at("mask.count")[i] != 5) continue;
    ++with_five;
    ASSERT_EQ(whole.planes.at("R")[i], fragments.planes.at("R")[i]) << "pixel " << i;
  }
  EXPECT_GT(with_five, whole.planes.at("R").size() / 4);
}

TEST(Order, RasterOrdersAgree) {
  const scenes::Content content = crossing();
  const Frame peeled = render(content, with(SIDERAY_OIT_PEEL, SIDERAY_TRANSLUCENCY_RASTER));
  const Frame listed = render(content, with(SIDERAY_OIT_ABUFFER, SIDERAY_TRANSLUCENCY_RASTER));
  EXPECT_EQ(differing_share(listed, peeled, 1e-5f), 0.0);
}

TEST(Order, WhatNeedsNoOrderIsSortedBitForBit) {
  const scenes::Content panes = scenes::generate("panes", {{"count", "5"}});
  const Frame sorted = render(panes, with(SIDERAY_OIT_SORTED, SIDERAY_TRANSLUCENCY_HYBRID));
  EXPECT_EQ(render(panes, with(SIDERAY_OIT_PEEL, SIDERAY_TRANSLUCENCY_HYBRID)).planes, sorted.planes);
}

}  // namespace
}  // namespace sideray::tests
