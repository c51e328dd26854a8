// Compares the shadow denoiser in lanes and tiles with the same steps written simply on whole images, over moving noisy
// frames with edges, slopes and holes of depth, for a sun and for a sphere.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "rt/masks/shadow_filter.h"

namespace sideray::rt::shadow_filter_model_test {
namespace {

using namespace shading;

constexpr int width = 75, height = 53, texels = width * height;
constexpr float infinite = std::numeric_limits<float>::infinity();
// Of a visibility: rounding that differs, through five passes and four frames.
constexpr float bound = 1e-4f;

using Image = std::vector<float>;

// Numbers from a counter (PCG hash, Jarzynski and Olano 2020).
float number(int which) {
  uint32_t state = static_cast<uint32_t>(which) * 747796405u + 2891336453u;
  const uint32_t word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
  return static_cast<float>(((word >> 22u) ^ word) >> 8) * 0x1p-24f;
}

struct Frame {
  Image visibility = Image(texels), hit = Image(texels), depth = Image(texels);
  std::vector<glm::vec2> motion = std::vector<glm::vec2>(texels);
};

// Two slanted surfaces, a hole, and a soft edge that moves over them; a contact in one corner.
Frame make_frame(int which) {
  Frame f;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const auto i = static_cast<size_t>(y * width + x);
      const float slant = 0.0004f * static_cast<float>(x) + 0.0002f * static_cast<float>(y);
      f.depth[i] = 1.0f / ((x > 50 ? 0.14f : 0.1f) + slant);
      if (x > 30 && x < 35 && y > 20 && y < 29) f.depth[i] = y > 24 ? infinite : 0.0f;
      const bool contact = x < 20 && y < 20;
      const float lit = std::clamp(0.5f + (static_cast<float>(x - 30 - 2 * which)) * 0.03f, 0.0f, 1.0f);
      const bool seen = contact ? y > 9 : number(which * texels + y * width + x) < lit;
      f.visibility[i] = seen ? 1.0f : 0.0f;
      f.hit[i] = seen ? infinite : contact ? 0.02f : 2.0f + number(x);
      f.motion[i] = {0.4f, y > 40 ? 2.6f : -0.3f};
    }
  f.motion[texels / 2] = {NAN, NAN};
  return f;
}

struct Model {
  SfView view{};
  SfLight light{};
  Image inverse, slope_x, slope_y, reach, filtered;
  std::vector<SfHistory> history;
  Image inverse_before;
  std::vector<bool> active = std::vector<bool>(texels);

  float at(const Image& image, int x, int y) const {
    return x < 0 || y < 0 || x >= width || y >= height ? 0.0f : image[static_cast<size_t>(y * width + x)];
  }
  SfPlane plane(size_t i) const { return {inverse[i], slope_x[i], slope_y[i]}; }

  float nearness(const Frame& f, int x, int y) const {
    if (at(inverse, x, y) <= 0.0f) return 0.0f;
    const auto i = static_cast<size_t>(y * width + x);
    return sf_nearness(f.visibility[i], f.hit[i]);
  }

  void prepare(const Frame& f, int x, int y);
  void blur(int step);
  void accumulate(const Frame& f, int x, int y, std::vector<SfHistory>& next) const;
  void run(const Frame& f);
};

void each_pixel(const std::function<void(int, int)>& work) {
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) work(x, y);
}

// Tiles of 16 x 16 that are, with their neighbours, all lit or all in shadow keep what they have.
void Model::prepare(const Frame& f, int x, int y) {
  float distances = 0.0f, hits = 0.0f, sum = 0.0f, total = 0.0f, least = 1.0f, lit = 0.0f;
  for (int ty = std::max(y / 16 - 1, 0) * 16; ty < std::min((y / 16 + 2) * 16, height); ++ty)
    for (int tx = std::max(x / 16 - 1, 0) * 16; tx < std::min((x / 16 + 2) * 16, width); ++tx) {
      if (const float near = nearness(f, tx, ty); near > 0.0f) distances += 1.0f / near, hits += 1.0f;
      if (at(inverse, tx, ty) <= 0.0f) continue;
      least = std::min(least, at(f.visibility, tx, ty)), lit = std::max(lit, at(f.visibility, tx, ty));
    }
  const auto i = static_cast<size_t>(y * width + x);
  active[i] = least < 1.0f && lit > 0.0f;
  slope_x[i] = sf_slope(at(inverse, x - 1, y), inverse[i], at(inverse, x + 1, y));
  slope_y[i] = sf_slope(at(inverse, x, y - 1), inverse[i], at(inverse, x, y + 1));
  for (int dy = -2; dy <= 2; ++dy)
    for (int dx = -2; dx <= 2; ++dx)
      if (const float near = nearness(f, x + dx, y + dy); near > 0.0f) {
        const float on =
            sf_on_plane(plane(i), static_cast<float>(dx), static_cast<float>(dy), at(inverse, x + dx, y + dy));
        sum += on * near, total += on;
      }
  const float mean =
      glm::mix(hits > 0.0f ? hits / distances : 0.0f, sum / std::max(total, 1e-6f), std::min(total, 1.0f));
  reach[i] = sf_reach(light, view, static_cast<float>(x), static_cast<float>(y), inverse[i], mean);
  if (!active[i]) reach[i] = sf_most_reach;
}

void Model::blur(int step) {
  Image next(texels);
  each_pixel([&](int x, int y) {
    const auto i = static_cast<size_t>(y * width + x);
    float sum = filtered[i], total = 1.0f;
    for (int k = 0; k < 9; ++k) {
      const int dx = (k % 3 - 1) * step, dy = (k / 3 - 1) * step;
      if (k == 4) continue;
      const float on =
          sf_on_plane(plane(i), static_cast<float>(dx), static_cast<float>(dy), at(inverse, x + dx, y + dy));
      const float weight = sf_weight(on, reach[i], at(reach, x + dx, y + dy), static_cast<float>(dx * dx + dy * dy)) *
                           (k % 2 == 0 ? 0.25f : 0.5f);
      sum += weight * at(filtered, x + dx, y + dy), total += weight;
    }
    next[i] = sum / total;
  });
  filtered = next;
}

void Model::accumulate(const Frame& f, int x, int y, std::vector<SfHistory>& next) const {
  const auto i = static_cast<size_t>(y * width + x);
  float total = 0.0f, sum = 0.0f, square = 0.0f, known = 0.0f, value = 0.0f, frames = 0.0f;
  for (int dy = -2; dy <= 2; ++dy)
    for (int dx = -2; dx <= 2; ++dx) {
      const float on =
          sf_on_plane(plane(i), static_cast<float>(dx), static_cast<float>(dy), at(inverse, x + dx, y + dy));
      const float seen = at(filtered, x + dx, y + dy);
      total += on, sum += on * seen, square += on * seen * seen;
    }
  const float most = std::max(total, 1e-6f);
  SfPlane then = plane(i);
  then.inverse = sf_inverse_before(view, static_cast<float>(x), static_cast<float>(y), inverse[i]);
  const glm::vec2 from = glm::vec2(x, y) - f.motion[i];
  for (int tap = 0; tap < 4 && !std::isnan(from.x) && !history.empty(); ++tap) {
    const glm::vec2 corner = glm::floor(from) + glm::vec2(tap & 1, tap >> 1), apart = corner - from;
    const int px = static_cast<int>(corner.x), py = static_cast<int>(corner.y);
    if (px < 0 || py < 0 || px >= width || py >= height) continue;
    const float weight = (1.0f - std::abs(apart.x)) * (1.0f - std::abs(apart.y)) *
                         sf_on_plane(then, apart.x, apart.y, at(inverse_before, px, py));
    const SfHistory& h = history[static_cast<size_t>(py * width + px)];
    known += weight, value += weight * h.value, frames += weight * h.frames;
  }
  const SfHistory before{value / std::max(known, 1e-6f), known > 0.05f ? frames / known : 0.0f};
  next[i] = sf_accumulate(light, before, filtered[i], {total, sum / most, square / most}, sf_samples(reach[i]));
  if (!active[i]) next[i] = {filtered[i], light.most_frames};
}

void Model::run(const Frame& f) {
  inverse.resize(texels), slope_x.resize(texels), slope_y.resize(texels), reach.resize(texels);
  std::transform(f.depth.begin(), f.depth.end(), inverse.begin(), [](float z) { return sf_inverse_depth(z); });
  each_pixel([&](int x, int y) { prepare(f, x, y); });
  filtered = f.visibility;
  for (int step = 1; step <= 8; step *= 2) blur(step);
  std::vector<SfHistory> next(texels);
  each_pixel([&](int x, int y) { accumulate(f, x, y, next); });
  history = next;
  inverse_before = inverse;
}

TEST(ShadowFilterModel, lanes_and_plain_steps_agree) {
  Executor executor(2);
  for (const bool is_sun : {true, false}) {
    const SfView view{-0.15f, -0.1f, 0.004f, 0.004f, {0.0f, 0.0f, 1.0f}, 0.001f};
    const SfLight light{{1.0f, 2.0f, 6.0f}, is_sun ? 0.0f : 0.2f, 0.1f, 32.0f, 8.0f};
    Model model;
    model.view = view, model.light = light;
    ShadowFilter filter;
    int soft = 0;
    for (int which = 0; which < 4; ++which) {
      const Frame f = make_frame(which);
      model.run(f);
      const ShadowFilterInput input{width, height, f.visibility, f.hit, f.depth, f.motion, view, light, {}, {}};
      Image filtered(texels), accumulated(texels);
      filter.spatial(executor, input, filtered);
      filter.temporal(executor, input, accumulated);
      for (size_t i = 0; i < texels; ++i) {
        ASSERT_NEAR(filtered[i], model.filtered[i], bound) << "frame " << which << ", pixel " << i % width << ", "
                                                           << i / width;
        ASSERT_NEAR(accumulated[i], model.history[i].value, bound) << "frame " << which << ", pixel " << i % width
                                                                   << ", " << i / width;
        soft += filtered[i] > 0.1f && filtered[i] < 0.9f;
      }
    }
    EXPECT_GT(soft, texels);  // of four frames
  }
}

}  // namespace
}  // namespace sideray::rt::shadow_filter_model_test
