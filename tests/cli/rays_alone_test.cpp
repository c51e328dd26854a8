// Tests the program without OpenGL: libraries, messages, refusals.
#include <cmath>

#include "cli/program.h"
#include "scenes/images/images.h"

namespace sideray::cli_tests {
namespace {

constexpr int not_drawn = 1, wrong_usage = 2;
const std::string without_egl = "__EGL_VENDOR_LIBRARY_FILENAMES=/nonexistent.json __EGL_VENDOR_LIBRARY_DIRS=/nonexistent";

class RaysAlone : public Program {
 protected:
  std::string picture(const std::string& name) const { return text_of(path(name)); }
  void draw(const std::string& arguments, const std::string& environment = "") {
    const Outcome outcome = run("render " + arguments, environment);
    ASSERT_EQ(outcome.exit_code, 0) << arguments << "\n" << outcome.errors;
    EXPECT_EQ(outcome.errors, "");
  }
};

// The loader's log lists all requested libraries, found or not.
TEST_F(RaysAlone, OpenNoLibraryOfOpenGL) {
  draw("solids --size 64x36 --gl none -o a.png", "LD_DEBUG=files LD_DEBUG_OUTPUT='" + path("loaded") + "'");
  std::string loaded;
  for (const std::string& name : files())
    if (name.starts_with("loaded")) loaded += text_of(path(name));
  ASSERT_NE(loaded.find("embree"), std::string::npos);
  for (const char* library : {"libEGL", "libOSMesa", "libGL.", "libGLX", "libOpenGL", "libgbm", "libGLdispatch"})
    EXPECT_EQ(loaded.find(library), std::string::npos) << library;
}

TEST_F(RaysAlone, AreChosenByAnEnvironmentVariable) {
  draw("panes --size 64x36 --gl none -o option.png");
  draw("panes --size 64x36 -o variable.png --stats s.json", "SIDERAY_GL=none");
  EXPECT_EQ(picture("option.png"), picture("variable.png"));
  const auto device = nlohmann::json::parse(text_of(path("s.json")))["device"];
  EXPECT_NE(device.dump().find("rays alone"), std::string::npos) << device.dump();
}

// Empty files in place of OSMesa's libraries are found but cannot be loaded.
TEST_F(RaysAlone, DrawWhereNoContextCanBeHad) {
  draw("panes --size 64x36 --gl none -o none.png");
  for (const char* library : {"libOSMesa.so.8", "libOSMesa.so.6"}) std::ofstream(path(library)).flush();
  const std::string nothing = without_egl + " LD_LIBRARY_PATH='" + folder_.string() + "'";
  const Outcome outcome = run("render panes --size 64x36 -o auto.png", nothing);
  ASSERT_EQ(outcome.exit_code, 0) << outcome.errors;
  EXPECT_EQ(outcome.error_lines(), 1u) << outcome.errors;
  EXPECT_TRUE(outcome.errors.starts_with("sideray: warning: no OpenGL: rays alone draw")) << outcome.errors;
  EXPECT_EQ(picture("none.png"), picture("auto.png"));
  expect_refused("render panes --size 16x16 --gl osmesa -o a.png", not_drawn, "no usable OpenGL device", nothing);
}

TEST_F(RaysAlone, RefuseInOneLine) {
  expect_refused("render panes --size 16x16 --gl none -o a.png --diagnose check --stats s.json", not_drawn, "checked against fragments");
  expect_refused("render panes --size 16x16 --gl none --device egl:surfaceless -o a.png", wrong_usage, "no device is used");
  expect_refused("render panes --size 16x16 --gl no -o a.png", wrong_usage, "--gl");
}

// Draws the raster look with layers and without, and channels beside it.
TEST_F(RaysAlone, DrawTheRasterLook) {
  draw("panes --size 64x36 --gl none -o raster.png --translucency raster");
  draw("panes --size 64x36 --gl none -o none.png --layers 0");
  draw("panes --size 64x36 --gl none -o layers.exr --layers 3 --aov layers");
  EXPECT_EQ(picture("raster.png"), picture("none.png"));
  const scenes::Image layers = scenes::read_image(path("layers.exr"));
  ASSERT_NE(layers.find("layer2.surface"), nullptr);
  EXPECT_EQ(layers.find("layer3.surface"), nullptr);
  expect_refused("render panes --size 16x16 --gl none -o a.exr --layers 0 --aov layers", wrong_usage, "this frame has no layers");
}

// A bound chooses among the ways of rays; `all` gives all channels that exist without OpenGL.
TEST_F(RaysAlone, KeepBoundsAndShowAllChannels) {
  draw("panes --size 64x36 --gl none -o all.exr --aov all");
  const Outcome bounded = run("render solids --size 64x36 --gl none -o a.png --max-error 0.9 --stats s.json", "SIDERAY_CACHE=off");
  ASSERT_EQ(bounded.exit_code, 0) << bounded.errors;
}

// Draws depth, motion and averages over frames with a moving camera.
TEST_F(RaysAlone, DrawSequences) {
  const std::string arguments = "haze --size 96x54 --frames 0-3 --aov motion,Z ";
  draw(arguments + "--gl none -o rays.#.exr");
  draw(arguments + "--gl none --threads 1 -o again.#.exr");
  if (!can_draw()) GTEST_SKIP() << "no OpenGL device; see sideray devices";
  draw(arguments + "--oit abuffer -o raster.#.exr");
  for (int frame = 0; frame < 4; ++frame) {
    const std::string number = std::to_string(frame) + ".exr";
    EXPECT_EQ(picture("rays." + number), picture("again." + number));
    const scenes::Image rays = scenes::read_image(path("rays." + number)), raster = scenes::read_image(path("raster." + number));
    for (const char* name : {"motion.X", "motion.Y", "R", "G", "B"}) {
      const std::vector<float>&a = rays.find(name)->values, &b = raster.find(name)->values;
      size_t off = 0;
      for (size_t i = 0; i < a.size(); ++i) off += std::abs(a[i] - b[i]) > 0.02f + 0.02f * std::abs(b[i]);
      EXPECT_LT(off, a.size() / 20) << name << " of frame " << frame;
    }
  }
}

std::vector<float> reds(const std::string& path) {
  return scenes::read_image(path).find("R")->values;
}

// A camera that turns a quarter with its surroundings sees the same of them.
TEST_F(RaysAlone, TurnAndScaleSurroundings) {
  draw("panes --size 32x16 --gl none -o around.exr");
  const std::string arguments = "panes --size 16x9 --gl none --env around.exr --eye 0,50,0 ";
  draw(arguments + "-o east.exr --target 10,53,0");
  draw(arguments + "-o north.exr --target 0,53,-10");
  draw(arguments + "-o turned.exr --target 0,53,-10 --env-rotate 90 --env-scale 2");
  const std::vector<float> east = reds(path("east.exr")), turned = reds(path("turned.exr"));
  EXPECT_NE(east, reds(path("north.exr")));
  for (size_t i = 0; i < east.size(); ++i) EXPECT_NEAR(turned[i], 2.0f * east[i], 0.004f * east[i]) << i;
}

TEST_F(RaysAlone, LightAFileWithoutLightsBySun) {
  const std::string arguments = SIDERAY_SOURCE_DIR "/tests/fuzz/corpus/scene/morphed.gltf --size 16x9 --gl none --env none ";
  draw(arguments + "-o sun.exr");
  draw(arguments + "-o dark.exr --default-light off");
  const std::vector<float> sun = reds(path("sun.exr")), dark = reds(path("dark.exr"));
  EXPECT_GT(std::ranges::max(sun), 0.01f);
  EXPECT_EQ(std::ranges::max(dark), 0.0f);
}

}  // namespace
}  // namespace sideray::cli_tests
