// Tests which points are donors, and when points trace their own rays, by a shader that invents the results of rays;
// and that the built-in model's light from its own reused answers equals that from rays.
#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <vector>

#include "rt/base/sampling.h"
#include "rt/shading/hit_shader.h"
#include "rt/shading/ray_reuse.h"
#include "rt/tracer_scene.h"

namespace sideray::rt {
namespace {

using namespace test;
using Pixel = RayReuse::Pixel;

// Returns `found` of each point's place, and counts the points for which rays are traced.
class FoundShader final : public PointShader, public RaySharing {
 public:
  explicit FoundShader(std::function<RayAnswer(glm::vec3)> found) : found_(std::move(found)) {}
  RaySharing* sharing() override { return this; }

  void shade(std::span<const SurfacePoint> points, glm::vec3* radiance) override {
    answers_.clear();
    for (size_t i = 0; i < points.size(); ++i) {
      const RayAnswer a = found_(points[i].position);
      answers_.push_back(a);
      radiance[i] = (a.has_mirror ? share * a.mirrored : glm::vec3(0.0f)) + a.arrived;
    }
    traced += points.size();
  }
  void shade_opaque(std::span<const SurfacePoint>, glm::vec3*) override {}
  glm::vec3 surroundings(glm::vec3, float) const override { return glm::vec3(0.0f); }
  void write_answers(RayAnswer* answers) const override { std::ranges::copy(answers_, answers); }
  void consider(std::span<const SurfacePoint> points, RayProspect* prospects) override {
    answers_.clear();
    for (size_t i = 0; i < points.size(); ++i) {
      const RayAnswer a = found_(points[i].position);
      answers_.push_back(a);
      prospects[i] = {a.offered, a.has_mirror ? share : 0.0f, keeps_mirrors};
    }
  }
  void shade_reusing(std::span<const SurfacePoint> points, std::span<const ReusedRays> reused,
                     glm::vec3* radiance) override {
    for (size_t i = 0; i < points.size(); ++i) {
      const bool own = reused[i].traces_mirrors && answers_[i].has_mirror;
      const glm::vec3 mirrored = own ? answers_[i].mirrored : reused[i].mirrored;
      radiance[i] =
          (own || reused[i].has_mirror ? share * mirrored : glm::vec3(0.0f)) + answers_[i].offered * reused[i].lit;
      escaped += reused[i].has_mirror && reused[i].nearness == 0.0f;
      mirrors_traced += own;
    }
  }

  float share = 0.5f;
  bool keeps_mirrors = false;
  size_t traced = 0, escaped = 0, mirrors_traced = 0;  // traced: points with all their rays

 private:
  std::function<RayAnswer(glm::vec3)> found_;
  std::vector<RayAnswer> answers_;
};

constexpr uint16_t side = 17;  // at other corners a pixel may have one donor

// A wall seen head on, a point a pixel, donors first.
struct Wall {
  std::vector<SurfacePoint> points;
  std::vector<Pixel> pixels;

  explicit Wall(const std::function<void(Pixel, SurfacePoint&)>& change = [](Pixel, SurfacePoint&) {}) {
    for (const bool is_donor : {true, false})
      for (uint16_t y = 0; y < side; ++y)
        for (uint16_t x = 0; x < side; ++x) {
          const Pixel pixel{x, y};
          if (pixel.is_donor() != is_donor) continue;
          SurfacePoint p{};
          p.position = {x, y, 0.0f};
          p.geometric_normal = p.surface.normal = p.to_eye = {0, 0, 1};
          p.hit.instance = 3;
          p.hit.front = true;
          p.weight = 1.0f;
          change(pixel, p);
          points.push_back(p);
          pixels.push_back(pixel);
        }
  }
  size_t donors() const {
    return static_cast<size_t>(std::ranges::count_if(pixels, [](Pixel p) { return p.is_donor(); }));
  }
};

struct Drawn {
  std::vector<glm::vec3> radiance;
  size_t reused, traced;
};

Drawn draw(const Wall& wall, FoundShader& shader, float error) {
  RayReuse reuse;
  reuse.begin(error);
  Drawn drawn{std::vector<glm::vec3>(wall.points.size()), 0, 0};
  drawn.reused = reuse.shade(shader, wall.points, wall.pixels, drawn.radiance.data());
  drawn.traced = shader.traced;
  return drawn;
}

RayAnswer plain(glm::vec3 mirrored, glm::vec3 offered, float lit) {
  return {.mirrored = mirrored, .nearness = 1.0f, .has_mirror = true, .offered = offered, .arrived = offered * lit};
}

TEST(RayReuse, OnePixelOfFourTracesWhereAllAgree) {
  FoundShader shader([](glm::vec3) { return plain({1, 2, 3}, {4, 4, 4}, 0.5f); });
  const Wall wall;
  EXPECT_LT(wall.donors(), wall.points.size() * 3 / 11) << "one of four, and all corners";
  const Drawn drawn = draw(wall, shader, 1e-6f);
  EXPECT_EQ(drawn.traced, wall.donors());
  EXPECT_EQ(drawn.reused, wall.points.size() - wall.donors());
  for (const glm::vec3& c : drawn.radiance) EXPECT_LT(glm::distance(c, {2.5f, 3.0f, 3.5f}), 1e-5f);
}

// Light that grows evenly over a surface is reused without an error, but for pixels at the border, which lean outward.
TEST(RayReuse, TakesAMeanOfTheDonorsAround) {
  FoundShader shader([](glm::vec3 at) { return plain({at.x, at.y, 0}, {}, 1.0f); });
  const Wall wall;
  const Drawn drawn = draw(wall, shader, 100.0f);
  for (size_t i = 0; i < wall.points.size(); ++i) {
    const Pixel p = wall.pixels[i];
    const bool inside = p.x >= 2 && p.y >= 2 && p.x + 2 < side && p.y + 2 < side;
    EXPECT_LT(glm::distance(2.0f * drawn.radiance[i], {p.x, p.y, 0}), inside ? 0.5f : 2.0f) << p.x << " " << p.y;
  }
}

// A shadow's edge is traced, and only there: no farther from it than donors are.
TEST(RayReuse, TracesWhereDonorsDiffer) {
  const auto lit = [](glm::vec3 at) { return at.x < 7.5f ? 0.0f : 1.0f; };
  FoundShader shader([&](glm::vec3 at) { return plain({}, {1, 1, 1}, lit(at)); });
  const Wall wall;
  const Drawn drawn = draw(wall, shader, 0.25f);
  for (size_t i = 0; i < wall.points.size(); ++i) EXPECT_EQ(drawn.radiance[i].x, lit(wall.points[i].position));
  EXPECT_GT(drawn.traced, wall.donors());
  EXPECT_LE(drawn.traced, wall.donors() + size_t{4} * side);
  FoundShader again([&](glm::vec3 at) { return plain({}, {1, 1, 1}, lit(at)); });
  EXPECT_EQ(draw(wall, again, 1.5f).traced, wall.donors()) << "a greater error is given leave";
}

TEST(RayReuse, WeighsWhatIsSeenOfAPoint) {
  const auto found = [](glm::vec3 at) { return plain({}, {1, 1, 1}, at.x < 7.5f ? 0.0f : 1.0f); };
  FoundShader shader(found);
  const Wall faint([](Pixel, SurfacePoint& p) { p.weight = 0.1f; });
  EXPECT_EQ(draw(faint, shader, 0.25f).traced, faint.donors());
}

TEST(RayReuse, ReusesWithinASurfaceAlone) {
  const auto found = [](glm::vec3) { return plain({1, 1, 1}, {}, 1.0f); };
  const auto reused = [&](const std::function<void(Pixel, SurfacePoint&)>& change) {
    FoundShader shader(found);
    return draw(Wall(change), shader, 1.0f).reused;
  };
  const size_t all = reused([](Pixel, SurfacePoint&) {});
  ASSERT_EQ(all, Wall().points.size() - Wall().donors());
  const auto unless_donor = [](const auto& change) {
    return [change](Pixel pixel, SurfacePoint& p) {
      if (!pixel.is_donor()) change(p);
    };
  };
  EXPECT_EQ(reused(unless_donor([](SurfacePoint& p) { p.hit.instance = 4; })), 0u);
  EXPECT_EQ(reused(unless_donor([](SurfacePoint& p) { p.hit.front = false; })), 0u);
  EXPECT_EQ(reused(unless_donor([](SurfacePoint& p) { p.position.z = 5.0f; })), 0u) << "off its plane";
  EXPECT_EQ(reused(unless_donor([](SurfacePoint& p) { p.geometric_normal = {1, 0, 0}; })), 0u);
}

TEST(RayReuse, LightsAreReusedWhereMirrorsCannotBe) {
  const auto found = [](glm::vec3 at) { return plain({at.x < 7.5f ? 0.0f : 9.0f, 0, 0}, {1, 1, 1}, 0.5f); };
  const Wall wall;
  const size_t others = wall.points.size() - wall.donors();
  FoundShader differing(found);
  const Drawn at_the_edge = draw(wall, differing, 0.25f);
  EXPECT_EQ(at_the_edge.reused, others);
  EXPECT_EQ(at_the_edge.traced, wall.donors());
  EXPECT_GT(differing.mirrors_traced, 0u);
  EXPECT_LE(differing.mirrors_traced, size_t{4} * side);
  FoundShader coats(found);
  coats.keeps_mirrors = true;
  EXPECT_EQ(draw(wall, coats, 0.25f).reused, others);
  EXPECT_EQ(coats.mirrors_traced, others) << "all of them";
  for (const FoundShader* shader : {&differing, &coats}) EXPECT_EQ(shader->escaped, 0u);
  for (size_t i = 0; i < wall.points.size(); ++i)
    EXPECT_LT(glm::distance(at_the_edge.radiance[i], 0.5f * found(wall.points[i].position).mirrored + glm::vec3(0.5f)),
              1e-5f);
  FoundShader dark([](glm::vec3) { return plain({1, 0, 0}, {}, 1.0f); });
  dark.keeps_mirrors = true;
  const Drawn unlit = draw(wall, dark, 0.25f);
  EXPECT_EQ(unlit.reused, 0u) << "nothing is reused";
  EXPECT_EQ(dark.mirrors_traced, others);
  EXPECT_EQ(unlit.traced, wall.donors()) << "nor is a mirror's ray traced twice";
  for (const glm::vec3& c : unlit.radiance) EXPECT_EQ(c, glm::vec3(0.5f, 0.0f, 0.0f));
}

// If no ray hit anything each point sees the environment in its own direction, however much it varies.
TEST(RayReuse, LeavesOwnSurroundingsToEach) {
  FoundShader shader([](glm::vec3 at) {
    return RayAnswer{.mirrored = 10.0f * at, .nearness = 0.0f, .has_mirror = true, .offered = {}, .arrived = {}};
  });
  const Wall wall;
  EXPECT_EQ(draw(wall, shader, 1e-6f).reused, wall.points.size() - wall.donors());
  EXPECT_EQ(shader.escaped, wall.points.size() - wall.donors());
}

TEST(RayReuse, DonorsWithOtherLightsDoNotCount) {
  const auto offered = [](glm::vec3 at) {
    return RayReuse::Pixel{static_cast<uint16_t>(at.x), static_cast<uint16_t>(at.y)}.is_donor() ? 1.0f : 5.0f;
  };
  FoundShader shader([&](glm::vec3 at) { return plain({}, glm::vec3(offered(at)), 0.5f); });
  EXPECT_EQ(draw(Wall(), shader, 0.25f).reused, 0u);
}

TEST(RayReuse, PointsWithoutLightsAndMirrorsNeedNoDonor) {
  FoundShader shader([](glm::vec3) { return RayAnswer{}; });
  const Wall wall([](Pixel pixel, SurfacePoint& p) { p.hit.instance = pixel.is_donor() ? 1 : 2; });
  EXPECT_EQ(draw(wall, shader, 1e-6f).reused, wall.points.size() - wall.donors());
}

TEST(RayReuse, WhatIsNotFiniteIsTraced) {
  FoundShader bright([](glm::vec3) { return plain(glm::vec3(INFINITY), {}, 1.0f); });
  const Wall wall;
  EXPECT_EQ(draw(wall, bright, 1.0f).reused, 0u);
  FoundShader lamps([](glm::vec3) { return plain({}, glm::vec3(INFINITY), 1.0f); });
  EXPECT_EQ(draw(wall, lamps, 1.0f).reused, 0u);
}

// A floor of glass that mirrors a checked wall and the sky, under two lamps, one behind a post.
struct Floor {
  std::unique_ptr<ShadingScene> shading;
  Intersector intersector{""};
  std::vector<SurfacePoint> points;

  explicit Floor(const sideray_material_desc& material) {
    TestScene scene;
    scene.quad({0, 0, 0}, {2, 0, 0}, {0, 2, 0}, material);
    scene.quad({0, 2, 1}, {1, 0, 0}, {0, 0, 1}, glowing({0.5f, 1.0f, 2.0f}));
    scene.quad({0.5f, 0, 0.5f}, {0.1f, 0, 0}, {0, 0, 0.5f}, plain_material());
    scene.lights({point_light({-1, -1, 1}, 3.0f), point_light({1, -1, 1}, 3.0f)});
    shading = std::make_unique<ShadingScene>(scene.commit());
    intersector.set_scene(shading->snapshot);
    for (int i = 0; i < 100; ++i) {
      const glm::vec3 eye(0.0f, -4.0f, 2.0f),
          at(0.3f * static_cast<float>(i % 10) - 1.35f, 0.3f * static_cast<float>(i / 10) - 1.35f, 0.0f);
      std::vector<Ray> rays{{eye, 0.0f, glm::normalize(at - eye), 1e30f}};
      Hit hit{};
      uint32_t count = 0;
      intersector.nearest_layers(LayerSet::all_translucent, rays, {.coherent = true}, &hit, &count);
      if (count == 0) continue;
      points.push_back(surface_point(*shading, hit, rays[0], {0.0f, 0.001f}));
      points.back().key = random_key({7u, static_cast<uint32_t>(i)});
    }
  }
};

// What a point's own rays found, reused by itself, makes the light that they made; rough lobes and coats trace rays.
TEST(RayReuse, TheModelMakesTheSameOfItsOwnAnswers) {
  sideray_material_desc rough = glass(), coated = glass(), painted = blended({0.2f, 0.6f, 0.4f}, 0.5f);
  sideray_material_desc narrow = glass();
  narrow.roughness = 0.08f;
  rough.roughness = 0.4f;
  coated.clearcoat = 1.0f, coated.clearcoat_roughness = 0.0f, coated.roughness = 0.3f;
  for (const sideray_material_desc& material : {glass(), narrow, rough, coated, painted}) {
    const Floor floor(material);
    ASSERT_GT(floor.points.size(), 50u);
    HitShader shader;
    shader.begin(*floor.shading, floor.intersector, {.tell_rough = true});
    const size_t count = floor.points.size();
    std::vector<glm::vec3> traced(count), reusing(count);
    shader.shade(floor.points, traced.data());
    const std::vector<RoughReflection> rough_traced(shader.rough().begin(), shader.rough().end());
    std::vector<RayAnswer> found(count);
    shader.write_answers(found.data());
    const uint64_t reflected = shader.rays_reflection, shadowed = shader.rays_shadow;
    EXPECT_GT(shadowed, 0u);
    std::vector<RayProspect> prospects(count);
    shader.consider(floor.points, prospects.data());
    std::vector<ReusedRays> donations(count);
    size_t keeping = 0;
    for (size_t i = 0; i < count; ++i) {
      ReusedRays& reused = donations[i];
      reused.traces_mirrors = prospects[i].keeps_mirrors;
      keeping += reused.traces_mirrors;
      if (!reused.traces_mirrors)
        reused.has_mirror = found[i].has_mirror, reused.mirrored = found[i].mirrored,
        reused.nearness = found[i].nearness;
      for (int c = 0; c < 3; ++c)
        if (found[i].offered[c] > 0.0f) reused.lit[c] = found[i].arrived[c] / found[i].offered[c];
      EXPECT_LT(glm::distance(prospects[i].offered, found[i].offered), 1e-5f * (1.0f + found[i].offered.x));
    }
    shader.shade_reusing(floor.points, donations, reusing.data());
    if (keeping == 0)
      EXPECT_EQ(shader.rays_shadow, shadowed) << "no shadow ray is traced";
    else
      EXPECT_LT(shader.rays_shadow - shadowed, shadowed / 4) << "only where mirror rays end";
    EXPECT_EQ((shader.rays_reflection - reflected) * count, reflected * keeping) << "of those that keep theirs";
    ASSERT_EQ(shader.rough().size(), count);
    for (size_t i = 0; i < count; ++i) {
      EXPECT_LT(glm::distance(reusing[i], traced[i]), 1e-4f * (1.0f + glm::length(traced[i]))) << i;
      const RoughReflection &mine = shader.rough()[i], &its = rough_traced[i];
      EXPECT_LT(glm::distance(mine.weight, its.weight), 1e-6f) << i;
      EXPECT_LT(glm::distance(mine.radiance, its.radiance), 1e-5f * (1.0f + glm::length(its.radiance))) << i;
      EXPECT_EQ(mine.nearness, its.nearness) << i;
      EXPECT_EQ(its.weight == glm::vec3(0.0f) ? its.roughness : mine.roughness, its.roughness) << i;
    }
  }
}

}  // namespace
}  // namespace sideray::rt
