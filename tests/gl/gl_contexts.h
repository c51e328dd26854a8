// Fixture that runs a test in every kind of headless context, and what such tests draw with. Main thread.
#pragma once

#include <gtest/gtest.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <vector>

#include "gl/context/context.h"
#include "gl/resources/program.h"

namespace sideray::gl {

// "device", "surfaceless" or "osmesa"; null where this machine has no such context. Debug output is synchronous.
std::unique_ptr<Context> open_context(const std::string& name, Profile profile = Profile::core);

// True where the environment variable SIDERAY_REQUIRE_CONTEXTS names it: then its absence is a failure, not a skip.
bool is_required(const std::string& name);

// "surfaceless", "osmesa" and, where it is required, "device": what tests that take long or depend on the driver run
// in, without running twice where both are the same software.
std::vector<std::string> driver_contexts();
std::string name_of_driver_and_profile(const testing::TestParamInfo<std::tuple<std::string, Profile>>& suite);

// Drains and returns what went wrong since the last call: messages of type error, or the code of glGetError.
std::vector<std::string> take_problems(Context& context);

class EveryContext : public testing::TestWithParam<std::string> {
 protected:
  void SetUp() override;
  void TearDown() override;
  const Functions& gl() const { return context->functions(); }
  std::unique_ptr<Context> context;
};

// An off-screen colour target of `side` squared pixels, bound as the framebuffer.
class Target {
 public:
  Target(const Functions& gl, GLenum internal_format, int side);
  void bind() const;
  std::vector<uint8_t> read_rgba8() const;
  std::vector<float> read_rgba32f() const;
  const int side;

 private:
  const Functions& gl_;
  Texture color_;
  Framebuffer framebuffer_;
};

// A triangle at corners in clip space, its colour a GLSL expression of gl_FragCoord.
void draw_triangle(const Functions& gl, const float (&corners)[6], const std::string& color_expression);

// Points at the pixels (x, y) whose centres are inside the triangle (0,0) (48,0) (0,56) of a 64 x 64 target; no centre
// lies on an edge.
inline constexpr float test_corners[6] = {-1.0f, -1.0f, 0.5f, -1.0f, -1.0f, 0.75f};
inline bool in_test_triangle(int x, int y) {
  return 56 * x + 48 * y < 2636;
}

}  // namespace sideray::gl
