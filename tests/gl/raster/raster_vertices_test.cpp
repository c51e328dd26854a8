// A mesh that got other vertices is drawn as one that was added with them.
#include <cmath>

#include "gl/gl_contexts.h"
#include "gl/raster/raster_scene_builder.h"

namespace sideray::gl::tests::raster_vertices_test {
namespace {

constexpr uint32_t width = 96, height = 64, steps = 8;

// A sheet that waves, and a floor for its shadow.
struct Waves {
  std::vector<glm::vec3> positions;
  std::vector<glm::vec4> colors;
  std::vector<uint32_t> indices;
  bool smooth;

  Waves(double time, bool is_smooth) : smooth(is_smooth) {
    for (uint32_t y = 0; y <= steps; ++y)
      for (uint32_t x = 0; x <= steps; ++x) {
        const double u = static_cast<double>(x) / steps, v = static_cast<double>(y) / steps;
        positions.emplace_back(1.6 * u - 0.8 + 0.2 * std::sin(time + 5 * v), 2 * v, 0.4 * std::sin(time + 4 * u));
        colors.emplace_back(u, v, 0.5 + 0.5 * std::sin(time), 1);
        if (x == steps || y == steps) continue;
        const uint32_t a = y * (steps + 1) + x, b = a + steps + 1;
        indices.insert(indices.end(), {a, a + 1, b + 1, a, b + 1, b});
      }
  }
  sideray_mesh_desc desc() const {
    sideray_mesh_desc mesh{};
    mesh.size = sizeof(mesh);
    mesh.vertex_count = static_cast<uint32_t>(positions.size());
    mesh.index_count = static_cast<uint32_t>(indices.size());
    mesh.indices = indices.data();
    mesh.positions.data = &positions[0].x;
    if (smooth) mesh.normals.data = &positions[0].x;  // any
    mesh.colors.data = &colors[0].x;
    return mesh;
  }
};

struct Stage {
  SceneBuilder builder;
  uint32_t mesh = 0;

  Stage(const Waves& waves, sideray_alpha_mode mode) {
    sideray_material_desc sheet = plain_material();
    sheet.double_sided = 1;
    sheet.alpha_mode = mode;
    if (mode == SIDERAY_BLEND) sheet.base_color[3] = 0.5f;
    mesh = builder.scene.add_mesh(waves.desc(), nullptr);
    sideray_instance_desc d{};
    d.mesh = mesh;
    d.material = builder.material(sheet);
    d.surface_id = 5;
    d.visibility = SIDERAY_VISIBLE_ALL;
    for (const double x : {-0.9, 0.9}) {
      const double place[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, x, 0, 0};
      std::copy_n(place, 12, d.world_from_object);
      builder.scene.add_instances(&d, 1);
      ++d.surface_id;
    }
    builder.quad(builder.material(plain_material()),
                 glm::scale(glm::rotate(glm::dmat4(1), -1.5707963, glm::dvec3(1, 0, 0)), glm::dvec3(4)), 7);
    sideray_light sun{};
    sun.type = SIDERAY_LIGHT_DIRECTIONAL;
    sun.direction[0] = 0.6f, sun.direction[1] = -0.64f, sun.direction[2] = -0.48f;
    for (float& c : sun.intensity) c = 2;
    builder.scene.set_lights(&sun, 1);
  }
};

class RasterVertices : public EveryContext {
 protected:
  static std::vector<glm::vec4> draw(Rasterizer& rasterizer, const std::shared_ptr<const model::Snapshot>& snapshot) {
    rasterizer.set_scene(snapshot);
    rasterizer.resize(width, height);
    rasterizer.set_view(rasterizer.make_view(camera_at({0.5, 2.5, 5}, {0, 1, 0}), glm::vec2(0)));
    rasterizer.gbuffer();
    rasterizer.shadow_maps();
    rasterizer.light(true);
    rasterizer.translucency({});
    return rasterizer.read_color();
  }
};

TEST_P(RasterVertices, are_drawn_as_those_of_a_new_mesh) {
  for (const bool smooth : {false, true}) {
    const sideray_alpha_mode mode = smooth ? SIDERAY_BLEND : SIDERAY_OPAQUE;
    Rasterizer kept(gl());
    Stage stage(Waves(0.0, smooth), mode);
    const std::vector<glm::vec4> before = draw(kept, stage.builder.commit());
    std::vector<glm::vec4> moved;
    for (const double time : {0.8, 1.9}) {
      stage.builder.scene.set_vertices(stage.mesh, Waves(time, smooth).desc());
      moved = draw(kept, stage.builder.commit());
    }
    EXPECT_NE(moved, before);
    Rasterizer fresh(gl());
    EXPECT_EQ(moved, draw(fresh, Stage(Waves(1.9, smooth), mode).builder.commit())) << smooth;
  }
}

INSTANTIATE_TEST_SUITE_P(Contexts, RasterVertices, testing::Values("device", "surfaceless", "osmesa"),
                         [](const auto& test) { return test.param; });

}  // namespace
}  // namespace sideray::gl::tests::raster_vertices_test
