// The layers' denoiser in lanes, against the same one by one.
#include "rt/cache/layer_filter_kernels.h"

#include <gmock/gmock.h>

#include <cmath>

#include "rt/base/sampling.h"
#include "rt/cache/one_by_one_filter.h"
#include "rt/kernel_sets.h"

namespace sideray::rt::layer_filter_kernels_test {
namespace {

struct Scene {
  uint32_t width, height, ranks;
  float covered;  // share of the pixels that a surface covers
};

// Patches of slanted, bent and scattered surfaces: rough and less so, near and far, in order of their pixels or not.
std::vector<LayerFilter::Chunk> layers_of(const Scene& scene, uint32_t seed) {
  constexpr uint32_t patch = 11, rows_in_chunk = 5;
  std::vector<LayerFilter::Chunk> chunks((scene.height + rows_in_chunk - 1) / rows_in_chunk);
  for (uint32_t y = 0; y < scene.height; ++y)
    for (uint32_t i = 0; i < scene.width; ++i) {
      const uint32_t x = y % 3 == 0 ? scene.width - 1 - i : i;
      for (uint32_t rank = 0; rank < scene.ranks; ++rank) {
        auto chance = [&, number = 0u](bool of_patch) mutable {
          return of_patch ? unit_float(random_key({seed, ++number, x / patch, y / patch, rank}))
                          : unit_float(random_key({seed, 100 + ++number, x, y, rank}));
        };
        if (chance(false) > scene.covered) continue;
        const bool bent = chance(true) < 0.4f, wild = chance(true) < 0.2f, through = chance(true) < 0.2f;
        const uint32_t surface = 1 + static_cast<uint32_t>(3 * chance(true));
        SurfacePoint p{};
        const float u = static_cast<float>(x), v = static_cast<float>(y),
                    wave = bent ? 0.1f * std::sin(0.5f * u) : 0.0f;
        p.position = 0.01f * glm::vec3(u, v, static_cast<float>(rank) + wave + (wild ? chance(false) : 0.2f * u));
        p.geometric_normal = glm::normalize(glm::vec3(wave - 0.2f, 0.1f * wave, 1));
        p.surface.normal = glm::normalize(p.geometric_normal + 0.02f * glm::vec3(chance(false), chance(false), 0));
        p.cone = {0.01f, 0.001f};
        const glm::vec3 light =
            glm::vec3(chance(false), chance(false), chance(false)) * (chance(false) < 0.1f ? 40.0f : 1.0f);
        const float roughness = 0.2f + 0.5f * chance(true) + (wild ? 0.02f * chance(false) : 0.0f);
        const float nearness = chance(true) < 0.3f ? 0.0f : 3.0f * chance(true) * chance(false);
        const uint32_t texel = (rank / 2 * scene.height + y) * scene.width + x;
        chunks[y / rows_in_chunk].add(y * scene.width + x, texel, surface, p, light + 0.25f,
                                      {light, glm::vec3(0.5f, 0.4f, 0.3f), roughness, nearness, 1.0f, through});
      }
    }
  return chunks;
}

LayerCache empty(const Scene& scene) {
  LayerCache cache;
  cache.width = scene.width, cache.height = scene.height, cache.layers = (scene.ranks + 1) / 2;
  cache.radiance.assign(size_t{4} * cache.layers * scene.width * scene.height, 0);
  return cache;
}

TEST(LayerFilterKernels, have_the_bits_of_one_by_one_for_any_threads_and_instruction_set) {
  // No whole tiles, less than a vector, single layers and many; each filter takes all of them in turn.
  const Scene scenes[] = {
      {531, 19, 1, 1.0f}, {93, 67, 4, 0.7f}, {5, 3, 2, 1.0f}, {61, 40, 9, 0.9f}, {200, 30, 2, 0.2f}};
  for (const char* isa : test::kernel_sets())
    for (const uint32_t threads : {1u, 3u}) {
      Executor executor(threads);
      LayerFilter filter(layer_filter_kernels(isa));
      uint32_t seed = 0;
      for (const Scene& scene : scenes) {
        const std::vector<LayerFilter::Chunk> chunks = layers_of(scene, ++seed);
        LayerCache expected = empty(scene), cache = empty(scene);
        filter_one_by_one(chunks, expected);
        filter.begin(chunks.size());
        for (size_t i = 0; i < chunks.size(); ++i) filter.chunk(i) = chunks[i];
        filter.apply(executor, cache);
        EXPECT_EQ(cache.radiance, expected.radiance) << isa << ", " << threads << " threads, " << scene.width;
        EXPECT_NE(cache.radiance, empty(scene).radiance);
      }
    }
}

// What was filtered before does not shine through.
TEST(LayerFilterKernels, forget_the_frame_before) {
  const Scene many{93, 67, 4, 0.9f}, few{93, 67, 2, 0.3f};
  const std::vector<LayerFilter::Chunk> before = layers_of(many, 1), after = layers_of(few, 2);
  Executor executor(2);
  LayerFilter filter;
  LayerCache expected = empty(few), cache = empty(many);
  for (const auto* chunks : {&before, &after}) {
    cache = empty(chunks == &before ? many : few);
    filter.begin(chunks->size());
    for (size_t i = 0; i < chunks->size(); ++i) filter.chunk(i) = (*chunks)[i];
    filter.apply(executor, cache);
  }
  filter_one_by_one(after, expected);
  EXPECT_EQ(cache.radiance, expected.radiance);
}

}  // namespace
}  // namespace sideray::rt::layer_filter_kernels_test
