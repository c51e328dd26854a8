// Reference pictures against closed forms, and their noise against what it should be.
#include <gtest/gtest.h>

#include <algorithm>

#include "rt/tracer_scene.h"

namespace sideray::rt {
namespace {

using namespace test;

struct Options {
  uint32_t size = 33, light_samples = 64, seed = 1, threads = 1;
  bool shadows = true;
};

ReferenceImage trace(const std::shared_ptr<const model::Snapshot>& snapshot, const TraceView& view,
                     const Options& options, Counters* counters = nullptr) {
  Tracer tracer({.threads = options.threads, .isa = ""});
  tracer.set_scene(snapshot);
  ReferenceRequest request;
  request.views = {view};
  request.width = request.height = options.size;
  request.light_samples = options.light_samples;
  request.shadows = options.shadows;
  request.seed = options.seed;
  ReferenceImage image;
  const Counters counted = tracer.trace_reference(request, image);
  if (counters) *counters = counted;
  return image;
}

// Straight down onto y = 0, +z toward the top of the picture's bottom; `half_width` of the floor is seen to each side.
TraceView downward(double height, double half_width) {
  return perspective({0, height, 0}, {0, 0, 0}, 2 * std::atan(half_width / height), 1.0, 1e-3);
}

double floor_x(uint32_t x, uint32_t size, double half_width) {
  return ((x + 0.5) / size * 2 - 1) * half_width;
}

sideray_material_desc paper() {
  sideray_material_desc m = plain_material();
  m.specular = 0.0f;
  return m;
}

// The share of the sun's disc that an edge over a plane leaves visible is that of a disc beyond a chord.
TEST(Reference, PenumbraOfTheSunsDisc) {
  constexpr double half_angle = 0.265 * M_PI / 180, edge_height = 1, half_width = 0.008;
  TestScene scene;
  scene.quad({0, 0, 0}, {0, 0, 9}, {9, 0, 0}, paper());
  scene.quad({-9, edge_height, 0}, {0, 0, 9}, {9, 0, 0}, plain_material());  // up to x = 0
  sideray_light sun = directional_light({0, -1, 0}, 2.0f);
  sun.angular_diameter_deg = 0.53f;
  scene.lights({sun});
  constexpr uint32_t size = 48;
  const ReferenceImage image = trace(scene.commit(), downward(0.02, half_width), {.size = size, .light_samples = 64});
  for (uint32_t x = 0; x < size; ++x) {
    const double u = std::clamp(floor_x(x, size, half_width) / (edge_height * std::tan(half_angle)), -1.0, 1.0);
    const double visible = 0.5 + (std::asin(u) + u * std::sqrt(1 - u * u)) / M_PI;
    double sum = 0, squares = 0;
    for (uint32_t y = 0; y < size; ++y) {
      const double value = static_cast<double>(image.color[y * size + x].x) * M_PI / 2.0;
      sum += value, squares += value * value;
    }
    const double mean = sum / size, variance = std::max(squares / size - mean * mean, 0.0);
    EXPECT_NEAR(mean, visible, 4 * std::sqrt(variance / size) + 2e-4) << "column " << x;
  }
}

// A sphere of constant radiance wholly above the horizon lights like the point at its centre.
TEST(Reference, IrradianceOfASphere) {
  const glm::dvec3 center(0.5, 1.5, -0.3);
  for (const float radius : {0.0f, 0.05f, 0.9f}) {
    TestScene scene;
    scene.quad({0, 0, 0}, {0, 0, 9}, {9, 0, 0}, paper());
    sideray_light light = point_light(glm::vec3(center), 3.0f);
    light.radius = radius;
    scene.lights({light});
    constexpr uint32_t size = 16;
    const ReferenceImage image = trace(scene.commit(), downward(0.5, 0.5), {.size = size, .light_samples = 256});
    double sum = 0, wanted = 0, variance = 0;
    for (const glm::vec3& d : image.half_difference) variance += static_cast<double>(d.y) * static_cast<double>(d.y);
    const double deviation = std::sqrt(variance / (size * size));
    EXPECT_LT(deviation, 0.01 * 3.0 / M_PI);
    for (uint32_t y = 0; y < size; ++y)
      for (uint32_t x = 0; x < size; ++x) {
        const glm::dvec3 to_light = center - glm::dvec3(floor_x(x, size, 0.5), 0, -floor_x(y, size, 0.5));
        const double d2 = glm::dot(to_light, to_light);
        const double expected = 3.0 / d2 * to_light.y / std::sqrt(d2) / M_PI;
        EXPECT_NEAR(static_cast<double>(image.color[y * size + x].y), expected, 5 * deviation + 1e-5);
        sum += static_cast<double>(image.color[y * size + x].y), wanted += expected;
      }
    EXPECT_NEAR(sum / wanted, 1.0, 1e-3) << "radius " << radius;
  }
}

TEST(Reference, AUniformEnvironmentComesBackWhole) {
  TestScene scene;
  scene.environment(glm::vec3(0.5f));
  scene.quad({0, 0, 0}, {0, 0, 9}, {9, 0, 0}, paper());
  const ReferenceImage image = trace(scene.commit(), downward(1, 0.5), {.size = 16, .light_samples = 64});
  double sum = 0;
  for (const glm::vec4& c : image.color) {
    EXPECT_EQ(c.w, 1.0f);
    sum += static_cast<double>(c.y);
  }
  EXPECT_NEAR(sum / 256 / 0.5, 1.0, 1e-3);
}

// Sky, then from behind: an opaque glow, a multiply filter, an additive glow and an alpha one, given in another order.
TEST(Reference, CompositesInTheOrderOfTheRay) {
  const auto glow = [](glm::vec3 radiance, float alpha, sideray_blend_mode blend) {
    sideray_material_desc m = glowing(radiance);
    m.alpha_mode = SIDERAY_BLEND;
    m.base_color[3] = alpha;
    m.blend_mode = blend;
    return m;
  };
  sideray_material_desc filter = blended({0.5f, 0.25f, 1.0f}, 0.8f);
  filter.blend_mode = SIDERAY_BLEND_MULTIPLY;
  TestScene scene;
  scene.environment(glm::vec3(0.125f));
  scene.quad({0, 0, -3}, {9, 0, 0}, {0, 9, 0}, glow({0.0f, 4.0f, 1.0f}, 0.5f, SIDERAY_BLEND_ADDITIVE));
  scene.quad({0, 0, -4}, {9, 0, 0}, {0, 9, 0}, filter);
  scene.quad({0, 0, -2}, {9, 0, 0}, {0, 9, 0}, glow({2.0f, 0.0f, 0.0f}, 0.25f, SIDERAY_BLEND_ALPHA));
  scene.quad({9, 0, -5}, {9, 0, 0}, {0, 9, 0}, glowing({8.0f, 8.0f, 8.0f}));  // right half
  scene.quad({0, 0, -6}, {9, 0, 0}, {0, 9, 0}, glow({99.0f, 0.0f, 0.0f}, 0.5f, SIDERAY_BLEND_ALPHA));
  const ReferenceImage image = trace(scene.commit(), perspective({0, 0, 0}, {0, 0, -1}, 0.5, 1.0), {.size = 8});
  const glm::vec3 through = glm::vec3(0.2f) + 0.8f * glm::vec3(0.5f, 0.25f, 1.0f);
  for (uint32_t x = 0; x < 8; ++x) {
    const glm::vec3 sky(0.125f);
    const glm::vec3 background = x >= 4 ? glm::vec3(8.0f) : 0.5f * glm::vec3(99.0f, 0, 0) + 0.5f * sky;
    const glm::vec3 expected = 0.25f * glm::vec3(2, 0, 0) + 0.75f * (0.5f * glm::vec3(0, 4, 1) + through * background);
    const glm::vec4 c = image.color[8 * 4 + x];
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(c[i], expected[i], 0.01f + 1e-3f * expected[i]) << x;
    const float mean_through = 0.75f * (through.x + through.y + through.z) / 3 * (x >= 4 ? 0.0f : 0.5f);
    EXPECT_NEAR(c.w, 1.0f - mean_through, 1e-5f);
  }
}

// More surfaces than any traversal holds.
TEST(Reference, MeetsEveryLayer) {
  TestScene scene;
  constexpr int panes = 150;
  sideray_material_desc pane = glowing(glm::vec3(0.0f));
  pane.alpha_mode = SIDERAY_BLEND;
  pane.base_color[3] = 0.01f;
  for (int i = 0; i < panes; ++i) scene.quad({0, 0, -1.0f - 0.01f * static_cast<float>(i)}, {9, 0, 0}, {0, 9, 0}, pane);
  scene.quad({0, 0, -9}, {9, 0, 0}, {0, 9, 0}, glowing(glm::vec3(1.0f)));
  const ReferenceImage image =
      trace(scene.commit(), perspective({0, 0, 0}, {0, 0, -1}, 0.5, 1.0), {.size = 8, .light_samples = 1});
  for (const glm::vec4& c : image.color) EXPECT_NEAR(c.x, std::pow(0.99f, float{panes}), 1e-4f);
}

// A bit of everything: two kinds of lights with sizes, an environment, rough and smooth, metal, coat, glass.
std::shared_ptr<const model::Snapshot> mixed_scene() {
  TestScene scene;
  std::vector<glm::vec3> texels(32 * 16, glm::vec3(0.2f, 0.3f, 0.4f));
  texels[4 * 32 + 10] = glm::vec3(30.0f);
  scene.scene.set_environment(32, 16, &texels[0].x, 1.0f, 20.0f);
  sideray_material_desc floor = plain_material(), coated = plain_material(), metal = plain_material();
  floor.base_color[1] = 0.5f;
  floor.roughness = 0.6f;
  coated.clearcoat = 1.0f, coated.clearcoat_roughness = 0.1f, coated.base_color[2] = 0.2f;
  metal.metallic = 1.0f, metal.roughness = 0.3f;
  scene.quad({0, -1, -4}, {4, 0, 0}, {0, 0, -4}, floor);
  scene.quad({-1, 0, -5}, {1, 0, 0}, {0, 1, 0.4f}, coated);
  scene.quad({1, 0, -5}, {1, 0, 0}, {0, 1, -0.4f}, metal);
  sideray_material_desc rough_glass = glass();
  rough_glass.roughness = 0.25f;
  scene.quad({-0.5f, -0.2f, -3}, {0.5f, 0, 0.1f}, {0, 0.5f, 0}, rough_glass);
  scene.quad({0.3f, 0, -2.5f}, {0.4f, 0, 0.2f}, {0, 0.4f, 0}, blended({0.8f, 0.2f, 0.2f}, 0.5f));
  sideray_light sun = directional_light({0.3f, -1, -0.4f}, 2.0f), lamp = point_light({0.8f, 1.2f, -3.5f}, 1.5f);
  sun.angular_diameter_deg = 4.0f;
  lamp.radius = 0.2f;
  scene.lights({sun, lamp, point_light({-1, 1, -3}, 1.0f)});
  return scene.commit();
}

const TraceView& mixed_view() {
  static const TraceView view = perspective({0, 0.3, 0}, {0, -0.2, -4}, 0.8, 1.0);
  return view;
}

// Two pictures with seeds of their own differ as much as the spread over other seeds says, and their halves too.
TEST(Reference, SeedsAreIndependentAndUnbiased) {
  constexpr uint32_t size = 24, pictures = 18;
  const auto snapshot = mixed_scene();
  std::vector<ReferenceImage> images;
  for (uint32_t seed = 1; seed <= pictures; ++seed)
    images.push_back(trace(snapshot, mixed_view(), {.size = size, .light_samples = 8, .seed = seed}));
  double z_sum = 0, z_squares = 0, z_fourths = 0, half_squares = 0, variances = 0;
  int compared = 0;
  for (size_t i = 0; i < size * size; ++i) {
    double sum = 0, squares = 0;
    for (uint32_t k = 2; k < pictures; ++k) {
      const double x = static_cast<double>(images[k].color[i].y),
                   d = static_cast<double>(images[k].half_difference[i].y);
      sum += x, squares += x * x, half_squares += d * d;
    }
    constexpr double n = pictures - 2;
    const double variance = (squares - sum * sum / n) / (n - 1);
    variances += n * variance;
    if (!(variance > 1e-12)) continue;
    const double z = static_cast<double>(images[0].color[i].y - images[1].color[i].y) / std::sqrt(2 * variance);
    z_sum += z, z_squares += z * z, z_fourths += z * z * z * z;
    ++compared;
  }
  EXPECT_GT(compared, 400);
  // A variance from n values makes z Student's: z^2 has the mean (n - 1) / (n - 3).
  const double mean = z_squares / compared, expected = (pictures - 3.0) / (pictures - 5.0);
  const double error = std::sqrt((z_fourths / compared - mean * mean) / compared);
  EXPECT_NEAR(mean, expected, 4 * error);
  EXPECT_LT(error, 0.2);
  EXPECT_NEAR(z_sum / compared, 0.0, 4 * std::sqrt(mean / compared));
  // (a - b) / 2 of two halves varies as their mean does.
  EXPECT_NEAR(half_squares / variances, 1.0, 0.1);
}

// Few samples and many agree in the mean over the picture: no sample count is biased.
TEST(Reference, MoreSamplesAreTheSamePictureWithLessNoise) {
  const auto snapshot = mixed_scene();
  const auto mean_and_noise = [&](uint32_t samples) {
    double sum = 0, noise = 0;
    const ReferenceImage image = trace(snapshot, mixed_view(), {.size = 32, .light_samples = samples});
    for (size_t i = 0; i < image.color.size(); ++i) {
      const double d = static_cast<double>(image.half_difference[i].y);
      sum += static_cast<double>(image.color[i].y), noise += d * d;
    }
    return std::pair(sum, noise);
  };
  const auto [few, few_noise] = mean_and_noise(4);
  const auto [many, many_noise] = mean_and_noise(64);
  EXPECT_NEAR(few, many, 4 * std::sqrt(few_noise + many_noise));
  EXPECT_LT(many_noise, few_noise / 16);
}

TEST(Reference, ThreadsDoNotChangeTheBits) {
  const auto snapshot = mixed_scene();
  const ReferenceImage one = trace(snapshot, mixed_view(), {.size = 40, .light_samples = 4, .threads = 1});
  const ReferenceImage two = trace(snapshot, mixed_view(), {.size = 40, .light_samples = 4, .threads = 2});
  EXPECT_EQ(one.color, two.color);
  EXPECT_EQ(one.half_difference, two.half_difference);
}

TEST(Reference, WithoutShadowsNoShadowRays) {
  Counters counters;
  trace(mixed_scene(), mixed_view(), {.size = 8, .light_samples = 2, .shadows = false}, &counters);
  EXPECT_EQ(counters.rays_shadow, 0u);
  EXPECT_GT(counters.rays_reflection, 0u);
  EXPECT_EQ(counters.pixels_total, 64u);
}

// Whatever an instance is hidden from, the eye sees it.
TEST(Reference, TheEyeSeesWhatOtherRaysDoNot) {
  TestScene scene;
  scene.quad({0, 0, -3}, {9, 0, 0}, {0, 9, 0}, glowing(glm::vec3(1.0f)), 0);
  const ReferenceImage image =
      trace(scene.commit(), perspective({0, 0, 0}, {0, 0, -1}, 0.5, 1.0), {.size = 4, .light_samples = 1});
  for (const glm::vec4& c : image.color) EXPECT_EQ(c, glm::vec4(1.0f));
}

}  // namespace
}  // namespace sideray::rt
