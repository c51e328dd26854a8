// Tests a room whose walls and ceiling face inwards, seen from outside and above: every way of drawing shows the inside
// (docs/adr/0043-back-faces.md), and none lets sunlight in.
#include <gtest/gtest.h>

#include <cmath>

#include "frame/frame.h"
#include "scenes/content/shapes.h"

namespace sideray::tests::back_faces_test {
namespace {

enum class Roof { none, ceiling };

// 4 by 3 by 2.4, a box on its floor; a pane of glass between it and the eye where `glazed`.
scenes::Content room(Roof roof, bool lamp, bool glazed = false) {
  scenes::ContentBuilder b("room");
  const uint32_t wall = b.material("wall", [] {
    sideray_material_desc d = scenes::opaque_material({0.7f, 0.65f, 0.6f}, 0.9f);
    d.double_sided = 0;
    return d;
  }());
  scenes::Shape walls;
  walls.quad({-2, 0, 1.5f}, {2, 0, 1.5f}, {2, 0, -1.5f}, {-2, 0, -1.5f});        // floor
  walls.quad({-2, 0, -1.5f}, {2, 0, -1.5f}, {2, 2.4f, -1.5f}, {-2, 2.4f, -1.5f});  // back
  walls.quad({2, 0, 1.5f}, {-2, 0, 1.5f}, {-2, 2.4f, 1.5f}, {2, 2.4f, 1.5f});      // toward the eye
  walls.quad({-2, 0, 1.5f}, {-2, 0, -1.5f}, {-2, 2.4f, -1.5f}, {-2, 2.4f, 1.5f});
  walls.quad({2, 0, -1.5f}, {2, 0, 1.5f}, {2, 2.4f, 1.5f}, {2, 2.4f, -1.5f});
  if (roof == Roof::ceiling) walls.quad({-2, 2.4f, -1.5f}, {2, 2.4f, -1.5f}, {2, 2.4f, 1.5f}, {-2, 2.4f, 1.5f});
  b.object("walls", b.mesh(walls, "walls"), wall);
  b.object("box", b.mesh(scenes::Shape().box({-0.6f, 0, -0.6f}, {0.4f, 0.8f, 0.4f}), "box"),
           b.material("blue", scenes::opaque_material({0.1f, 0.2f, 0.7f}, 0.8f)));
  if (glazed)
    b.object("pane", b.mesh(scenes::Shape().box({-3, 0, 2.0f}, {3, 3, 2.1f}), "pane"),
             b.material("glass", scenes::glass_material({1, 1, 1}, 0.0f)));
  b.light("sun", scenes::sun_light({0.3f, -0.8f, -0.45f}, glm::vec3(3.0f)));
  if (lamp) b.light("lamp", scenes::point_light({0, 1.9f, 0}, glm::vec3(4.0f), 0.0f));
  const double eye[3] = {-2, 4, 7}, target[3] = {0, 0.8, 0};
  b.camera("view", scenes::look_at(eye, target, 30));
  return b.take();
}

struct Way {
  const char* name;
  sideray_translucency translucency;
  bool reference;
  uint32_t bounces;
};
constexpr Way ways[] = {{"raster", SIDERAY_TRANSLUCENCY_RASTER, false, 1},
                        {"hybrid", SIDERAY_TRANSLUCENCY_HYBRID, false, 1},
                        {"raytraced", SIDERAY_TRANSLUCENCY_RAYTRACED, false, 1},
                        {"reference", SIDERAY_TRANSLUCENCY_HYBRID, true, 1},
                        {"paths", SIDERAY_TRANSLUCENCY_HYBRID, true, 0}};

Frame draw(const scenes::Content& content, const Way& way) {
  return render(content, {.width = 64, .height = 36, .translucency = way.translucency,
                          .shadows = SIDERAY_SHADOWS_EXACT, .sky = false, .reference = way.reference,
                          .light_samples = 4, .bounces = way.bounces, .refraction = true});
}

// Returns the share of pixels that are not black: there is no sky.
double lit_share(const Frame& frame) {
  double lit = 0;
  for (const float g : frame.planes.at("G")) lit += g > 1e-3f;
  return lit / static_cast<double>(frame.planes.at("G").size());
}

double mean_difference(const Frame& a, const Frame& b) {
  double sum = 0;
  for (size_t i = 0; i < a.planes.at("G").size(); ++i)
    sum += std::abs(double{a.planes.at("G")[i]} - double{b.planes.at("G")[i]});
  return sum / static_cast<double>(a.planes.at("G").size());
}

TEST(BackFaces, EveryWayOfDrawingLooksIn) {
  for (const bool glazed : {false, true}) {
    SCOPED_TRACE(glazed);
    const scenes::Content content = room(Roof::ceiling, true, glazed);
    const Frame reference = draw(content, ways[3]);
    const double share = lit_share(reference);
    EXPECT_GT(share, 0.2);
    for (const Way& way : ways) {
      SCOPED_TRACE(way.name);
      const Frame frame = draw(content, way);
      EXPECT_GT(lit_share(frame), share - 0.01);
      if (way.bounces != 1) continue;  // light that bounces reaches shadows too
      EXPECT_LT(lit_share(frame), share + 0.01);
      EXPECT_LT(mean_difference(frame, reference), 0.02);
    }
  }
}

// Without a lamp the closed room is dark in all of them; with its ceiling off the sun comes in.
TEST(BackFaces, TheSunComesInNowhere) {
  for (const Way& way : ways) {
    SCOPED_TRACE(way.name);
    EXPECT_LT(lit_share(draw(room(Roof::ceiling, false), way)), 0.01);
    EXPECT_GT(lit_share(draw(room(Roof::none, false), way)), 0.03);
  }
}

}  // namespace
}  // namespace sideray::tests::back_faces_test
