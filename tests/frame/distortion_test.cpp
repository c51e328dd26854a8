// Tests distortion on whole frames: the same offsets of the same picture in every mode.
#include <gtest/gtest.h>

#include <array>
#include <cmath>

#include "frame/frame.h"
#include "lab/metrics/metrics.h"
#include "scenes/builtin/builtin.h"
#include "scenes/content/shapes.h"

namespace sideray::tests::distortion_test {
namespace {

constexpr uint32_t width = 160, height = 90;
constexpr float distance = 3.0f;
// The texel of a constant normal map, by which the pane distorts the picture.
constexpr uint8_t tilted_texel[3] = {200, 96, 232};

glm::vec3 tilted_normal() {
  return glm::normalize(glm::vec3(tilted_texel[0], tilted_texel[1], tilted_texel[2]) / 127.5f - 1.0f);
}

sideray_material_desc air(uint32_t normals, float distortion) {
  sideray_material_desc d = scenes::opaque_material(glm::vec3(0), 1.0f);
  d.alpha_mode = SIDERAY_BLEND;
  d.blend_mode = SIDERAY_BLEND_ADDITIVE;
  d.unlit = 1;
  d.normal_texture.texture = normals;
  d.distortion = distortion;
  return d;
}

// Returns an unlit checkered wall behind air that adds nothing, with a pane of glass beside and behind the air.
scenes::Content checker_behind_air(float pixels, bool glass) {
  scenes::ContentBuilder b("air");
  sideray_material_desc wall = scenes::opaque_material(glm::vec3(1), 1.0f);
  wall.unlit = 1;
  wall.base_color_texture.texture = b.checker("checker", {240, 200, 40}, {20, 60, 120}, 8);
  b.object("wall", b.mesh(scenes::Shape().quad({-6, -4, -1}, {6, -4, -1}, {6, 4, -1}, {-6, 4, -1}, {3, 2}), "wall"),
           b.material("wall", wall));
  scenes::Texture normals{"tilted", 4, 4, {}, false};
  for (int i = 0; i < 16; ++i)
    normals.rgba.insert(normals.rgba.end(), {tilted_texel[0], tilted_texel[1], tilted_texel[2], 255});
  const glm::vec3 n = tilted_normal();
  const float distortion = pixels / (std::hypot(n.x, n.y) * static_cast<float>(height));
  b.object("air",
           b.mesh(scenes::Shape().quad({-1.1f, -0.8f, 0}, {1.1f, -0.8f, 0}, {1.1f, 0.8f, 0}, {-1.1f, 0.8f, 0}), "air"),
           b.material("air", air(b.texture(normals), distortion), scenes::RayTraced::no));
  if (glass) {
    sideray_material_desc pane = scenes::glass_material({0.9f, 1.0f, 0.95f}, 0.02f);
    b.object("glass",
             b.mesh(scenes::Shape().quad({-1, -1, -0.5f}, {2, -1, -0.5f}, {2, 1, -0.5f}, {-1, 1, -0.5f}), "glass"),
             b.material("glass", pane, scenes::RayTraced::yes));
  }
  const double eye[3] = {0, 0, double{distance}}, target[3] = {0, 0, 0};
  b.camera("front", scenes::look_at(eye, target, 45));
  return b.take();
}

double mean_difference(const Frame& a, const Frame& b) {
  const std::vector<float> x = a.rgb(), y = b.rgb();
  double sum = 0;
  for (size_t i = 0; i < x.size(); ++i) sum += std::abs(double{x[i]} - double{y[i]});
  return sum / static_cast<double>(x.size());
}

tests::Setup mode(sideray_translucency translucency) {
  tests::Setup setup{.width = width, .height = height, .translucency = translucency};
  setup.selection = "auto";
  return setup;
}

// Expects that inside the air a pixel shows the undistorted picture, `pixels` along the normal's view-space direction:
// that of the rasterizer, or the reference's own.
void expect_closed_form(bool reference) {
  constexpr float pixels = 6.25f;
  tests::Setup setup = mode(SIDERAY_TRANSLUCENCY_RASTER);
  setup.reference = reference;
  setup.light_samples = 1;
  const std::vector<float> plain = render(checker_behind_air(0.0f, false), setup).planes.at("G");
  const std::vector<float> moved = render(checker_behind_air(pixels, false), setup).planes.at("G");
  const glm::vec2 toward = glm::normalize(glm::vec2(tilted_normal()));
  const float reach = 0.5f / std::tan(0.5f * 0.785398163f) / distance * static_cast<float>(height);
  size_t compared = 0;
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      const glm::vec2 from_middle(static_cast<float>(x) + 0.5f - 0.5f * width,
                                  0.5f * height - static_cast<float>(y) - 0.5f);
      const bool inside = std::abs(from_middle.x) < 1.1f * reach - 1 && std::abs(from_middle.y) < 0.8f * reach - 1;
      const bool outside = std::abs(from_middle.x) > 1.1f * reach + 1 || std::abs(from_middle.y) > 0.8f * reach + 1;
      const size_t i = size_t{y} * width + x;
      if (outside) {
        EXPECT_EQ(moved[i], plain[i]) << x << "," << y;
      }
      if (!inside) continue;
      // Rows run down in the picture.
      const glm::vec2 at(static_cast<float>(x) + pixels * toward.x, static_cast<float>(y) - pixels * toward.y);
      const glm::vec2 corner = glm::floor(at), share = at - corner;
      const size_t first = static_cast<size_t>(corner.y) * width + static_cast<size_t>(corner.x);
      const float top = glm::mix(plain[first], plain[first + 1], share.x);
      const float bottom = glm::mix(plain[first + width], plain[first + width + 1], share.x);
      EXPECT_NEAR(moved[i], glm::mix(top, bottom, share.y), 1e-3f) << x << "," << y;
      ++compared;
    }
  EXPECT_GT(compared, 2000u);
}

TEST(Distortion, OfATiltedNormalMapIsTheClosedForm) {
  expect_closed_form(false);
}

TEST(Distortion, OfTheReferenceIsTheClosedForm) {
  expect_closed_form(true);
}

// Distorting surfaces without ray tracing have the same bits, whether or not rays shade the glass elsewhere.
TEST(Distortion, IsBitIdenticalUnderRasterAndHybrid) {
  for (const bool glass : {false, true}) {
    const scenes::Content content = checker_behind_air(4.4f, glass);
    const Frame raster = render(content, mode(SIDERAY_TRANSLUCENCY_RASTER));
    const Frame hybrid = render(content, mode(SIDERAY_TRANSLUCENCY_HYBRID));
    size_t differing = 0;
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; ++x) {
        // The glass begins 1 left of the middle, 3.5 away.
        const float edge = 0.5f * width - 0.5f / std::tan(0.5f * 0.785398163f) / 3.5f * static_cast<float>(height) - 1;
        const bool free = !glass || static_cast<float>(x) < edge;
        for (const char* channel : {"R", "G", "B", "A"}) {
          const size_t i = size_t{y} * width + x;
          if (free)
            ASSERT_EQ(raster.planes.at(channel)[i], hybrid.planes.at(channel)[i]) << x << "," << y;
          else
            differing += raster.planes.at(channel)[i] != hybrid.planes.at(channel)[i];
        }
      }
    EXPECT_EQ(differing > 0, glass) << "rays shade the glass";
  }
}

// The glass adds the same light to the same distorted picture in every mode; without an environment it adds none.
TEST(Distortion, IsTheSameUnderEveryMode) {
  const scenes::Content content = checker_behind_air(4.4f, true);
  tests::Setup setup = mode(SIDERAY_TRANSLUCENCY_RASTER);
  setup.sky = false;
  const Frame raster = render(content, setup);
  for (const sideray_translucency other : {SIDERAY_TRANSLUCENCY_HYBRID, SIDERAY_TRANSLUCENCY_RAYTRACED}) {
    tests::Setup traced = setup;
    traced.translucency = other;
    traced.seen_in_reflections = false;
    const Frame frame = render(content, traced);
    EXPECT_LT(mean_difference(frame, raster), 2e-3) << static_cast<int>(other);
  }
}

// The reference has its own opaque picture and offsets. It differs from raster by its texture filter alone, as without
// distortion.
TEST(Distortion, OfTheReferenceIsThatOfRaster) {
  for (const bool glass : {false, true}) {
    const auto pictures = [&](float pixels) {
      const scenes::Content content = checker_behind_air(pixels, glass);
      tests::Setup setup = mode(SIDERAY_TRANSLUCENCY_RASTER);
      setup.sky = false;
      setup.samples = 2;
      setup.light_samples = 1;
      const Frame raster = render(content, setup);
      setup.translucency = SIDERAY_TRANSLUCENCY_REFERENCE;
      const Frame layers = render(content, setup);
      setup.reference = true;
      return std::array{raster, layers, render(content, setup)};
    };
    const auto plain = pictures(0.0f), moved = pictures(6.25f);
    const double filters = mean_difference(plain[0], plain[2]), distortion = mean_difference(plain[0], moved[0]);
    EXPECT_LT(mean_difference(moved[0], moved[1]), 0.01 * distortion) << "layers alone, over the same picture";
    EXPECT_LT(mean_difference(moved[0], moved[2]), 1.1 * filters) << "of " << distortion;
    EXPECT_LT(filters, 0.2 * distortion);
  }
}

TEST(Distortion, OfNothingIsThePlainPictureBitForBit) {
  const scenes::Content content = scenes::generate("haze", {{"strength", "0"}});
  scenes::Content unmarked = content;
  std::erase_if(unmarked.objects, [](const scenes::Object& o) { return o.name == "haze"; });
  const tests::Setup setup = mode(SIDERAY_TRANSLUCENCY_HYBRID);
  EXPECT_EQ(render(content, setup).planes, render(unmarked, setup).planes) << "the air itself adds nothing";
  const scenes::Content strong = scenes::generate("haze", {});
  EXPECT_NE(render(strong, setup).planes, render(content, setup).planes);
  EXPECT_EQ(render(strong, mode(SIDERAY_TRANSLUCENCY_OFF)).planes,
            render(content, mode(SIDERAY_TRANSLUCENCY_OFF)).planes);
}

}  // namespace
}  // namespace sideray::tests::distortion_test
