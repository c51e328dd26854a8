// Tests that glass conserves energy: paths through clear glass in furnaces and in a closed box, and through slabs with
// closed forms, with and without caustics.
#include <gtest/gtest.h>

#include <functional>

#include "rt/reference/path_pictures.h"
#include "rt/refraction/refraction_scene.h"

namespace sideray::rt::glass_energy_test {
namespace {

using namespace test;

// The faces of an octahedron, each cut into `steps` squared triangles, on a sphere.
Triangles ball(glm::vec3 center, float radius, uint32_t steps = 12) {
  Triangles t;
  const auto at = [&](glm::vec3 p) { return center + radius * glm::normalize(p); };
  for (int face = 0; face < 8; ++face) {
    const glm::vec3 a(face & 1 ? -1 : 1, 0, 0), b(0, face & 2 ? -1 : 1, 0), c(0, 0, face & 4 ? -1 : 1);
    const bool turned = glm::dot(glm::cross(b - a, c - a), a + b + c) < 0;
    const auto corner = [&](uint32_t i, uint32_t j) {
      const auto s = static_cast<float>(steps);
      return at(a + static_cast<float>(i) / s * (b - a) + static_cast<float>(j) / s * (c - a));
    };
    const auto triangle = [&](glm::vec3 p, glm::vec3 q, glm::vec3 r) {
      t.polygon(turned ? std::vector{p, r, q} : std::vector{p, q, r});
    };
    for (uint32_t i = 0; i < steps; ++i)
      for (uint32_t j = 0; i + j < steps; ++j) {
        triangle(corner(i, j), corner(i + 1, j), corner(i, j + 1));
        if (i + j + 1 < steps) triangle(corner(i + 1, j), corner(i + 1, j + 1), corner(i, j + 1));
      }
  }
  return t;
}

struct Body {
  const char* name;
  std::function<void(TestScene&)> add;
};

// All of them within half a unit about the origin.
std::vector<Body> clear_bodies() {
  return {{"slab", [](TestScene& s) { Triangles::box({-0.5f, -0.4f, -0.1f}, {0.5f, 0.4f, 0.1f}).add_to(s, solid_glass(1.5f)); }},
          {"ball", [](TestScene& s) { ball({0, 0, 0}, 0.45f).add_to(s, solid_glass(1.5f)); }},
          {"ball of a colour that absorbs nothing",
           [](TestScene& s) { ball({0, 0, 0}, 0.45f).add_to(s, solid_glass(1.8f, glm::vec3(1.0f), 0.2f)); }},
          {"water in glass", [](TestScene& s) {
             Triangles::box({-0.4f, -0.4f, -0.4f}, {0.4f, 0.4f, 0.4f}).add_to(s, solid_glass(1.5f));
             Triangles::box({-0.3f, -0.3f, -0.3f}, {0.3f, 0.3f, 0.3f}).add_to(s, solid_glass(1.33f));
           }}};
}

// Expects the radiance in the whole picture and in 9 parts: the glass is in the middle one.
void expect_furnace(const ReferenceImage& image, double radiance) {
  const uint32_t part = image.width / 3;
  for (uint32_t j = 0; j < 3; ++j)
    for (uint32_t i = 0; i < 3; ++i) {
      const Mean mean = mean_where(image, [&](uint32_t x, uint32_t y) { return x / part == i && y / part == j; });
      EXPECT_NEAR(mean.value, radiance, 5 * mean.deviation + 1e-3 * radiance) << i << ' ' << j;
      EXPECT_LT(mean.deviation, 0.02 * radiance);
    }
  const Mean mean = mean_of(image);
  EXPECT_NEAR(mean.value, radiance, 5 * mean.deviation + 3e-4 * radiance);
  EXPECT_LT(mean.deviation, 0.004 * radiance);
}

// Expects the mean of the whole picture: between a ball and a white floor a few long paths cause most of the noise.
void expect_open_furnace(const ReferenceImage& image, double radiance) {
  const Mean mean = mean_of(image);
  EXPECT_NEAR(mean.value, radiance, 5 * mean.deviation + 3e-4 * radiance);
  EXPECT_LT(mean.deviation, 0.01 * radiance);
}

// In a room of equally emissive walls glass changes nothing, seen directly, through glass and in reflections.
TEST(GlassEnergy, AClosedRoomThatShinesIsAFurnace) {
  constexpr double albedo = 0.5, radiance = 0.5;
  for (const Body& body : clear_bodies()) {
    SCOPED_TRACE(body.name);
    TestScene scene;
    add_room(scene, shining(static_cast<float>(albedo), static_cast<float>(radiance)));
    body.add(scene);
    const TraceView view = perspective({0.3, 0.4, 0.95}, {0, 0, 0}, 1.6, 1.0, 1e-3);
    expect_furnace(trace_paths(scene.commit(), {view}, {.size = 12, .light_samples = 96, .caustics = true}),
                   radiance / (1 - albedo));
  }
}

// On a white floor under a white sky, light that glass takes from one place returns from others. Refracted paths find
// the sky with and without caustics.
TEST(GlassEnergy, AWhiteFloorIsAFurnace) {
  for (const Body& body : clear_bodies())
    for (const bool caustics : {false, true}) {
      SCOPED_TRACE(testing::Message() << body.name << ' ' << caustics);
      TestScene scene;
      scene.environment(glm::vec3(0.75f));
      scene.quad({0, -0.55f, 0}, {0, 0, 5}, {5, 0, 0}, diffuse(1.0f));
      body.add(scene);
      const TraceView view = perspective({0.5, 1.2, 1.6}, {0, -0.2, 0}, 0.6, 1.0);
      expect_open_furnace(trace_paths(scene.commit(), {view}, {.size = 12, .light_samples = 192, .caustics = caustics}), 0.75);
    }
}

sideray_material_desc rough_glass(float roughness) {
  sideray_material_desc m = solid_glass(1.5f);
  m.roughness = roughness;
  return m;
}

// A facet of a rough surface lets out what its shading normal would reflect totally; otherwise a ball keeps it for ever.
TEST(GlassEnergy, RoughBallsUnderAWhiteSkyAreWhite) {
  for (const float roughness : {0.3f, 0.6f, 1.0f}) {
    TestScene scene;
    scene.environment(glm::vec3(0.75f));
    ball({0, 0, 0}, 0.45f).add_to(scene, rough_glass(roughness));
    const Mean mean = mean_of(trace_paths(scene.commit(), {perspective({0, 0, 2}, {0, 0, 0}, 0.35, 1.0)}, {.size = 10, .light_samples = 32}));
    EXPECT_NEAR(mean.value, 0.75, 5 * mean.deviation + 1e-3) << roughness;
    EXPECT_LT(mean.deviation, 6e-3) << roughness;
  }
}

// A ball between a white and a black half of the sky shows the same by composites as by paths.
TEST(GlassEnergy, TheRimOfARoughBallIsTheSameInCompositesAsInPaths) {
  constexpr uint32_t size = 16;
  TestScene scene;
  std::vector<glm::vec3> sky(16 * 8, glm::vec3(0.0f));
  std::fill_n(sky.begin(), 16 * 4, glm::vec3(1.0f));
  scene.scene.set_environment(16, 8, &sky[0].x, 1.0f, 0.0f);
  ball({0, 0, 0}, 0.45f).add_to(scene, rough_glass(0.6f));
  const auto snapshot = scene.commit();
  const TraceView view = perspective({0, 0, 2}, {0, 0, 0}, 0.43, 1.0);
  const ReferenceImage paths = trace_paths(snapshot, {view}, {.size = size});
  Tracer tracer({.threads = 1, .isa = ""});
  tracer.set_scene(snapshot);
  TestFrame frame(view, size, size, 0);
  frame.request.all_translucent = frame.request.refraction = true;
  CompositeImage composite;
  tracer.trace_composite(frame.get(), composite);
  for (const bool above : {true, false}) {
    const auto counts = [&](uint32_t x, uint32_t y) {
      return x >= size / 4 && x < 3 * size / 4 && (above ? y < size / 4 : y >= 3 * size / 4);
    };
    double sum = 0;
    for (uint32_t y = 0; y < size; ++y)
      for (uint32_t x = 0; x < size; ++x)
        if (counts(x, y)) sum += static_cast<double>(rgb(composite.radiance, y * size + x).y);
    EXPECT_NEAR(sum / (size * size / 8), mean_where(paths, counts).value, 0.02) << above;
  }
}

// A plane-parallel plate with glTF's Schlick term; cosines are those of the angle in the air.
struct Slab {
  double ior, thickness, absorption;

  double inside(double cosine) const { return std::sqrt(1 - (1 - cosine * cosine) / (ior * ior)); }
  double kept(double cosine) const { return std::exp(-absorption * thickness / inside(cosine)); }
  // Of the light that is reflected `turns` times at both faces inside before it leaves on the far side.
  double transmitted(double cosine, int turns) const {
    const double r = schlick(cosine, ior), k = kept(cosine);
    return (1 - r) * (1 - r) * k * std::pow(r * k, 2 * turns);
  }
  double transmitted(double cosine) const {
    const double r = schlick(cosine, ior), k = kept(cosine);
    return (1 - r) * (1 - r) * k / (1 - r * r * k * k);
  }
  double reflected(double cosine) const { return schlick(cosine, ior) + transmitted(cosine) * schlick(cosine, ior) * kept(cosine); }
  // What a ray that is not bent keeps.
  double straight(double cosine) const {
    const double r = schlick(cosine, ior);
    return (1 - r) * (1 - r) * std::exp(-absorption * thickness / cosine);
  }
};

// The mean of a function of the cosine over a hemisphere, weighted by cosine.
template <typename Function>
double diffuse_mean(const Function& f) {
  constexpr int steps = 20000;
  double sum = 0;
  for (int i = 0; i < steps; ++i) {
    const double cosine = (i + 0.5) / steps;
    sum += 2 * f(cosine) * cosine / steps;
  }
  return sum;
}

const Slab slabs[] = {{1.5, 0.3, 0.0}, {1.5, 0.3, 3.0}, {2.0, 0.3, 1.0}};
constexpr double slab_height = 1.0;

void add_floor_and_slab(TestScene& scene, double floor_albedo, const Slab& slab) {
  scene.quad({0, 0, 0}, {0, 0, 400}, {400, 0, 0}, diffuse(static_cast<float>(floor_albedo)));
  const auto low = static_cast<float>(slab_height), high = static_cast<float>(slab_height + slab.thickness);
  Triangles::box({-300, low, -300}, {300, high, 300})
      .add_to(scene, solid_glass(static_cast<float>(slab.ior), glm::vec3(static_cast<float>(std::exp(-slab.absorption))), 1.0f));
}

// Under a uniform sky or an equally emissive ceiling, light is reflected between floor and slab.
TEST(GlassEnergy, AFloorBelowASlab) {
  constexpr double albedo = 0.5;
  for (const Slab& slab : slabs) {
    SCOPED_TRACE(testing::Message() << slab.ior << ' ' << slab.absorption);
    const double back = diffuse_mean([&](double c) { return slab.reflected(c); });
    const double expected = albedo * diffuse_mean([&](double c) { return slab.transmitted(c); }) / (1 - albedo * back);
    const auto expect = [&](TestScene& scene, bool caustics) {
      add_floor_and_slab(scene, albedo, slab);
      const Mean mean = mean_of(trace_paths(scene.commit(), {from_above(0.5, 0.2)},
                                            {.size = 12, .light_samples = 160, .caustics = caustics}));
      EXPECT_NEAR(mean.value, expected, 5 * mean.deviation + 1e-3 * expected) << caustics;
      EXPECT_LT(mean.deviation, 0.007 * expected);
    };
    for (const bool caustics : {false, true}) {
      TestScene under_sky;
      under_sky.environment(glm::vec3(1.0f));
      expect(under_sky, caustics);
    }
    TestScene under_ceiling;
    under_ceiling.quad({0, 3, 0}, {0, 0, 400}, {400, 0, 0}, glowing(glm::vec3(1.0f)));
    expect(under_ceiling, true);
  }
}

// A lamp of 44 degrees above the slab: with caustics its light is refracted, and every two internal reflections
// displace it; without them it goes straight.
TEST(GlassEnergy, AWideLampAboveASlab) {
  constexpr double albedo = 0.005;  // next to nothing goes to and fro
  constexpr double lamp_height = 4, radius = 1.5, intensity = 9, radiance = intensity / (M_PI * radius * radius);
  for (const Slab& slab : slabs) {
    SCOPED_TRACE(testing::Message() << slab.ior << ' ' << slab.absorption);
    TestScene scene;
    add_floor_and_slab(scene, albedo, slab);
    sideray_light lamp = point_light({0, static_cast<float>(lamp_height), 0}, static_cast<float>(intensity));
    lamp.radius = static_cast<float>(radius);
    scene.lights({lamp});
    const auto snapshot = scene.commit();
    const auto irradiance = [&](bool bent) {
      return M_PI * radiance * diffuse_mean([&](double c) {
               const double s = std::sqrt(1 - c * c), inside = slab.inside(c), t = slab.thickness;
               if (!bent) return s * lamp_height < radius ? slab.straight(c) : 0.0;
               double sum = 0;
               for (int turns = 0; turns < 4; ++turns) {
                 const double aside = (lamp_height - t) * s / c + (2 * turns + 1) * t * s / slab.ior / inside;
                 if (aside * c < radius) sum += slab.transmitted(c, turns);
               }
               return sum;
             });
    };
    for (const bool caustics : {false, true}) {
      const double expected = albedo / M_PI * irradiance(caustics);
      // Light that turns inside before it goes straight on is no part of the rule: two bounces keep it out.
      const PathOptions options = caustics ? PathOptions{.size = 12, .light_samples = 500, .caustics = true}
                                           : PathOptions{.bounces = 2, .size = 8, .light_samples = 64};
      const Mean mean = mean_of(trace_paths(snapshot, {from_above(0.3, 0.001)}, options));
      EXPECT_NEAR(mean.value, expected, 5 * mean.deviation + 1e-3 * expected) << caustics;
      EXPECT_LT(mean.deviation, 0.02 * expected);
    }
  }
}

// The walls of a closed box absorb all light of a lamp, whatever glass does in between; walls of albedo a receive it 1
// + a + a^2 + ... times.
TEST(GlassEnergy, ABallInAClosedBoxLosesNothing) {
  constexpr double albedo = 0.3, intensity = 0.7;
  const auto flux_of_walls = [&](bool with_ball) {
    TestScene scene;
    add_room(scene, diffuse(static_cast<float>(albedo)));
    if (with_ball) ball({0.15f, -0.1f, 0.05f}, 0.5f, 24).add_to(scene, solid_glass(1.5f));
    sideray_light lamp = point_light({-0.6f, 0.55f, 0.3f}, static_cast<float>(intensity));
    lamp.radius = 0.25f;
    scene.lights({lamp});
    const auto snapshot = scene.commit();
    std::vector<Mean> walls;
    for (int axis = 0; axis < 3; ++axis)
      for (const double side : {-1.0, 1.0}) {
        // Seen straight on, so that each pixel is as much of the wall, from between it and the glass.
        constexpr double before = 0.3, yfov = 2 * 1.2793395323170296;  // atan(1 / before)
        glm::dvec3 wall(0), eye(0);
        wall[axis] = side, eye[axis] = side * (1 - before);
        const Mean mean = mean_of(trace_paths(snapshot, {perspective(eye, wall, yfov, 1.0, 1e-3)},
                                              {.size = 24, .light_samples = with_ball ? 32u : 8u, .caustics = true}));
        const double per_radiance = M_PI / albedo * 4;  // irradiance times area
        walls.push_back({mean.value * per_radiance, mean.deviation * per_radiance});
      }
    return walls;
  };
  const double expected = 4 * M_PI * intensity / (1 - albedo);
  const std::vector<Mean> bare = flux_of_walls(false), with_ball = flux_of_walls(true);
  double most_changed = 0;
  for (const auto& walls : {bare, with_ball}) {
    Mean sum;
    for (const Mean& wall : walls) sum.value += wall.value, sum.deviation += wall.deviation * wall.deviation;
    sum.deviation = std::sqrt(sum.deviation);
    EXPECT_NEAR(sum.value, expected, 5 * sum.deviation + 1e-3 * expected);
    EXPECT_LT(sum.deviation, 0.006 * expected);
  }
  for (size_t i = 0; i < bare.size(); ++i)
    most_changed = std::max(most_changed, std::abs(with_ball[i].value / bare[i].value - 1));
  EXPECT_GT(most_changed, 0.04);  // the glass is in the light's way
}

}  // namespace
}  // namespace sideray::rt::glass_energy_test
