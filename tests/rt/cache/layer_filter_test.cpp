// The filter of rough reflections on made-up layers, whose true radiance is known.
#include "rt/cache/layer_filter.h"

#include <gmock/gmock.h>

#include <cmath>
#include <functional>
#include <glm/gtc/packing.hpp>

#include "rt/base/sampling.h"

namespace sideray::rt::layer_filter_test {
namespace {

constexpr uint32_t width = 64, height = 48, surface = 7;
constexpr float pixel = 0.01f;  // world units, at distance 10

struct Texel {
  uint32_t layer = 0, id = surface;
  float depth = 0, nearness = 0.1f, roughness = 0.5f;
  glm::vec3 reflected{1.0f};
};

// A plane that faces the eye; weight 0.5, and 0.25 of other light.
LayerCache filtered(const std::function<std::vector<Texel>(uint32_t x, uint32_t y)>& texels, uint32_t threads = 2) {
  Executor executor(threads);
  LayerCache cache;
  cache.width = width, cache.height = height, cache.layers = 2;
  cache.radiance.assign(size_t{2} * width * height * 4, 0);
  LayerFilter filter;
  filter.begin(height);
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x)
      for (const Texel& t : texels(x, y)) {
        SurfacePoint p{};
        p.position = {static_cast<float>(x) * pixel, static_cast<float>(y) * pixel, t.depth};
        p.surface.normal = p.geometric_normal = {0, 0, 1};
        p.cone = {pixel, pixel / 10};
        const RoughReflection rough{t.reflected, glm::vec3(0.5f), t.roughness, t.nearness};
        filter.chunk(y).add(y * width + x, (t.layer * height + y) * width + x, t.id, p,
                            glm::vec3(0.25f) + rough.weight * rough.radiance, rough);
      }
  filter.apply(executor, cache);
  return cache;
}

double red(const LayerCache& cache, uint32_t x, uint32_t y, uint32_t layer = 0) {
  const size_t texel = (size_t{layer} * height + y) * width + x;
  return (static_cast<double>(glm::unpackHalf1x16(cache.radiance[4 * texel])) - 0.25) / 0.5;
}

float chance(uint32_t x, uint32_t y) {
  return unit_float(random_key({3, x, y}));
}

struct Statistics {
  double mean = 0, variance = 0;
};

Statistics inside(const LayerCache& cache) {
  double sum = 0, squares = 0, count = 0;
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x)
      sum += red(cache, x, y), squares += red(cache, x, y) * red(cache, x, y), ++count;
  return {sum / count, squares / count - (sum / count) * (sum / count)};
}

// Every fifth direction meets a lamp: as good as 64 of them at least, and no darker.
TEST(LayerFilter, averages_what_is_left_to_chance) {
  const LayerCache cache = filtered([](uint32_t x, uint32_t y) {
    Texel t;
    t.reflected = glm::vec3(chance(x, y) < 0.2f ? 5.0f : 0.0f);
    return std::vector{t};
  });
  const Statistics s = inside(cache);
  EXPECT_NEAR(s.mean, 1.0, 4 * 2 / std::sqrt(width * height));  // 5 or 0: a deviation of 2
  EXPECT_LT(s.variance, 4.0 / 64);
}

TEST(LayerFilter, keeps_what_is_even) {
  const LayerCache cache = filtered([](uint32_t, uint32_t) { return std::vector{Texel{}}; });
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) ASSERT_NEAR(red(cache, x, y), 1.0, 0.002);
}

// A rough pane has one random direction for reflection and another for transmission: the filter must not mix them, and
// must keep reflections of the environment alone.
TEST(LayerFilter, keeps_what_is_seen_through_apart_from_reflections) {
  for (const bool reflects_environment : {false, true}) {
    Executor executor(2);
    LayerCache cache;
    cache.width = width, cache.height = height, cache.layers = 1;
    cache.radiance.assign(size_t{width} * height * 4, 0);
    LayerFilter filter;
    filter.begin(height);
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; ++x) {
        SurfacePoint p{};
        p.position = {static_cast<float>(x) * pixel, static_cast<float>(y) * pixel, 0};
        p.surface.normal = p.geometric_normal = {0, 0, 1};
        p.cone = {pixel, pixel / 10};
        const float lit = chance(x, y) < 0.5f ? 2.0f : 0.0f, seen = chance(y + 100, x) < 0.5f ? 6.0f : 2.0f;
        const RoughReflection mirrored{glm::vec3(reflects_environment ? 1.0f : lit), glm::vec3(0.5f), 0.5f,
                                       reflects_environment ? 0.0f : 0.1f};
        const RoughReflection through{glm::vec3(seen), glm::vec3(1.0f), 0.5f, 0.1f, 1.0f, true};
        const glm::vec3 all = glm::vec3(0.25f) + mirrored.weight * mirrored.radiance + through.radiance;
        for (const RoughReflection& rough : {mirrored, through})
          filter.chunk(y).add(y * width + x, y * width + x, surface, p, all, rough);
      }
    filter.apply(executor, cache);
    double sum = 0, squares = 0;
    for (size_t i = 0; i < size_t{width} * height; ++i) {
      const double value = static_cast<double>(glm::unpackHalf1x16(cache.radiance[4 * i]));
      sum += value, squares += value * value;
    }
    const double count = width * height, mean = sum / count;
    EXPECT_NEAR(mean, 0.25 + 0.5 + 4.0, 4 * 2.1 / std::sqrt(count));  // deviations of 0.5 and 2
    EXPECT_LT(squares / count - mean * mean, 4.25 / 16);
  }
}

// What touches the surface is reflected sharply.
TEST(LayerFilter, keeps_contacts) {
  const auto value = [](uint32_t x, uint32_t y) { return (x / 4 + y / 4) % 2 == 0 ? 1.0f : 0.2f; };
  const LayerCache cache = filtered([&](uint32_t x, uint32_t y) {
    return std::vector{Texel{.nearness = 1 / (0.5f * pixel), .reflected = glm::vec3(value(x, y))}};
  });
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x)
      ASSERT_NEAR(red(cache, x, y), static_cast<double>(value(x, y)), 0.002) << x << ' ' << y;
}

// And what is far beside it does not reach into it.
TEST(LayerFilter, keeps_the_far_out_of_contacts) {
  const LayerCache cache = filtered([&](uint32_t x, uint32_t) {
    const bool near = x < width / 2;
    return std::vector{Texel{.nearness = near ? 1 / (0.5f * pixel) : 0.0f, .reflected = glm::vec3(near ? 1.0f : 4.0f)}};
  });
  for (uint32_t x = 0; x < width / 2; ++x) EXPECT_NEAR(red(cache, x, height / 2), 1.0, 0.002) << x;
}

TEST(LayerFilter, keeps_other_surfaces_planes_and_roughness_apart) {
  const Texel here;
  for (const Texel& there : {Texel{.id = surface + 1}, Texel{.depth = -5 * pixel}, Texel{.roughness = 0.9f}}) {
    const LayerCache cache = filtered([&](uint32_t x, uint32_t) {
      Texel t = x < width / 2 ? here : there;
      t.reflected = glm::vec3(x < width / 2 ? 1.0f : 3.0f);
      return std::vector{t};
    });
    // A plane behind is told apart but for where the step between two neighbours could be a slope.
    for (uint32_t x = 0; x < width; ++x) EXPECT_NEAR(red(cache, x, height / 2), x < width / 2 ? 1.0 : 3.0, 0.01) << x;
  }
}

// The same surface is the first layer of one pixel and the second of the next.
TEST(LayerFilter, finds_a_surface_in_whichever_layer) {
  const auto second = [](uint32_t x) { return x % 2 == 1; };
  const LayerCache cache = filtered([&](uint32_t x, uint32_t y) {
    const Texel wanted{.layer = second(x), .reflected = glm::vec3(chance(x, y) < 0.2f ? 5.0f : 0.0f)};
    const Texel other{.id = surface + 1, .depth = 1, .reflected = glm::vec3(9.0f)};
    return second(x) ? std::vector{other, wanted} : std::vector{wanted};
  });
  double sum = 0, squares = 0;
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      const double value = red(cache, x, y, second(x));
      sum += value, squares += value * value;
    }
  const double mean = sum / (width * height);
  EXPECT_NEAR(mean, 1.0, 4 * 2 / std::sqrt(width * height));
  EXPECT_LT(squares / (width * height) - mean * mean, 4.0 / 64);
}

// Where few samples are averaged, a single bright one must not show as a spot; elsewhere no energy is lost.
TEST(LayerFilter, spreads_no_single_spark) {
  const auto spark_among = [](float nearness) {
    return filtered([nearness](uint32_t x, uint32_t y) {
      const bool spark = x == width / 2 && y == height / 2;
      return std::vector{Texel{.nearness = nearness, .reflected = glm::vec3(spark ? 100.0f : 1.0f)}};
    });
  };
  const LayerCache near = spark_among(1 / (4 * pixel)), far = spark_among(0.001f);
  EXPECT_LT(red(near, width / 2, height / 2), 4 * (100.0 + 16) / 17);
  EXPECT_NEAR(inside(far).mean * width * height, width * height + 99.0, 15);
}

TEST(LayerFilter, is_the_same_for_any_number_of_threads) {
  const auto noise = [](uint32_t x, uint32_t y) { return std::vector{Texel{.reflected = glm::vec3(chance(x, y))}}; };
  EXPECT_EQ(filtered(noise, 1).radiance, filtered(noise, 4).radiance);
}

}  // namespace
}  // namespace sideray::rt::layer_filter_test
