// Tests that a picture with nothing to trace costs no more than a rasterizer's, in OpenGL calls, objects and heap
// allocations, for a renderer's first picture and for later ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <new>
#include <sideray/sideray.hpp>
#include <vector>

#include "bridge/renderer/renderer.h"
#include "economy/counted_calls.h"
#include "scenes/builtin/builtin.h"

namespace {

std::atomic<uint64_t> allocations{0};

void* allocate(size_t bytes) {
  if (!sideray::tests::in_driver()) ++allocations;
  if (void* memory = std::malloc(std::max<size_t>(bytes, 1))) return memory;
  throw std::bad_alloc();
}

}  // namespace

void* operator new(size_t bytes) {
  return allocate(bytes);
}
void* operator new(size_t bytes, const std::nothrow_t&) noexcept {  // std::stable_sort uses it
  if (!sideray::tests::in_driver()) ++allocations;
  return std::malloc(std::max<size_t>(bytes, 1));
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, size_t) noexcept {
  std::free(memory);
}

namespace sideray::tests {
namespace {

struct Cost {
  CallCounts gl;
  uint64_t allocations = 0;
};

class Stage {
 public:
  explicit Stage(const scenes::Content& content, const std::string& selection = "all", bool has_sky = true)
      : camera_(content.cameras.empty() ? scenes::framing_camera(content, 16.0f / 9.0f)
                                        : content.cameras.front().camera) {
    auto context = gl::Context::create("auto", "");
    count_calls(const_cast<gl::Functions&>(context->functions()));
    // With several threads, whose scratch memory grows would depend on which of them takes a piece of work first.
    renderer_ = std::make_unique<bridge::Renderer>(std::move(context), rt::TracerConfig{.threads = 1, .isa = ""});
    const scenes::Sky sky = scenes::sky();
    if (has_sky) scene_.set_environment(sky.width, sky.height, sky.rgb.data(), 1.0f, 0.0f);
    scenes::fill(scene_, content, scenes::select_ray_traced(content, selection, camera_, 1280, 720));
  }

  // Returns the cost of one picture with its readback.
  Cost draw(const RenderOptions& options) { return draw(*this, options); }
  // Returns the cost of a picture of another stage's scene in this renderer.
  Cost draw(Stage& shown, const RenderOptions& options) {
    const CallCounts calls = call_counts();
    const uint64_t allocated = allocations;
    const sideray_render_options given = options.c();
    renderer_->render(shown.scene_.get(), shown.camera_, bridge::read_render_options(&given));
    return {call_counts() - calls, allocations - allocated};
  }

 private:
  std::unique_ptr<bridge::Renderer> renderer_;
  Scene scene_ = Scene::create().value();
  sideray_camera camera_;
};

RenderOptions options_of(sideray_translucency translucency, sideray_shadows shadows) {
  RenderOptions o;
  o.picture.ambient = o.picture.reflections = 0;
  o.picture.width = 160;
  o.picture.height = 90;
  o.translucency->method = translucency;
  o.shadows->method = shadows;
  return o;
}

void print(const char* what, const char* which, const Cost& c) {
  std::printf("%-28s %-14s %6llu calls %5llu objects %7llu allocations\n", what, which,
              static_cast<unsigned long long>(c.gl.calls), static_cast<unsigned long long>(c.gl.objects),
              static_cast<unsigned long long>(c.allocations));
}

void expect_within(uint64_t test, uint64_t raster, const char* what) {
  EXPECT_LE(static_cast<double>(test), 1.03 * static_cast<double>(raster)) << what;
}

// Compares first and later pictures of two renderers with different options.
void expect_no_more(Stage& test, const RenderOptions& test_options, Stage& raster,
                    const RenderOptions& raster_options, const char* what) {
  sideray_option_count();  // makes the table that options are checked by, once a process
  for (const char* which : {"first", "second", "third"}) {
    const Cost a = test.draw(test_options), b = raster.draw(raster_options);
    print(what, which, a);
    print("  against raster", which, b);
    expect_within(a.gl.calls, b.gl.calls, which);
    expect_within(a.gl.objects, b.gl.objects, which);
    expect_within(a.allocations, b.allocations, which);
    EXPECT_GT(b.gl.calls, 50u) << "nothing was counted";
    EXPECT_GT(b.allocations, 10u) << "nothing was counted";
  }
}

class Empty : public testing::TestWithParam<sideray_shadows> {};

TEST_P(Empty, CostsNoMoreThanRaster) {
  const scenes::Content content = scenes::generate("empty", {});
  Stage hybrid(content), raster(content);
  expect_no_more(hybrid, options_of(SIDERAY_TRANSLUCENCY_HYBRID, GetParam()), raster,
                 options_of(SIDERAY_TRANSLUCENCY_RASTER, GetParam()), "empty, hybrid");
}

INSTANTIATE_TEST_SUITE_P(Economy, Empty,
                         testing::Values(SIDERAY_SHADOWS_OFF, SIDERAY_SHADOWS_MAP, SIDERAY_SHADOWS_EXACT,
                                         SIDERAY_SHADOWS_INEXACT));

TEST(Economy, HybridOfNothingTracedCostsNoMoreThanRaster) {
  const scenes::Content content = scenes::generate("panes", {});
  Stage hybrid(content, "none"), raster(content, "none");
  expect_no_more(hybrid, options_of(SIDERAY_TRANSLUCENCY_HYBRID, SIDERAY_SHADOWS_MAP), raster,
                 options_of(SIDERAY_TRANSLUCENCY_RASTER, SIDERAY_SHADOWS_MAP), "panes, none traced");
}

TEST(Economy, RasterOfWhatCouldBeTracedCostsNoMoreThanOfWhatCannot) {
  const scenes::Content content = scenes::generate("panes", {});
  Stage marked(content, "all"), plain(content, "none");
  const RenderOptions options = options_of(SIDERAY_TRANSLUCENCY_RASTER, SIDERAY_SHADOWS_MAP);
  expect_no_more(marked, options, plain, options, "panes, raster, marked");
}

// Options that auto disables cost as little as `off`.
TEST(Economy, OpaqueRaysThatAreLeftOutCostNothing) {
  const scenes::Content content = scenes::generate("panes", {});
  Stage automatic(content, "none", false), off(content, "none", false);
  RenderOptions left = options_of(SIDERAY_TRANSLUCENCY_RASTER, SIDERAY_SHADOWS_MAP);
  left.picture.reflections = SIDERAY_REFLECTIONS_AUTO;
  expect_no_more(automatic, left, off, options_of(SIDERAY_TRANSLUCENCY_RASTER, SIDERAY_SHADOWS_MAP), "panes, auto");
}

// Later pictures reuse shadow maps: scenes in turn cost no more than each alone, apart from setting state.
TEST(Economy, ScenesInTurnCostWhatEachCostsAlone) {
  Stage one(scenes::generate("solids", {})), other(scenes::generate("solids", {}));
  const RenderOptions options = options_of(SIDERAY_TRANSLUCENCY_HYBRID, SIDERAY_SHADOWS_MAP);
  other.draw(one, options);
  const Cost alone = other.draw(one, options);
  other.draw(options);
  for (const char* turn : {"first", "second"}) {
    const Cost in_turn = other.draw(one, options);
    print("after another scene", turn, in_turn);
    EXPECT_EQ(in_turn.gl.calls, alone.gl.calls);
    EXPECT_EQ(in_turn.gl.objects, 0u);
    other.draw(options);
  }
}

TEST(Economy, AFewScenesInTurnAreKept) {
  std::vector<std::unique_ptr<Stage>> stages;
  for (int i = 0; i < 6; ++i) stages.push_back(std::make_unique<Stage>(scenes::generate("panes", {})));
  const RenderOptions options = options_of(SIDERAY_TRANSLUCENCY_HYBRID, SIDERAY_SHADOWS_MAP);
  Stage& drawing = *stages.back();
  for (const auto& stage : stages) drawing.draw(*stage, options);
  const CallCounts kept = drawing.draw(*stages[2], options).gl, forgotten = drawing.draw(*stages[0], options).gl;
  EXPECT_EQ(kept.objects, drawing.draw(*stages[0], options).gl.objects);
  EXPECT_GT(forgotten.objects, kept.objects + 5);
}

TEST(Economy, ShadowMapsOfWhatStandsStillAreDrawnOnce) {
  const scenes::Content content = scenes::generate("solids", {});
  Stage with_maps(content), without(content);
  const RenderOptions maps = options_of(SIDERAY_TRANSLUCENCY_RASTER, SIDERAY_SHADOWS_MAP);
  const RenderOptions none = options_of(SIDERAY_TRANSLUCENCY_RASTER, SIDERAY_SHADOWS_OFF);
  const Cost first = with_maps.draw(maps), second = with_maps.draw(maps);
  without.draw(none);
  const Cost plain = without.draw(none);
  EXPECT_LT(second.gl.calls, plain.gl.calls + 40);
  EXPECT_GT(first.gl.calls, second.gl.calls + 20);
}

}  // namespace
}  // namespace sideray::tests
