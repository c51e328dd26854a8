// Tests the first pictures after a cut, under a budget: pixels without rays yet look as rasterized, not unshadowed.
#include <gtest/gtest.h>
#include <sideray/diagnostics.h>

#include <algorithm>
#include <cmath>

#include "frame/views/view.h"

namespace sideray::tests::first_pictures_test {
namespace {

double difference(const Shown& a, const Shown& b) {
  double sum = 0.0;
  for (size_t i = 0; i < a.colors.size(); ++i) sum += std::abs(double{std::min(a.colors[i], 1.0f)} - double{std::min(b.colors[i], 1.0f)});
  return sum / static_cast<double>(a.colors.size());
}

View opaque_view(const char* scene) {
  View view(scenes::generate(scene, {}), 256, 144);
  view.options.picture.taa = 0;
  view.options.picture.reflections = 0;
  view.options.picture.ambient = 0;
  view.options.translucency->method = SIDERAY_TRANSLUCENCY_OFF;
  return view;
}

// One tile of 32x32 pixels has rays, and filters reach 16 pixels beyond it.
TEST(FirstPictures, HaveTheShadowsOfTheMaps) {
  View mapped = opaque_view("bistro");
  mapped.options.shadows->method = SIDERAY_SHADOWS_MAP;
  const Shown maps = mapped.draw();
  View view = opaque_view("bistro");
  sideray_diagnostics diagnostics = sideray_diagnostics_defaults();
  diagnostics.budget_pieces = 1;
  view.options.picture.diagnostics = &diagnostics;
  const Shown shown = view.draw();
  const size_t pixels = size_t{256} * 144;
  size_t others = 0, lit = 0;
  for (size_t i = 0; i < pixels; ++i) others += shown.colors[i] != maps.colors[i];
  EXPECT_GT(others, 0u);
  EXPECT_LE(others, 64u * 64u);
  View unshadowed = opaque_view("bistro");
  unshadowed.options.shadows->method = SIDERAY_SHADOWS_OFF;
  const Shown bright = unshadowed.draw();
  for (size_t i = 0; i < pixels; ++i) lit += bright.colors[i] != maps.colors[i];
  EXPECT_GT(lit, 2 * 64u * 64u) << "the scene has shadows to lose";
}

// A room whose walls hide most of the sky: without occlusion it would be far too bright.
TEST(FirstPictures, HaveTheSkyOfAFewSamples) {
  View view = opaque_view("bistro");
  view.options.picture.ambient = 1;
  const Shown whole = view.draw();
  View open = opaque_view("bistro");
  const double without = difference(open.draw(), whole);
  View first = opaque_view("bistro");
  first.options.picture.ambient = 1;
  sideray_diagnostics diagnostics = sideray_diagnostics_defaults();
  diagnostics.budget_pieces = 3;  // of 40 tiles; a sample costs a sixteenth
  first.options.picture.diagnostics = &diagnostics;
  EXPECT_LT(difference(first.draw(), whole), 0.5 * without);
}

}  // namespace
}  // namespace sideray::tests::first_pictures_test
