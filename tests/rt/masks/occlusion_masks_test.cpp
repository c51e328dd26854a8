// Tests shadow masks from a depth buffer: planes are lit, and inexact tests follow their closed forms.
#include <gtest/gtest.h>
#include <sideray/diagnostics.h>

#include <algorithm>
#include <cmath>

#include "rt/base/view_rays.h"
#include "rt/tracer.h"
#include "rt/tracer_scene.h"

namespace sideray::rt::occlusion_masks_test {
namespace {

using namespace test;

constexpr uint32_t width = 64, height = 48;
constexpr uint32_t marked = 0x80;

TraceView ordinary(glm::dvec3 eye, glm::dvec3 target, double near) {
  TraceView view;
  view.clip_from_local = glm::perspectiveRH_NO(0.8, double{width} / height, near, 1e5 * near) *
                         glm::lookAt(eye, target, glm::dvec3(0, 1, 0));
  view.local_from_clip = glm::inverse(view.clip_from_local);
  return view;
}

// What a rasterizer stores of planes dot(normal, p) = distance, rounded to floats; `plane` says which one a pixel
// shows.
struct Plane {
  glm::dvec3 normal;
  double distance;
};
template <typename PlaneOfColumn>
DepthBuffer depth_of(const TraceView& view, uint32_t stencil, const PlaneOfColumn& plane_of) {
  DepthBuffer depth(width, height, view.reversed_depth ? 0.0f : 1.0f, stencil);
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      const Plane plane = plane_of(x);
      const glm::dvec2 ndc((x + 0.5) / width * 2.0 - 1.0, (y + 0.5) / height * 2.0 - 1.0);
      const auto at = [&](double z) {
        const glm::dvec4 h = view.local_from_clip * glm::dvec4(ndc, z, 1.0);
        return glm::dvec3(h) / h.w;
      };
      const glm::dvec3 a = at(0.9), b = at(0.5);
      const double height_a = glm::dot(a, plane.normal) - plane.distance;
      const double t = height_a / (height_a - (glm::dot(b, plane.normal) - plane.distance));
      const glm::dvec4 clip = view.clip_from_local * glm::dvec4(a + t * (b - a), 1.0);
      if (clip.w <= 0.0) continue;
      const double z = clip.z / clip.w, window = view.zero_to_one_depth ? z : 0.5 * z + 0.5;
      if (window > 0.0 && window < 1.0) depth.set(x, y, static_cast<float>(window), stencil);
    }
  return depth;
}

DepthBuffer depth_of_floor(const TraceView& view, uint32_t stencil) {
  return depth_of(view, stencil, [](uint32_t) { return Plane{{0, 1, 0}, 0.0}; });
}

size_t dark(const OcclusionMasks& masks) {
  return static_cast<size_t>(std::count(masks.lit.begin(), masks.lit.end(), uint8_t{0}));
}

MaskRequest request_of(const TraceView& view, const DepthBuffer& depth) {
  MaskRequest request;
  request.view = view;
  request.width = width, request.height = height;
  request.depth = depth.image();
  request.shadow_lights = 1;
  return request;
}

TEST(OcclusionMasks, a_plane_does_not_shadow_itself) {
  Tracer tracer({2, ""});
  size_t pixels = 0;
  for (const double h : {0.1, 1.0, 10.0, 100.0, 1000.0, 10000.0}) {
    const auto size = static_cast<float>(h);
    TestScene scene;
    scene.quad({0, 0, 0}, {100 * size, 0, 0}, {0, 0, 100 * size}, plain_material());
    scene.lights({directional_light({0.9f, -0.3f, 0.2f}, 1.0f)});
    tracer.set_scene(scene.commit());
    const glm::dvec3 eye(0.1 * h, h, 0.3 * h), steep(0, 0, -0.5 * h), shallow(0, 0, -12.0 * h);
    for (const glm::dvec3& target : {steep, shallow})
      for (const TraceView& view :
           {perspective(eye, target, 0.8, double{width} / height, 0.1),
            perspective(eye, target, 0.8, double{width} / height, 0.001 * h), ordinary(eye, target, 0.01 * h)}) {
        const DepthBuffer depth = depth_of_floor(view, 0);
        OcclusionMasks masks;
        pixels += tracer.trace_masks(request_of(view, depth), masks).rays_shadow;
        EXPECT_EQ(dark(masks), 0u) << h << " m up, toward " << target.z;
      }
  }
  EXPECT_GT(pixels, 30000u);
}

// Both neighbours of a leaf one pixel wide show the wall behind, whose depth does not give the leaf's normal.
TEST(OcclusionMasks, a_thin_leaf_does_not_shadow_itself) {
  const TraceView view = perspective({0, 0, 5}, {0, 0, 0}, 0.8, double{width} / height);
  for (const float turn : {-1.1f, -0.5f, 0.0f, 0.4f, 1.2f})
    for (const float sun : {-0.9f, -0.2f, 0.5f, 1.0f}) {
      const glm::vec3 normal(std::sin(turn), 0, std::cos(turn)), across(std::cos(turn), 0, -std::sin(turn));
      TestScene scene;
      scene.quad({0.03f, 0, 0}, 0.1f * across, {0, 4, 0}, plain_material());
      scene.quad({0, 0, -20}, {50, 0, 0}, {0, 50, 0}, plain_material());
      scene.lights({directional_light({-std::sin(sun), -0.3f, -std::cos(sun)}, 1.0f)});
      Tracer tracer({1, ""});
      tracer.set_scene(scene.commit());
      const DepthBuffer depth = depth_of(view, 0, [&](uint32_t x) {
        return x == width / 2 ? Plane{glm::dvec3(normal), 0.03 * double{normal.x}} : Plane{{0, 0, 1}, -20.0};
      });
      OcclusionMasks masks;
      tracer.trace_masks(request_of(view, depth), masks);
      for (uint32_t y = 2; y + 2 < height; ++y)
        EXPECT_EQ(masks.lit[y * width + width / 2], 255) << "leaf at " << turn << ", sun at " << sun << ", row " << y;
    }
}

// The floor is drawn at y = 0; rays meet it a gap above, as where wind has moved it down.
class MovedFloor : public testing::Test {
 protected:
  MovedFloor() {
    scene_.quad({0, gap, 0}, {50, 0, 0}, {0, 0, 50}, plain_material());
    scene_.lights({directional_light({0, -1, 0}, 1.0f)});
    tracer_.set_scene(scene_.commit());
  }
  MaskRequest request(sideray_inexact inexact) {
    MaskRequest r = request_of(view_, depth_);
    r.inexact = inexact;
    r.inexact_bits = marked;
    r.inexact_bias = bias;
    return r;
  }
  double share(const MaskRequest& r) {
    tracer_.trace_masks(r, masks_);
    return static_cast<double>(dark(masks_)) / pixels;
  }
  // Of a share of independent pixels.
  static double standard_error(double p) { return std::sqrt(p * (1.0 - p) / pixels); }

  static constexpr float gap = 0.1f, bias = 0.4f;
  static constexpr double pixels = width * height;
  TestScene scene_;
  Tracer tracer_{{2, ""}};
  TraceView view_ = perspective({0, 5, 0}, {0, 0, -1}, 0.8, double{width} / height);
  DepthBuffer depth_ = depth_of_floor(view_, marked);
  OcclusionMasks masks_;
};

TEST_F(MovedFloor, exact_rays_see_the_gap_everywhere) {
  EXPECT_EQ(share(request(SIDERAY_EXACT)), 1.0);
  MaskRequest unmarked = request(SIDERAY_INEXACT_TMIN);
  unmarked.inexact_bits = 0x40;
  EXPECT_EQ(share(unmarked), 1.0);
}

TEST_F(MovedFloor, tmin_and_origin_lose_an_occluder_with_the_probability_of_the_closed_form) {
  const double expected = double{gap} / double{bias};
  for (const sideray_inexact inexact : {SIDERAY_INEXACT_TMIN, SIDERAY_INEXACT_ORIGIN})
    EXPECT_NEAR(share(request(inexact)), expected, 4.0 * standard_error(expected));
}

TEST_F(MovedFloor, tmin_keeps_hit_distances_and_origin_does_not) {
  const auto distances = [&](sideray_inexact inexact) {
    MaskRequest r = request(inexact);
    r.hit_distances = true;
    tracer_.trace_masks(r, masks_);
    double sum = 0, count = 0;
    for (size_t i = 0; i < masks_.lit.size(); ++i)
      if (masks_.lit[i] == 0 && std::isfinite(masks_.hit_distance[i]))
        sum += double{masks_.hit_distance[i]}, count += 1.0;
    EXPECT_GT(count, 100.0);
    return sum / count;
  };
  EXPECT_NEAR(distances(SIDERAY_INEXACT_TMIN), double{gap}, 1e-4);
  // Uniform between 0 and the gap: of those that still hit.
  EXPECT_NEAR(distances(SIDERAY_INEXACT_ORIGIN), 0.5 * double{gap}, 4.0 * double{gap} / std::sqrt(12.0 * 500.0));
}

TEST_F(MovedFloor, bounded_takes_the_pixels_own_bound) {
  std::vector<glm::vec4> rest(size_t{width} * height, glm::vec4(0, 0, 0, 0));
  MaskRequest r = request(SIDERAY_INEXACT_BOUNDED);
  r.rest_offsets = rest;
  EXPECT_EQ(share(r), 1.0);
  for (glm::vec4& v : rest) v.w = 2.0f * gap;
  EXPECT_NEAR(share(r), 0.5, 4.0 * standard_error(0.5));
}

TEST_F(MovedFloor, the_rest_pose_meets_no_gap_and_has_no_noise) {
  const std::vector<glm::vec4> rest(size_t{width} * height, glm::vec4(0, gap, 0, gap));
  MaskRequest r = request(SIDERAY_INEXACT_RESTPOSE);
  r.rest_offsets = rest;
  EXPECT_EQ(share(r), 0.0);
}

TEST_F(MovedFloor, the_same_bits_for_any_thread_count) {
  Tracer one({1, ""});
  one.set_scene(scene_.commit());
  MaskRequest r = request(SIDERAY_INEXACT_TMIN);
  r.hit_distances = true, r.ao_rays = 4;
  OcclusionMasks a, b;
  one.trace_masks(r, a);
  tracer_.trace_masks(r, b);
  EXPECT_EQ(a.lit, b.lit);
  EXPECT_EQ(a.hit_distance, b.hit_distance);
  EXPECT_EQ(a.open, b.open);
}

// On a floor in shadow, pixels to which a light adds less than `least_light` are lit without a ray.
TEST(OcclusionMasks, where_a_light_adds_little_no_ray_goes) {
  Tracer tracer({2, ""});
  const TraceView view = perspective({0, 5, 0}, {0, 0, -3}, 0.8, double{width} / height);
  const DepthBuffer depth = depth_of_floor(view, 0);
  TestScene scene;
  scene.quad({0, 0, 0}, {1e4f, 0, 0}, {0, 0, 1e4f}, plain_material());
  scene.quad({0, 1, 0}, {1e4f, 0, 0}, {0, 0, 1e4f}, plain_material());
  scene.lights({point_light({0, 2, -3}, 10.0f)});
  tracer.set_scene(scene.commit());
  MaskRequest r = request_of(view, depth);
  OcclusionMasks all, near;
  const uint64_t rays = tracer.trace_masks(r, all).rays_shadow;
  r.least_light = 10.0f / glm::pi<float>() / (2.5f * 2.5f);  // at 1.5 from the point below the light
  const uint64_t rays_near = tracer.trace_masks(r, near).rays_shadow;
  EXPECT_EQ(dark(all), rays);
  EXPECT_EQ(dark(near), rays_near);
  const ViewRays pixels(view, width, height);
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      const Ray ray = pixels.ray(x, y);
      const glm::dvec3 from(ray.origin), d(ray.direction), floor = from - d * (from.y / d.y);
      const double aside = glm::length(floor - glm::dvec3(0, 0, -3));
      if (std::abs(aside - 1.5) < 0.01) continue;
      ASSERT_EQ(near.lit[size_t{y} * width + x], aside < 1.5 ? 0 : 255) << x << ' ' << y << ' ' << aside;
    }
}

// Under an endless ceiling nothing of the sky is open; without it everything is.
TEST(OcclusionMasks, open_sky_and_none) {
  Tracer tracer({2, ""});
  const TraceView view = perspective({0, 5, 0}, {0, 0, -1}, 0.8, double{width} / height);
  const DepthBuffer depth = depth_of_floor(view, 0);
  for (const bool roof : {false, true}) {
    TestScene scene;
    scene.quad({0, 0, 0}, {1e4f, 0, 0}, {0, 0, 1e4f}, plain_material());
    if (roof) scene.quad({0, 8, 0}, {1e7f, 0, 0}, {0, 0, 1e7f}, plain_material());
    tracer.set_scene(scene.commit());
    MaskRequest r = request_of(view, depth);
    r.shadow_lights = 0, r.ao_rays = 8;
    OcclusionMasks masks;
    tracer.trace_masks(r, masks);
    for (const uint8_t open : masks.open) ASSERT_EQ(open, roof ? 0 : 255);
  }
}

// A translucent ceiling takes as much of the sky as it does not let through, where it takes part at all.
TEST(OcclusionMasks, veiled_sky) {
  Tracer tracer({2, ""});
  const TraceView view = perspective({0, 5, 0}, {0, 0, -1}, 0.8, double{width} / height);
  const DepthBuffer depth = depth_of_floor(view, 0);
  sideray_material_desc additive = blended(glm::vec3(1), 0.5f), green = glass();
  additive.blend_mode = SIDERAY_BLEND_ADDITIVE;
  green.base_color[0] = green.base_color[2] = 0.0f, green.specular = 0.0f;
  const struct {
    sideray_material_desc roof;
    uint32_t visibility;
    int open;
  } cases[] = {{blended(glm::vec3(1), 0.25f), SIDERAY_VISIBLE_ALL, 191},
               {blended(glm::vec3(1), 0.25f), SIDERAY_VISIBLE_ALL & ~SIDERAY_VISIBLE_AO, 255},
               {blended(glm::vec3(1), 1.0f), SIDERAY_VISIBLE_ALL, 0},
               {additive, SIDERAY_VISIBLE_ALL, 255},
               {green, SIDERAY_VISIBLE_ALL, 85}};
  for (const auto& c : cases) {
    TestScene scene;
    scene.quad({0, 0, 0}, {1e4f, 0, 0}, {0, 0, 1e4f}, plain_material());
    scene.quad({0, 8, 0}, {1e7f, 0, 0}, {0, 0, 1e7f}, c.roof, c.visibility);
    tracer.set_scene(scene.commit());
    MaskRequest r = request_of(view, depth);
    r.shadow_lights = 0, r.ao_rays = 8, r.unhidden_sky = 1;
    OcclusionMasks masks;
    tracer.trace_masks(r, masks);
    for (const uint8_t open : masks.open) ASSERT_NEAR(open, c.open, 1);
    ASSERT_EQ(masks.layers, 1u);
    for (const uint8_t unhidden : masks.lit) ASSERT_EQ(unhidden, 255);
  }
}

}  // namespace
}  // namespace sideray::rt::occlusion_masks_test
