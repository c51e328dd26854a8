// Tests that a rasterizer that follows a scene through random edits draws the same as a new one.
#include <utility>

#include "gl/raster/raster_scene_builder.h"
#include "model/random_edits.h"

namespace sideray::gl::tests::raster_edits_test {
namespace {

struct RasterEdits : RasterTest {
  void SetUp() override {
    width = 48;
    height = 32;
    RasterTest::SetUp();
  }
};

TEST_F(RasterEdits, leave_the_picture_of_a_scene_built_from_nothing) {
  size_t covered = 0;
  for (uint32_t seed = 11; seed <= 12; ++seed) {
    model::test::RandomEdits edits(seed);
    for (int commit = 0; commit < 6; ++commit) {
      for (int i = 0; i < 25; ++i) edits.step();
      sideray_light light{};
      light.size = sizeof(light);
      light.direction[2] = -1.0f;
      for (float& c : light.intensity) c = 1.0f;
      edits.scene().set_lights(&light, 1);
      edits.scene().commit();
      draw_opaque(edits.scene().snapshot(), camera_at({0, 0, 7}), true);
      const std::vector<glm::vec4> edited = rasterizer->read_color();
      model::Scene built;
      edits.build(built);
      built.set_lights(&light, 1);
      built.commit();
      auto kept = std::exchange(rasterizer, std::make_unique<Rasterizer>(context->functions()));
      draw_opaque(built.snapshot(), camera_at({0, 0, 7}), true);
      EXPECT_EQ(rasterizer->read_color(), edited) << "seed " << seed << ", commit " << commit;
      rasterizer = std::move(kept);
      for (const glm::vec4& pixel : edited) covered += pixel.w > 0.0f ? 1 : 0;
    }
  }
  EXPECT_GT(covered, 500u);
}

}  // namespace
}  // namespace sideray::gl::tests::raster_edits_test
