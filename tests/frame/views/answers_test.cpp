// Compares the answers in pixels of pictures with a budget (SIDERAY_AOV_ANSWERS), through the C functions, with the
// counts in statistics.
#include <sideray/diagnostics.h>

#include <cstring>
#include <functional>
#include <span>

#include "frame/frame.h"
#include "scenes/builtin/builtin.h"

namespace sideray::tests::answers_test {
namespace {

constexpr uint32_t width = 160, height = 90, asks_for_none = 0, has_none = 1, traced = 2;
constexpr size_t pixels = size_t{width} * height;

struct Drawn {
  sideray_picture* picture = nullptr;
  sideray_render_stats stats{};

  std::span<const uint32_t> answers(const char* name) const {
    for (size_t i = 0; i < sideray_picture_channel_count(picture); ++i) {
      const sideray_channel* channel = sideray_picture_channel(picture, i);
      if (std::strcmp(channel->name, name) == 0 && channel->type == SIDERAY_CHANNEL_UINT)
        return {static_cast<const uint32_t*>(channel->values), pixels};
    }
    return {};
  }
  size_t count(const std::function<bool(size_t)>& holds) const {
    size_t found = 0;
    for (size_t i = 0; i < pixels; ++i) found += holds(i);
    return found;
  }
};

class Answers : public testing::TestWithParam<const char*> {
 protected:
  Answers() : content_(scenes::generate("bistro", {})), scene_(Scene::create().value()) {
    const scenes::Sky sky = scenes::sky();
    scene_.set_environment(sky.width, sky.height, sky.rgb.data(), 1.0f, 0.0f);
    camera_ = camera_of(content_, {.width = width, .height = height});
    scenes::fill(scene_, content_, scenes::select_ray_traced(content_, "all", camera_, width, height));
    sideray_renderer_desc desc = sideray_renderer_defaults();
    desc.gl = GetParam();
    sideray_error error{};
    has_device_ = sideray_renderer_create(&desc, &renderer_, &error) == SIDERAY_OK;
    options_.width = width, options_.height = height;
    options_.aovs = SIDERAY_AOV_ANSWERS;
    translucency_.layers = 4;
    options_.translucency = &translucency_;
    shadows_.method = SIDERAY_SHADOWS_EXACT;
    options_.shadows = &shadows_;
    options_.reflections = 1;
    options_.ambient = SIDERAY_AMBIENT_AO;
  }
  ~Answers() override {
    sideray_picture_release(drawn_.picture);
    sideray_renderer_destroy(renderer_);
  }
  void SetUp() override {
    if (!has_device_) GTEST_SKIP() << "no such device; see sideray devices";
  }

  const Drawn& draw() {
    sideray_picture_release(drawn_.picture);
    sideray_error error{};
    EXPECT_EQ(sideray_renderer_render(renderer_, scene_.get(), &camera_, &options_, &drawn_.picture, &error), SIDERAY_OK)
        << error.message;
    drawn_.stats.size = sizeof(drawn_.stats);
    sideray_picture_stats(drawn_.picture, &drawn_.stats, &error);
    options_.continues = 1;
    ++options_.seed;
    return drawn_;
  }
  // The camera moves on, and an object with it.
  void move() {
    camera_.world_from_camera[9] += 0.02;
    double* matrix = content_.objects.front().world_from_object;
    matrix[9] += 0.001;
    scene_.move_instance(1, matrix);
    scene_.commit();
  }

  scenes::Content content_;
  Scene scene_;
  sideray_camera camera_{};
  sideray_renderer* renderer_ = nullptr;
  bool has_device_ = false;
  sideray_render_options options_ = sideray_render_defaults();
  sideray_translucency_options translucency_ = sideray_translucency_defaults();
  sideray_shadow_options shadows_ = sideray_shadow_defaults();
  sideray_diagnostics pieces_ = sideray_diagnostics_defaults();
  Drawn drawn_;
};

constexpr const char* kinds[] = {"answer.lights", "answer.sky", "answer.reflections", "answer.layers"};

TEST_P(Answers, AreAllTracedWithoutABudget) {
  const Drawn& drawn = draw();
  for (const char* kind : kinds) {
    const auto answers = drawn.answers(kind);
    ASSERT_EQ(answers.size(), pixels) << kind;
    const size_t asked = drawn.count([&](size_t i) { return answers[i] != asks_for_none; });
    EXPECT_GT(asked, 0u) << kind;
    EXPECT_EQ(drawn.count([&](size_t i) { return answers[i] == traced; }), asked) << kind;
  }
}

TEST_P(Answers, AreAsManyLateAndOlderOnesAsTheStatisticsCount) {
  pieces_.budget_pieces = 2;
  options_.diagnostics = &pieces_;
  uint64_t late = 0, older = 0, oldest = 0;
  for (int frame = 0; frame < 12; ++frame) {
    const Drawn& drawn = draw();
    const sideray_render_stats& s = drawn.stats;
    const auto lights = drawn.answers("answer.lights"), sky = drawn.answers("answer.sky");
    const auto mirrored = drawn.answers("answer.reflections"), glass = drawn.answers("answer.layers");
    ASSERT_FALSE(lights.empty() || sky.empty() || mirrored.empty() || glass.empty());
    const auto lacks = [&](size_t i) { return lights[i] == has_none || sky[i] == has_none; };
    EXPECT_EQ(drawn.count(lacks), s.mask_pixels_late) << frame;
    EXPECT_EQ(drawn.count([&](size_t i) { return !lacks(i) && (lights[i] > traced || sky[i] > traced); }), s.mask_pixels_older)
        << frame;
    EXPECT_EQ(drawn.count([&](size_t i) { return mirrored[i] == has_none; }), s.reflection_pixels_late) << frame;
    EXPECT_EQ(drawn.count([&](size_t i) { return mirrored[i] > traced; }), s.reflection_pixels_older) << frame;
    EXPECT_EQ(drawn.count([&](size_t i) { return glass[i] == has_none; }), s.pixels_late) << frame;
    EXPECT_EQ(drawn.count([&](size_t i) { return glass[i] > traced; }), s.pixels_older) << frame;
    late += s.mask_pixels_late, older += s.mask_pixels_older;
    for (const auto& answers : {lights, sky, mirrored, glass})
      for (const uint32_t answer : answers) oldest = std::max<uint64_t>(oldest, answer);
    EXPECT_LE(oldest, 3 + s.answer_age) << frame;
    move();
  }
  EXPECT_GT(late, 0u);
  EXPECT_GT(older, 0u);
  EXPECT_GT(oldest, 3u) << "something is older than a change";
}

TEST_P(Answers, AreNotThereInAReference) {
  const sideray_reference_options reference = sideray_reference_defaults();
  options_.reference = &reference;
  sideray_error error{};
  EXPECT_EQ(sideray_renderer_render(renderer_, scene_.get(), &camera_, &options_, &drawn_.picture, &error), SIDERAY_INVALID_ARGUMENT);
  EXPECT_NE(std::string(error.message).find("ANSWERS"), std::string::npos) << error.message;
}

INSTANTIATE_TEST_SUITE_P(Devices, Answers, testing::Values("none", "auto"),
                         [](const auto& device) { return std::string(device.param); });

}  // namespace
}  // namespace sideray::tests::answers_test
