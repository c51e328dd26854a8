// Reflections of opaque surfaces in whole frames, beside the reference's.
#include <gtest/gtest.h>

#include <cmath>
#include <iostream>

#include "frame/frame.h"
#include "scenes/content/shapes.h"

namespace sideray::tests {
namespace {

// A mirror floor, a red box on it, and a wall of another colour behind.
scenes::Content mirror_room() {
  scenes::ContentBuilder b("mirror room");
  sideray_material_desc floor = scenes::opaque_material({0.9f, 0.9f, 0.9f}, 0.0f);
  floor.metallic = 1.0f;
  b.object("floor", b.mesh(scenes::Shape().quad({-6, 0, 6}, {6, 0, 6}, {6, 0, -6}, {-6, 0, -6}), "floor"),
           b.material("floor", floor));
  b.object("box", b.mesh(scenes::Shape().box({-0.8f, 0.2f, -0.8f}, {0.8f, 1.8f, 0.8f}), "box"),
           b.material("red", scenes::opaque_material({0.7f, 0.1f, 0.05f}, 0.8f)), glm::dvec3(0, 0, -1), 20);
  b.object("wall", b.mesh(scenes::Shape().quad({-6, 0, -6}, {6, 0, -6}, {6, 4, -6}, {-6, 4, -6}), "wall"),
           b.material("blue", scenes::opaque_material({0.1f, 0.2f, 0.6f}, 0.9f)));
  b.light("sun", scenes::sun_light({-0.4f, -0.8f, -0.45f}, glm::vec3(3.0f)));
  const double eye[3] = {0.5, 1.6, 5}, target[3] = {0, 0.4, -1};
  b.camera("view", scenes::look_at(eye, target, 45));
  return b.take();
}

// Of pixels that show the floor.
double floor_error(const Frame& frame, const Frame& reference) {
  double sum = 0, count = 0;
  for (size_t i = 0; i < frame.uint_planes.at("id.surface").size(); ++i) {
    if (frame.uint_planes.at("id.surface")[i] != 1) continue;
    for (const char* channel : {"R", "G", "B"})
      sum += std::abs(double{frame.planes.at(channel)[i]} - double{reference.planes.at(channel)[i]}), ++count;
  }
  return sum / count;
}

TEST(Reflections, AMirrorFloorComesCloseToTheReference) {
  const scenes::Content content = mirror_room();
  tests::Setup setup{.width = 112, .height = 63, .shadows = SIDERAY_SHADOWS_EXACT, .aovs = SIDERAY_AOV_ID};
  const Frame without = render(content, setup);
  EXPECT_EQ(without.stats.rays_reflection, 0u);
  setup.reflections = true, setup.repeats = 1;
  const Frame with = render(content, setup);
  setup.repeats = 0, setup.reference = true, setup.light_samples = 8, setup.aovs = 0;
  const Frame reference = render(content, setup);
  const double before = floor_error(without, reference), after = floor_error(with, reference);
  std::cout << "  the floor is off by " << before << " without, " << after << " with reflections\n";
  EXPECT_LT(after, 0.15 * before);
  EXPECT_GT(with.stats.rays_reflection, 112u * 63u / 4);
  // What mirrors nothing is what it was.
  for (size_t i = 0; i < with.planes.at("R").size(); ++i) {
    if (with.uint_planes.at("id.surface")[i] == 1) continue;
    ASSERT_EQ(with.planes.at("R")[i], without.planes.at("R")[i]) << i;
  }
}

}  // namespace
}  // namespace sideray::tests
