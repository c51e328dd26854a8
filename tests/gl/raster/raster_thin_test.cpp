// Lines and points in the G-buffer, one pixel wide whatever the context has set, which stays set.
#include "gl/raster/raster_scene_builder.h"

namespace sideray::gl::tests {
namespace {

struct RasterThin : RasterTest {
  // One unit a pixel; the middle of the picture is the origin.
  static sideray_camera flat_camera() {
    sideray_camera camera = camera_at({0, 0, 5});
    camera.orthographic = 1;
    camera.half_height = 32;
    camera.z_far = 100;
    return camera;
  }

  static void add(SceneBuilder& builder, sideray_topology topology, const std::vector<float>& positions) {
    sideray_mesh_desc desc{};
    desc.size = sizeof(desc);
    desc.vertex_count = static_cast<uint32_t>(positions.size() / 3);
    desc.positions = {positions.data(), 0};
    desc.topology = topology;
    sideray_instance_desc instance{};
    instance.mesh = builder.scene.add_mesh(desc, nullptr);
    instance.material = builder.scene.add_material(unlit({1, 0.5f, 0.25f, 1}));
    for (const int i : {0, 4, 8}) instance.world_from_object[i] = 1;
    instance.surface_id = 7;
    builder.scene.add_instances(&instance, 1);
  }

  // How many pixels show them.
  size_t seen() {
    size_t count = 0;
    for (const glm::uvec2& ids : rasterizer->read_gbuffer().ids) count += ids.x == 7 ? 1 : 0;
    return count;
  }
};

TEST_F(RasterThin, WidthsOfTheContextDoNotCountAndStay) {
  const Functions& gl = context->functions();
  float widths[2] = {1, 1};
  gl.GetFloatv(GL_ALIASED_LINE_WIDTH_RANGE, widths);
  gl.LineWidth(widths[1]);
  gl.PointSize(6);
  gl.Enable(GL_PROGRAM_POINT_SIZE);
  float wide = 0, large = 0;
  gl.GetFloatv(GL_LINE_WIDTH, &wide);
  SceneBuilder builder;
  add(builder, SIDERAY_LINES, {-20.5f, 3.5f, 0, 19.5f, 3.5f, 0});
  add(builder, SIDERAY_POINTS, {0.5f, -8.5f, 0, 5.2f, -9.3f, 0});
  draw_opaque(builder.commit(), flat_camera());
  EXPECT_EQ(seen(), 42u);
  expect_near(rasterizer->read_color()[pixel(48, 23)], {1, 0.5f, 0.25f, 1}, 1e-3f);
  EXPECT_EQ(gl.IsEnabled(GL_PROGRAM_POINT_SIZE), GL_TRUE);
  gl.GetFloatv(GL_POINT_SIZE, &large);
  EXPECT_EQ(large, 6.0f);
  gl.GetFloatv(GL_LINE_WIDTH, &large);
  EXPECT_EQ(large, wide);
  gl.LineWidth(1);
  gl.PointSize(1);
  gl.Disable(GL_PROGRAM_POINT_SIZE);
}

TEST_F(RasterThin, TheyCanBeMovedAndReplaced) {
  SceneBuilder builder;
  add(builder, SIDERAY_LINES, {-20.5f, 3.5f, 0, 19.5f, 3.5f, 0});
  draw_opaque(builder.commit(), flat_camera());
  EXPECT_EQ(seen(), 40u);
  const std::vector<float> shorter = {-20.5f, 3.5f, 0, -10.5f, 3.5f, 0};
  sideray_mesh_desc desc{};
  desc.size = sizeof(desc);
  desc.vertex_count = 2;
  desc.positions = {shorter.data(), 0};
  builder.scene.set_vertices(2, desc);  // the first is the builder's
  draw_opaque(builder.commit(), flat_camera());
  EXPECT_EQ(seen(), 10u);
  const double aside[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 500, 0, 0};
  const uint32_t first = 1;
  builder.scene.move_instances(&first, 1, aside);
  draw_opaque(builder.commit(), flat_camera());
  EXPECT_EQ(seen(), 0u);
}

}  // namespace
}  // namespace sideray::gl::tests
