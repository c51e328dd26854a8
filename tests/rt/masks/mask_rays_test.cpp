// Points and rays made many at a time are those made one by one, bit for bit, for every instruction set.
#include "model/environment.h"
#include "rt/masks/mask_rays.h"
#include "rt/textures/sky_directions.h"

#include <gtest/gtest.h>
#include <sideray/diagnostics.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <glm/gtc/matrix_transform.hpp>
#include <memory>
#include <string>
#include <vector>

#include "rt/base/float_mode.h"

namespace sideray::rt::mask_rays_test {
namespace {

constexpr uint32_t width = 70, height = 45;  // tiles that are cut, and a row of them below

std::vector<std::string> instruction_sets() {
  std::vector<std::string> sets{"baseline"};
#if defined(__x86_64__)
  if (__builtin_cpu_supports("avx2")) sets.push_back("avx2");
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512vl"))
    sets.push_back("avx512");
#endif
  return sets;
}

// A pseudo-random picture of depth: tilted planes that hide each other, thin ones and holes, some of it marked.
class Picture {
 public:
  Picture(DepthFormat format, bool reversed, bool zero_to_one) : format_(format) {
    request.view.clip_from_local = zero_to_one ? glm::perspectiveRH_ZO(0.9, 1.4, 0.05, 90.0)
                                               : glm::perspectiveRH_NO(0.9, 1.4, 0.05, 90.0);
    request.view.clip_from_local = request.view.clip_from_local *
                                   glm::lookAt(glm::dvec3(3.1, 2.2, 7.3), glm::dvec3(0, 0.5, 0), glm::dvec3(0, 1, 0));
    if (reversed) {
      glm::dmat4 flip(1.0);
      flip[2][2] = -1.0;
      flip[3][2] = zero_to_one ? 1.0 : 0.0;
      request.view.clip_from_local = flip * request.view.clip_from_local;
    }
    request.view.local_from_clip = glm::inverse(request.view.clip_from_local);
    request.view.reversed_depth = reversed;
    request.view.zero_to_one_depth = zero_to_one;
    request.width = width;
    request.height = height;
    request.seed = 7;
    texel_bytes_ = format == DepthFormat::d16 ? 2 : format == DepthFormat::d32f_s8 ? 8 : 4;
    texels_.resize(size_t{width} * height * texel_bytes_);
    request.depth = {texels_.data(), size_t{width} * texel_bytes_, format};
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; ++x) draw(x, y, reversed);
  }

  void set_rest_offsets() {
    for (uint32_t i = 0; i < width * height; ++i) {
      const uint32_t key = random_key({i / 9, 5});
      const float u = unit_float(key);
      offsets_.emplace_back(0.02f * u, 0.03f * unit_float(hash_bits(key)), -0.01f, 0.1f * u);
    }
    request.rest_offsets = offsets_;
  }

  MaskRequest request;

 private:
  void draw(uint32_t x, uint32_t y, bool reversed) {
    const uint32_t patch = random_key({x / 7, y / 5, 1});
    double depth = 0.93 + 0.05 * static_cast<double>(unit_float(patch)) + 1e-4 * x + 2e-4 * y * ((patch & 4) ? 1 : -1);
    if ((patch & 7) == 3 || x % 23 == 11) depth = 0.97 + 2e-5 * x;
    if (reversed) depth = 1.0 - depth;
    if (random_key({x / 5, y / 3, 2}) % 6 == 0) depth = reversed ? 0.0 : 1.0;
    std::byte* to = &texels_[(size_t{y} * width + x) * texel_bytes_];
    const uint32_t stencil = patch % 5 < 2 ? 0x40 : 0;
    const auto put = [&]<typename T>(size_t offset, T value) { std::memcpy(to + offset, &value, sizeof(T)); };
    if (format_ == DepthFormat::d16) put(0, static_cast<uint16_t>(std::lround(depth * 65535.0)));
    if (format_ == DepthFormat::d24s8) put(0, static_cast<uint32_t>(std::lround(depth * 16777215.0)) << 8 | stencil);
    if (format_ == DepthFormat::d32f || format_ == DepthFormat::d32f_s8) put(0, static_cast<float>(depth));
    if (format_ == DepthFormat::d32f_s8) put(4, stencil);
  }

  DepthFormat format_;
  uint32_t texel_bytes_ = 0;
  std::vector<std::byte> texels_;
  std::vector<glm::vec4> offsets_;
};

uint32_t bits(float v) {
  return std::bit_cast<uint32_t>(v);
}

void expect_same(const float (&a)[3][point_tile_pixels], const float (&b)[3][point_tile_pixels], uint32_t pixel,
                 const char* what) {
  for (int i = 0; i < 3; ++i) ASSERT_EQ(bits(a[i][pixel]), bits(b[i][pixel])) << what << " of pixel " << pixel;
}

// Returns how many points there are.
uint32_t expect_same_points(const MaskRequest& request, const PointKernels& kernels) {
  const FlushDenormals flush;
  const ViewRays view(request.view, width, height);
  DepthPoints many(kernels), one;
  uint32_t count = 0;
  for (uint32_t y = 0; y < height; y += DepthPoints::tile_size)
    for (uint32_t x = 0; x < width; x += DepthPoints::tile_size) {
      const PointTile &a = many.gather(request, view, x, y), &b = one.gather_singly(request, view, x, y);
      for (int block = 0; block < tile_blocks; ++block) {
        EXPECT_EQ(a.drawn[block], b.drawn[block]);
        EXPECT_EQ(a.inexact[block], b.inexact[block]);
      }
      for_each_pixel(b.drawn, [&](uint32_t pixel) {
        ++count;
        expect_same(a.front, b.front, pixel, "front");
        expect_same(a.back, b.back, pixel, "back");
        expect_same(a.normal, b.normal, pixel, "normal");
        ASSERT_EQ(bits(a.doubt[pixel]), bits(b.doubt[pixel])) << pixel;
        ASSERT_EQ(bits(a.skip[pixel]), bits(b.skip[pixel])) << pixel;
      });
    }
  return count;
}

TEST(DepthPointsInLanes, are_those_made_one_by_one) {
  for (const std::string& isa : instruction_sets())
    for (const DepthFormat format : {DepthFormat::d16, DepthFormat::d24s8, DepthFormat::d32f, DepthFormat::d32f_s8})
      for (const bool reversed : {false, true})
        for (const bool zero_to_one : {false, true}) {
          SCOPED_TRACE(isa + " " + std::to_string(static_cast<int>(format)) + (reversed ? " reversed" : ""));
          Picture picture(format, reversed, zero_to_one);
          EXPECT_GT(expect_same_points(picture.request, point_kernels(isa.c_str())), 1000u);
        }
}

TEST(DepthPointsInLanes, are_those_made_one_by_one_in_the_rest_pose) {
  for (const std::string& isa : instruction_sets()) {
    SCOPED_TRACE(isa);
    Picture picture(DepthFormat::d24s8, false, false);
    picture.set_rest_offsets();
    picture.request.inexact = SIDERAY_INEXACT_RESTPOSE;
    picture.request.inexact_bits = 0x40;
    picture.request.shadow_bias = 0.001f;
    EXPECT_GT(expect_same_points(picture.request, point_kernels(isa.c_str())), 1000u);
  }
}

model::Light lamp(sideray_light_type type, float radius) {
  model::Light light{};
  light.type = type;
  light.position = {2.2f, 2.4f, 5.7f};
  light.direction = glm::normalize(glm::vec3(0.3f, -0.8f, 0.2f));
  light.radius = radius;
  light.angular_radius = radius;
  light.range = 1.2f;
  light.cos_outer = 0.8f;
  return light;
}

class MaskRays : public testing::Test {
 protected:
  // Returns how many rays there are.
  static uint32_t expect_same_rays(const RayLight& to, const MaskRequest& request, const PointKernels& kernels) {
    const FlushDenormals flush;
    const ViewRays view(request.view, width, height);
    const RayRandom random{request.seed, 31, 2, 2, request.inexact};
    DepthPoints points;
    const auto rays = std::make_unique<TileRays>(kernels);
    uint32_t count = 0;
    for (uint32_t y = 0; y < height; y += DepthPoints::tile_size)
      for (uint32_t x = 0; x < width; x += DepthPoints::tile_size) {
        const PointTile& tile = points.gather(request, view, x, y);
        const TileSamples samples(random, x, y);
        rays->make(to, random, samples, tile);
        uint32_t next = 0;
        for_each_pixel(tile.drawn, [&](uint32_t pixel) {
          Ray one;
          if (!make_ray(to, random, samples, point_at(tile, pixel), one)) return;
          ASSERT_LT(next, rays->size());
          ASSERT_EQ(rays->pixel(next), pixel);
          const Ray ray = rays->columns()[next++];
          ASSERT_EQ(std::memcmp(&ray, &one, sizeof(Ray)), 0) << "pixel " << pixel;
        });
        EXPECT_EQ(next, rays->size());
        count += next;
      }
    return count;
  }

  static void expect_same_rays(const RayLight& to) {
    for (const std::string& isa : instruction_sets())
      for (const sideray_inexact inexact :
           {SIDERAY_EXACT, SIDERAY_INEXACT_TMIN, SIDERAY_INEXACT_BOUNDED, SIDERAY_INEXACT_ORIGIN}) {
        SCOPED_TRACE(isa + " inexact " + std::to_string(static_cast<int>(inexact)));
        Picture picture(DepthFormat::d24s8, false, false);
        picture.set_rest_offsets();
        picture.request.inexact = inexact;
        picture.request.inexact_bits = inexact == SIDERAY_EXACT ? 0 : 0x40;
        EXPECT_GT(expect_same_rays(to, picture.request, point_kernels(isa.c_str())), 300u);
      }
  }
};

TEST_F(MaskRays, to_points_are_those_made_one_by_one) {
  expect_same_rays(rays_to(lamp(SIDERAY_LIGHT_POINT, 0.2f)));
  expect_same_rays(rays_to(lamp(SIDERAY_LIGHT_POINT, 0.0f)));
}

TEST_F(MaskRays, to_spots_are_those_made_one_by_one) {
  expect_same_rays(rays_to(lamp(SIDERAY_LIGHT_SPOT, 0.2f)));
}

TEST_F(MaskRays, to_suns_are_those_made_one_by_one) {
  expect_same_rays(rays_to(lamp(SIDERAY_LIGHT_DIRECTIONAL, 0.02f)));
  expect_same_rays(rays_to(lamp(SIDERAY_LIGHT_DIRECTIONAL, 0.0f)));
}

TEST_F(MaskRays, to_the_sky_are_those_made_one_by_one) {
  for (const uint32_t index : {0u, 1u, 4u}) expect_same_rays(rays_to_the_sky(3.0f, 5, index));
}

// At the end of its range a light adds just `least_light`.
// A ray below the surface would hit the surface itself at once. That is no occlusion of the sky, and the filter would
// treat it as a contact and leave the pixels around it unfiltered.
TEST_F(MaskRays, of_a_sky_go_above_the_surface) {
  const std::vector<float> rgb(size_t{16} * 8 * 3, 1.0f);
  const SkyDirections sky(model::build_environment(16, 8, rgb.data(), 1.0f, 0.0f));
  Picture picture(DepthFormat::d24s8, false, false);
  const MaskRequest& request = picture.request;
  const ViewRays view(request.view, width, height);
  DepthPoints points;
  TileRays rays;
  size_t count = 0, drawn = 0;
  for (uint32_t y = 0; y < height; y += DepthPoints::tile_size)
    for (uint32_t x = 0; x < width; x += DepthPoints::tile_size) {
      const PointTile& tile = points.gather(request, view, x, y);
      for_each_pixel(tile.drawn, [&](uint32_t) { ++drawn; });
      for (uint32_t k = 0; k < 4; ++k) {
        const RayRandom random{request.seed, 33, 0, 64 + k, request.inexact};
        rays.make(rays_to_the_sky(0.0f, 4, k), sky, random, TileSamples(random, x, y), tile);
        for (uint32_t r = 0; r < rays.size(); ++r)
          EXPECT_GT(glm::dot(rays.columns()[r].direction, point_at(tile, rays.pixel(r)).normal), 0.0f);
        count += rays.size();
      }
    }
  EXPECT_LT(count, 4 * drawn) << "some are drawn below";
  EXPECT_GT(count, 4 * drawn * 9 / 10);
}

TEST(ReachingLight, ends_where_it_adds_the_least) {
  for (const sideray_light_type type : {SIDERAY_LIGHT_POINT, SIDERAY_LIGHT_SPOT})
    for (const float range : {0.0f, 3.0f, 300.0f})
      for (const float least : {1e-4f, 1.0f / 512.0f, 1.0f}) {
        model::Light light = lamp(type, 0.1f);
        light.intensity = {2.0f, 5.0f, 3.0f};
        light.range = range;
        const model::Light shorter = reaching(light, least);
        EXPECT_LE(shorter.range, range > 0.0f ? range : INFINITY);
        const double d = double{shorter.range}, q = range > 0.0f ? d / double{range} : 0.0;
        const double adds = 5.0 * (1.0 - q * q * q * q) / (d * d) / glm::pi<double>();
        EXPECT_NEAR(adds / double{least}, 1.0, 1e-3) << range << ' ' << least;
        light.range = shorter.range;
        EXPECT_EQ(shorter, light);
      }
}

TEST(ReachingLight, stays_where_nothing_is_asked_for_or_nothing_bounds_it) {
  model::Light light = lamp(SIDERAY_LIGHT_POINT, 0.1f), sun = lamp(SIDERAY_LIGHT_DIRECTIONAL, 0.1f);
  light.intensity = sun.intensity = glm::vec3(4.0f);
  EXPECT_EQ(reaching(light, 0.0f), light);
  EXPECT_EQ(reaching(sun, 0.1f), sun);
  light.intensity = glm::vec3(0.0f);
  EXPECT_EQ(reaching(light, 0.1f), light);
}

// Sobol's second coordinate by its definition: a direction a bit of the index.
TEST(PointSet, second_coordinates_are_sobols) {
  const auto second = [](uint32_t index) {
    uint32_t result = 0;
    for (uint32_t v = 1u << 31; index != 0; index >>= 1, v ^= v >> 1)
      if (index & 1u) result ^= v;
    return result;
  };
  for (uint32_t i = 0; i < 10000; ++i) {
    const uint32_t order = hash_bits(i), x = hash_bits(order), y = hash_bits(x);
    const PointSet set(order, x, y);
    EXPECT_EQ(set[i].y, unit_float(scramble_nested(second(scramble_nested(i, order)), y)));
  }
}

}  // namespace
}  // namespace sideray::rt::mask_rays_test
