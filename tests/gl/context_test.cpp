#include "gl/context/context.h"

#include <gmock/gmock.h>

#include <cstring>
#include <thread>

#include "gl/gl_contexts.h"
#include "model/failure.h"

namespace sideray::gl {
namespace {

using testing::HasSubstr;

INSTANTIATE_TEST_SUITE_P(All, EveryContext, testing::Values("device", "surfaceless", "osmesa"),
                         [](const auto& suite) { return suite.param; });

void expect_test_triangle(const std::vector<uint8_t>& pixels, int side) {
  for (int y = 0; y < side; ++y)
    for (int x = 0; x < side; ++x) {
      const auto at = 4 * static_cast<size_t>(y * side + x);
      const uint8_t inside = in_test_triangle(x, y) ? 255 : 0;
      ASSERT_EQ(pixels[at], inside) << x << ", " << y;
      ASSERT_EQ(pixels[at + 1], 0) << x << ", " << y;
      ASSERT_EQ(pixels[at + 3], inside) << x << ", " << y;
    }
}

TEST_P(EveryContext, DrawsATriangleExactly) {
  const Target target(gl(), GL_RGBA8, 64);
  draw_triangle(gl(), test_corners, "vec4(1.0, 0.0, 0.0, 1.0)");
  expect_test_triangle(target.read_rgba8(), 64);
}

TEST_P(EveryContext, SaysWhatItIs) {
  EXPECT_GE(gl().version, 33);
  EXPECT_TRUE(gl().core_profile);
  EXPECT_FALSE(context->info().renderer.empty());
  EXPECT_EQ(context->info().version, gl().version_string);
  EXPECT_TRUE(context->info().usable);
  EXPECT_EQ(gl().software,
            gl().renderer.find("llvmpipe") != std::string::npos || gl().renderer.find("softpipe") != std::string::npos);
}

TEST_P(EveryContext, ReportsErrorMessages) {
  if (!gl().debug) GTEST_SKIP() << "no KHR_debug";
  gl().Enable(0x1234);
  EXPECT_EQ(context->take_errors().size(), 1u);
  EXPECT_EQ(gl().GetError(), GLenum{GL_INVALID_ENUM});
  EXPECT_TRUE(context->take_errors().empty());
}

TEST_P(EveryContext, CanBeReleasedAndTakenByAnotherThread) {
  context->release_current();
  std::thread([&] {
    context->make_current();
    const Target target(gl(), GL_RGBA8, 64);
    draw_triangle(gl(), test_corners, "vec4(1.0, 0.0, 0.0, 1.0)");
    expect_test_triangle(target.read_rgba8(), 64);
    context->release_current();
  }).join();
  context->make_current();
}

TEST_P(EveryContext, SurvivesTheListingOfDevicesAndOtherContextsComingAndGoing) {
  const Target target(gl(), GL_RGBA8, 64);
  EXPECT_FALSE(list_devices().empty());
  for (const char* other : {"device", "surfaceless", "osmesa"}) {
    const std::unique_ptr<Context> passing = open_context(other);
    context->make_current();
  }
  draw_triangle(gl(), test_corners, "vec4(1.0, 0.0, 0.0, 1.0)");
  expect_test_triangle(target.read_rgba8(), 64);
}

struct Canvas {
  explicit Canvas(std::unique_ptr<Context> opened)
      : context(std::move(opened)), target(std::make_unique<Target>(context->functions(), GL_RGBA32F, 64)) {}
  ~Canvas() {
    context->make_current();
    target.reset();
  }
  std::unique_ptr<Context> context;
  std::unique_ptr<Target> target;
};

// Every context draws its part of the same picture, taking turns on this thread.
TEST(Contexts, OfBothPlatformsAlternateOnOneThread) {
  std::vector<std::unique_ptr<Canvas>> canvases;
  for (const char* name : {"surfaceless", "osmesa"}) {
    std::unique_ptr<Context> context = open_context(name);
    if (context == nullptr && is_required(name)) FAIL() << "required context " << name;
    if (context == nullptr) GTEST_SKIP() << "needs both surfaceless EGL and OSMesa";
    canvases.push_back(std::make_unique<Canvas>(std::move(context)));
  }
  for (int strip = 0; strip < 16; ++strip) {
    for (const auto& canvas : canvases) {
      const Functions& gl = canvas->context->functions();
      canvas->context->make_current();
      canvas->target->bind();
      gl.Enable(GL_SCISSOR_TEST);
      gl.Scissor(4 * strip, 0, 4, 64);
      draw_triangle(gl, test_corners, "vec4(sin(gl_FragCoord.xy), exp2(gl_FragCoord.x * 0.01), 1.0)");
    }
  }
  std::vector<std::vector<float>> pictures;
  for (const auto& canvas : canvases) {
    canvas->context->make_current();
    pictures.push_back(canvas->target->read_rgba32f());
    EXPECT_TRUE(take_problems(*canvas->context).empty());
  }
  for (size_t i = 0; i < pictures[0].size(); i += 4) {
    const int x = static_cast<int>(i / 4) % 64, y = static_cast<int>(i / 4) / 64;
    ASSERT_EQ(pictures[0][i + 3] == 1.0f, in_test_triangle(x, y)) << x << ", " << y;
  }
  if (canvases[0]->context->functions().renderer != canvases[1]->context->functions().renderer)
    GTEST_SKIP() << "the two are different drivers";
  EXPECT_EQ(std::memcmp(pictures[0].data(), pictures[1].data(), pictures[0].size() * sizeof(float)), 0);
}

TEST(Contexts, WorkOnSeveralThreadsAtOnce) {
  std::vector<std::thread> threads;
  for (const char* name : {"surfaceless", "osmesa", "surfaceless", "osmesa"}) {
    const std::unique_ptr<Context> probe = open_context(name);
    if (probe == nullptr) continue;
    const std::string id = probe->info().id;
    threads.emplace_back([id] {
      for (int i = 0; i < 3; ++i) {
        const std::unique_ptr<Context> context = Context::create("auto", id);
        {
          const Target target(context->functions(), GL_RGBA8, 64);
          draw_triangle(context->functions(), test_corners, "vec4(1.0, 0.0, 0.0, 1.0)");
          expect_test_triangle(target.read_rgba8(), 64);
        }
        EXPECT_TRUE(take_problems(*context).empty());
      }
    });
  }
  for (std::thread& thread : threads) thread.join();
}

TEST(Contexts, RequiredOnesAreThere) {
  for (const char* name : {"device", "surfaceless", "osmesa"})
    EXPECT_TRUE(!is_required(name) || open_context(name) != nullptr) << name;
}

TEST(Contexts, AutoPrefersWhatIsListedFirstAndHardware) {
  const std::vector<DeviceInfo> devices = list_devices();
  std::string expected;
  for (const DeviceInfo& device : devices)
    if (device.usable && (expected.empty() || device.renderer.find("llvmpipe") == std::string::npos)) {
      expected = device.id;
      if (device.renderer.find("llvmpipe") == std::string::npos) break;
    }
  if (expected.empty()) GTEST_SKIP() << "no context at all";
  EXPECT_EQ(Context::create("auto", "")->info().id, expected);
}

std::string failure_message(const std::string& choice, const std::string& device, sideray_status expected) {
  try {
    Context::create(choice, device);
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.status, expected);
    return failure.what();
  }
  ADD_FAILURE() << "no failure";
  return "";
}

TEST(Contexts, UnknownDeviceNamesTheKnownOnes) {
  const std::string message = failure_message("auto", "egl:no-such-device", SIDERAY_INVALID_ARGUMENT);
  EXPECT_THAT(message, HasSubstr("\"egl:no-such-device\""));
  for (const DeviceInfo& device : list_devices()) EXPECT_THAT(message, HasSubstr(device.id));
  EXPECT_EQ(message.find('\n'), std::string::npos);
  EXPECT_THAT(failure_message("osmesa", "egl:surfaceless", SIDERAY_INVALID_ARGUMENT), HasSubstr("osmesa"));
}

TEST(Contexts, UnknownChoiceIsRefused) {
  EXPECT_THAT(failure_message("vulkan", "", SIDERAY_INVALID_ARGUMENT), HasSubstr("auto, egl, osmesa or none"));
}

TEST(Contexts, LoadingWithoutAContextIsAFailure) {
  const auto nothing = [](void*, const char*) -> void* { return nullptr; };
  try {
    load_functions(nothing, nullptr);
    FAIL() << "no failure";
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.status, SIDERAY_UNSUPPORTED);
    EXPECT_THAT(failure.what(), HasSubstr("no context is current"));
  }
}

}  // namespace
}  // namespace sideray::gl
