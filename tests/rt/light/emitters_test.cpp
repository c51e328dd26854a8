// Tests which surfaces are sampled as emitters, and that the densities of samples are those of sampling.
#include "rt/light/emitters.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numeric>
#include <string>
#include <vector>

#include "rt/base/sampling.h"
#include "rt/embree/intersector.h"
#include "rt/tracer_scene.h"

namespace sideray::rt::emitters_test {
namespace {

using namespace test;

constexpr uint32_t samples = 20000;

struct Sampled {
  explicit Sampled(TestScene& scene) : snapshot(scene.commit()), emitters(*snapshot) {
    intersector.set_scene(snapshot);
  }
  // Returns the mean of value / density over samples: the integral of `value` over the directions that are sampled.
  double integral(const LitPoint& point, const std::function<double(const EmitterSampler::Sample&)>& value) const {
    double sum = 0.0;
    for (uint32_t i = 0; i < samples; ++i) {
      const EmitterSampler::Sample s = sample(point, i);
      if (s.density > 0.0f) sum += value(s) / static_cast<double>(s.density);
    }
    return sum / samples;
  }
  EmitterSampler::Sample sample(const LitPoint& point, uint32_t i) const {
    const uint32_t u = random_key({i, 3}), v = hash_bits(u), w = hash_bits(v);
    return emitters.sample(point, unit_float(u), {unit_float(v), unit_float(w)});
  }
  Hit hit(const Ray& ray) const {
    Hit found;
    intersector.nearest_opaque({&ray, 1}, {}, &found);
    return found;
  }

  std::shared_ptr<const model::Snapshot> snapshot;
  EmitterSampler emitters;
  Intersector intersector{""};
};

sideray_material_desc one_sided(glm::vec3 radiance) {
  sideray_material_desc m = glowing(radiance);
  m.double_sided = 0;
  return m;
}

// Adds panels of various sizes, turns and brightness on a sphere about the origin, so that no panel hides another.
void add_panels(TestScene& scene, uint32_t count) {
  for (uint32_t i = 0; i < count; ++i) {
    const uint32_t key = random_key({i, 11}), other = hash_bits(key);
    const float y = 2.0f * (static_cast<float>(i) + 0.5f) / static_cast<float>(count) - 1.0f;
    const float turn = 2.4f * static_cast<float>(i);
    const glm::vec3 out(std::sqrt(1.0f - y * y) * std::cos(turn), y, std::sqrt(1.0f - y * y) * std::sin(turn));
    const glm::vec3 aside(unit_float(key) - 0.5f, unit_float(other) - 0.5f, 0.1f);
    const glm::mat3 frame = frame_about(glm::normalize(out + 0.4f * aside));
    const float size = 0.1f + 0.1f * unit_float(other);
    scene.quad(5.0f * out, size * frame[0], size * frame[1], glowing(glm::vec3(1.0f + 8.0f * unit_float(key))));
  }
}

// Returns the solid angle of a triangle seen from the origin (Van Oosterom and Strackee 1983).
double solid_angle(glm::dvec3 a, glm::dvec3 b, glm::dvec3 c) {
  a = glm::normalize(a), b = glm::normalize(b), c = glm::normalize(c);
  const double volume = std::abs(glm::dot(a, glm::cross(b, c)));
  return 2.0 * std::atan2(volume, 1.0 + glm::dot(a, b) + glm::dot(b, c) + glm::dot(c, a));
}

// Returns the solid angle, and the integral of the direction over it, of the scene's triangles seen from the origin.
glm::dvec4 seen_from_origin(const model::Snapshot& snapshot) {
  constexpr int parts = 8;
  glm::dvec4 sum(0.0);
  for (const model::Instance& instance : snapshot.instances) {
    const model::Mesh& mesh = *snapshot.meshes[instance.mesh];
    for (const glm::uvec3 t : mesh.triangles) {
      const auto corner = [&](uint32_t k) {
        return glm::dvec3(instance.local_from_object * glm::vec4(mesh.positions[k], 1.0f));
      };
      const glm::dvec3 a = corner(t.x), u = (corner(t.y) - a) / double{parts}, v = (corner(t.z) - a) / double{parts};
      for (int i = 0; i < parts; ++i)
        for (int j = 0; i + j < parts; ++j)
          for (int upper = 0; upper < (i + j + 1 < parts ? 2 : 1); ++upper) {
            const double way = upper ? -1.0 : 1.0;
            const glm::dvec3 from = a + double(i + upper) * u + double(j + upper) * v, side = way * u, other = way * v;
            const double angle = solid_angle(from, from + side, from + other);
            sum += glm::dvec4(glm::normalize(from + (side + other) / 3.0), 1.0) * angle;
          }
    }
  }
  return sum;
}

TEST(Emitters, AreSampledByTheirDensity) {
  TestScene scene;
  add_panels(scene, 50);
  const Sampled sampled(scene);
  const LitPoint origin{glm::vec3(0.0f), glm::vec3(0, 1, 0), true};
  const glm::dvec4 expected = seen_from_origin(*sampled.snapshot);
  EXPECT_NEAR(sampled.integral(origin, [](const auto&) { return 1.0; }), expected.w, 0.02 * expected.w);
  for (int c = 0; c < 3; ++c) {
    const auto direction = [c](const auto& s) { return static_cast<double>(s.ray.direction[c]); };
    EXPECT_NEAR(sampled.integral(origin, direction), expected[c], 0.02 * expected.w) << c;
  }
}

// A sample is the hit of a ray to it, and has the density of a hit that a random ray found.
TEST(Emitters, HaveOneDensityForSamplesAndHits) {
  TestScene scene;
  add_panels(scene, 50);
  const Sampled sampled(scene);
  const LitPoint center{glm::vec3(0.0f), glm::vec3(0, 1, 0), false}, aside{{1, -2, 0.5f}, {1, 0, 0}, true};
  for (const LitPoint& point : {center, aside})
    for (uint32_t i = 0; i < 500; ++i) {
      const EmitterSampler::Sample s = sampled.sample(point, i);
      ASSERT_GT(s.density, 0.0f);
      Ray beyond = s.ray;
      beyond.t_far = farthest;
      const Hit hit = sampled.hit(beyond);
      if (hit.instance != s.hit.instance || hit.primitive != s.hit.primitive) continue;  // hidden, or at an edge
      EXPECT_EQ(hit.front, s.hit.front);
      EXPECT_NEAR(hit.distance, s.hit.distance, 1e-4 * hit.distance);
      EXPECT_NEAR(hit.u, s.hit.u, 1e-3f);
      EXPECT_NEAR(hit.v, s.hit.v, 1e-3f);
      EXPECT_NEAR(sampled.emitters.density(point, hit, s.ray.direction), s.density, 1e-3f * s.density);
    }
}

// A one-sided panel is sampled from its front alone, mirrored or not; a two-sided one, and a solid's wall, from its
// back too.
TEST(Emitters, AreSampledFromSidesThatEmit) {
  sideray_material_desc solid = one_sided(glm::vec3(1.0f));
  solid.transmission = 1.0f, solid.thickness = 1.0f;
  const struct {
    const char* name;
    sideray_material_desc material;
    float mirror;
    bool back;
  } cases[] = {{"one-sided", one_sided(glm::vec3(1.0f)), 1.0f, false},
               {"mirrored", one_sided(glm::vec3(1.0f)), -1.0f, false},
               {"two-sided", glowing(glm::vec3(1.0f)), 1.0f, true},
               {"solid", solid, 1.0f, true}};
  for (const auto& c : cases) {
    TestScene scene;
    // Its front faces +Z, mirrored or not.
    scene.add({{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}}, {{0, 0}, {1, 0}, {0, 1}}, {0, 1, 2}, c.material,
              glm::scale(glm::dmat4(1.0), {c.mirror, 1, 1}));
    const Sampled sampled(scene);
    for (const bool front : {true, false}) {
      const float z = front ? 2.0f : -2.0f;
      const EmitterSampler::Sample s = sampled.sample({{0.1f, 0.0f, z}, {0, 0, -z / 2.0f}, false}, 1);
      EXPECT_EQ(s.density > 0.0f, front || c.back) << c.name << front;
      const Hit hit{2.0, 0.3f, 0.3f, 0, 0, front};
      EXPECT_EQ(sampled.emitters.samples(hit), front || c.back) << c.name << front;
      EXPECT_TRUE(!(s.density > 0.0f) || s.hit.front == front) << c.name;
    }
  }
}

TEST(Emitters, AreOnlyWhatRandomRaysFindWithoutHoles) {
  const auto is_sampled = [](const sideray_material_desc& material, uint32_t visibility = SIDERAY_VISIBLE_ALL) {
    TestScene scene;
    scene.quad({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, material, visibility);
    return !EmitterSampler(*scene.commit()).empty();
  };
  const glm::vec3 bright(2.0f);
  EXPECT_TRUE(is_sampled(glowing(bright)));
  EXPECT_FALSE(is_sampled(glowing(glm::vec3(0.0f))));
  EXPECT_FALSE(is_sampled(glowing(bright), SIDERAY_VISIBLE_ALL & ~SIDERAY_VISIBLE_REFLECTION));
  sideray_material_desc unlit = matt(0.5f);
  unlit.unlit = 1;
  EXPECT_TRUE(is_sampled(unlit)) << "its base colour is emitted";
  sideray_material_desc dark = glowing(bright);
  dark.unlit = 1;
  EXPECT_FALSE(is_sampled(dark)) << "its emission is not";
  sideray_material_desc veil = glowing(bright);
  veil.alpha_mode = SIDERAY_BLEND, veil.base_color[3] = 0.5f;
  EXPECT_TRUE(is_sampled(veil));
  unlit.alpha_mode = SIDERAY_BLEND, unlit.base_color[3] = 0.5f;
  EXPECT_FALSE(is_sampled(unlit));
  sideray_material_desc holes = glowing(bright);
  holes.alpha_mode = SIDERAY_MASK, holes.base_color[3] = 0.5f, holes.alpha_cutoff = 0.75f;
  EXPECT_FALSE(is_sampled(holes));
}

// A point between two panels chooses each in proportion to its mean radiance, its texture's included.
TEST(Emitters, AreChosenByTheirRadiance) {
  for (const bool srgb : {false, true}) {
    TestScene scene;
    sideray_material_desc textured = glowing(glm::vec3(2.0f));
    const std::vector<uint8_t> texels(size_t{4} * 4 * 4, 128);
    textured.emissive_texture.texture =
        scene.scene.add_texture(4, 4, srgb ? SIDERAY_RGBA8_SRGB : SIDERAY_RGBA8, texels.data());
    scene.quad({-3, 0, 0}, {0, 1, 0}, {0, 0, 1}, textured);
    scene.quad({3, 0, 0}, {0, 1, 0}, {0, 0, 1}, glowing(glm::vec3(2.0f)));
    const Sampled sampled(scene);
    uint32_t first = 0;
    for (uint32_t i = 0; i < samples; ++i)
      first += sampled.sample({glm::vec3(0.0f), glm::vec3(0, 1, 0), true}, i).hit.instance == 0;
    const double mean = srgb ? 0.2159 : 0.502;
    EXPECT_NEAR(first / double{samples}, mean / (1.0 + mean), 0.02) << srgb;
  }
}

}  // namespace
}  // namespace sideray::rt::emitters_test
