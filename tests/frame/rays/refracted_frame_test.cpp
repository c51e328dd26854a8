// Tests refracting glass in whole frames: compares hybrid translucency with rays through every surface, in every order
// of blending, at every rate, with smoke around; and tests the rasterizer without rays.
#include <algorithm>
#include <cmath>

#include "frame/frame.h"
#include "scenes/builtin/builtin.h"

namespace sideray::tests::refracted_frame_test {
namespace {

tests::Setup drawn(sideray_translucency translucency, uint32_t layers) {
  tests::Setup setup{.width = 160, .height = 90, .translucency = translucency};
  setup.layers = layers;
  setup.refraction = true;
  return setup;
}

tests::Setup hybrid() {
  return drawn(SIDERAY_TRANSLUCENCY_HYBRID, 4);
}

tests::Setup by_rays() {
  return drawn(SIDERAY_TRANSLUCENCY_RAYTRACED, 0);
}

// Holds the mean difference, and the share of pixels that show something else.
struct Difference {
  double mean = 0, others = 0;
};

Difference difference(const Frame& a, const Frame& b) {
  const std::vector<float> x = a.rgb(), y = b.rgb();
  Difference d;
  for (size_t i = 0; i < x.size(); i += 3) {
    float most = 0.0f;
    for (size_t c = i; c < i + 3; ++c) {
      d.mean += static_cast<double>(std::abs(x[c] - y[c]));
      most = std::max(most, std::abs(x[c] - y[c]));
    }
    d.others += most > 0.1f;
  }
  d.mean /= static_cast<double>(x.size());
  d.others /= static_cast<double>(x.size()) / 3;
  return d;
}

const scenes::Content& solids() {
  static const scenes::Content content = scenes::generate("solids", {});
  return content;
}

// Edges fall on either side; layers are halfs.
constexpr double most_mean = 0.003, most_others = 0.01;

TEST(RefractedFrames, HybridShowsWhatRaysShowInEveryOrder) {
  const Frame rays = render(solids(), by_rays());
  tests::Setup straight = hybrid();
  straight.refraction = false;
  const Difference before = difference(render(solids(), straight), rays);
  for (const sideray_oit oit : {SIDERAY_OIT_SORTED, SIDERAY_OIT_ABUFFER, SIDERAY_OIT_PEEL}) {
    tests::Setup setup = hybrid();
    setup.oit = oit;
    const Difference d = difference(render(solids(), setup), rays);
    EXPECT_LT(d.mean, most_mean) << oit;
    EXPECT_LT(d.others, most_others) << oit;
    EXPECT_LT(4 * d.mean, before.mean) << oit;
  }
}

TEST(RefractedFrames, MatchersAndContextsAgree) {
  const Frame rays = render(solids(), by_rays());
  tests::Setup nearest = hybrid(), osmesa = hybrid();
  nearest.match = SIDERAY_MATCH_NEAREST;
  osmesa.gl = "osmesa";
  for (const tests::Setup& setup : {nearest, osmesa}) {
    const Difference d = difference(render(solids(), setup), rays);
    EXPECT_LT(d.mean, most_mean);
    EXPECT_LT(d.others, most_others);
  }
}

// The view through glass has more detail than the glass, and half the pixels take it from their neighbours.
TEST(RefractedFrames, ReducedRatesLoseNoSurface) {
  const Frame rays = render(solids(), by_rays());
  tests::Setup straight = hybrid();
  straight.refraction = false;
  const Difference before = difference(render(solids(), straight), rays);
  for (const sideray_cache_rate rate : {SIDERAY_RATE_CHECKERBOARD, SIDERAY_RATE_INTERLEAVED, SIDERAY_RATE_QUARTER}) {
    tests::Setup setup = hybrid();
    setup.cache_rate = rate;
    const Difference d = difference(render(solids(), setup), rays);
    EXPECT_LT(d.mean, 0.5 * before.mean) << rate;
    EXPECT_LT(d.others, 0.5 * before.others) << rate;
  }
}

void add_puffs(scenes::Content& content) {
  scenes::Emitter emitter{};
  emitter.node = "puffs";
  emitter.particles.desc = sideray_particles_defaults();
  const double places[][3] = {{-1.75, 0.5, 0.1}, {-1.6, 0.6, 1.2}, {-1.7, 0.5, -1.0},  // inside, in front of and behind the ball
                              {-0.6, 0.4, -0.2}, {-0.4, 0.5, 1.0}, {-0.7, 0.5, -1.2},
                              {1.3, 0.7, 0.9},   {1.3, 0.5, -1.0}};
  for (const auto& place : places) {
    sideray_sprite s{};
    std::copy(std::begin(place), std::end(place), s.position);
    s.width = s.height = 0.25f;
    s.color[0] = 0.9f, s.color[1] = 0.1f, s.color[2] = 0.1f, s.color[3] = 0.6f;
    emitter.sprites.push_back(s);
  }
  content.emitters.push_back(emitter);
}

TEST(RefractedFrames, SmokeInFrontInsideAndBehindIsSeen) {
  scenes::Content content = solids();
  add_puffs(content);
  tests::Setup with_particles = by_rays();
  with_particles.rt_particles = true;
  const Frame rays = render(content, with_particles), clear = render(solids(), by_rays());
  const double puffs = difference(rays, clear).others;
  EXPECT_GT(puffs, 0.01);
  for (const sideray_oit oit : {SIDERAY_OIT_SORTED, SIDERAY_OIT_ABUFFER, SIDERAY_OIT_PEEL}) {
    tests::Setup setup = hybrid();
    setup.oit = oit;
    const Difference d = difference(render(content, setup), rays);
    EXPECT_LT(d.mean, most_mean) << oit;
    EXPECT_LT(d.others, most_others) << oit;
  }
}

// Screen-space refraction knows one surface: it improves the picture of rough solids, but not of clear ones.
TEST(RefractedFrames, WithoutRaysTheOpaquePictureIsBentAndBlurred) {
  const scenes::Content rough = scenes::generate("solids", {{"roughness", "0.3"}});
  tests::Setup truth = drawn(SIDERAY_TRANSLUCENCY_HYBRID, 4);
  truth.reference = true;
  truth.light_samples = 4;
  const Frame reference = render(rough, truth);
  tests::Setup raster = drawn(SIDERAY_TRANSLUCENCY_RASTER, 0), straight = raster;
  straight.refraction = false;
  const Frame bent = render(rough, raster), unbent = render(rough, straight);
  EXPECT_LT(difference(bent, reference).mean, difference(unbent, reference).mean);
  for (const sideray_oit oit : {SIDERAY_OIT_ABUFFER, SIDERAY_OIT_PEEL}) {
    tests::Setup setup = raster;
    setup.oit = oit;
    EXPECT_LT(difference(render(rough, setup), bent).mean, 0.02) << oit;
  }
}

TEST(RefractedFrames, ResolvedLayersAreShownAsOthers) {
  tests::Setup on = hybrid(), off = on;
  on.aovs = off.aovs = SIDERAY_AOV_LAYERS;
  off.refraction = false;
  const Frame bent = render(solids(), on), straight = render(solids(), off);
  EXPECT_EQ(bent.planes.at("layer0.distance"), straight.planes.at("layer0.distance"));
  EXPECT_EQ(bent.uint_planes.at("layer0.surface"), straight.uint_planes.at("layer0.surface"));
  EXPECT_NE(bent.planes.at("layer0.R"), straight.planes.at("layer0.R"));
  EXPECT_EQ(*std::max_element(bent.planes.at("layer1.distance").begin(), bent.planes.at("layer1.distance").end()), 0.0f)
      << "what lies behind is in the first";
}

TEST(RefractedFrames, NothingChangesWhereNothingBends) {
  const scenes::Content panes = scenes::generate("panes", {});
  for (const sideray_translucency method :
       {SIDERAY_TRANSLUCENCY_RASTER, SIDERAY_TRANSLUCENCY_HYBRID, SIDERAY_TRANSLUCENCY_RAYTRACED}) {
    tests::Setup on = drawn(method, 4), off = on;
    off.refraction = false;
    const Frame bent = render(panes, on), straight = render(panes, off);
    EXPECT_EQ(bent.planes, straight.planes);
    EXPECT_EQ(bent.stats.rays_primary, straight.stats.rays_primary);
    EXPECT_EQ(bent.stats.layers_refracted, 0u);
  }
}

}  // namespace
}  // namespace sideray::tests::refracted_frame_test
