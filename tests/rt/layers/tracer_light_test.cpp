// Light at traced hits against closed forms: mirrors, shadows, Fresnel, absorption, environments, textures.
#include <gmock/gmock.h>

#include <algorithm>
#include <random>

#include "rt/shading/hit_shader.h"
#include "rt/tracer_scene.h"

namespace sideray::rt::tracer_light_test {
namespace {

using namespace test;

constexpr uint32_t size = 65;  // odd: one pixel looks straight ahead
constexpr size_t middle = size_t{size / 2} * size + size / 2;
constexpr float half_precision = 1e-3f;

TraceView forward_view() {
  return perspective({0, 0, 0}, {0, 0, -1}, 0.8, 1.0);
}

// Unit direction of a pixel of forward_view.
glm::dvec3 direction_of(uint32_t x, uint32_t y) {
  const double half = std::tan(0.4);
  return glm::normalize(glm::dvec3(((x + 0.5) / size * 2 - 1) * half, ((y + 0.5) / size * 2 - 1) * half, -1));
}

LayerCache trace_layers(const std::shared_ptr<const model::Snapshot>& snapshot, uint32_t layers = 1,
                        bool shadows = true, Counters* counters = nullptr) {
  Tracer tracer({.threads = 1, .isa = ""});
  tracer.set_scene(snapshot);
  TestFrame frame(forward_view(), size, size, layers);
  frame.request.shadows = shadows;
  LayerCache cache;
  const Counters counted = tracer.trace_cache(frame.get(), cache);
  if (counters) *counters = counted;
  return cache;
}

CompositeImage trace_all(const std::shared_ptr<const model::Snapshot>& snapshot) {
  Tracer tracer({.threads = 1, .isa = ""});
  tracer.set_scene(snapshot);
  TestFrame frame(forward_view(), size, size, 0);
  CompositeImage image;
  tracer.trace_composite(frame.get(), image);
  return image;
}

void expect_near(glm::vec3 value, glm::vec3 expected, float relative) {
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(value[c], expected[c], relative * std::abs(expected[c]) + 1e-5f);
}

// A mirror at 45 degrees shows a wall beside the camera whose texels all differ.
TEST(TracerLight, a_mirror_shows_the_pattern_where_it_is) {
  constexpr uint32_t texels = 8;
  std::vector<uint8_t> rgba;
  for (uint32_t row = 0; row < texels; ++row)
    for (uint32_t column = 0; column < texels; ++column)
      rgba.insert(rgba.end(), {static_cast<uint8_t>(20 + 30 * column), static_cast<uint8_t>(20 + 30 * row), 255, 255});
  TestScene scene;
  sideray_material_desc wall = glowing(glm::vec3(1.0f));
  wall.emissive_texture.texture = scene.scene.add_texture(texels, texels, SIDERAY_RGBA8, rgba.data());
  wall.emissive_texture.filter = SIDERAY_NEAREST;
  scene.quad({0, 0, -4}, {2, 0, -2}, {0, 3, 0}, mirror());
  scene.quad({5, 0, -4}, {0, 0, 4}, {0, 4, 0}, wall);  // u along +z, the texture's top at +y
  const LayerCache cache = trace_layers(scene.commit());
  int compared = 0;
  for (uint32_t y = 0; y < size; ++y)
    for (uint32_t x = 0; x < size; ++x) {
      if (cache.distance[texel_of(cache, x, y, 0)] == 0.0f) continue;
      const glm::dvec3 d = direction_of(x, y), n = glm::normalize(glm::dvec3(1, 0, 1));
      const glm::dvec3 p = d * (glm::dot(n, glm::dvec3(0, 0, -4)) / glm::dot(n, d));
      const glm::dvec3 r = glm::reflect(d, n), q = p + r * ((5 - p.x) / r.x);
      const double s = (q.z + 4 + 4) / 8 * texels, t = (4 - q.y) / 8 * texels;
      const double to_edge = std::min(std::abs(s - std::round(s)), std::abs(t - std::round(t)));
      if (to_edge < 1e-3 || s < 0 || t < 0 || s >= texels || t >= texels) continue;
      const glm::vec3 expected(20 + 30 * std::floor(s), 20 + 30 * std::floor(t), 255);
      // A white metal's albedo is 1 but for what the lobe loses: under 1 % when smooth.
      expect_near(rgb(cache.radiance, texel_of(cache, x, y, 0)), expected / 255.0f, 0.01f);
      ++compared;
    }
  EXPECT_GT(compared, 2000);
}

// The edge of a blocker between light and receiver, for a light at a point and one from a direction.
TEST(TracerLight, hard_shadows_end_where_geometry_says) {
  sideray_material_desc paper = blended(glm::vec3(0.8f), 0.5f);
  paper.specular = 0.0f;
  for (const bool point : {true, false}) {
    TestScene scene;
    scene.quad({0, 0, -4}, {5, 0, 0}, {0, 5, 0}, paper);
    scene.quad({-4.7f, 0, -3}, {5, 0, 0}, {0, 5, 0}, plain_material());  // ends at x = 0.3
    const glm::vec3 travel = glm::normalize(glm::vec3(-0.3f, 0, -1));
    scene.lights({point ? point_light({0.5f, 0, 0}, 10.0f) : directional_light(travel, 2.0f)});
    const double edge = point ? 0.5 - 0.2 * 4.0 / 3.0 : 0.3 - 0.3;
    const LayerCache cache = trace_layers(scene.commit());
    for (uint32_t y = 0; y < size; ++y)
      for (uint32_t x = 0; x < size; ++x) {
        const glm::dvec3 d = direction_of(x, y), p = d * (-4.0 / d.z);
        if (std::abs(p.x - edge) < 1e-4) continue;
        float expected = 0.0f;
        if (p.x > edge && point) {
          const glm::dvec3 to_light = glm::dvec3(0.5, 0, 0) - p;
          const double square = glm::dot(to_light, to_light);
          expected = static_cast<float>(0.8 / M_PI * 10.0 / square * (to_light.z / std::sqrt(square)));
        } else if (p.x > edge) {
          expected = 0.8f / static_cast<float>(M_PI) * 2.0f * -travel.z;
        }
        EXPECT_NEAR(rgb(cache.radiance, texel_of(cache, x, y, 0)).y, expected, half_precision * expected)
            << x << ' ' << y;
      }
  }
}

TEST(TracerLight, translucent_surfaces_cast_no_shadow_and_none_is_cast_on_request) {
  TestScene scene;
  scene.quad({0, 0, -4}, {5, 0, 0}, {0, 5, 0}, blended(glm::vec3(0.8f), 0.5f));
  scene.quad({0, 0, -3}, {5, 0, 0}, {0, 5, 0}, blended(glm::vec3(0.8f), 0.5f));
  scene.lights({point_light({0.5f, 0, 0}, 10.0f)});
  Counters counters;
  const LayerCache lit = trace_layers(scene.commit(), 2, true, &counters);
  EXPECT_THAT(lit.radiance, testing::Not(testing::Contains(uint16_t{0})));
  EXPECT_EQ(counters.rays_shadow, 2u * size * size);
  scene.quad({0, 0, -1}, {5, 0, 0}, {0, 5, 0}, plain_material());
  const auto blocked = scene.commit();
  EXPECT_EQ(rgb(trace_layers(blocked).radiance, middle).x, 0.0f);
  const LayerCache unshadowed = trace_layers(blocked, 2, false, &counters);
  EXPECT_EQ(unshadowed.radiance[4 * middle], lit.radiance[4 * middle]);
  EXPECT_EQ(counters.rays_shadow, 0u);
}

TEST(TracerLight, glass_transmits_what_fresnel_leaves) {
  for (const float ior : {1.0f, 1.33f, 1.5f, 2.4f})
    for (const int panes : {1, 2, 5}) {
      TestScene scene;
      sideray_material_desc material = glass();
      material.ior = ior;
      for (int k = 0; k < panes; ++k) scene.quad({0, 0, -3.0f - static_cast<float>(k)}, {9, 0, 0}, {0, 9, 0}, material);
      const float r = (ior - 1) / (ior + 1), expected = std::pow(1 - r * r, static_cast<float>(panes));
      expect_near(rgb(trace_all(scene.commit()).transmittance, middle), glm::vec3(expected), half_precision);
    }
}

TEST(TracerLight, glass_transmits_less_at_an_angle_as_schlick_says) {
  TestScene scene;
  scene.quad({0, 0, -3}, {9, 0, 0}, {0, 9, 0}, glass());
  const CompositeImage image = trace_all(scene.commit());
  for (uint32_t x = 0; x < size; ++x) {
    const double cosine = -direction_of(x, 3).z;
    const float expected = static_cast<float>(0.96 * (1 - std::pow(1 - cosine, 5)));
    expect_near(rgb(image.transmittance, size_t{3} * size + x), glm::vec3(expected), half_precision);
  }
}

TEST(TracerLight, a_slab_absorbs_by_beer_and_lambert) {
  TestScene scene;
  sideray_material_desc slab = glass();
  slab.thickness = 0.7f;
  slab.attenuation_distance = 0.4f;
  const glm::vec3 kept(0.9f, 0.5f, 0.2f), tint(0.6f, 1.0f, 0.8f);
  for (int c = 0; c < 3; ++c) slab.attenuation_color[c] = kept[c], slab.base_color[c] = tint[c];
  scene.quad({0, 0, -3}, {9, 0, 0}, {0, 9, 0}, slab);
  const glm::vec3 expected = tint * glm::pow(kept, glm::vec3(0.7f / 0.4f)) * 0.96f;
  expect_near(rgb(trace_all(scene.commit()).transmittance, middle), expected, 2 * half_precision);
}

TEST(TracerLight, glass_reflects_the_environment_by_fresnel) {
  for (const float ior : {1.33f, 1.5f, 2.4f}) {
    TestScene scene;
    sideray_material_desc material = glass();
    material.ior = ior;
    scene.quad({0, 0, -3}, {9, 0, 0}, {0, 9, 0}, material);
    scene.environment({1, 2, 3});
    const float r = (ior - 1) / (ior + 1);
    expect_near(rgb(trace_layers(scene.commit()).radiance, middle), r * r * glm::vec3(1, 2, 3), 0.02f);
  }
}

TEST(TracerLight, white_paper_under_a_white_sky_is_white) {
  TestScene scene;
  sideray_material_desc paper = blended(glm::vec3(1), 0.5f);
  paper.specular = 0.0f;
  scene.quad({0, 0, -3}, {9, 0, 4}, {0, 9, 2}, paper);
  scene.environment(glm::vec3(0.7f));
  const LayerCache cache = trace_layers(scene.commit());
  for (size_t i = 0; i < size_t{size} * size; ++i) expect_near(rgb(cache.radiance, i), glm::vec3(0.7f), 2e-3f);
}

TEST(TracerLight, surfaces_between_a_mirror_and_what_it_shows_are_composited) {
  TestScene scene;
  sideray_material_desc pane = blended({0, 0, 0}, 0.25f);
  pane.specular = 0.0f;
  pane.emissive[2] = 8.0f;
  scene.quad({0, 0, -4}, {2, 0, -2}, {0, 3, 0}, mirror());
  scene.quad({5, 0, -4}, {0, 0, 9}, {0, 9, 0}, glowing({1, 0.5f, 0}));
  scene.quad({4, 0, -4}, {0, 0, 9}, {0, 9, 0}, pane);
  scene.quad({6, 0, -4}, {0, 0, 9}, {0, 9, 0}, pane);  // behind the wall
  const glm::vec3 expected = glm::vec3(1, 0.5f, 0) * 0.75f + glm::vec3(0, 0, 8) * 0.25f;
  expect_near(rgb(trace_layers(scene.commit()).radiance, middle), expected, 0.01f);
}

// However many there are: 20 black panes before what a mirror shows.
TEST(TracerLight, no_surface_before_a_reflection_is_lost) {
  TestScene scene;
  sideray_material_desc pane = blended({0, 0, 0}, 0.1f);
  pane.specular = 0.0f;
  scene.quad({0, 0, -4}, {2, 0, -2}, {0, 3, 0}, mirror());
  scene.quad({5, 0, -4}, {0, 0, 9}, {0, 9, 0}, glowing({4, 2, 1}));
  for (int i = 0; i < 20; ++i) scene.quad({4.9f - 0.05f * static_cast<float>(i), 0, -4}, {0, 0, 9}, {0, 9, 0}, pane);
  const glm::vec3 expected = glm::vec3(4, 2, 1) * std::pow(0.9f, 20.0f);
  expect_near(rgb(trace_layers(scene.commit()).radiance, middle), expected, 0.01f);
}

// Two wings of one mesh at a right angle, both glowing mirrors: each shows the other.
TEST(TracerLight, a_surface_reflects_other_parts_of_itself) {
  sideray_material_desc material = mirror();
  material.emissive[0] = material.emissive[1] = material.emissive[2] = 1.0f;
  const std::vector<glm::vec3> corners{{-2, -2, -3}, {0, -2, -5}, {2, -2, -3}, {-2, 2, -3}, {0, 2, -5}, {2, 2, -3}};
  TestScene scene;
  scene.add(corners, std::vector<glm::vec2>(6), {0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4}, material, glm::dmat4(1.0));
  const LayerCache cache = trace_layers(scene.commit());
  // The second hit is not reflected any further, so that it adds its own glow alone.
  for (const uint32_t x : {22u, 27u, 40u})
    expect_near(rgb(cache.radiance, texel_of(cache, x, 32, 0)), glm::vec3(2.0f), 0.01f);
}

// Rays that leave a lone triangle must not meet it: neither its shadow rays nor its reflections.
TEST(TracerLight, surfaces_do_not_shadow_or_reflect_themselves) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> unit(-1, 1);
  const auto vector = [&] { return glm::dvec3(unit(random), unit(random), unit(random)); };
  sideray_material_desc metal = plain_material();
  metal.metallic = 1.0f;
  for (const double offset : {0.0, 30.0, 1000.0})
    for (const double scale : {0.01, 1.0, 50.0}) {
      int wrong = 0, tried = 0;
      for (int repeat = 0; repeat < 40; ++repeat) {
        glm::dmat4 m(glm::dvec4(vector(), 0), glm::dvec4(vector(), 0), glm::dvec4(vector(), 0), glm::dvec4(0, 0, 0, 1));
        if (std::abs(glm::determinant(glm::dmat3(m))) < 0.1) continue;
        for (int c = 0; c < 3; ++c) m[c] *= scale;
        m[3] = glm::dvec4(offset * vector(), 1);
        TestScene scene;
        const glm::vec3 a(vector()), b(vector()), c(vector());
        if (glm::length(glm::cross(b - a, c - a)) < 0.1f) continue;
        scene.add({a, b, c}, std::vector<glm::vec2>(3), {0, 1, 2}, metal, m);
        scene.environment(glm::vec3(1));
        const auto probe = scene.commit();
        const ShadingScene dark(probe);
        // Lit from the side that is looked at.
        std::vector<SurfacePoint> points;
        std::uniform_real_distribution<float> share(0.0f, 0.5f);
        for (int i = 0; i < 100; ++i) {
          Hit hit{};
          hit.u = share(random), hit.v = share(random), hit.front = i % 2 == 0;
          Ray ray{};
          const glm::vec3 front = geometric_normal(*probe, hit);
          ray.direction = glm::normalize(glm::vec3(vector()) * 0.99f - (hit.front ? front : -front));
          points.push_back(surface_point(dark, hit, ray, {0, 0}));
        }
        for (const float side : {1.0f, -1.0f}) {
          const glm::vec3 front = geometric_normal(*probe, Hit{});
          const glm::vec3 travel = -side * front + 0.9f * glm::cross(front, glm::vec3(glm::normalize(vector())));
          scene.lights({directional_light(travel, 1.0f)});
          const auto snapshot = scene.commit();
          const ShadingScene lit(snapshot);
          Intersector intersector("");
          intersector.set_scene(snapshot);
          HitShader shader;
          std::vector<glm::vec3> with(points.size()), without(points.size());
          shader.begin(lit, intersector);
          shader.shade(points, with.data());
          shader.begin(lit, intersector, {.shadows = false});
          shader.shade(points, without.data());
          for (size_t i = 0; i < points.size(); ++i, ++tried) wrong += with[i] != without[i] || !(with[i].x > 0.05f);
        }
      }
      EXPECT_EQ(wrong, 0) << "offset " << offset << ", scale " << scale << ", of " << tried;
      EXPECT_GT(tried, 2000);
    }
}

TEST(TracerLight, distant_textures_are_averaged) {
  std::vector<uint8_t> checker;
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) checker.insert(checker.end(), 4, static_cast<uint8_t>((x + y) % 2 * 255));
  TestScene scene;
  sideray_material_desc material = blended(glm::vec3(0), 1.0f);
  material.specular = 0.0f;
  for (float& c : material.emissive) c = 1.0f;
  material.emissive_texture.texture = scene.scene.add_texture(64, 64, SIDERAY_RGBA8, checker.data());
  material.emissive_texture.texture_from_uv[0] = material.emissive_texture.texture_from_uv[3] = 4.0f;
  scene.quad({0, 0, -10}, {5, 0, 0}, {0, 5, 0}, material);
  const LayerCache cache = trace_layers(scene.commit());
  for (size_t i = 0; i < size_t{size} * size; ++i) EXPECT_NEAR(rgb(cache.radiance, i).x, 0.5f, 0.01f);
}

TEST(TracerPrimary, sees_what_the_rasterizer_draws) {
  TestScene scene;
  sideray_material_desc one_sided = plain_material();
  one_sided.double_sided = 0;
  scene.quad({0, 0, -2}, {-9, 0, 0}, {0, 9, 0}, one_sided);  // its back
  scene.quad({0, 0, -3}, {9, 0, 0}, {0, 9, 0}, blended(glm::vec3(1), 0.5f));
  const uint32_t wall = scene.quad({0, 0, -4}, {9, 0, 0}, {0, 0.3f, 0}, one_sided);
  Tracer tracer({.threads = 2, .isa = ""});
  tracer.set_scene(scene.commit());
  const PrimaryImage image = tracer.trace_primary(forward_view(), size, size);
  for (uint32_t y = 0; y < size; ++y)
    for (uint32_t x = 0; x < size; ++x) {
      const size_t i = size_t{y} * size + x;
      const glm::dvec3 d = direction_of(x, y);
      const bool inside = std::abs(d.y * (-4 / d.z)) < 0.3;
      EXPECT_EQ(image.ids[i].x, inside ? wall : 0u);
      EXPECT_EQ(image.ids[i].y != 0, inside);
      if (!inside) {
        EXPECT_EQ(image.distance[i], INFINITY);
        continue;
      }
      EXPECT_NEAR(static_cast<double>(image.distance[i]), -4 / d.z, 4e-6);
      EXPECT_NEAR(image.normal[i].z, 1.0f, 1e-6f);
    }
}

TEST(TracerRays, report_hits_in_order_in_the_callers_numbering) {
  TestScene scene;
  const uint32_t front = scene.quad({0, 0, -2}, {1, 0, 0}, {0, 1, 0}, plain_material());
  const uint32_t pane = scene.quad({0, 0, -3}, {1, 0, 0}, {0, 1, 0}, glass());
  // The first triangle has no area and is dropped: the hit one keeps its number.
  const uint32_t back = scene.add({{-1, -1, -4}, {3, -1, -4}, {-1, 3, -4}}, std::vector<glm::vec2>(3),
                                  {0, 0, 1, 0, 1, 2}, plain_material(), glm::dmat4(1.0));
  Tracer tracer({.threads = 1, .isa = ""});
  tracer.set_scene(scene.commit());
  const std::vector<sideray_ray> rays{{{0.25, 0.25, 0}, {0, 0, -2}, 0.0f, INFINITY}, {{7, 0, 0}, {0, 0, -1}, 0, 9}};
  std::vector<sideray_hit> hits(6);
  tracer.trace_rays(SIDERAY_RAYS_OPAQUE, rays, 3, hits.data());
  EXPECT_EQ(hits[0].surface_id, front);
  EXPECT_EQ(hits[0].distance, 1.0);
  EXPECT_EQ(hits[0].instance, 1u);
  EXPECT_EQ(hits[0].normal[2], 1.0f);
  EXPECT_EQ(hits[1].surface_id, back);
  EXPECT_EQ(hits[1].distance, 2.0);
  EXPECT_EQ(hits[1].instance, 3u);
  EXPECT_EQ(hits[1].primitive, 1u);
  for (const size_t none : {2u, 3u, 4u, 5u}) {
    EXPECT_EQ(hits[none].surface_id, 0u);
    EXPECT_EQ(hits[none].distance, INFINITY);
  }
  tracer.trace_rays(SIDERAY_RAYS_TRANSLUCENT, rays, 2, hits.data());
  EXPECT_EQ(hits[0].surface_id, pane);
  EXPECT_EQ(hits[0].distance, 1.5);
  EXPECT_EQ(hits[1].surface_id, 0u);
}

}  // namespace
}  // namespace sideray::rt::tracer_light_test
