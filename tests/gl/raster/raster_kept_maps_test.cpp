// Tests that reused shadow maps equal maps drawn for one picture.
#include <cstdlib>
#include <functional>
#include <utility>

#include "gl/raster/raster_scene_builder.h"

namespace sideray::gl::tests {
namespace {

sideray_light light_at(glm::vec3 position) {
  sideray_light light{};
  light.size = sizeof(light);
  light.type = SIDERAY_LIGHT_POINT;
  for (int c = 0; c < 3; ++c) light.position[c] = position[c], light.intensity[c] = 6.0f;
  return light;
}

glm::dmat4 lying(glm::dvec3 center, double size) {
  const glm::dmat4 turned = glm::rotate(glm::translate(glm::dmat4(1), center), -1.5707963, glm::dvec3(1, 0, 0));
  return glm::scale(turned, glm::dvec3(size));
}

// A floor, four plates above it, one of them with holes, under a sun and a lamp.
class RasterKeptMaps : public RasterTest {
 protected:
  void SetUp() override {
    RasterTest::SetUp();
    const uint32_t white = builder_.material(plain_material());
    builder_.quad(white, lying({0, 0, 0}, 6));
    for (int i = 0; i < 3; ++i) builder_.quad(white, lying({1.5 * i - 2, 1 + 0.3 * i, 0.5 * i}, 0.4), 2);
    sideray_material_desc holes = plain_material();
    holes.alpha_mode = SIDERAY_MASK;
    holes.base_color[3] = 0.9f;
    holes.double_sided = 1;
    holed_ = holes;
    builder_.quad(builder_.material(holes), lying({0, 0.8, -1}, 0.5), 3);
    lights_ = {light_at({0.5f, 3, 0}), light_at({})};
    lights_[1].type = SIDERAY_LIGHT_DIRECTIONAL;
    lights_[1].direction[0] = 0.3f, lights_[1].direction[1] = -1.0f;
  }

  void move(uint32_t instance, glm::dvec3 to) {
    const glm::dmat4 at = lying(to, 0.4);
    double columns[12];
    for (int c = 0; c < 4; ++c)
      for (int r = 0; r < 3; ++r) columns[3 * c + r] = at[c][r];
    builder_.scene.move_instances(&instance, 1, columns);
  }

  // Draws with the rasterizer that keeps maps, and with a new one.
  void expect_as_new(const char* what) {
    builder_.scene.set_lights(lights_.data(), lights_.size());
    const auto snapshot = builder_.commit();
    const sideray_camera camera = camera_at(eye_, {0, 0, 0});
    draw_opaque(snapshot, camera, true);
    const std::vector<glm::vec4> kept = rasterizer->read_color();
    auto keeping = std::exchange(rasterizer, std::make_unique<Rasterizer>(context->functions()));
    draw_opaque(snapshot, camera, true);
    EXPECT_EQ(rasterizer->read_color(), kept) << what;
    rasterizer = std::move(keeping);
    EXPECT_NE(kept, before_) << what << " changes nothing in the picture";
    before_ = kept;
  }

  SceneBuilder builder_;
  sideray_material_desc holed_;
  std::vector<sideray_light> lights_;
  glm::dvec3 eye_{0, 4, 5};
  std::vector<glm::vec4> before_;
};

TEST_F(RasterKeptMaps, follow_what_changes) {
  expect_as_new("the first picture");
  eye_ = {1, 2, 1.5};
  expect_as_new("another view, near the floor");
  eye_ = {-1, 5, 6};
  expect_as_new("a view that shows more");
  move(2, {1.5, 1.2, 1});
  expect_as_new("a plate that moved");
  move(2, {40, 1.2, 1});
  expect_as_new("a plate that left");
  move(2, {0.2, 0.7, 1});
  expect_as_new("a plate that came back");
  lights_[0].position[0] = -1.0f;
  expect_as_new("a lamp that moved");
  lights_[0].intensity[1] = 1.0f;
  expect_as_new("a lamp of another colour");
  lights_.insert(lights_.begin(), light_at({2, 2, 2}));
  expect_as_new("a lamp before the others");
  lights_.erase(lights_.begin() + 1);
  expect_as_new("a lamp less");
  holed_.base_color[3] = 0.1f;
  builder_.scene.replace_material(2, holed_);
  expect_as_new("a plate that is all hole");
  holed_.base_color[3] = 0.9f;
  builder_.scene.replace_material(2, holed_);
  expect_as_new("a plate without a hole");
  const uint32_t third = 3;
  builder_.scene.remove_instances(&third, 1);
  expect_as_new("a plate that is gone");
  builder_.quad(1, lying({0, 1.5, 0}, 0.7), 7);
  expect_as_new("a plate that was added");
}

// A caster that the picture did not need at first joins those in the map.
TEST_F(RasterKeptMaps, hold_what_any_view_needs) {
  for (const glm::dvec3 eye : {glm::dvec3(-2, 1, 1), glm::dvec3(3, 1, 1), glm::dvec3(0, 6, 0.1), glm::dvec3(-2, 1, 1.5)}) {
    eye_ = eye;
    expect_as_new("a view");
  }
}

}  // namespace
}  // namespace sideray::gl::tests
