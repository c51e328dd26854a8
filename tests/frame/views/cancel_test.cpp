// Tests that a picture cancelled by another thread ends early, and does not change the next one.
#include <gtest/gtest.h>

#include <atomic>
#include <thread>

#include "frame/views/view.h"

namespace sideray::tests::cancel_test {
namespace {

constexpr uint32_t width = 96, height = 64;
constexpr uint32_t most_samples = 4096;

struct Case {
  const char* name;
  const char* gl;
  bool is_reference;
};

class Cancelled : public testing::TestWithParam<Case> {
 protected:
  Cancelled() : content_(scenes::generate("solids", {})), scene_(Scene::create().value()) {
    camera_ = camera_of(content_, {.width = width, .height = height});
    scenes::fill(scene_, content_, scenes::select_ray_traced(content_, "all", camera_, width, height));
  }

  Renderer renderer() const {
    sideray_renderer_desc desc = sideray_renderer_defaults();
    desc.gl = GetParam().gl;
    return Renderer::create(desc).value();
  }
  RenderOptions options(uint32_t samples) const {
    RenderOptions options;
    options.picture.width = width, options.picture.height = height;
    options.picture.samples = samples;
    if (GetParam().is_reference) {
      options.reference = sideray_reference_defaults();
      options.translucency.reset(), options.shadows.reset(), options.poses.reset();
    }
    return options;
  }
  std::vector<float> colors(Renderer& renderer) const {
    const Picture picture = renderer.render(scene_, camera_, options(1)).value();
    const auto* red = static_cast<const float*>(picture.channel(0).values);
    return {red, red + size_t{width} * height};
  }

  scenes::Content content_;
  Scene scene_;
  sideray_camera camera_;
};

TEST_P(Cancelled, EndsAndLeavesNothingBehind) {
  Renderer cancelled = renderer();
  const std::vector<float> before = colors(cancelled);
  std::atomic<bool> ended{false};
  std::thread other([&] {
    while (!ended) {
      cancelled.cancel();
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  });
  // More samples than could be drawn to the end.
  const sideray_error error = [&] {
    const Result<Picture> result = cancelled.render(scene_, camera_, options(most_samples));
    return result ? sideray_error{} : result.error();
  }();
  ended = true;
  other.join();
  EXPECT_EQ(error.status, SIDERAY_CANCELLED) << error.message;
  Renderer fresh = renderer();
  EXPECT_EQ(colors(cancelled), before);
  EXPECT_EQ(colors(cancelled), colors(fresh));
}

TEST_P(Cancelled, DoesNothingWhereNothingIsDrawn) {
  Renderer idle = renderer();
  idle.cancel();
  EXPECT_EQ(colors(idle).size(), size_t{width} * height);
}

INSTANTIATE_TEST_SUITE_P(All, Cancelled,
                         testing::Values(Case{"rays", "none", false}, Case{"opengl", "auto", false},
                                         Case{"reference", "none", true}),
                         [](const auto& info) { return std::string(info.param.name); });

}  // namespace
}  // namespace sideray::tests::cancel_test
