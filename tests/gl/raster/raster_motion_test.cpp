// Motion vectors against closed forms: views that move, instances that move, vertices in wind.
#include <cmath>

#include "gl/gl_contexts.h"
#include "gl/raster/raster_scene_builder.h"
#include "gl/scene/raster_view.h"
#include "model/wind.h"
#include "shaders/shading/shading_cpp.h"

namespace sideray::gl::tests::raster_motion_test {
namespace {

constexpr uint32_t width = 64, height = 48;
constexpr size_t pixels = size_t{width} * height;

glm::dvec2 centre_of(size_t pixel) {
  return {static_cast<double>(pixel % width) + 0.5, static_cast<double>(pixel / width) + 0.5};
}

// Where a world position is in the picture without jitter, in pixels; the tests' cameras share one projection.
glm::dvec2 place_of(const sideray_camera& camera, glm::dvec3 world) {
  const double* m = camera.world_from_camera;
  const glm::dmat3 turn(m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8]);
  const glm::dvec3 p = glm::transpose(turn) * (world - glm::dvec3(m[9], m[10], m[11]));
  const double scale = 0.5 * height / std::tan(0.5 * double{camera.yfov});
  return glm::dvec2(0.5 * width, 0.5 * height) + scale * glm::dvec2(p) / -p.z;
}

// Of the pixel centre, jitter included, as a direction in world space.
glm::dvec3 ray_of(const sideray_camera& camera, size_t pixel, glm::vec2 jitter) {
  const double* m = camera.world_from_camera;
  const glm::dmat3 turn(m[0], m[1], m[2], m[3], m[4], m[5], m[6], m[7], m[8]);
  const double scale = 0.5 * height / std::tan(0.5 * double{camera.yfov});
  const glm::dvec2 place = centre_of(pixel) + glm::dvec2(jitter) - glm::dvec2(0.5 * width, 0.5 * height);
  return turn * glm::dvec3(place / scale, -1.0);
}

glm::dvec3 eye_of(const sideray_camera& camera) {
  return {camera.world_from_camera[9], camera.world_from_camera[10], camera.world_from_camera[11]};
}

class RasterMotion : public EveryContext {
 protected:
  void SetUp() override {
    EveryContext::SetUp();
    if (!context) return;
    rasterizer = std::make_unique<Rasterizer>(gl());
    rasterizer->resize(width, height);
  }
  void TearDown() override {
    rasterizer.reset();
    EveryContext::TearDown();
  }

  RasterView view_of(const sideray_camera& camera, const model::Snapshot& snapshot, glm::vec2 jitter = glm::vec2(0)) {
    return make_raster_view(camera, jitter, {width, height, snapshot.origin, reversed && gl().clip_control});
  }

  using Scene = std::shared_ptr<const model::Snapshot>;
  std::vector<glm::vec2> motion(const Scene& now, const sideray_camera& camera, glm::vec2 jitter, const Scene& before,
                                const sideray_camera& camera_before, glm::vec2 jitter_before) {
    rasterizer->set_scene(now);
    rasterizer->set_view(view_of(camera, *now, jitter));
    rasterizer->gbuffer();
    rasterizer->motion({view_of(camera_before, *before, jitter_before), before});
    return rasterizer->read_motion();
  }

  std::unique_ptr<Rasterizer> rasterizer;
  bool reversed = true;  // where the context can; ordinary depth can be drawn anywhere
};

constexpr glm::vec2 jitter_now(0.3f, -0.2f), jitter_before(-0.4f, 0.1f);

// A plane before a camera that moves and turns: every pixel's point, projected into both views.
TEST_P(RasterMotion, of_a_plane_and_of_the_sky_before_a_moving_camera) {
  SceneBuilder builder;
  builder.quad(builder.material(plain_material()), {0, -1, 0}, 1.5);
  const auto scene = builder.commit();
  for (const float far : {0.0f, 50.0f})
    for (const bool is_reversed : {true, false}) {
      reversed = is_reversed;
      sideray_camera now = camera_at({0.4, 0.3, 5}), before = camera_at({0.2, 0.35, 5.3}, {0.1, -0.05, 0});
      now.z_far = before.z_far = far;
      const auto motion = this->motion(scene, now, jitter_now, scene, before, jitter_before);
      const auto ids = rasterizer->read_gbuffer().ids;
      size_t surfaces = 0;
      for (size_t i = 0; i < pixels; ++i) {
        const glm::dvec3 ray = ray_of(now, i, jitter_now), eye = eye_of(now);
        const bool is_sky = ids[i].y == 0;
        const glm::dvec3 point = is_sky ? eye_of(before) + ray : eye - ray * (eye.z / ray.z);
        const glm::dvec2 expected = centre_of(i) + glm::dvec2(jitter_now) - place_of(before, point);
        EXPECT_NEAR(motion[i].x, expected.x, 2e-3) << "pixel " << i << (is_sky ? ", sky" : "");
        EXPECT_NEAR(motion[i].y, expected.y, 2e-3) << "pixel " << i << (is_sky ? ", sky" : "");
        surfaces += !is_sky;
      }
      EXPECT_GT(surfaces, 200u);
      EXPECT_LT(surfaces, pixels - 200);
    }
}

TEST_P(RasterMotion, jitter_alone_is_no_motion) {
  SceneBuilder builder;
  builder.quad(builder.material(plain_material()), {0, 0, 0});
  const auto scene = builder.commit();
  const sideray_camera camera = camera_at({0.4, 0.3, 5});
  for (const glm::vec2 m : motion(scene, camera, jitter_now, scene, camera, jitter_before)) {
    EXPECT_LT(std::abs(m.x), 1e-6f);
    EXPECT_LT(std::abs(m.y), 1e-6f);
  }
}

// Two quads that face the camera: the one that moved has the motion of its points, the other none.
TEST_P(RasterMotion, of_a_moved_instance) {
  SceneBuilder builder;
  const uint32_t material = builder.material(plain_material());
  builder.quad(material, {-1.2, 0, 0}, 1, 1);
  builder.quad(material, {1.0, 0, 0.5}, 1, 2);
  const auto before = builder.commit();
  const glm::dmat4 place = glm::scale(glm::translate(glm::dmat4(1), glm::dvec3(1.2, 0.1, 0)), glm::dvec3(1.1, 1, 1));
  double values[12];
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 3; ++r) values[3 * c + r] = place[c][r];
  const uint32_t second = 2;
  builder.scene.move_instances(&second, 1, values);
  const auto now = builder.commit();
  const sideray_camera camera = camera_at({0, 0, 5});
  for (const bool is_reversed : {true, false}) {
    reversed = is_reversed;
    const auto motion = this->motion(now, camera, jitter_now, before, camera, jitter_before);
    const auto ids = rasterizer->read_gbuffer().ids;
    size_t moved = 0;
    for (size_t i = 0; i < pixels; ++i) {
      glm::dvec2 expected(0);
      if (ids[i].x == 2) {
        const glm::dvec3 ray = ray_of(camera, i, jitter_now), point = eye_of(camera) - ray * (5.0 / ray.z);
        const glm::dvec3 object((point.x - 1.2) / 1.1, point.y - 0.1, 0);
        expected = centre_of(i) + glm::dvec2(jitter_now) - place_of(camera, object + glm::dvec3(1.0, 0, 0.5));
        ++moved;
      }
      EXPECT_NEAR(motion[i].x, expected.x, 2e-3) << "pixel " << i;
      EXPECT_NEAR(motion[i].y, expected.y, 2e-3) << "pixel " << i;
    }
    EXPECT_GT(moved, 100u);
  }
}

// A mesh that got other vertices, alone and with another transform: two quads that show the one mesh.
TEST_P(RasterMotion, of_moved_vertices) {
  SceneBuilder builder;
  const uint32_t material = builder.material(plain_material());
  const auto corners = [](float wide, float high) {
    return std::vector<glm::vec3>{{-wide, -high, 0}, {wide, -high, 0}, {wide, high, 0},
                                  {-wide, -high, 0}, {wide, high, 0},  {-wide, high, 0}};
  };
  const auto desc_of = [](const std::vector<glm::vec3>& positions) {
    sideray_mesh_desc mesh{};
    mesh.size = sizeof(mesh);
    mesh.vertex_count = static_cast<uint32_t>(positions.size());
    mesh.positions.data = &positions[0].x;
    return mesh;
  };
  const std::vector<glm::vec3> small = corners(0.5f, 0.5f), large = corners(0.8f, 0.6f);
  sideray_instance_desc d{};
  d.mesh = builder.scene.add_mesh(desc_of(small), nullptr);
  d.material = material;
  d.visibility = SIDERAY_VISIBLE_ALL;
  double places[2][12] = {{1, 0, 0, 0, 1, 0, 0, 0, 1, -1.2, 0, 0}, {1, 0, 0, 0, 1, 0, 0, 0, 1, 1.0, 0, 0.5}};
  for (uint32_t i = 0; i < 2; ++i) {
    std::copy_n(places[i], 12, d.world_from_object);
    d.surface_id = i + 1;
    builder.scene.add_instances(&d, 1);
  }
  const auto before = builder.commit();
  builder.scene.set_vertices(d.mesh, desc_of(large));
  const double moved_to[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 1.2, 0.1, 0};
  const uint32_t second = 2;
  builder.scene.move_instances(&second, 1, moved_to);
  const auto now = builder.commit();
  const sideray_camera camera = camera_at({0, 0, 5});
  for (const bool is_reversed : {true, false}) {
    reversed = is_reversed;
    const auto motion = this->motion(now, camera, jitter_now, before, camera, jitter_before);
    const auto ids = rasterizer->read_gbuffer().ids;
    size_t seen[3] = {};
    for (size_t i = 0; i < pixels; ++i) {
      const uint32_t id = std::min(ids[i].x, 2u);
      ++seen[id];
      glm::dvec2 expected(0);
      if (id != 0) {
        const glm::dvec3 ray = ray_of(camera, i, jitter_now), point = eye_of(camera) - ray * (5.0 / ray.z);
        const glm::dvec3 origin = id == 1 ? glm::dvec3(-1.2, 0, 0) : glm::dvec3(1.2, 0.1, 0);
        const glm::dvec3 was = id == 1 ? origin : glm::dvec3(1.0, 0, 0.5);
        const glm::dvec3 object = (point - origin) * glm::dvec3(0.5 / 0.8, 0.5 / 0.6, 1);
        expected = centre_of(i) + glm::dvec2(jitter_now) - place_of(camera, object + was);
      }
      EXPECT_NEAR(motion[i].x, expected.x, 2e-3) << "pixel " << i;
      EXPECT_NEAR(motion[i].y, expected.y, 2e-3) << "pixel " << i;
    }
    EXPECT_GT(seen[1], 100u);
    EXPECT_GT(seen[2], 100u);
  }
  // The same vertices again are no motion, and the attribute of the frame before is put away.
  const auto still = this->motion(now, camera, jitter_now, now, camera, jitter_before);
  for (const glm::vec2 m : still) EXPECT_EQ(m, glm::vec2(0));
}

glm::vec3 displaced(glm::vec3 position, double time_s, float phase) {
  const sideray_wind_desc d = breeze();
  const shading::SrWind wind{{d.direction[0], d.direction[1], d.direction[2]},
                             d.amplitude,
                             d.height,
                             d.branch_amplitude,
                             d.leaf_amplitude,
                             d.wavelength};
  const glm::vec3 cycles = model::wind_phase({d}, time_s, phase);
  return position + shading::sr_wind(wind, {cycles.x, cycles.y, cycles.z}, position);
}

// Triangles in wind: the motion of a pixel is that of its point between the corners, which the C++ text moves.
TEST_P(RasterMotion, of_vertices_in_wind) {
  constexpr float phase = 0.37f;
  constexpr double time_now = 1.55, time_before = 1.5;
  const glm::vec3 corners[3] = {{-1.5f, 0.2f, 0.1f}, {1.5f, 0.3f, 0.2f}, {0.1f, 2.4f, -0.3f}};
  SceneBuilder builder;
  const uint32_t indices[] = {0, 1, 2};
  sideray_mesh_desc mesh{};
  mesh.size = sizeof(mesh);
  mesh.vertex_count = mesh.index_count = 3;
  mesh.indices = indices;
  mesh.positions.data = &corners[0].x;
  sideray_material_desc leaf = plain_material();
  leaf.double_sided = 1;
  sideray_instance_desc d{};
  d.mesh = builder.scene.add_mesh(mesh, nullptr);
  d.material = builder.material(leaf);
  d.world_from_object[0] = d.world_from_object[4] = d.world_from_object[8] = 1;
  d.surface_id = 5;
  d.visibility = SIDERAY_VISIBLE_ALL;
  d.wind = builder.scene.add_wind(breeze());
  d.wind_phase = phase;
  builder.scene.add_instances(&d, 1);
  builder.scene.set_time(time_before, time_before);
  const auto before = builder.commit();
  builder.scene.set_time(time_now, time_before);
  const auto now = builder.commit();
  const sideray_camera camera = camera_at({0, 1, 5}, {0, 1, 0});
  const auto motion = this->motion(now, camera, jitter_now, before, camera, jitter_before);
  const auto ids = rasterizer->read_gbuffer().ids;
  glm::dvec3 p[3], q[3];
  for (int k = 0; k < 3; ++k)
    p[k] = displaced(corners[k], time_now, phase), q[k] = displaced(corners[k], time_before, phase);
  size_t checked = 0;
  double longest = 0;
  for (size_t i = 0; i < pixels; ++i) {
    if (ids[i].x != 5) continue;
    // Barycentric coordinates of the ray's point on the triangle of now.
    const glm::dvec3 ray = ray_of(camera, i, jitter_now), eye = eye_of(camera);
    const glm::dvec3 weights = glm::inverse(glm::dmat3(p[1] - p[0], p[2] - p[0], -ray)) * (eye - p[0]);
    const glm::dvec3 old = q[0] + weights.x * (q[1] - q[0]) + weights.y * (q[2] - q[0]);
    const glm::dvec2 expected = centre_of(i) + glm::dvec2(jitter_now) - place_of(camera, old);
    EXPECT_NEAR(motion[i].x, expected.x, 4e-3) << "pixel " << i;
    EXPECT_NEAR(motion[i].y, expected.y, 4e-3) << "pixel " << i;
    longest = std::max(longest, glm::length(expected));
    ++checked;
  }
  EXPECT_GT(checked, 200u);
  EXPECT_GT(longest, 0.5);
}

TEST_P(RasterMotion, without_a_frame_before_there_is_none_and_the_picture_stays) {
  SceneBuilder builder;
  builder.quad(builder.material(plain_material()), {0, 0, 0});
  const auto scene = builder.commit();
  const sideray_camera camera = camera_at({0.4, 0.3, 5});
  rasterizer->set_scene(scene);
  rasterizer->set_view(view_of(camera, *scene));
  rasterizer->gbuffer();
  rasterizer->light(false);
  const auto color = rasterizer->read_color();
  const auto depth = rasterizer->read_depth();
  rasterizer->gbuffer();
  rasterizer->motion({});
  for (const glm::vec2 m : rasterizer->read_motion()) EXPECT_EQ(m, glm::vec2(0));
  rasterizer->motion({view_of(camera_at({0, 0, 6}), *scene), scene});
  rasterizer->light(false);
  EXPECT_EQ(rasterizer->read_color(), color);
  EXPECT_EQ(rasterizer->read_depth(), depth);
}

INSTANTIATE_TEST_SUITE_P(Contexts, RasterMotion, testing::Values("device", "surfaceless", "osmesa"),
                         [](const auto& test) { return test.param; });

}  // namespace
}  // namespace sideray::gl::tests::raster_motion_test
