// Compares pictures by paths of several bounces with closed forms, with a brute-force computation, and with pictures of
// one bounce where they must agree.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "model/hemisphere.h"
#include "rt/reference/path_pictures.h"
#include "rt/refraction/refraction_scene.h"

namespace sideray::rt::paths_test {
namespace {

using namespace test;

ReferenceImage trace(const std::shared_ptr<const model::Snapshot>& snapshot, const TraceView& view, const PathOptions& options) {
  return trace_paths(snapshot, {view}, options);
}

// `relative` is the error from rounding, and from the few surfaces that the closed form leaves out.
void expect_mean(const ReferenceImage& image, double expected, double relative = 1e-4) {
  const Mean mean = mean_of(image);
  EXPECT_NEAR(mean.value, expected, 5 * mean.deviation + relative * expected);
  EXPECT_LT(mean.deviation, 0.02 * expected);  // the test says something
}

// Every wall of a closed room of any shape has the radiance e (1 + a + a^2 + ...), up to the number of bounces.
TEST(Paths, AClosedRoomIsASumOfBounces) {
  constexpr double albedo = 0.7, radiance = 0.5;
  TestScene scene;
  add_room(scene, shining(static_cast<float>(albedo), static_cast<float>(radiance)));
  const auto snapshot = scene.commit();
  const TraceView view = perspective({0.2, -0.3, 0.1}, {0, 0, -1}, 1.5, 1.0);
  for (const uint32_t bounces : {2u, 3u, 5u, unlimited}) {
    SCOPED_TRACE(bounces);
    double expected = radiance / (1 - albedo);
    if (bounces != unlimited) expected *= 1 - std::pow(albedo, bounces + 1);
    expect_mean(trace(snapshot, view, {.bounces = bounces}), expected);
  }
}

// Two parallel plates: the one that shines is seen in the other, that in the first, and so on.
TEST(Paths, TwoPlatesLightEachOther) {
  constexpr double a = 0.8, b = 0.5;
  TestScene scene;
  scene.quad({0, 0, 0}, {0, 0, 2000}, {2000, 0, 0}, shining(static_cast<float>(a), 1.0f));
  scene.quad({0, 1, 0}, {0, 0, 2000}, {2000, 0, 0}, diffuse(static_cast<float>(b)));
  const auto snapshot = scene.commit();
  const TraceView view = from_above(0.5, 0.2);
  expect_mean(trace(snapshot, view, {.bounces = 2}), 1 + a * b);
  expect_mean(trace(snapshot, view, {.bounces = 3}), 1 + a * b);
  expect_mean(trace(snapshot, view, {.bounces = 4}), 1 + a * b + a * a * b * b);
  expect_mean(trace(snapshot, view, {}), 1 / (1 - a * b), 3e-3);
}

// A small square that shines over a floor: its form factor, by a sum over the square.
TEST(Paths, SurfacesThatShineAreSampled) {
  constexpr double half = 0.1, height = 0.8, aside = 0.5, albedo = 0.6, radiance = 4;
  TestScene scene;
  scene.quad({0, 0, 0}, {0, 0, 9}, {9, 0, 0}, diffuse(static_cast<float>(albedo)));
  scene.quad({0, height, 0}, {0, 0, half}, {half, 0, 0}, shining(0.0f, static_cast<float>(radiance)));
  // A dim one besides, so that there is a choice, which the floor does not see.
  scene.quad({0, -1, 0}, {0, 0, 1}, {1, 0, 0}, shining(0.0f, 0.1f));
  double irradiance = 0;
  constexpr int steps = 100;
  for (int i = 0; i < steps; ++i)
    for (int j = 0; j < steps; ++j) {
      const glm::dvec3 to(half * (2 * (i + 0.5) / steps - 1) - aside, height, half * (2 * (j + 0.5) / steps - 1));
      const double d2 = glm::dot(to, to);
      irradiance += radiance * height * height / (d2 * d2) * 4 * half * half / (steps * steps);
    }
  const ReferenceImage image =
      trace(scene.commit(), from_above(0.3, 0.001, {aside, 0, 0}), {.bounces = 2, .light_samples = 64});
  const Mean mean = mean_of(image);
  EXPECT_NEAR(mean.value, irradiance * albedo / M_PI, 5 * mean.deviation);
  EXPECT_LT(mean.deviation, 0.02 * mean.value);  // a 270th of the floor's sky is the square
}

// A wall of height h hides (1 - d / sqrt(d^2 + h^2)) / 2 of the sky from a floor at the distance d.
TEST(Paths, AWallOccludesTheEnvironment) {
  constexpr double height = 1.0, distance = 0.6;
  TestScene scene;
  scene.environment(glm::vec3(1.0f));
  scene.quad({0, 0, 0}, {0, 0, 4000}, {4000, 0, 0}, diffuse(0.5f));
  scene.quad({0, height / 2, 0}, {0, height / 2, 0}, {0, 0, 4000}, diffuse(0.0f));
  const double hidden = 0.5 * (1 - distance / std::hypot(distance, height));
  const ReferenceImage image =
      trace(scene.commit(), from_above(0.1, 0.002, {distance, 0, 0}), {.bounces = 2, .light_samples = 256});
  expect_mean(image, 0.5 * (1 - hidden), 1e-3);
}

// White surfaces under a uniform sky are as bright as the sky, however they stand to each other.
TEST(Paths, AWhiteCornerIsAWhiteFurnace) {
  TestScene scene;
  scene.environment(glm::vec3(0.75f));
  scene.quad({0, 0, 0}, {0, 0, 5}, {5, 0, 0}, diffuse(1.0f));
  scene.quad({0, 1, 0}, {0, 1, 0}, {0, 0, 5}, diffuse(1.0f));
  const ReferenceImage image = trace(scene.commit(), from_above(0.2, 0.15, {0.2, 0, 0}), {.light_samples = 256});
  expect_mean(image, 0.75);
  // What the corner would be if paths ended.
  const Mean two = mean_of(trace(scene.commit(), from_above(0.2, 0.15, {0.2, 0, 0}), {.bounces = 2, .light_samples = 256}));
  EXPECT_LT(two.value, 0.74);
}

// Under a white sky a plate shows its directional albedo. Returns it as an integral of the shading model over the
// hemisphere, without paths, which gives the energy that the lobes lose or gain.
double directional_albedo(const SurfacePoint& point) {
  const model::Frame frame(point.surface.normal);
  constexpr int steps = 1024;
  double sum = 0;
  for (int i = 0; i < steps; ++i)
    for (int j = 0; j < steps; ++j) {
      // Dense about the mirror direction too: cosine^2 is uniform, squared toward the pole.
      const double s = (i + 0.5) / steps, sine2 = s * s, weight = 2 * s, sine = std::sqrt(sine2);
      const double azimuth = 2 * M_PI * (j + 0.5) / steps;
      const glm::vec3 l = frame.world({sine * std::cos(azimuth), sine * std::sin(azimuth), std::sqrt(1 - sine2)});
      const double cosine = std::sqrt(1 - sine2);
      if (cosine < 1e-9) continue;
      const double reflected = static_cast<double>(shading::sr_reflect_light(point.surface, point.to_eye, l).y);
      sum += reflected * M_PI * weight / (cosine * steps * steps);
    }
  return sum;
}

TEST(Paths, EveryLobeInAFurnace) {
  std::vector<std::pair<const char*, sideray_material_desc>> lobes;
  const auto add = [&](const char* name, const auto& change) {
    sideray_material_desc m = plain_material();
    change(m);
    lobes.emplace_back(name, m);
  };
  add("plastic", [](auto& m) { m.roughness = 0.5f; });
  add("metal", [](auto& m) { m.metallic = 1.0f, m.roughness = 0.3f; });
  add("rough metal", [](auto& m) { m.metallic = 1.0f; });
  add("coat", [](auto& m) { m.clearcoat = 1.0f, m.clearcoat_roughness = 0.3f; });
  add("sheen", [](auto& m) { m.sheen_color[0] = m.sheen_color[1] = m.sheen_color[2] = 1.0f, m.sheen_roughness = 0.5f; });
  for (const auto& [name, material] : lobes) {
    SCOPED_TRACE(name);
    TestScene scene;
    scene.environment(glm::vec3(1.0f));
    scene.quad({0, 0, 0}, {0, 0, 9}, {9, 0, 0}, material);
    const auto snapshot = scene.commit();
    // A narrow view: all pixels see the same angle.
    const ReferenceImage image = trace(snapshot, from_above(1, 0.001), {.light_samples = 128});
    const ShadingScene shading(snapshot);
    Hit hit{1.0, 0.3f, 0.3f, 0, 0, true};
    const SurfacePoint point = surface_point(shading, hit, {{0, 1, 0}, 0, {0, -1, 0}, 10}, {});
    const double albedo = directional_albedo(point);
    expect_mean(image, albedo, 2e-3);
    EXPECT_LT(albedo, 1.02);
    RecordProperty(name, std::to_string(albedo));
  }
}

// A thin pane, rough or smooth, hides nothing: what it does not reflect it lets through.
TEST(Paths, PanesInAFurnace) {
  for (const float roughness : {0.0f, 0.5f, 1.0f}) {
    SCOPED_TRACE(roughness);
    TestScene scene;
    scene.environment(glm::vec3(1.0f));
    sideray_material_desc m = glass();
    m.roughness = roughness;
    scene.quad({0, 0, 0}, {0, 0, 9}, {9, 0, 0}, m);
    const Mean mean = mean_of(trace(scene.commit(), from_above(1, 0.1), {.light_samples = 64}));
    EXPECT_LT(mean.value, 1.0 + 5 * mean.deviation + 1e-4);
    EXPECT_GT(mean.value, 0.97);  // rough facets reflect less of 0.04 than smooth ones
  }
}

// A body of glass is invisible too: every path out of it ends in the sky. Rough glass loses multiple scattering at
// every surface.
TEST(Paths, ABoxOfGlassInAFurnace) {
  for (const auto& [roughness, dispersion] : {std::pair(0.0f, 0.0f), {0.4f, 0.0f}, {0.0f, 5.0f}}) {
    SCOPED_TRACE(testing::Message() << roughness << ' ' << dispersion);
    TestScene scene;
    scene.environment(glm::vec3(1.0f));
    sideray_material_desc m = glass();
    m.thickness = 1.0f;
    m.roughness = roughness;
    m.dispersion = dispersion;
    Triangles::box(glm::vec3(-1), glm::vec3(1)).add_to(scene, m);
    const TraceView view = perspective({0.7, 0.9, 3}, {0, 0, 0}, 0.5, 1.0);
    const Mean mean = mean_of(trace(scene.commit(), view, {.light_samples = 16}));
    EXPECT_LT(mean.value, 1.0 + 5 * mean.deviation + 1e-4);
    EXPECT_GT(mean.value, roughness > 0 ? 0.9 : 0.995);
  }
}

// A large sun through a solid pane: the caustic of a plane-parallel plate is the sun's light times its transmittance,
// (1 - R) / (1 + R). Only paths find it.
TEST(Paths, LightThroughASlabIsFoundByChance) {
  const float albedo = 0.05f;  // little comes back from the slab
  TestScene scene;
  scene.quad({0, 0, 0}, {0, 0, 400}, {400, 0, 0}, diffuse(albedo));
  sideray_light sun = directional_light({0, -1, 0}, 3.0f);
  sun.angular_diameter_deg = 60.0f;
  scene.lights({sun});
  const auto bare = scene.commit();
  sideray_material_desc m = glass();
  m.thickness = 1.0f;
  Triangles::box({-200, 1, -200}, {200, 1.2f, 200}).add_to(scene, m);
  const auto covered = scene.commit();
  const TraceView view = from_above(0.5, 0.2);
  const Mean all = mean_of(trace(bare, view, {.bounces = 2}));
  EXPECT_NEAR(all.value, static_cast<double>(albedo) * 3 / M_PI, 5 * all.deviation + 1e-4);
  const Mean through = mean_of(trace(covered, view, {.light_samples = 512}));
  // The mean of the plate's transmittance over the sun's disc, by cosine.
  double sum = 0, weights = 0;
  for (int i = 0; i < 1000; ++i) {
    const double c = 1 - (1 - std::cos(M_PI / 6)) * (i + 0.5) / 1000, r = schlick(c, 1.5);
    sum += c * (1 - r) / (1 + r), weights += c;
  }
  EXPECT_NEAR(through.value / all.value, sum / weights, 5 * through.deviation / all.value + 0.01);
  EXPECT_LT(through.deviation, 0.02 * through.value);
}

// Light of point lights passes refracting surfaces straight, since no path would find it; absorption still applies.
TEST(Paths, LightWithoutASizePassesWhatIsTranslucent) {
  const auto lit = [](const sideray_material_desc& material, bool solid) {
    TestScene scene;
    scene.quad({0, 0, 0}, {0, 0, 9}, {9, 0, 0}, diffuse(0.05f));
    scene.lights({directional_light({0, -1, 0}, 2.0f)});
    if (solid)
      Triangles::box({-9, 1, -9}, {9, 1.5f, 9}).add_to(scene, material);
    else
      scene.quad({0, 1, 0}, {0, 0, 9}, {9, 0, 0}, material);
    return mean_of(trace(scene.commit(), from_above(0.5, 0.2), {.bounces = 2})).value * M_PI / (0.05 * 2.0);
  };
  EXPECT_NEAR(lit(blended({0, 0, 0}, 0.25f), false), 0.75, 1e-3);
  sideray_material_desc medium = glass();
  medium.thickness = 1.0f;
  EXPECT_NEAR(lit(medium, true), 0.96 * 0.96, 0.01);
  medium.ior = 1.0f;
  medium.attenuation_distance = 0.5f;
  for (float& c : medium.attenuation_color) c = 0.4f;
  EXPECT_NEAR(lit(medium, true), 0.4, 0.003);
}

// The same by a computation of its own: a convex room, open toward the eye, in which no light is blocked.
class BruteForce {
 public:
  static constexpr double albedo[6] = {0.8, 0.2, 0.6, 0.7, 0.5, 0.0};  // -x +x -y +y -z, and nothing at +z
  const glm::dvec3 lamp{0.3, 0.5, 0.2};

  double seen(glm::dvec3 origin, glm::dvec3 direction, int bounces) {
    double sum = 0, weight = 1;
    for (int k = 0; k < bounces; ++k) {
      double t = 1e30;
      int wall = -1;
      for (int i = 0; i < 6; ++i) {
        const double side = i % 2 ? 1 : -1, along = direction[i / 2];
        const double d = (side - origin[i / 2]) / along;
        if (along * side > 0 && d > 1e-12 && d < t) t = d, wall = i;
      }
      if (wall < 0 || wall == 5) return sum;
      origin += t * direction;
      glm::dvec3 normal(0);
      normal[wall / 2] = wall % 2 ? -1 : 1;
      const glm::dvec3 to_lamp = lamp - origin;
      const double d2 = glm::dot(to_lamp, to_lamp);
      weight *= albedo[wall];
      sum += weight / M_PI * std::max(glm::dot(normal, to_lamp), 0.0) / (d2 * std::sqrt(d2));
      direction = model_cosine(normal);
    }
    return sum;
  }

 private:
  glm::dvec3 model_cosine(glm::dvec3 normal) {
    // A point on the sphere about the tip of the normal.
    const double z = 2 * uniform_(random_) - 1, azimuth = 2 * M_PI * uniform_(random_), s = std::sqrt(1 - z * z);
    return glm::normalize(normal * 1.0000001 + glm::dvec3(s * std::cos(azimuth), s * std::sin(azimuth), z));
  }
  std::mt19937 random_{7};
  std::uniform_real_distribution<double> uniform_;
};

TEST(Paths, ARoomByBruteForce) {
  constexpr uint32_t size = 6;
  constexpr double yfov = 0.9;
  TestScene scene;
  const glm::vec3 centers[5] = {{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}};
  for (int i = 0; i < 5; ++i) {
    glm::vec3 u(0.0f), v(0.0f);
    u[(i / 2 + 1) % 3] = 1.0f, v[(i / 2 + 2) % 3] = 1.0f;
    scene.quad(centers[i], u, v, diffuse(static_cast<float>(BruteForce::albedo[i])));
  }
  BruteForce brute;
  scene.lights({point_light(glm::vec3(brute.lamp), 1.0f)});
  const ReferenceImage image =
      trace(scene.commit(), perspective({0, 0, 0.99}, {0, 0, -1}, yfov, 1.0, 1e-3), {.bounces = 4, .size = size, .light_samples = 256});
  for (uint32_t y = 0; y < size; ++y)
    for (uint32_t x = 0; x < size; ++x) {
      const double h = std::tan(0.5 * yfov);
      const glm::dvec3 direction =
          glm::normalize(glm::dvec3(((x + 0.5) / size * 2 - 1) * h, ((y + 0.5) / size * 2 - 1) * h, -1));
      double sum = 0, squares = 0;
      constexpr int samples = 4000;
      for (int i = 0; i < samples; ++i) {
        const double value = brute.seen({0, 0, 0.99}, direction, 4);
        sum += value, squares += value * value;
      }
      const double mean = sum / samples, error = std::sqrt((squares / samples - mean * mean) / samples);
      const size_t texel = size_t{y} * size + x;
      EXPECT_NEAR(static_cast<double>(image.color[texel].y), mean, 5 * error + 0.02 * mean) << x << ' ' << y;
    }
}

// Light goes from one patch to another as it goes back, past a metal that mirrors it.
TEST(Paths, LightGoesBothWays) {
  const auto received = [](bool back) {
    TestScene scene;
    const glm::vec3 small(-0.8f, 0, 0), large(0.8f, 0, 0);
    scene.quad(small, {0.4f, 0, 0}, {0, 0, -0.4f}, shining(0.5f, back ? 0.0f : 1.0f));
    scene.quad(large, {0.7f, 0, 0}, {0, 0, -0.7f}, shining(0.5f, back ? 1.0f : 0.0f));
    sideray_material_desc metal = plain_material();
    metal.metallic = 1.0f, metal.roughness = 0.5f;
    scene.quad({0, 1.5f, 0}, {2, 0, 0}, {0, 0, 2}, metal);
    // Patches face up; the eye sees the whole of one of them, from below the metal.
    const glm::dvec3 at(back ? small : large);
    const double half = back ? 0.4 : 0.7;
    const Mean mean = mean_of(trace(scene.commit(), from_above(0.9, half, at), {.bounces = 3, .light_samples = 2048}));
    return Mean{mean.value * half * half, mean.deviation * half * half};
  };
  const Mean there = received(false), back = received(true);
  EXPECT_NEAR(there.value, back.value, 5 * std::hypot(there.deviation, back.deviation));
  EXPECT_LT(there.deviation, 0.03 * there.value);
}

// On a single plate no light bounces twice: both ways of computing are the same integral, whatever they sample.
TEST(Paths, WhereNothingBouncesTheyAreTheReference) {
  std::vector<glm::vec3> texels(32 * 16, glm::vec3(0.1f));
  texels[3 * 32 + 8] = glm::vec3(60.0f);
  sideray_material_desc m = plain_material();
  m.roughness = 0.35f;
  m.base_color[1] = 0.4f;
  m.clearcoat = 0.5f, m.clearcoat_roughness = 0.2f;
  TestScene scene;
  scene.scene.set_environment(32, 16, &texels[0].x, 1.0f, 0.0f);
  scene.quad({0, 0, 0}, {0, 0, 9}, {9, 0, 0}, m);
  sideray_light lamp = point_light({0.4f, 0.6f, 0.1f}, 0.3f), sun = directional_light({0.5f, -1, 0.2f}, 1.0f);
  lamp.radius = 0.25f;
  sun.angular_diameter_deg = 8.0f;
  scene.lights({lamp, sun, point_light({-0.3f, 0.5f, 0}, 0.2f)});
  const auto snapshot = scene.commit();
  const TraceView view = perspective({0.5, 0.7, 1}, {0, 0, 0}, 0.6, 1.0);
  const ReferenceImage one = trace(snapshot, view, {.bounces = 1, .size = 16});
  const ReferenceImage all = trace(snapshot, view, {.bounces = unlimited, .size = 16});
  for (int c = 0; c < 3; ++c) {
    const Mean a = mean_of(one, c), b = mean_of(all, c);
    EXPECT_NEAR(a.value, b.value, 4 * std::hypot(a.deviation, b.deviation));
    EXPECT_LT(std::hypot(a.deviation, b.deviation), 0.005 * a.value);
  }
}

// All that paths meet: glass in water, a rough pane, blended and single-sided quads, lights with sizes and without.
// `opaque`: and what is behind.
std::shared_ptr<const model::Snapshot> everything(bool opaque = true) {
  TestScene scene;
  std::vector<glm::vec3> texels(32 * 16, glm::vec3(0.2f, 0.3f, 0.4f));
  texels[4 * 32 + 10] = glm::vec3(30.0f);
  scene.scene.set_environment(32, 16, &texels[0].x, 1.0f, 20.0f);
  sideray_material_desc metal = plain_material(), rough = glass(), water = glass(), body = glass();
  metal.metallic = 1.0f, metal.roughness = 0.3f;
  rough.roughness = 0.4f;
  water.thickness = body.thickness = 1.0f;
  water.ior = 1.33f, water.attenuation_distance = 1.0f, water.attenuation_color[0] = 0.3f;
  body.roughness = 0.2f;
  sideray_material_desc leaf = diffuse(0.4f), single = blended({0.2f, 0.8f, 0.2f}, 0.4f);
  leaf.diffuse_transmission = 0.5f;
  single.double_sided = 0;
  if (opaque) {
    scene.quad({0, -1, -4}, {4, 0, 0}, {0, 0, -4}, diffuse(0.7f));
    scene.quad({0, 1, -6}, {3, 0, 0}, {0, 2, 0}, metal);
  }
  scene.quad({-1.2f, 0, -3}, {0.4f, 0, 0.1f}, {0, 0.5f, 0}, rough);
  if (opaque) scene.quad({1.2f, 0.5f, -3.5f}, {0.4f, 0, 0.2f}, {0, 0.4f, 0}, leaf);
  scene.quad({0.3f, 1, -3.5f}, {0.4f, 0, 0.2f}, {0, 0.4f, 0}, single);
  Triangles::box({-0.6f, -0.9f, -4.5f}, {0.6f, 0, -3.5f}).add_to(scene, water);
  Triangles::box({-0.3f, -0.7f, -4.2f}, {0.3f, -0.2f, -3.8f}).add_to(scene, body);
  sideray_light sun = directional_light({0.3f, -1, -0.4f}, 2.0f), lamp = point_light({0.8f, 1.2f, -3.5f}, 1.5f);
  sun.angular_diameter_deg = 10.0f;
  lamp.radius = 0.2f;
  scene.lights({sun, lamp, point_light({-1, 1, -3}, 1.0f)});
  return scene.commit();
}

const TraceView& view_of_everything() {
  static const TraceView view = perspective({0, 0.3, 0}, {0, -0.2, -4}, 0.8, 1.0);
  return view;
}

TEST(Paths, ThreadsDoNotChangeTheBits) {
  const auto snapshot = everything();
  const ReferenceImage one = trace(snapshot, view_of_everything(), {.size = 40, .light_samples = 4, .threads = 1});
  const ReferenceImage two = trace(snapshot, view_of_everything(), {.size = 40, .light_samples = 4, .threads = 2});
  EXPECT_EQ(one.color, two.color);
  EXPECT_EQ(one.half_difference, two.half_difference);
  for (const glm::vec4& c : one.color)
    for (int i = 0; i < 4; ++i) EXPECT_TRUE(std::isfinite(c[i]) && c[i] >= 0.0f);
}

// After many bounces no light is left. Rooms and furnaces test that Russian roulette is unbiased.
TEST(Paths, ManyBouncesAreAllThereIs) {
  const auto snapshot = everything();
  const PathOptions many{.bounces = 64, .size = 12, .light_samples = 64}, other{.bounces = unlimited, .size = 12, .light_samples = 64, .seed = 2};
  const Mean a = mean_of(trace(snapshot, view_of_everything(), many)),
             b = mean_of(trace(snapshot, view_of_everything(), other));
  EXPECT_NEAR(a.value, b.value, 4 * std::hypot(a.deviation, b.deviation));
  const Mean two = mean_of(trace(snapshot, view_of_everything(), {.bounces = 2, .size = 12, .light_samples = 64}));
  EXPECT_LT(two.value, a.value);
}

// Layers with separate paths have the same surfaces, in front of the same sky.
TEST(Paths, TheEyesAreThoseOfLayers) {
  const auto snapshot = everything(false);
  constexpr uint32_t size = 32;
  const ReferenceImage image = trace(snapshot, view_of_everything(), {.size = size, .light_samples = 64});
  Tracer tracer({.threads = 1, .isa = ""});
  tracer.set_scene(snapshot);
  TestFrame frame(view_of_everything(), size, size, 0);
  frame.request.all_translucent = true;
  frame.request.refraction = true;
  frame.request.light_samples = 64;
  LayerRequest request = frame.get();
  request.bounces = unlimited;
  request.seed = 2;
  CompositeImage layers;
  tracer.trace_composite(request, layers);
  double by_eye = 0, by_layers = 0, deviation = 0, through = 0;
  for (size_t i = 0; i < image.color.size(); ++i) {
    // What nothing bends on the way to the sky is not a layer's.
    const bool is_clear = rgb(layers.transmittance, i) != glm::vec3(0.0f);
    through += is_clear;
    if (is_clear) continue;
    by_eye += static_cast<double>(image.color[i].y), by_layers += static_cast<double>(rgb(layers.radiance, i).y);
    const double a = static_cast<double>(image.half_difference[i].y), b = static_cast<double>(layers.half_difference[i].y);
    deviation += a * a + b * b;
  }
  EXPECT_LT(through, 0.9 * static_cast<double>(image.color.size()));
  EXPECT_NEAR(by_eye, by_layers, 5 * std::sqrt(deviation) + 1e-3 * by_layers);
  EXPECT_LT(std::sqrt(deviation), 0.02 * by_layers);
}

// With translucent surfaces alone by paths, opaque ones stay as they were drawn.
TEST(Paths, CompositesTakeThem) {
  TestScene scene;
  scene.environment(glm::vec3(0.5f));
  sideray_material_desc pane = blended({1, 1, 1}, 0.5f);
  pane.specular = 0.0f;
  scene.quad({0, 0, -3}, {9, 0, 0}, {0, 9, 0}, pane);
  scene.quad({0, 0, 1}, {90, 0, 0}, {0, 90, 0}, diffuse(0.0f));  // hides the sky in front of the pane
  Tracer tracer({.threads = 1, .isa = ""});
  tracer.set_scene(scene.commit());
  const auto radiance = [&](uint32_t bounces) {
    TestFrame frame(perspective({0, 0, 0}, {0, 0, -1}, 0.5, 1.0), 8, 8, 0);
    frame.request.all_translucent = true;
    frame.request.light_samples = 64;
    LayerRequest request = frame.get();
    request.bounces = bounces;
    CompositeImage image;
    tracer.trace_composite(request, image);
    return rgb(image.radiance, 20).y;
  };
  EXPECT_NEAR(radiance(1), 0.25f, 0.01f);
  EXPECT_LT(radiance(2), 0.05f);
}

// A quarter of a card shines, in squares that a pixel's footprint averages to nothing: with many positions each reads
// finer texels, and the picture is that of the squares.
TEST(Paths, PositionsReadTexturesByTheirShareOfThePixel) {
  constexpr uint32_t size = 64;
  std::vector<uint8_t> texels(size * size * 4, 255);
  for (uint32_t y = 0; y < size; ++y)
    for (uint32_t x = 0; x < size; ++x) texels[4 * (y * size + x) + 3] = x % 4 < 2 && y % 4 < 2 ? 255 : 0;
  TestScene scene;
  const uint32_t texture = scene.scene.add_texture(size, size, SIDERAY_RGBA8, texels.data());
  sideray_material_desc m = plain_material();
  m.alpha_mode = SIDERAY_MASK, m.alpha_cutoff = 0.5f;
  m.base_color_texture.texture = texture;
  m.unlit = 1;
  scene.quad({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, m);
  const auto snapshot = scene.commit();
  const auto seen = [&](uint32_t side) {
    std::vector<TraceView> views;
    for (uint32_t i = 0; i < side * side; ++i) {
      const double pixel = 1.0 / 8, x = (i % side + 0.5) / side * pixel, y = (i / side + 0.5) / side * pixel;
      views.push_back(perspective({x, y, 10}, {x, y, 0}, 2 * std::atan(0.05), 1.0));
    }
    return mean_of(trace_paths(snapshot, views, {.light_samples = 1})).value;
  };
  EXPECT_EQ(seen(1), 0.0);
  EXPECT_NEAR(seen(16), 0.25, 0.03);
}

}  // namespace
}  // namespace sideray::rt::paths_test
