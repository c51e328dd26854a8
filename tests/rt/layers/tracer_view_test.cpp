// Pixels to rays, stored depth to distances.
#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "rt/base/view_rays.h"
#include "rt/tracer_scene.h"

namespace sideray::rt {
namespace {

using test::perspective;

TraceView ordinary(glm::dvec3 eye, glm::dvec3 target) {
  TraceView view;
  view.clip_from_local = glm::perspectiveRH_NO(0.9, 1.5, 0.1, 1000.0) * glm::lookAt(eye, target, glm::dvec3(0, 1, 0));
  view.local_from_clip = glm::inverse(view.clip_from_local);
  return view;
}

TraceView orthographic() {
  TraceView view;
  view.clip_from_local = glm::orthoRH_ZO(-3.0, 3.0, -2.0, 2.0, 100.0, 0.5) *  // far and near swapped: reversed
                         glm::lookAt(glm::dvec3(1, 2, 3), glm::dvec3(4, 2, -5), glm::dvec3(0, 1, 0));
  view.local_from_clip = glm::inverse(view.clip_from_local);
  view.reversed_depth = view.zero_to_one_depth = true;
  return view;
}

// Projects points that lie on pixel rays and compares pixel, depth and distance.
void expect_rays_project_back(const TraceView& view, uint32_t width, uint32_t height) {
  const ViewRays rays(view, width, height);
  for (uint32_t y = 0; y < height; y += 7)
    for (uint32_t x = 0; x < width; x += 5) {
      const Ray ray = rays.ray(x, y);
      EXPECT_NEAR(glm::length(ray.direction), 1.0f, 1e-6f);
      for (const double distance : {0.5, 3.0, 70.0}) {
        const glm::dvec4 clip =
            view.clip_from_local * glm::dvec4(glm::dvec3(ray.origin) + distance * glm::dvec3(ray.direction), 1.0);
        const glm::dvec3 ndc = glm::dvec3(clip) / clip.w;
        EXPECT_NEAR((ndc.x * 0.5 + 0.5) * width, x + 0.5, 2e-4);
        EXPECT_NEAR((ndc.y * 0.5 + 0.5) * height, y + 0.5, 2e-4);
        const double depth = view.zero_to_one_depth ? ndc.z : ndc.z * 0.5 + 0.5;
        EXPECT_NEAR(rays.distance(x, y, depth) / distance, 1.0, 2e-5);
      }
    }
}

TEST(ViewRays, perspective_rays_go_through_pixel_centres) {
  expect_rays_project_back(perspective({1, 2, 3}, {-4, 1, -20}, 0.8, 1.5), 30, 20);
  expect_rays_project_back(ordinary({1, 2, 3}, {-4, 1, -20}), 30, 20);
}

TEST(ViewRays, orthographic_rays_go_through_pixel_centres) {
  expect_rays_project_back(orthographic(), 30, 20);
  const ViewRays rays(orthographic(), 30, 20);
  EXPECT_FALSE(rays.perspective());
  EXPECT_EQ(rays.ray(0, 0).direction, rays.ray(29, 19).direction);
  EXPECT_NEAR(rays.cone(3, 3).width, 4.0f / 20.0f, 1e-6f);
}

TEST(ViewRays, the_eye_is_where_the_camera_is) {
  const ViewRays rays(perspective({100, 20, -3}, {0, 0, 0}, 0.8, 1.0), 8, 8);
  EXPECT_NEAR(glm::length(rays.eye() - glm::dvec3(100, 20, -3)), 0.0, 1e-9);
}

TEST(ViewRays, an_infinite_far_plane_gives_a_finite_ray) {
  const ViewRays rays(perspective({0, 0, 0}, {0, 0, -1}, 0.8, 1.0), 8, 8);
  EXPECT_EQ(rays.distance(4, 4, 0.0), INFINITY);
  EXPECT_EQ(rays.end_of_ray(4, 4, 0.0, DepthFormat::d32f_s8), 1e30f);
}

// The end of the ray never lies behind the surface whose depth was rounded to the format, and is not shortened by more
// than one step of it and 2^-20.
TEST(ViewRays, rays_end_before_the_stored_surface_in_every_format) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> log_distance(std::log(0.2), std::log(500.0));
  for (const TraceView& view : {ordinary({0, 0, 0}, {0, 0, -1}), perspective({0, 0, 0}, {0, 0, -1}, 0.9, 1.5)}) {
    const ViewRays rays(view, 64, 64);
    for (int i = 0; i < 2000; ++i) {
      const double z = std::exp(log_distance(random));
      const glm::dvec4 clip = view.clip_from_local * glm::dvec4(0, 0, -z, 1);
      const double depth = view.zero_to_one_depth ? clip.z / clip.w : 0.5 * clip.z / clip.w + 0.5;
      // The ray of pixel (x, y) through the plane at this depth.
      const double distance = rays.distance(9, 40, depth);
      const auto check = [&](double stored, double step, DepthFormat format) {
        if (stored >= 1.0 || stored <= 0.0) return;
        const double end = static_cast<double>(rays.end_of_ray(9, 40, stored, format));
        EXPECT_LE(end, distance * (1 + 1e-9)) << z;
        const double toward_eye = stored + (view.reversed_depth ? step : -step);
        const double shortest = rays.distance(9, 40, std::clamp(toward_eye, 0.0, 1.0)) * (1 - 0x1p-20) - 1e-9;
        EXPECT_GE(end, shortest) << z;
      };
      check(std::round(depth * 65535.0) / 65535.0, 1 / 65535.0, DepthFormat::d16);
      check(std::round(depth * 16777215.0) / 16777215.0, 1 / 16777215.0, DepthFormat::d24s8);
      const double stored = static_cast<double>(static_cast<float>(depth));
      check(stored, view.zero_to_one_depth ? stored * 0x1p-23 : 0x1p-24, DepthFormat::d32f_s8);
    }
  }
}

// Fills a block with pixels anywhere, and depths from one end of the range to the other.
ViewRays::Block some_pixels(uint32_t width, uint32_t height, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  ViewRays::Block block;
  for (uint32_t i = 0; i < ViewRays::Block::size; ++i) {
    block.x[i] = std::floor(unit(random) * width);
    block.y[i] = std::floor(unit(random) * height);
    const double depths[] = {0.0, 1.0, unit(random), 1.0 - 1e-7 * unit(random), 1e-7 * unit(random), 1e-40};
    block.depth[i] = static_cast<double>(static_cast<float>(depths[random() % std::size(depths)]));
  }
  return block;
}

TEST(ViewRays, blocks_have_the_bits_of_single_pixels) {
  constexpr uint32_t width = 1920, height = 1080;
  std::mt19937 random(1);
  for (const TraceView& view :
       {ordinary({1, 2, 3}, {-20, 4, 1}), perspective({1, 2, 3}, {-20, 4, 1}, 0.9, 1.5), orthographic()}) {
    const ViewRays rays(view, width, height);
    for (const DepthFormat format :
         {DepthFormat::d16, DepthFormat::d24, DepthFormat::d24s8, DepthFormat::d32f, DepthFormat::d32f_s8})
      for (int round = 0; round < 200; ++round) {
        const ViewRays::Block block = some_pixels(width, height, random);
        std::array<Ray, ViewRays::Block::size> made;
        std::array<Cone, ViewRays::Block::size> cones;
        rays.fill(block, format, made.data(), cones.data());
        for (uint32_t i = 0; i < ViewRays::Block::size; ++i) {
          const auto x = static_cast<uint32_t>(block.x[i]), y = static_cast<uint32_t>(block.y[i]);
          Ray ray = rays.ray(x, y);
          ray.t_far = rays.end_of_ray(x, y, block.depth[i], format);
          const Cone cone = rays.cone(x, y);
          ASSERT_EQ(std::memcmp(&made[i], &ray, sizeof(Ray)), 0) << x << ' ' << y << ' ' << block.depth[i];
          ASSERT_EQ(std::memcmp(&cones[i], &cone, sizeof(Cone)), 0) << x << ' ' << y;
        }
      }
    const Ray open = rays.ray(5, 7);
    EXPECT_EQ(rays.end_of_ray(5, 7, rays.far_depth(), DepthFormat::d32f), open.t_far);
  }
}

TEST(ViewRays, refuses_matrices_that_are_no_camera) {
  TraceView view = orthographic();
  view.local_from_clip[0][0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(ViewRays(view, 4, 4), std::runtime_error);
  TraceView zero;
  zero.clip_from_local = zero.local_from_clip = glm::dmat4(0.0);
  EXPECT_THROW(ViewRays(zero, 4, 4), std::runtime_error);
}

TEST(ReadDepth, decodes_native_formats) {
  const uint32_t d24s8[2] = {0, (0xabcdefu << 8) | 0x85u};
  const DepthTexel a = read_depth({reinterpret_cast<const std::byte*>(d24s8), 8, DepthFormat::d24s8}, 1, 0);
  EXPECT_DOUBLE_EQ(a.depth, 0xabcdef / 16777215.0);
  EXPECT_EQ(a.stencil, 0x85u);

  struct {
    float depth;
    uint32_t stencil;
  } d32f_s8[2] = {{0.25f, 7}, {0.75f, 0xffffff3fu}};
  const DepthTexel b = read_depth({reinterpret_cast<const std::byte*>(d32f_s8), 8, DepthFormat::d32f_s8}, 0, 1);
  EXPECT_EQ(b.depth, 0.75);
  EXPECT_EQ(b.stencil, 0x3fu);

  const float d32f[2] = {0.1f, 0.3f};
  EXPECT_EQ(read_depth({reinterpret_cast<const std::byte*>(d32f), 8, DepthFormat::d32f}, 1, 0).depth,
            static_cast<double>(0.3f));
  const uint16_t d16[2] = {65535, 32768};
  EXPECT_DOUBLE_EQ(read_depth({reinterpret_cast<const std::byte*>(d16), 4, DepthFormat::d16}, 1, 0).depth,
                   32768 / 65535.0);
}

}  // namespace
}  // namespace sideray::rt
