// Tests which pixels get the inexact shadow test, marked by a separate pass or in the G-buffer.
#include "gl/gl_contexts.h"
#include "gl/raster/raster_scene_builder.h"

namespace sideray::gl::tests {
namespace {

constexpr uint32_t width = 128, height = 80;

// Cut-out leaves before and behind plain walls, a pane of glass before them all; every other leaf takes the test, and
// one plain wall does.
std::shared_ptr<const model::Snapshot> leaves() {
  SceneBuilder builder;
  std::vector<uint8_t> texels;
  for (uint32_t i = 0; i < 32 * 32; ++i) {
    const uint8_t alpha = (i / 4 + i / 96) % 3 == 0 ? 20 : 240;
    texels.insert(texels.end(), {90, 160, 60, alpha});
  }
  sideray_material_desc leaf = plain_material();
  leaf.alpha_mode = SIDERAY_MASK;
  leaf.double_sided = 1;
  leaf.base_color_texture.texture = builder.scene.add_texture(32, 32, SIDERAY_RGBA8, texels.data());
  sideray_material_desc marked_leaf = leaf, marked_wall = plain_material();
  marked_leaf.inexact_shadow = marked_wall.inexact_shadow = 1;
  const uint32_t materials[] = {builder.material(leaf), builder.material(marked_leaf)};
  for (uint32_t i = 0; i < 14; ++i) {
    const double x = 0.45 * i - 3.0, z = 0.5 * ((i * 5) % 7) - 1.0;
    const glm::dmat4 place =
        glm::rotate(glm::translate(glm::dmat4(1), glm::dvec3(x, 0.1 * (i % 4), z)), 0.3 * i, glm::dvec3(0.2, 1, 0.1));
    builder.quad(materials[i % 2], place, i + 1);
  }
  builder.quad(builder.material(plain_material()), glm::dvec3(-1.5, -0.4, 0.3), 0.7, 30);
  builder.quad(builder.material(marked_wall), glm::dvec3(1.7, -0.3, 0.4), 0.6, 31);
  builder.quad(builder.material(unlit({1, 1, 1, 0.4}, SIDERAY_BLEND)), glm::dvec3(0.4, 0, 3), 0.8, 40);
  return builder.commit();
}

class RasterInexact : public EveryContext {
 protected:
  void begin(Rasterizer& rasterizer, bool in_gbuffer) {
    rasterizer.set_scene(leaves());
    rasterizer.resize(width, height);
    rasterizer.set_view(rasterizer.make_view(camera_at({0, 0.5, 6}), glm::vec2(0)));
    rasterizer.gbuffer(in_gbuffer);
  }
  std::vector<glm::vec4> rest_of(const Rasterizer& rasterizer) {
    std::vector<glm::vec4> texels(size_t{width} * height);
    gl().BindTexture(GL_TEXTURE_2D, rasterizer.rest_texture());
    gl().GetTexImage(GL_TEXTURE_2D, 0, GL_RGBA, GL_FLOAT, texels.data());
    return texels;
  }
};

TEST_P(RasterInexact, TheBitOfTheGBufferIsThatOfThePass) {
  for (const bool masks : {false, true})
    for (const bool rest : {false, true}) {
      Rasterizer by_pass(gl()), by_bit(gl());
      begin(by_pass, false);
      begin(by_bit, true);
      for (Rasterizer* rasterizer : {&by_pass, &by_bit})
        if (masks) rasterizer->mask(MaskKind::count, TracedSet::all_translucent);
      by_pass.mark_inexact({.target = SIDERAY_TARGET_STENCIL, .rest = rest});
      by_bit.mark_inexact({.target = SIDERAY_TARGET_BIT, .rest = rest});
      const std::vector<uint8_t> expected = by_pass.read_stencil(), stencil = by_bit.read_stencil();
      EXPECT_EQ(stencil, expected);
      if (rest) {
        EXPECT_EQ(rest_of(by_bit), rest_of(by_pass));
      }
      const auto count = [&](uint32_t bits) {
        return std::count_if(stencil.begin(), stencil.end(), [&](uint8_t s) { return (s & bits) != 0; });
      };
      EXPECT_GT(count(inexact_stencil_bit), 500);
      EXPECT_LT(count(inexact_stencil_bit), width * height / 2);
      EXPECT_EQ(count(mask_stencil_bits) > 100, masks);
      by_bit.light(false);
      by_bit.translucency({});
      EXPECT_EQ(by_bit.read_stencil(), expected) << "it is there still after the frame";
    }
}

TEST_P(RasterInexact, ANextGBufferForgetsIt) {
  Rasterizer rasterizer(gl());
  begin(rasterizer, true);
  begin(rasterizer, false);
  rasterizer.mask(MaskKind::stencil, TracedSet::none);
  for (const uint8_t stencil : rasterizer.read_stencil()) EXPECT_EQ(stencil, 0);
}

INSTANTIATE_TEST_SUITE_P(Contexts, RasterInexact, testing::Values("device", "surfaceless", "osmesa"),
                         [](const auto& test) { return test.param; });

}  // namespace
}  // namespace sideray::gl::tests
