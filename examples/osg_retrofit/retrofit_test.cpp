// Checks that the retrofit changes only what it should: one engine, headless, many frames.
#include <gtest/gtest.h>
#include <osg/GLExtensions>
#include <osg/MatrixTransform>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

#include "engine.h"
#include "retrofit.h"
#include "rules.h"

namespace {

constexpr int width = 256, height = 144;

std::vector<std::string> driver_errors;

void GL_APIENTRY remember(GLenum, GLenum type, GLuint, GLenum, GLsizei, const GLchar* message, const void*) {
  if (type == GL_DEBUG_TYPE_ERROR) driver_errors.emplace_back(message);
}

struct Picture {
  std::vector<uint8_t> rgb;
  std::vector<uint8_t> stencil;  // count of blended surfaces, if the retrofit counts them

  int largest_difference(const Picture& other, size_t pixel) const {
    int largest = 0;
    for (size_t c = 3 * pixel; c < 3 * pixel + 3; ++c) largest = std::max(largest, std::abs(rgb[c] - other.rgb[c]));
    return largest;
  }
  bool same_at(const Picture& other, size_t pixel) const { return largest_difference(other, pixel) == 0; }
};

// Counts the pixels for which `f` is true.
template <typename F>
size_t count(F&& f) {
  size_t n = 0;
  for (size_t pixel = 0; pixel < size_t{width} * height; ++pixel) n += f(pixel) ? 1 : 0;
  return n;
}

class RetrofitTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    EngineSettings settings;
    settings.scene = SIDERAY_RETROFIT_SCENE;
    settings.width = width, settings.height = height;
    settings.debug = true;
    engine = std::make_unique<Engine>(settings);
    engine->look({2.35, 1.45, -7.9}, {-0.5, 1.2, -4.6}, 50.0);
    listen();
    engine->update(0);
    adapter = std::make_unique<sideray_osg::SceneAdapter>(engine->scene(), terrace_rules());
    before = draw(0);
  }
  static void TearDownTestSuite() {
    adapter.reset();
    engine.reset();
  }
  void TearDown() override {
    EXPECT_EQ(glGetError(), GLenum{GL_NO_ERROR});
    EXPECT_TRUE(driver_errors.empty()) << driver_errors.front();
    driver_errors.clear();
  }

  static void listen() {
    using Register = void (*)(GLDEBUGPROC, const void*);
    const auto set_callback = reinterpret_cast<Register>(osg::getGLExtensionFuncPtr("glDebugMessageCallback"));
    ASSERT_NE(set_callback, nullptr);
    glEnable(GL_DEBUG_OUTPUT);
    glEnable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
    set_callback(&remember, nullptr);
  }

  static Picture draw(double time_s, bool follow = true) {
    engine->update(time_s);
    if (follow) moved = adapter->update();
    engine->keep_picture(true);
    engine->draw();
    Picture picture;
    const uint8_t* const from = engine->picture().data();
    for (int y = 0; y < height; ++y) {
      const uint8_t* const row = from + static_cast<size_t>(y) * engine->picture().getRowSizeInBytes();
      picture.rgb.insert(picture.rgb.end(), row, row + size_t{3} * width);
    }
    picture.stencil.resize(size_t{width} * height);
    glPixelStorei(GL_PACK_ALIGNMENT, 1);
    glReadPixels(0, 0, width, height, GL_STENCIL_INDEX, GL_UNSIGNED_BYTE, picture.stencil.data());
    return picture;
  }

  static Picture draw_retrofitted(const RetrofitSettings& settings, double time_s = 0) {
    Retrofit retrofit(engine->viewer(), engine->scene(), *adapter, settings);
    const Picture picture = draw(time_s);
    EXPECT_EQ(retrofit.error(), "");
    return picture;
  }

  static std::unique_ptr<Engine> engine;
  static std::unique_ptr<sideray_osg::SceneAdapter> adapter;
  static Picture before;  // at time 0
  static size_t moved;
};

std::unique_ptr<Engine> RetrofitTest::engine;
std::unique_ptr<sideray_osg::SceneAdapter> RetrofitTest::adapter;
Picture RetrofitTest::before;
size_t RetrofitTest::moved;

RetrofitSettings glass_alone() {
  RetrofitSettings settings;
  settings.shadows = false;
  return settings;
}

TEST_F(RetrofitTest, TakenOffTheEngineDrawsTheSameBits) {
  const Picture after = draw_retrofitted({});
  EXPECT_NE(after.rgb, before.rgb);
  EXPECT_EQ(draw(0).rgb, before.rgb);
}

// Checks the first frame of an engine that does not wait, which has no answers yet.
TEST_F(RetrofitTest, WithoutAnswersItLooksAsBefore) {
  RetrofitSettings settings;
  settings.wait = false;
  const Picture first = draw_retrofitted(settings);
  // At silhouettes sphere map coordinates are near 0 / 0, and the driver's vertex programs round differently.
  const auto of_one = [&](size_t p) { return first.stencil[p] == 1; };
  EXPECT_LT(count([&](size_t p) { return of_one(p) && first.largest_difference(before, p) > 1; }), count(of_one) / 100);
  EXPECT_EQ(count([&](size_t p) { return first.stencil[p] == 0 && !first.same_at(before, p); }), 0u);
}

TEST_F(RetrofitTest, GlassAloneChangesNothingElse) {
  const Picture after = draw_retrofitted(glass_alone());
  const size_t glass = count([&](size_t p) { return after.stencil[p] != 0; });
  EXPECT_GT(glass, size_t{width} * height / 5);
  EXPECT_EQ(count([&](size_t p) { return after.stencil[p] == 0 && !after.same_at(before, p); }), 0u);
  EXPECT_GT(count([&](size_t p) { return after.stencil[p] != 0 && !after.same_at(before, p); }), glass * 99 / 100);
}

TEST_F(RetrofitTest, ShadowsDarkenOpaqueSurfacesAlone) {
  const Picture after = draw_retrofitted({});
  const auto opaque = [&](size_t p) { return after.stencil[p] == 0; };
  size_t darker = 0, brighter = 0;
  for (size_t c = 0; c < after.rgb.size(); ++c) {
    if (!opaque(c / 3)) continue;
    darker += after.rgb[c] < before.rgb[c] ? 1 : 0;
    brighter += after.rgb[c] > before.rgb[c] ? 1 : 0;
  }
  EXPECT_EQ(brighter, 0u);
  const size_t all = 3 * count(opaque);
  EXPECT_GT(darker, all / 5);
  EXPECT_LT(darker, all * 4 / 5);  // the rest is in the sun, or faces away from it
}

TEST_F(RetrofitTest, WhatMovesMovesInTheGlass) {
  Retrofit retrofit(engine->viewer(), engine->scene(), *adapter, glass_alone());
  const Picture at_first = draw(0);
  const Picture forgotten = draw(0.8, false), followed = draw(0.8);
  EXPECT_EQ(moved, 7u);  // four parts of the van, three of the lantern
  // The van is behind the viewer, so its position is visible only in glass.
  const auto changed = [&](const Picture& p) {
    return count([&](size_t i) { return p.stencil[i] == 1 && at_first.stencil[i] == 1 && !p.same_at(at_first, i); });
  };
  EXPECT_GT(changed(followed), changed(forgotten) + 200);
  EXPECT_EQ(draw(0).rgb, at_first.rgb);
}

TEST_F(RetrofitTest, LateAnswersAreThoseThatWereWaitedFor) {
  const Picture waited = draw_retrofitted({});
  RetrofitSettings settings;
  settings.wait = false;
  Retrofit retrofit(engine->viewer(), engine->scene(), *adapter, settings);
  // Nothing moves, so once an answer has arrived, the picture is the same.
  Picture late;
  for (int frame = 0; frame < 1000 && late.rgb != waited.rgb; ++frame) late = draw(0);
  EXPECT_EQ(late.rgb, waited.rgb);
}

TEST_F(RetrofitTest, AFailureEndsTheRetrofitAlone) {
  RetrofitSettings refused;
  refused.layers = 99;
  {
    Retrofit retrofit(engine->viewer(), engine->scene(), *adapter, refused);
    draw(0);
    EXPECT_NE(retrofit.error().find("max_layers 99"), std::string::npos) << retrofit.error();
  }
  EXPECT_EQ(draw(0).rgb, before.rgb);
}

}  // namespace
