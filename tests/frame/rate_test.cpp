// Tests layer caches of reduced rates: interpolation from neighbours, and the second wave.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "frame/frame.h"
#include "scenes/builtin/builtin.h"
#include "scenes/content/shapes.h"

namespace sideray::tests::rate_test {
namespace {

using scenes::Content;
using scenes::ContentBuilder;
using scenes::Shape;

struct Rate {
  sideray_cache_rate rate;
  const char* name;
  double share;  // of pixels traced, of a large picture
  // Of a pixel, rows counted from the bottom.
  bool traces(uint32_t x, uint32_t y) const {
    if (rate == SIDERAY_RATE_CHECKERBOARD) return (x + y) % 2 == 0;
    return y % 2 == 0 && (rate == SIDERAY_RATE_INTERLEAVED || x % 2 == 0);
  }
  // Pixels on either side of an untraced one, as offsets to one of the two.
  std::vector<std::pair<int, int>> pairs(uint32_t x, uint32_t y) const {
    if (rate == SIDERAY_RATE_CHECKERBOARD) return {{1, 0}, {0, 1}};
    if (rate == SIDERAY_RATE_INTERLEAVED) return {{0, 1}, {1, 1}, {-1, 1}};
    if (x % 2 == 1 && y % 2 == 1) return {{1, 1}, {-1, 1}};
    return {x % 2 == 1 ? std::pair(1, 0) : std::pair(0, 1)};
  }
};
void PrintTo(const Rate& rate, std::ostream* out) {
  *out << rate.name;
}

class CacheRate : public testing::TestWithParam<Rate> {
 protected:
  // Reduced rates have no whole pixels: fragments are compared with fragments.
  static tests::Setup full(tests::Setup setup) {
    setup.cache_rate = SIDERAY_RATE_FULL;
    setup.whole_pixels = false;
    return setup;
  }
  static tests::Setup reduced(tests::Setup setup, bool second_wave = true) {
    setup.cache_rate = GetParam().rate;
    setup.second_wave = second_wave;
    return setup;
  }
};

constexpr float opacity = 0.25f;  // of the panes

Content panes(int count, double angle = 0) {
  return scenes::generate("panes", {{"count", std::to_string(count)}, {"angle", std::to_string(angle)}});
}

// The picture equals that at full rate with each untraced pixel's layer replaced by the mean of its neighbours'.
TEST_P(CacheRate, AFlatPaneIsInterpolated) {
  const tests::Setup setup{.layers = 1, .aovs = SIDERAY_AOV_LAYERS};
  const Frame truth = render(panes(1), full(setup)), frame = render(panes(1), reduced(setup));
  const auto texel = [&](uint32_t x, uint32_t y) { return size_t{setup.height - 1 - y} * setup.width + x; };
  const std::vector<float>& distance = truth.planes.at("layer0.distance");
  size_t interpolated = 0, untraced = 0;
  for (uint32_t y = 1; y + 1 < setup.height; ++y)
    for (uint32_t x = 1; x + 1 < setup.width; ++x) {
      if (GetParam().traces(x, y) || distance[texel(x, y)] == 0) continue;
      ++untraced;
      std::vector<size_t> donors;
      for (const auto& [dx, dy] : GetParam().pairs(x, y))
        for (const int side : {-1, 1})
          donors.push_back(texel(static_cast<uint32_t>(static_cast<int>(x) + side * dx),
                                 static_cast<uint32_t>(static_cast<int>(y) + side * dy)));
      if (std::any_of(donors.begin(), donors.end(), [&](size_t d) { return distance[d] == 0; })) continue;
      ++interpolated;
      for (const char* channel : {"R", "G", "B"}) {
        const std::vector<float>& layer = truth.planes.at(std::string("layer0.") + channel);
        float mean = 0;
        for (const size_t d : donors) mean += layer[d] / static_cast<float>(donors.size());
        const float own = layer[texel(x, y)], whole = truth.planes.at(channel)[texel(x, y)];
        const float expected = whole + opacity * (mean - own);
        // Sums of a handful of floats.
        ASSERT_NEAR(frame.planes.at(channel)[texel(x, y)], expected, 16 * 0x1p-24f * (std::abs(whole) + own + mean))
            << x << "," << y << " " << channel;
      }
    }
  ASSERT_GT(untraced, 1000u);
  EXPECT_GT(interpolated, untraced * 9 / 10);
}

TEST_P(CacheRate, TracedPixelsAreTheSameBits) {
  const tests::Setup setup{};
  const Frame truth = render(panes(3, 40), full(setup)), frame = render(panes(3, 40), reduced(setup));
  for (uint32_t y = 0; y < setup.height; ++y)
    for (uint32_t x = 0; x < setup.width; ++x) {
      if (!GetParam().traces(x, y)) continue;
      const size_t i = size_t{setup.height - 1 - y} * setup.width + x;
      for (const char* channel : {"R", "G", "B"})
        ASSERT_EQ(frame.planes.at(channel)[i], truth.planes.at(channel)[i]) << x << "," << y;
    }
}

sideray_material_desc plain_colour(glm::vec3 color) {
  sideray_material_desc d = scenes::opaque_material(color, 1.0f);
  d.base_color[3] = 0.5f;
  d.alpha_mode = SIDERAY_BLEND;
  d.double_sided = 1;
  d.unlit = 1;
  return d;
}

void add_camera(ContentBuilder& b) {
  const double eye[3] = {0, 0, 0}, target[3] = {0, 0, -1};
  b.camera("front", scenes::look_at(eye, target, 45));
}

// Two panes touch in one plane, another is behind them: each keeps its own colour in every pixel.
TEST_P(CacheRate, SurfacesNeverMix) {
  ContentBuilder b("neighbours");
  const auto pane = [&](const char* name, glm::vec3 color, glm::vec3 low, glm::vec3 high) {
    const Shape quad = Shape().quad(low, {high.x, low.y, high.z}, high, {low.x, high.y, low.z});
    b.object(name, b.mesh(quad, name), b.material(name, plain_colour(color), scenes::RayTraced::yes));
  };
  pane("left", {1, 0, 0}, {-1.3f, -0.9f, -3.2f}, {0.07f, 0.8f, -3});
  pane("right", {0, 0, 1}, {0.07f, -0.9f, -3}, {1.2f, 0.8f, -2.8f});
  pane("behind", {0, 1, 0.25f}, {-0.6f, -0.4f, -4.1f}, {0.9f, 0.61f, -4.1f});
  add_camera(b);
  const Content content = b.take();
  EXPECT_EQ(render(content, reduced({})).planes, render(content, full({})).planes);
}

// The sides of a box are one surface id in six planes. A donor across an edge by less than the eighth of a pixel that
// is granted to curved surfaces counts as one: an edge is off by no more than that.
TEST_P(CacheRate, SidesOfABoxHardlyMix) {
  ContentBuilder b("box");
  b.object("box", b.mesh(Shape().box({-0.7f, -0.6f, -0.7f}, {0.7f, 0.6f, 0.7f}), "box"),
           b.material("box", plain_colour({1, 1, 1}), scenes::RayTraced::yes), {0.1, -0.4, -4}, 33);
  add_camera(b);
  Content content = b.take();
  scenes::Mesh& mesh = content.meshes[0];
  for (size_t v = 0; v < mesh.normals.size(); v += 3)
    for (const float channel :
         {0.5f + 0.5f * mesh.normals[v], 0.5f + 0.5f * mesh.normals[v + 1], 0.5f + 0.5f * mesh.normals[v + 2], 1.0f})
      mesh.colors.push_back(channel);
  const tests::Setup setup{.layers = 8};
  const std::vector<float> truth = render(content, full(setup)).rgb(), frame = render(content, reduced(setup)).rgb();
  size_t edges = 0, mixed = 0;
  for (uint32_t y = 1; y + 1 < setup.height; ++y)
    for (uint32_t x = 1; x + 1 < setup.width; ++x) {
      const size_t i = size_t{y} * setup.width + x;
      const auto differ = [&](size_t a, size_t c) {
        return !std::equal(&truth[3 * a], &truth[3 * a] + 3, &truth[3 * c]);
      };
      const bool edge = differ(i, i - 1) || differ(i, i + 1) || differ(i, i - setup.width) ||
                        differ(i, i + setup.width) || differ(i, i - setup.width - 1) ||
                        differ(i, i + setup.width + 1) || differ(i, i - setup.width + 1) ||
                        differ(i, i + setup.width - 1);
      const bool same = std::equal(&truth[3 * i], &truth[3 * i] + 3, &frame[3 * i]);
      edges += edge, mixed += !same;
      ASSERT_TRUE(same || edge) << x << "," << y;
    }
  ASSERT_GT(edges, 300u);
  EXPECT_LT(static_cast<double>(mixed), 0.125 * static_cast<double>(edges));
}

// Masked pixels with a neighbour that is not.
uint64_t rim_of(const Frame& frame) {
  const std::vector<uint32_t>& count = frame.uint_planes.at("mask.count");
  uint64_t rim = 0;
  for (uint32_t y = 1; y + 1 < frame.height; ++y)
    for (uint32_t x = 1; x + 1 < frame.width; ++x) {
      const size_t i = size_t{y} * frame.width + x;
      bool inside = true;
      for (const size_t row : {i - frame.width, i, i + frame.width})
        for (const size_t n : {row - 1, row, row + 1}) inside &= count[n] > 0;
      rim += count[i] > 0 && !inside;
    }
  return rim;
}

// At 85 and 88 degrees the distance changes more between pixels than any fixed tolerance allows. All neighbours in the
// plane are donors, except those beyond the rim.
TEST_P(CacheRate, AGlancingPaneKeepsItsDonors) {
  for (const double angle : {80.0, 85.0, 88.0}) {
    const tests::Setup setup{.layers = 1, .aovs = SIDERAY_AOV_LAYERS | SIDERAY_AOV_MASK, .repeats = 1};
    const Frame truth = render(panes(1, angle), full(setup)), frame = render(panes(1, angle), reduced(setup, false));
    EXPECT_LE(frame.stats.layers_missed, truth.stats.layers_missed + rim_of(truth)) << angle;
    if (angle < 85) continue;
    const std::vector<float>& distance = truth.planes.at("layer0.distance");
    size_t beyond = 0, neighbours = 0;
    for (size_t i = 1; i < distance.size(); ++i) {
      if (distance[i] == 0 || distance[i - 1] == 0) continue;
      ++neighbours;
      beyond += std::abs(distance[i] - distance[i - 1]) > 1e-3f * distance[i];
    }
    EXPECT_GT(beyond, neighbours * 9 / 10) << angle;
  }
}

tests::Setup edges_setup() {
  return {.layers = 4, .repeats = 1};
}
Content edges() {
  return scenes::generate("edges", {{"thickness", "2"}});
}

TEST_P(CacheRate, TheSecondWaveLeavesNoFragmentThatFullRateAnswers) {
  const sideray_render_stats truth = render(edges(), full(edges_setup())).stats;
  const sideray_render_stats one = render(edges(), reduced(edges_setup(), false)).stats;
  const sideray_render_stats two = render(edges(), reduced(edges_setup())).stats;
  EXPECT_LE(two.layers_missed, truth.layers_missed);
  EXPECT_GT(one.layers_missed, truth.layers_missed) << "the scene has rods that need the second wave";
  EXPECT_EQ(two.layers_missed + two.layers_matched, truth.layers_missed + truth.layers_matched);
  EXPECT_EQ(two.pixels_masked, truth.pixels_masked);
  EXPECT_EQ(two.layers_requested, truth.layers_requested);
  EXPECT_NEAR(static_cast<double>(one.rays_primary), GetParam().share * static_cast<double>(truth.rays_primary),
              0.02 * static_cast<double>(truth.rays_primary));
  EXPECT_GT(two.rays_primary, one.rays_primary);
  EXPECT_LT(two.rays_primary, truth.rays_primary);
}

TEST_P(CacheRate, OddSizesHaveNoGaps) {
  for (const auto& [width, height] : {std::pair{1u, 1u}, {3u, 5u}, {33u, 31u}}) {
    const tests::Setup setup{.width = width, .height = height, .repeats = 1};
    const sideray_render_stats truth = render(panes(2), full(setup)).stats, s = render(panes(2), reduced(setup)).stats;
    EXPECT_LE(s.layers_missed, truth.layers_missed) << width << "x" << height;
    EXPECT_LE(s.rays_primary, truth.rays_primary) << width << "x" << height;
  }
}

TEST_P(CacheRate, EveryMaskGivesThePicture) {
  tests::Setup setup{.mask = SIDERAY_STENCIL_MASK};
  const Frame stencil = render(panes(3, 40), reduced(setup));
  setup.mask = SIDERAY_NO_MASK;
  const Frame none = render(panes(3, 40), reduced(setup));
  setup.mask = SIDERAY_COUNT_MASK;
  const Frame count = render(panes(3, 40), reduced(setup));
  EXPECT_EQ(stencil.planes, none.planes);
  // The count is off where rasterization and rays disagree about the rim.
  size_t different = 0;
  for (size_t i = 0; i < stencil.planes.at("R").size(); ++i)
    different += stencil.planes.at("R")[i] != count.planes.at("R")[i];
  EXPECT_LE(different, stencil.planes.at("R").size() / 1000);
}

TEST_P(CacheRate, SameBitsForAnyThreadCount) {
  tests::Setup setup = reduced({.width = 160, .height = 90, .threads = 1});
  const Frame one = render(edges(), setup);
  setup.threads = 2;
  EXPECT_EQ(render(edges(), setup).planes, one.planes);
}

// A renderer's earlier pictures, at any rate and from any place, do not influence later ones.
TEST_P(CacheRate, EarlierPicturesLeaveNothing) {
  const Content content = edges();
  Renderer renderer = Renderer::create(sideray_renderer_defaults()).value();
  Scene scene = Scene::create().value();
  scenes::fill(scene, content, std::vector<bool>(content.objects.size(), true));
  RenderOptions options;
  options.picture.ambient = options.picture.reflections = 0;
  options.picture.width = 160, options.picture.height = 90;
  const double eye[3] = {0.4, 0.1, -0.5}, target[3] = {-0.5, 0, -3};
  const auto draw = [&](Renderer& with, const sideray_camera& camera, sideray_cache_rate rate) {
    options.translucency->cache_rate = rate;
    const Picture picture = with.render(scene, camera, options).value();
    const auto* red = static_cast<const float*>(picture.channel(0).values);
    return std::vector<float>(red, red + size_t{160} * 90);
  };
  const sideray_camera front = content.cameras[0].camera, aside = scenes::look_at(eye, target, 40);
  draw(renderer, aside, SIDERAY_RATE_FULL);
  draw(renderer, front, GetParam().rate);
  draw(renderer, aside, GetParam().rate);
  const std::vector<float> again = draw(renderer, front, GetParam().rate);
  Renderer other = Renderer::create(sideray_renderer_defaults()).value();
  EXPECT_EQ(again, draw(other, front, GetParam().rate));
}

INSTANTIATE_TEST_SUITE_P(Rates, CacheRate,
                         testing::Values(Rate{SIDERAY_RATE_CHECKERBOARD, "checkerboard", 0.5},
                                         Rate{SIDERAY_RATE_INTERLEAVED, "interleaved", 0.5},
                                         Rate{SIDERAY_RATE_QUARTER, "quarter", 0.25}),
                         [](const auto& rate) { return std::string(rate.param.name); });

}  // namespace
}  // namespace sideray::tests::rate_test
