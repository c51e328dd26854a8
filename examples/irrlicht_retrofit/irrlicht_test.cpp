// Tests the retrofitted engine: its picture before and after, edits, animation, resizing, smoke, late answers, budgets.
#include <GL/gl.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "room.h"
#include "sideray_irrlicht.h"

namespace {

class Retrofitted : public testing::Test {
 protected:
  static constexpr unsigned width = 256, height = 144;
  Picture picture() {
    Picture result;
    room.draw(&result);
    return result;
  }
  Picture frame(sideray_irrlicht::Retrofit& retrofit) {
    retrofit.update();
    const Picture result = picture();
    EXPECT_EQ(retrofit.error(), "");
    return result;
  }
  // Returns the mean difference, in steps of 1/255.
  static double apart(const Picture& a, const Picture& b) {
    EXPECT_EQ(a.bgra.size(), b.bgra.size());
    double sum = 0;
    for (size_t i = 0; i < std::min(a.bgra.size(), b.bgra.size()); ++i)
      if (i % 4 != 3) sum += std::abs(int{a.bgra[i]} - int{b.bgra[i]});
    return sum / (0.75 * static_cast<double>(a.bgra.size()));
  }
  // Returns how many pixels differ by more than 4/255 in red.
  static size_t changed(const Picture& a, const Picture& b) {
    size_t count = 0;
    for (size_t i = 2; i < a.bgra.size(); i += 4) count += std::abs(int{a.bgra[i]} - int{b.bgra[i]}) > 4;
    return count;
  }
  sideray_irrlicht::Settings quiet() const {
    sideray_irrlicht::Settings settings;
    settings.shadows = false;
    return settings;
  }

  Room room{width, height};
};

// Checks that glass without reflectance looks as the fixed function draws it, except that rays light each pixel instead
// of each vertex.
TEST_F(Retrofitted, GlassIsLitAsTheEngineLightsIt) {
  room.show_smoke(false);
  const Picture before = picture();
  sideray_irrlicht::Settings settings = quiet();
  settings.reflectance = 0;
  sideray_irrlicht::Retrofit retrofit(room.device(), settings);
  const Picture after = frame(retrofit);
  const sideray_frame_stats& stats = retrofit.stats();
  EXPECT_GT(stats.pixels_masked, 3000u);
  EXPECT_EQ(stats.layers_found, stats.layers_requested);
  EXPECT_LT(apart(before, after), 1.0);
}

TEST_F(Retrofitted, GlassReflectsWhatIsBehindTheCamera) {
  const Picture before = picture();
  {
    sideray_irrlicht::Retrofit retrofit(room.device(), quiet());
    const Picture after = frame(retrofit);
    EXPECT_GT(changed(before, after), 1500u);
    EXPECT_GT(retrofit.stats().rays_reflection, 1000u);
  }
  EXPECT_EQ(apart(before, picture()), 0.0) << "given up, it draws as before";
}

TEST_F(Retrofitted, ShadowsFallWhereTheEngineHasNone) {
  const Picture before = picture();
  sideray_irrlicht::Retrofit retrofit(room.device(), {});
  EXPECT_GT(changed(before, frame(retrofit)), 3000u);
  EXPECT_GT(retrofit.stats().rays_shadow, 10000u);
}

TEST_F(Retrofitted, FollowsEditsAndAnimation) {
  sideray_irrlicht::Retrofit retrofit(room.device(), {});
  const Picture first = frame(retrofit);
  room.add_crate();
  const Picture with = frame(retrofit);
  EXPECT_GT(changed(first, with), 150u);
  room.remove_crate();
  EXPECT_EQ(apart(first, frame(retrofit)), 0.0);
  room.set_time(300);
  EXPECT_GT(changed(first, frame(retrofit)), 100u);
  room.set_time(0);
  EXPECT_LT(apart(first, frame(retrofit)), 0.05);
}

TEST_F(Retrofitted, SmokeBetweenThePanesStays) {
  sideray_irrlicht::Retrofit retrofit(room.device(), quiet());
  const Picture with = frame(retrofit);
  room.show_smoke(false);
  EXPECT_GT(changed(with, frame(retrofit)), 200u);
}

TEST_F(Retrofitted, IsResized) {
  sideray_irrlicht::Retrofit retrofit(room.device(), {});
  frame(retrofit);
  room.device().getVideoDriver()->OnResize({200, 100});
  room.draw();
  retrofit.update();
  room.draw();
  EXPECT_EQ(retrofit.error(), "");
  EXPECT_EQ(retrofit.stats().pixels_total, 200u * 100u);
}

TEST_F(Retrofitted, LateAnswersArriveAndSettle) {
  sideray_irrlicht::Retrofit retrofit(room.device(), {});
  const Picture waited = frame(retrofit);
  retrofit.set_wait(false);
  Picture late;
  for (int i = 0; i < 60; ++i) late = frame(retrofit);
  EXPECT_LT(apart(waited, late), 0.3);
}

// A view at rest converges to the picture without a budget.
TEST_F(Retrofitted, ABudgetLeavesNothingWithoutAnswersForLong) {
  Picture whole;
  {
    sideray_irrlicht::Retrofit retrofit(room.device(), {});
    whole = frame(retrofit);
  }
  sideray_irrlicht::Settings settings;
  settings.budget_ms = 8;
  sideray_irrlicht::Retrofit retrofit(room.device(), settings);
  Picture settled;
  for (int i = 0; i < 60; ++i) settled = frame(retrofit);
  EXPECT_EQ(retrofit.stats().pixels_late, 0u);
  EXPECT_LT(apart(whole, settled), 0.3);
}

// The engine is left-handed and its triangles are clockwise. From any side it must be lit as by the engine.
TEST_F(Retrofitted, IsLeftHandedFromEverySide) {
  room.show_smoke(false);
  for (const float degrees : {0.0f, 140.0f, 250.0f}) {
    room.turn_camera(degrees);
    const Picture before = picture();
    sideray_irrlicht::Settings settings = quiet();
    settings.reflectance = 0;
    sideray_irrlicht::Retrofit retrofit(room.device(), settings);
    const Picture after = frame(retrofit);
    EXPECT_GT(retrofit.stats().layers_found, 500u) << degrees;
    EXPECT_LT(apart(before, after), 1.0) << degrees;
  }
}

// The banner waves while answers come late and in pieces.
TEST_F(Retrofitted, AnimationGoesOnLateAndUnderABudget) {
  for (const float budget_ms : {0.0f, 8.0f}) {
    sideray_irrlicht::Settings settings;
    settings.wait = false, settings.budget_ms = budget_ms;
    sideray_irrlicht::Retrofit retrofit(room.device(), settings);
    Picture last;
    size_t layers = 0;
    for (unsigned i = 0; i < 40; ++i) {
      room.set_time(30 * i);
      last = frame(retrofit);
      layers += retrofit.stats().layers_found;
    }
    EXPECT_GT(layers, 0u) << "glass has a turn";
    room.set_time(0);
    const Picture first = frame(retrofit);
    EXPECT_GT(changed(first, last), 50u) << budget_ms;
  }
}

TEST_F(Retrofitted, LeavesNoErrors) {
  sideray_irrlicht::Retrofit retrofit(room.device(), {});
  for (int i = 0; i < 5; ++i) {
    room.turn_camera(static_cast<float>(i));
    frame(retrofit);
    EXPECT_EQ(glGetError(), static_cast<GLenum>(GL_NO_ERROR));
  }
}

}  // namespace
