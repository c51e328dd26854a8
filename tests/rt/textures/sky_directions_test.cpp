// Directions drawn by an environment against sums over all directions.
#include "rt/textures/sky_directions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "model/environment.h"
#include "rt/base/sampling.h"
#include "rt/textures/environment_lookup.h"

namespace sideray::rt::sky_directions_test {
namespace {

constexpr uint32_t width = 64, height = 32;

glm::vec3 direction_at(double u, double v) {
  const double azimuth = (u - 0.5) * 2 * M_PI, polar = v * M_PI;
  return {glm::dvec3(std::sin(polar) * std::sin(azimuth), std::cos(polar), -std::sin(polar) * std::cos(azimuth))};
}

std::shared_ptr<const model::Environment> uniform() {
  const std::vector<float> rgb(size_t{3} * width * height, 0.7f);
  return model::build_environment(width, height, rgb.data(), 1.0f, 0.0f);
}

// Bright above, dark below, with a sun that outshines both; black where x < -0.8.
std::shared_ptr<const model::Environment> sky_and_sun() {
  std::vector<float> rgb;
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      const glm::vec3 d = direction_at((x + 0.5) / width, (y + 0.5) / height);
      const bool sun = x == 40 && y == 9;
      const float gray = sun ? 5000.0f : d.x < -0.8f ? 0.0f : 0.2f + std::max(d.y, 0.0f);
      rgb.insert(rgb.end(), {gray, 0.5f * gray, 1.5f * gray});
    }
  return model::build_environment(width, height, rgb.data(), 1.0f, 0.0f);
}

glm::vec3 random_direction(std::mt19937& random) {
  std::normal_distribution<float> normal;
  glm::vec3 d;
  do d = {normal(random), normal(random), normal(random)};
  while (glm::length(d) < 0.1f);
  return glm::normalize(d);
}

// What a plane through the point leaves visible: half of all directions.
bool is_visible(glm::vec3 blocker, glm::vec3 d) {
  return glm::dot(blocker, d) < 0.0f;
}

float drawn_share(const SkyDirections& sky, glm::vec3 normal, glm::vec3 blocker, uint32_t rays) {
  const PointSet points(7);
  double sum = 0, visible = 0;
  for (uint32_t i = 0; i < rays; ++i) {
    const SkyDirections::Draw draw = sky.draw(SkyDirections::facing(normal), normal, points[i]);
    EXPECT_NEAR(glm::length(draw.direction), 1.0f, 1e-5f);
    EXPECT_TRUE(draw.weight >= 0.0f && std::isfinite(draw.weight)) << draw.weight;
    EXPECT_TRUE(draw.weight == 0.0f || glm::dot(normal, draw.direction) > 0.0f);
    sum += double{draw.weight};
    if (is_visible(blocker, draw.direction)) visible += double{draw.weight};
  }
  return static_cast<float>(visible / sum);
}

float summed_share(const model::Environment& environment, glm::vec3 normal, glm::vec3 blocker) {
  constexpr int columns = 8 * width, rows = 8 * height;
  double sum = 0, visible = 0;
  for (int y = 0; y < rows; ++y)
    for (int x = 0; x < columns; ++x) {
      const double v = (y + 0.5) / rows;
      const glm::vec3 d = direction_at((x + 0.5) / columns, v);
      const glm::vec3 c = environment_specular(environment, d, 0.0f);
      const double light = std::max(double{glm::dot(normal, d)}, 0.0) * double{c.x + c.y + c.z} * std::sin(v * M_PI);
      sum += light;
      if (is_visible(blocker, d)) visible += light;
    }
  return static_cast<float>(visible / sum);
}

// The cells are 5.6 degrees wide: a blocker's edge goes through some of them.
TEST(SkyDirections, the_weights_mean_is_the_share_of_light_that_is_visible) {
  const auto environment = sky_and_sun();
  const SkyDirections sky(environment);
  std::mt19937 random(5);
  for (int i = 0; i < 40; ++i) {
    const glm::vec3 normal = random_direction(random), blocker = random_direction(random);
    EXPECT_NEAR(drawn_share(sky, normal, blocker, 1u << 14), summed_share(*environment, normal, blocker), 0.02f) << i;
  }
}

// The depth's rounding turns normals by about 1e-6; pictures with and without OpenGL would have other rays then.
TEST(SkyDirections, rounding_of_a_wall_s_or_floor_s_normal_selects_no_other_table) {
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {-1.0f, 1.0f})
      for (const float a : {-1e-6f, 1e-6f})
        for (const float b : {-1e-6f, 1e-6f}) {
          glm::vec3 exact(0), turned(0);
          exact[axis] = turned[axis] = side;
          turned[(axis + 1) % 3] = a, turned[(axis + 2) % 3] = b;
          EXPECT_EQ(SkyDirections::facing(turned), SkyDirections::facing(exact)) << axis << side << a << b;
        }
}

// The visible part of a uniform sky, by the plane's angle to the surface: (1 + cos) / 2.
TEST(SkyDirections, a_uniform_sky_is_visible_by_the_closed_form) {
  const SkyDirections sky(uniform());
  for (const float angle : {0.3f, 1.0f, 1.6f, 2.5f}) {
    const glm::vec3 normal(0, 1, 0), blocker(std::sin(angle), std::cos(angle), 0);
    EXPECT_NEAR(drawn_share(sky, normal, blocker, 1u << 14), 0.5f * (1.0f - std::cos(angle)), 0.005f) << angle;
  }
}

// Where few rays tell, they go where the light comes from.
TEST(SkyDirections, four_rays_find_the_sun) {
  const auto environment = sky_and_sun();
  const SkyDirections sky(environment);
  const glm::vec3 sun = direction_at(40.5 / width, 9.5 / height), normal(0, 1, 0);
  uint32_t found = 0;
  constexpr uint32_t pixels = 1000;
  for (uint32_t i = 0; i < pixels; ++i) {
    const PointSet points(i);
    bool any = false;
    for (uint32_t k = 0; k < 4; ++k)
      any = any || glm::dot(sky.draw(SkyDirections::facing(normal), normal, points[k]).direction, sun) > 0.98f;
    found += any ? 1 : 0;
  }
  EXPECT_GT(found, 950u);
}

TEST(SkyDirections, one_bright_texel_below_the_surface_is_not_drawn_from) {
  std::vector<float> rgb(size_t{3} * width * height, 0.0f);
  for (int c = 0; c < 3; ++c) rgb[3 * (20 * width + 30) + static_cast<size_t>(c)] = 1e4f;
  const SkyDirections sky(model::build_environment(width, height, rgb.data(), 1.0f, 0.0f));
  EXPECT_FALSE(sky.black());
  const PointSet points(1);
  for (uint32_t i = 0; i < 256; ++i)
    EXPECT_EQ(sky.draw(SkyDirections::facing({0, 1, 0}), {0, 1, 0}, points[i]).weight, 0.0f);
}

TEST(SkyDirections, a_black_environment_has_none) {
  const std::vector<float> rgb(size_t{3} * width * height, 0.0f);
  EXPECT_TRUE(SkyDirections(model::build_environment(width, height, rgb.data(), 1.0f, 0.0f)).black());
}

}  // namespace
}  // namespace sideray::rt::sky_directions_test
