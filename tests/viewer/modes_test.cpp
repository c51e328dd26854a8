// The window's modes of display.
#include "viewer/drawing/modes.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <set>
#include <string>

#include "scenes/builtin/builtin.h"
#include "scenes/content/content.h"

namespace sideray::tests::modes_test {
namespace {

using namespace viewer;

// Names of modes that a scene's picture has no pixels of, and of those whose pixels are all alike.
struct Lacking {
  std::set<std::string> pixels, contrast;
};

// Draws the channels of each mode as the window asks for them.
Lacking lacking_in(const char* scene_name, int32_t ambient) {
  const scenes::Content content = scenes::load(scene_name);
  Scene scene = Scene::create().value();
  scenes::fill(scene, content, std::vector<bool>(content.objects.size(), true));
  sideray_renderer_desc desc = sideray_renderer_defaults();
  desc.gl = "none";
  Renderer renderer = Renderer::create(desc).value();
  Lacking lacking;
  for (const Mode& mode : modes()) {
    sideray_render_options options = sideray_render_defaults();
    options.width = 64, options.height = 36, options.ambient = ambient;
    options.aovs = mode.aov | SIDERAY_AOV_Z | SIDERAY_AOV_ID;
    const Picture picture = renderer.render(scene, content.cameras.front().camera, options).value();
    const std::vector<uint8_t> rgb = shown(picture, mode);
    if (rgb.empty()) {
      lacking.pixels.insert(mode.name);
      continue;
    }
    EXPECT_EQ(rgb.size(), 3u * 64 * 36) << mode.name;
    if (std::equal(rgb.begin() + 3, rgb.end(), rgb.begin())) lacking.contrast.insert(mode.name);
  }
  return lacking;
}

TEST(Modes, AreShown) {
  const Lacking bistro = lacking_in("bistro", SIDERAY_AMBIENT_AUTO), solids = lacking_in("solids", SIDERAY_AMBIENT_AO);
  // Only more than 32 lights share a mask; the bistro's evening has no sky, and nothing in solids mirrors.
  EXPECT_THAT(bistro.pixels, testing::UnorderedElementsAre("shadow of all lights", "age of the sky's light"));
  EXPECT_THAT(solids.pixels, testing::UnorderedElementsAre("shadow of all lights", "age of reflections"));
  // Everything stands still, all light is traced for this picture, no surface takes the inexact test, and glass that
  // bends light is the last layer of its pixel.
  EXPECT_THAT(bistro.contrast, testing::UnorderedElementsAre("motion", "age of light", "inexact shadow test", "layer 1",
                                                             "layer 2", "layer 3"));
}

}  // namespace
}  // namespace sideray::tests::modes_test
