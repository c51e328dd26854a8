// Tests the shadow denoiser by closed forms: the penumbra of a half-plane, constants, depth edges, switched lights.
#include "rt/masks/shadow_filter.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iostream>
#include <limits>
#include <string>

namespace sideray::rt {
namespace {

constexpr float infinite = std::numeric_limits<float>::infinity();

// Returns a random number from a counter (PCG hash, Jarzynski and Olano 2020).
float number(uint32_t which) {
  uint32_t state = which * 747796405u + 2891336453u;
  const uint32_t word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
  return static_cast<float>(((word >> 22u) ^ word) >> 8) * 0x1p-24f;
}

// A floor at depth 10 seen from above, a hundredth of a unit a pixel, under a sun of half angle atan(tan_radius).
struct Clip {
  uint32_t width = 96, height = 64;
  std::vector<float> visibility, hit, depth, result;
  std::vector<glm::vec2> motion;
  shading::SfView view{0.0f, 0.0f, 0.001f, 0.001f, {0.0f, 0.0f, 1.0f}, 0.0f};
  shading::SfLight light{{}, 0.0f, 0.05f, 32.0f, 8.0f};

  explicit Clip(uint32_t w = 96, uint32_t h = 64) : width(w), height(h) {
    const size_t texels = size_t{w} * h;
    visibility.assign(texels, 1.0f), hit.assign(texels, infinite), depth.assign(texels, 10.0f), result.resize(texels);
  }
  ShadowFilterInput input() const { return {width, height, visibility, hit, depth, motion, view, light, {}, {}}; }
  void set(size_t i, bool lit, float distance) {
    visibility[i] = lit ? 1.0f : 0.0f;
    hit[i] = lit ? infinite : distance;
  }
};

// Returns the visible share of a sun in the zenith, at x from the edge of a half-plane at `height` that hides it.
double visible(double x, double height, double tan_radius) {
  const double u = std::clamp(x / (height * tan_radius), -1.0, 1.0);
  return 1.0 - (std::acos(u) - u * std::sqrt(1.0 - u * u)) / 3.14159265358979;
}

// Fills a clip with samples of visible(); the edge lies above column `edge`.
void sample(Clip& clip, double height, double edge, uint32_t seed) {
  for (uint32_t y = 0; y < clip.height; ++y)
    for (uint32_t x = 0; x < clip.width; ++x) {
      const size_t i = size_t{y} * clip.width + x;
      const double p = visible((x - edge) * 0.01, height, static_cast<double>(clip.light.tan_radius));
      clip.set(i, static_cast<double>(number(seed * 7919u + static_cast<uint32_t>(i))) < p, static_cast<float>(height));
    }
}

double error(const Clip& clip, const std::vector<float>& image, double height, double edge) {
  double sum = 0.0;
  for (uint32_t y = 0; y < clip.height; ++y)
    for (uint32_t x = 0; x < clip.width; ++x) {
      const double p = visible((x - edge) * 0.01, height, static_cast<double>(clip.light.tan_radius));
      const double off = static_cast<double>(image[size_t{y} * clip.width + x]) - p;
      sum += off * off;
    }
  return std::sqrt(sum / static_cast<double>(image.size()));
}

// Penumbrae of radii 4 to 40 pixels, one sample a pixel.
TEST(ShadowFilter, eight_frames_of_one_sample_are_as_good_as_sixteen_samples) {
  Executor executor(1);
  for (const double height : {0.8, 2.0, 4.0, 8.0}) {
    Clip clip(160, 96);
    ShadowFilter filter;
    std::vector<float> first(clip.result.size()), raw(clip.result.size());
    for (uint32_t frame = 0; frame < 8; ++frame) {
      sample(clip, height, 80.3, frame + 1);
      filter.spatial(executor, clip.input(), frame == 0 ? first : clip.result);
      filter.temporal(executor, clip.input(), clip.result);
    }
    Clip other = clip;
    for (uint32_t n = 0; n < 16; ++n) {
      sample(other, height, 80.3, 100 + n);
      for (size_t i = 0; i < raw.size(); ++i) raw[i] += other.visibility[i] / 16.0f;
    }
    const double is = error(clip, clip.result, height, 80.3), sixteen = error(clip, raw, height, 80.3);
    std::cout << "  penumbra " << height * 5 << " px: error after one frame " << error(clip, first, height, 80.3)
              << ", eight " << is << ", sixteen raw samples " << sixteen << "\n";
    EXPECT_LE(is, sixteen);
    EXPECT_GT(sixteen, 0.01);
  }
}

TEST(ShadowFilter, constants_stay) {
  Executor executor(1);
  for (const float level : {0.0f, 1.0f, 0.5f}) {
    Clip clip;
    clip.visibility.assign(clip.visibility.size(), level);
    if (level < 1.0f) clip.hit.assign(clip.hit.size(), 3.0f);
    ShadowFilter filter;
    for (int frame = 0; frame < 3; ++frame) {
      filter.spatial(executor, clip.input(), clip.result);
      for (const float v : clip.result) ASSERT_EQ(v, level);
      filter.temporal(executor, clip.input(), clip.result);
      for (const float v : clip.result) ASSERT_EQ(v, level);
    }
    EXPECT_EQ(filter.active_tiles() > 0, level == 0.5f);
  }
}

// A lit surface on the left is nearer than a surface in shadow on the right; the filter must not mix them.
TEST(ShadowFilter, edges_of_depth_do_not_bleed) {
  Executor executor(1);
  Clip clip;
  for (size_t i = 0; i < clip.depth.size(); ++i) {
    const bool left = i % clip.width < 45;
    clip.depth[i] = left ? 9.5f : 10.0f;
    clip.set(i, left, 20.0f);
  }
  ShadowFilter filter;
  for (int frame = 0; frame < 3; ++frame) {
    filter.spatial(executor, clip.input(), clip.result);
    EXPECT_GT(filter.active_tiles(), 0u);
    filter.temporal(executor, clip.input(), clip.result);
    for (size_t i = 0; i < clip.result.size(); ++i) ASSERT_EQ(clip.result[i], clip.visibility[i]);
  }
}

// A plane seen at a grazing angle, 2.9 % of depth a pixel at first: its pixels are filtered as one surface.
TEST(ShadowFilter, slopes_are_no_edges) {
  Executor executor(1);
  Clip clip;
  for (size_t i = 0; i < clip.depth.size(); ++i)
    clip.depth[i] = 1.0f / (0.1f - 0.0005f * static_cast<float>(i % clip.width));
  for (size_t i = 0; i < clip.depth.size(); ++i) clip.set(i, number(static_cast<uint32_t>(i)) < 0.5f, 40.0f);
  ShadowFilter filter;
  filter.spatial(executor, clip.input(), clip.result);
  double sum = 0.0;
  for (const float v : clip.result) sum += (static_cast<double>(v) - 0.5) * (static_cast<double>(v) - 0.5);
  // As many samples as sf_samples() claims would have the error 0.5 / sqrt(n).
  const auto n = static_cast<double>(shading::sf_samples(shading::sf_most_reach));
  EXPECT_LT(std::sqrt(sum / static_cast<double>(clip.result.size())), 1.5 * 0.5 / std::sqrt(n));
}

TEST(ShadowFilter, a_contact_stays_sharp) {
  Executor executor(1);
  Clip clip;
  for (size_t i = 0; i < clip.depth.size(); ++i) clip.set(i, i % clip.width < 45, 0.05f);
  ShadowFilter filter;
  filter.spatial(executor, clip.input(), clip.result);
  for (size_t i = 0; i < clip.result.size(); ++i) ASSERT_EQ(clip.result[i], clip.visibility[i]);
}

// The error is halved within four frames after all light is switched on, in a dark picture and in a noisy one.
TEST(ShadowFilter, ghosts_halve_within_four_frames) {
  Executor executor(1);
  Clip clip;
  ShadowFilter filter;
  const auto mean_after = [&](int frames, const auto& fill) {
    for (int frame = 0; frame < frames; ++frame) {
      fill(static_cast<uint32_t>(frame));
      filter.spatial(executor, clip.input(), clip.result);
      filter.temporal(executor, clip.input(), clip.result);
    }
    double sum = 0.0;
    for (const float v : clip.result) sum += static_cast<double>(v);
    return sum / static_cast<double>(clip.result.size());
  };
  const auto share = [&](float lit) {
    return [&clip, lit](uint32_t frame) {
      for (size_t i = 0; i < clip.depth.size(); ++i)
        clip.set(i, number(frame * 31337u + static_cast<uint32_t>(i)) < lit, 4.0f);
    };
  };
  EXPECT_EQ(mean_after(12, share(0.0f)), 0.0);
  EXPECT_GE(mean_after(4, share(1.0f)), 0.5);
  // The masks are noisy before and after, so no tile is uniform.
  EXPECT_LT(mean_after(12, share(0.05f)), 0.1);
  EXPECT_GE(mean_after(4, share(0.95f)), 0.5);
}

// A shadow's edge moves by four pixels a frame over a still floor. Pixels that it leaves are lit within four frames.
TEST(ShadowFilter, moving_shadows_leave_no_trail) {
  Executor executor(1);
  Clip clip;
  ShadowFilter filter;
  for (uint32_t frame = 0; frame < 10; ++frame) {
    sample(clip, 0.8, 20.0 + 4.0 * frame, frame + 1);
    filter.spatial(executor, clip.input(), clip.result);
    filter.temporal(executor, clip.input(), clip.result);
  }
  // The edge stands at column 56, 36 pixels further; its shadow lies to the left.
  EXPECT_LT(error(clip, clip.result, 0.8, 56.0), 0.12);
}

// Stripes of one pixel move by three pixels; the neighbourhood allows all values between 0 and 1. Reprojected history
// agrees with them, history at the same pixel is their opposite. Inverting them shows how much history is used.
TEST(ShadowFilter, history_follows_motion_and_not_what_was_hidden) {
  Executor executor(1);
  Clip clip;
  clip.light.tan_radius = 0.0f;  // sharp: no filter within the frame
  ShadowFilter filter;
  const auto frame = [&](size_t moved, uint32_t x_of_new_surface) {
    for (size_t i = 0; i < clip.depth.size(); ++i) {
      clip.set(i, (i % clip.width + moved) % 2 == 0, 5.0f);
      clip.depth[i] = i % clip.width > x_of_new_surface ? 8.0f : 10.0f;
    }
    filter.spatial(executor, clip.input(), clip.result);
    EXPECT_EQ(clip.result, clip.visibility);
    filter.temporal(executor, clip.input(), clip.result);
  };
  frame(0, 1000);
  clip.motion.assign(clip.depth.size(), glm::vec2(3.0f, 0.0f));
  frame(3, 60);
  EXPECT_EQ(clip.result, clip.visibility);
  clip.motion.clear();
  frame(4, 60);
  for (uint32_t y = 2; y < clip.height - 2; ++y)
    for (uint32_t x = 2; x < clip.width - 2; ++x) {
      const size_t i = size_t{y} * clip.width + x;
      if (x > 2 && x < 5) continue;
      if (x > 58 && x < 63) continue;  // less than the whole neighbourhood
      const bool is_new = x < 3 || x > 60;
      ASSERT_NEAR(clip.result[i], is_new ? 0.5f : (2.0f - clip.visibility[i]) / 3.0f, 1e-5f) << x << ", " << y;
    }
}

TEST(ShadowFilter, same_bits_for_any_threads_and_instruction_set) {
  std::vector<float> expected;
  for (const char* isa : {"baseline", "avx2", "avx512"})
    for (const uint32_t threads : {1u, 3u}) {
#if defined(__x86_64__)
      if (std::string(isa) == "avx2" && !__builtin_cpu_supports("avx2")) continue;
      if (std::string(isa) == "avx512" && !__builtin_cpu_supports("avx512dq")) continue;
#endif
      Executor executor(threads);
      Clip clip(93, 67);  // no whole tiles
      clip.light.position = {1.0f, 2.0f, 4.0f}, clip.light.radius = 0.3f;
      clip.motion.assign(clip.depth.size(), glm::vec2(0.3f, -1.7f));
      clip.motion[77] = glm::vec2(NAN, INFINITY);
      for (size_t i = 0; i < clip.depth.size(); ++i)
        clip.depth[i] += 0.01f * static_cast<float>(i % 7 + i / 300) - (i % 97 == 0 ? 11.0f : 0.0f);
      ShadowFilter filter(shadow_kernels(isa));
      for (uint32_t frame = 0; frame < 3; ++frame) {
        sample(clip, 1.5, 40.0, frame + 5);
        filter.spatial(executor, clip.input(), clip.result);
        filter.temporal(executor, clip.input(), clip.result);
      }
      for (const float v : clip.result) ASSERT_TRUE(v >= 0.0f && v <= 1.0f) << v;
      if (expected.empty()) expected = clip.result;
      EXPECT_EQ(clip.result, expected) << isa << ", " << threads << " threads";
    }
}

// Holds a clip's masks as bytes, and what its tiles see.
struct Bytes {
  std::vector<uint8_t> mask, seen;

  explicit Bytes(const Clip& clip) {
    for (const float v : clip.visibility) mask.push_back(v > 0.5f ? 255 : 0);
    const uint32_t across = (clip.width + 15) / 16;
    seen.assign(size_t{across} * ((clip.height + 15) / 16), 0);
    for (uint32_t y = 0; y < clip.height; ++y)
      for (uint32_t x = 0; x < clip.width; ++x) {
        uint8_t& tile = seen[size_t{y / 16} * across + x / 16];
        tile = static_cast<uint8_t>(tile | (mask[size_t{y} * clip.width + x] ? 2 : 1));
      }
  }
  ShadowFilterInput input(const Clip& clip) const {
    ShadowFilterInput in = clip.input();
    in.visibility = {};
    in.mask = mask;
    in.seen = seen;
    return in;
  }
};

std::vector<uint8_t> rounded(const std::vector<float>& values) {
  std::vector<uint8_t> bytes;
  for (const float v : values) bytes.push_back(static_cast<uint8_t>(v * 255.0f + 0.5f));
  return bytes;
}

// A narrow penumbra in a large picture lets the filter skip most tiles, with and without a following frame.
TEST(ShadowFilter, tiles_left_out_change_nothing) {
  Executor executor(2);
  Clip clip(211, 147);
  clip.light.position = {1.0f, 2.0f, 4.0f}, clip.light.radius = 0.3f;
  for (size_t i = 0; i < clip.depth.size(); ++i)
    clip.depth[i] += 0.01f * static_cast<float>(i % 7 + i / 300) - (i % 97 == 0 ? 11.0f : 0.0f);
  ShadowFilter whole, sparse;
  ShadowFilter* const filters[] = {&sparse};
  std::vector<float> depth_before = clip.depth;
  for (uint32_t frame = 0; frame < 3; ++frame) {
    sample(clip, 0.2, 60.0 + frame, frame + 5);
    if (frame > 0) {
      whole.follow(clip.light, depth_before);
      sparse.follow(clip.light, depth_before);
    }
    Bytes bytes(clip);
    const ShadowFilterInput input = bytes.input(clip);
    uint8_t* const masks[] = {bytes.mask.data()};
    whole.spatial(executor, clip.input(), clip.result);
    ShadowFilter::spatial(executor, filters, {&input, 1}, frame > 0);
    if (frame > 0) {
      whole.temporal(executor, clip.input(), clip.result);
      sparse.temporal(executor, input);
    }
    ShadowFilter::store(executor, filters, masks, frame > 0);
    EXPECT_EQ(bytes.mask, rounded(clip.result)) << "frame " << frame;
    EXPECT_GT(whole.active_tiles(), 0u);
    EXPECT_LT(whole.active_tiles(), whole.tiles() / 2);
    EXPECT_EQ(sparse.active_tiles(), whole.active_tiles());
    depth_before = clip.depth;
    for (float& d : clip.depth) d += 0.001f;
  }
}

// Several lights are filtered at once; some are missing in one frame, and then the picture becomes smaller.
TEST(ShadowFilter, lights_at_once_have_the_bits_of_each_alone) {
  Executor executor(3);
  std::vector<ShadowFilter> together(3), alone(3);
  uint32_t frame = 0;
  for (const uint32_t width : {147u, 147u, 147u, 131u, 131u}) {
    ++frame;
    std::vector<Clip> clips(together.size(), Clip(width, 75));
    std::vector<ShadowFilter*> filters;
    std::vector<ShadowFilterInput> inputs;
    std::vector<std::vector<float>> expected;
    std::vector<std::vector<uint8_t>> masks;
    for (uint32_t light = frame % 2; light < together.size(); ++light) {
      Clip& clip = clips[light];
      clip.light.position = {1.0f, 2.0f + static_cast<float>(light), 4.0f}, clip.light.radius = 0.3f;
      for (size_t i = 0; i < clip.depth.size(); ++i)
        clip.depth[i] += 0.01f * static_cast<float>(i % 7 + i / 300 + frame) - (i % 97 == 0 ? 11.0f : 0.0f);
      sample(clip, 0.2 + light, 40.0, frame + light);
      ShadowFilterInput input = clip.input();
      alone[light].spatial(executor, input, clip.result);
      expected.push_back(clip.result);
      filters.push_back(&together[light]);
      input.depth = clips[frame % 2].depth;
      inputs.push_back(input);
      masks.emplace_back(clip.depth.size(), uint8_t{7});
    }
    std::vector<uint8_t*> to;
    for (std::vector<uint8_t>& mask : masks) to.push_back(mask.data());
    ShadowFilter::spatial(executor, filters, inputs, true);
    for (size_t i = 0; i < filters.size(); ++i) {
      filters[i]->temporal(executor, inputs[i]);
      alone[i + frame % 2].temporal(executor, inputs[i]);
    }
    ShadowFilter::store(executor, filters, to, false);
    for (size_t i = 0; i < filters.size(); ++i) {
      EXPECT_EQ(filters[i]->active_tiles(), alone[i + frame % 2].active_tiles());
      EXPECT_GT(filters[i]->active_tiles(), 0u);
      const std::vector<uint8_t> wanted = rounded(expected[i]);
      for (size_t k = 0; k < wanted.size(); ++k)
        ASSERT_TRUE(masks[i][k] == 7 || masks[i][k] == wanted[k]) << "frame " << frame << ", light " << i << ", " << k;
    }
    ShadowFilter::store(executor, filters, to, true);
    std::vector<std::vector<uint8_t>> apart = masks;
    for (size_t i = 0; i < filters.size(); ++i) {
      ShadowFilter* const one[] = {&alone[i + frame % 2]};
      uint8_t* const its[] = {apart[i].data()};
      ShadowFilter::store(executor, one, its, true);
    }
    EXPECT_EQ(masks, apart) << "frame " << frame;
  }
}

// Red, green and blue of a tint name one image of distances. If all three are tinted in the same pixels, each has the
// bits of a filter of its own.
TEST(ShadowFilter, colours_of_one_light_have_the_bits_of_each_alone) {
  Executor executor(3);
  std::array<ShadowFilter, 3> together, alone;
  std::array<std::vector<uint8_t>, 3> masks, masks_alone;
  for (uint32_t frame = 1; frame <= 3; ++frame) {
    Clip clip(147, 75);
    sample(clip, 1.5, 60.0, frame);
    std::vector<ShadowFilterInput> inputs;
    std::vector<ShadowFilter*> filters;
    std::vector<uint8_t*> to;
    const auto input_of = [&](std::vector<uint8_t>& mask) {
      ShadowFilterInput input = clip.input();
      input.visibility = {}, input.mask = mask;
      return input;
    };
    for (size_t c = 0; c < 3; ++c) {
      masks[c].assign(clip.hit.size(), 255);
      for (size_t i = 0; i < clip.hit.size(); ++i)
        if (clip.hit[i] < infinite) masks[c][i] = static_cast<uint8_t>(c == 2 ? 200 : 60 * c + i % 5);
      masks_alone[c] = masks[c];
      inputs.push_back(input_of(masks[c]));
      filters.push_back(&together[c]);
      to.push_back(masks[c].data());
    }
    ShadowFilter::spatial(executor, filters, inputs, true);
    for (size_t c = 0; c < 3; ++c) together[c].temporal(executor, inputs[c]);
    ShadowFilter::store(executor, filters, to, true);
    for (size_t c = 0; c < 3; ++c) {
      const ShadowFilterInput input = input_of(masks_alone[c]);
      ShadowFilter* const one[] = {&alone[c]};
      uint8_t* const its[] = {masks_alone[c].data()};
      const std::vector<uint8_t> before = masks_alone[c];
      ShadowFilter::spatial(executor, one, {&input, 1}, true);
      alone[c].temporal(executor, input);
      ShadowFilter::store(executor, one, its, true);
      EXPECT_NE(masks_alone[c], before);
      EXPECT_EQ(masks[c], masks_alone[c]) << "frame " << frame << ", colour " << c;
    }
  }
}

// Returns the kernels' result for a picture of one tile, with all passes.
std::vector<float> in_all_passes(const Clip& clip) {
  constexpr int32_t side = shadow_tile, stride = 3 * side;
  const shading::SfView& v = clip.view;
  const ShadowTerms terms{{},
                          0.0f,
                          clip.light.tan_radius,
                          clip.light.most_penumbra,
                          clip.light.most_frames,
                          v.origin_x,
                          v.origin_y,
                          v.step_x,
                          v.step_y,
                          {0.0f, 0.0f, 1.0f},
                          0.0f};
  std::vector<std::vector<float>> planes(7, std::vector<float>(stride * stride));
  const auto plane = [&](size_t i) { return planes[i].data(); };
  ShadowPlanes to{plane(0), plane(1), plane(2), plane(3), plane(4), plane(5), plane(6),
                  side * stride + side, stride};
  const ShadowKernels& kernels = shadow_kernels();
  const auto for_rows = [&](const auto& work) {
    for (int32_t y = 0; y < side; ++y) work(y, to.origin + y * stride);
  };
  ShadowColumns columns{};
  for_rows([&](int32_t y, int32_t at) { kernels.invert(&clip.depth[static_cast<size_t>(y * side)], to.inverse + at); });
  for_rows([&](int32_t, int32_t at) { kernels.slope(to, at); });
  for_rows([&](int32_t y, int32_t at) {
    const auto first = static_cast<size_t>(y * side);
    kernels.load(&clip.visibility[first], &clip.visibility[first], &clip.hit[first], to, at, columns);
  });
  float distances = 0.0f, hits = 0.0f;
  for (int32_t i = 0; i < side; ++i) distances += columns.distances[i], hits += columns.hits[i];
  ShadowTileReach reach{{}, hits / distances};
  for_rows([&](int32_t y, int32_t) { kernels.prepare(terms, to, 0, y, reach); });
  for (const int32_t step : {1, 2, 4, 8}) {
    for_rows([&](int32_t, int32_t at) { kernels.blur(&to, 1, at, step); });
    std::swap(to.visibility, to.filtered);
  }
  std::vector<float> result;
  for_rows([&](int32_t, int32_t at) { result.insert(result.end(), to.visibility + at, to.visibility + at + side); });
  return result;
}

// The reaches are such that the filter may stop after each of the passes, or before the first.
TEST(ShadowFilter, passes_left_out_change_nothing) {
  Executor executor(1);
  for (const double height : {0.05, 0.1, 0.2, 0.4, 0.8, 1.2, 1.6, 3.0, 6.0}) {
    Clip clip(shadow_tile, shadow_tile);
    for (uint32_t frame = 0; frame < 2; ++frame) {
      for (size_t i = 0; i < clip.depth.size(); ++i)
        clip.set(i, number(static_cast<uint32_t>(i) + frame) < 0.5f, static_cast<float>(height));
      ShadowFilter filter;
      filter.spatial(executor, clip.input(), clip.result);
      EXPECT_EQ(clip.result, in_all_passes(clip)) << "height " << height;
      EXPECT_EQ(clip.result == clip.visibility, height < 0.15) << "height " << height;
    }
  }
}

TEST(ShadowFilter, bytes_that_do_not_change_stay) {
  for (int i = 0; i < 256; ++i) EXPECT_EQ(static_cast<int>(static_cast<float>(i) * (1.0f / 255.0f) * 255.0f + 0.5f), i);
}

}  // namespace
}  // namespace sideray::rt
