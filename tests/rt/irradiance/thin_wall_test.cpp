// Tests a wall of 1 cm between a room with a lamp and one without. The rooms open only to a black sky, so that no light
// may reach the dark one.
#include <gtest/gtest.h>

#include <optional>

#include "rt/base/view_rays.h"
#include "rt/irradiance/irradiance_history.h"
#include "rt/tracer_scene.h"

namespace sideray::rt::thin_wall_test {
namespace {

using namespace test;

constexpr uint32_t width = 160, height = 96;
constexpr float half_wall = 0.005f;
constexpr float two_codes = 2.0f / 255 / 12.92f;  // of a PNG, in linear light

// Rooms of 2 x 2 x 3 on either side of x = 0. The wall goes through the walls about it, so that no edge lies on another.
std::shared_ptr<const model::Snapshot> two_rooms(bool front) {
  TestScene scene;
  sideray_material_desc white = plain_material();
  white.roughness = 1.0f;
  for (int c = 0; c < 3; ++c) white.base_color[c] = 0.7f;
  scene.quad({0, 0, 0}, {2, 0, 0}, {0, 0, -1.5f}, white);
  for (const float side : {-1.0f, 1.0f}) {
    scene.quad({2 * side, 1, 0}, {0, 1, 0}, {0, 0, 1.5f}, white);
    scene.quad({half_wall * side, 0.95f, 0}, {0, 1.05f, 0}, {0, 0, 1.6f}, white);
  }
  scene.quad({0, 2, 0}, {half_wall, 0, 0}, {0, 0, 1.6f}, white);
  scene.quad({0, 0.95f, 1.6f}, {half_wall, 0, 0}, {0, 1.05f, 0}, white);
  scene.quad({0, 1, -1.5f}, {2, 0, 0}, {0, 1, 0}, white);
  if (front) scene.quad({0, 1, 1.5f}, {2, 0, 0}, {0, 1, 0}, white);
  scene.environment(glm::vec3(0.0f));
  scene.lights({point_light({-1, 1.5f, 0}, 8)});
  return scene.commit();
}

// What a view shows of the scene: its depth as a rasterizer stores it, and which pixels are of the dark room.
struct RoomFrame {
  enum class Side { none, lit, dark };
  TraceView view;
  DepthBuffer depth{width, height, 0.0f, 0};
  std::vector<Side> sides = std::vector<Side>(size_t{width} * height, Side::none);

  RoomFrame(Tracer& tracer, const TraceView& seen) : view(seen) {
    const ViewRays rays(view, width, height);
    const std::vector<OpaquePoint> points = tracer.trace_points(view, width, height);
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; ++x) {
        const size_t texel = size_t{y} * width + x;
        if (!(points[texel].distance < 1e6)) continue;
        const Ray ray = rays.ray(x, y);
        const glm::dvec3 p = glm::dvec3(ray.origin) + glm::dvec3(ray.direction) * points[texel].distance;
        const glm::dvec4 clip = view.clip_from_local * glm::dvec4(p, 1.0);
        depth.set(x, y, static_cast<float>(clip.z / clip.w), 0);
        // The rooms' insides; on the wall's edges either counts for neither.
        const bool inside = std::abs(p.z) < 1.5001 && p.y < 1.999;
        if (inside && p.x > double{half_wall} - 1e-5) sides[texel] = Side::dark;
        if (inside && p.x < -double{half_wall}) sides[texel] = Side::lit;
      }
  }
};

struct Distance {
  const char* name;
  glm::dvec3 eye, target;
  double yfov;
  bool front;  // the rooms have a front wall
};
const Distance distances[] = {{"above", {0.3, 4, 0.1}, {0, 0, 0}, 1.05, true},
                              {"farther above", {0.3, 12, 0.1}, {0, 0, 0}, 0.44, true},
                              {"far above", {0.3, 40, 0.1}, {0, 0, 0}, 0.14, true},
                              {"before", {0.05, 1, 5}, {0, 1, 0}, 0.7, false},
                              {"far before", {0.05, 1.5, 15}, {0, 1, 0}, 0.26, false}};

class ThinWall : public testing::TestWithParam<Distance> {
 protected:
  TraceView view_from(double sideways) const {
    const Distance& at = GetParam();
    const glm::dvec3 aside(sideways, 0, 0);
    return perspective(at.eye + aside, at.target - at.eye, at.yfov, double{width} / height);
  }
  // Returns how many pixels of the dark room have light.
  size_t leaks(const RoomFrame& frame, const IrradianceImage& image) const {
    size_t bright = 0, dark = 0, lit = 0;
    for (size_t t = 0; t < frame.sides.size(); ++t) {
      const glm::vec3 light = rgb(image.light, t);
      lit += frame.sides[t] == RoomFrame::Side::lit && light.x > 0.05f;
      dark += frame.sides[t] == RoomFrame::Side::dark;
      bright += frame.sides[t] == RoomFrame::Side::dark && light.x > two_codes;
    }
    EXPECT_GT(lit, 300u);
    EXPECT_GT(dark, 300u);
    return bright;
  }
};

TEST_P(ThinWall, LeaksNothingInASinglePicture) {
  Tracer tracer({2, ""});
  tracer.set_scene(two_rooms(GetParam().front));
  const RoomFrame frame(tracer, view_from(0));
  for (const bool denoise : {false, true}) {
    size_t sum = 0;
    // Seed 28 sends paths to the wall from distant cells alone.
    for (const uint32_t seed : {1u, 2u, 3u, 28u}) {
      IrradianceRequest request;
      request.view = frame.view;
      request.width = width, request.height = height;
      request.depth = frame.depth.image();
      request.denoise = denoise;
      request.seed = seed;
      IrradianceImage image;
      tracer.trace_irradiance(request, image);
      sum += leaks(frame, image);
    }
    EXPECT_EQ(sum, 0u) << (denoise ? "filtered" : "as traced");
  }
}

TEST_P(ThinWall, LeaksNothingOverAMovingCamerasFrames) {
  Tracer tracer({2, ""});
  tracer.set_scene(two_rooms(GetParam().front));
  IrradianceHistory history;
  IrradianceImage image;
  std::optional<RoomFrame> frame;
  size_t sum = 0;
  for (int i = 0; i < 16; ++i) {
    // It moves by about a pixel a frame, then rests.
    const double step = GetParam().yfov * glm::length(GetParam().target - GetParam().eye) / height;
    frame.emplace(tracer, view_from(-step * std::min(i, 8)));
    IrradianceRequest request;
    request.view = frame->view;
    request.width = width, request.height = height;
    request.depth = frame->depth.image();
    request.denoise = true;
    request.history = &history;
    request.sequence = i == 0 ? SequenceStep::first : SequenceStep::next;
    tracer.trace_irradiance(request, image);
    sum += leaks(*frame, image);
  }
  EXPECT_EQ(sum, 0u);
}

INSTANTIATE_TEST_SUITE_P(Views, ThinWall, testing::ValuesIn(distances), [](const auto& info) {
  std::string name = info.param.name;
  std::erase(name, ' ');
  return name;
});

}  // namespace
}  // namespace sideray::rt::thin_wall_test
