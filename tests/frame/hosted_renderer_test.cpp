// Tests a renderer in a host's context with random state: the state stays, pictures have the bits of a renderer with
// its own context, and the host's pending errors stay.
#include <gmock/gmock.h>

#include <functional>
#include <memory>

#include "frame/frame.h"
#include "gl/gl_contexts.h"
#include "gl/random_state.h"
#include "scenes/builtin/builtin.h"

namespace sideray::tests::hosted_renderer_test {
namespace {

struct Drawn {
  std::string name;
  std::vector<float> values;
  std::vector<uint32_t> uint_values;
  bool operator==(const Drawn&) const = default;
};

std::vector<Drawn> channels_of(const Picture& picture) {
  std::vector<Drawn> channels;
  const size_t count = size_t{picture.width()} * picture.height();
  for (size_t i = 0; i < picture.channel_count(); ++i) {
    const sideray_channel c = picture.channel(i);
    Drawn drawn{c.name, {}, {}};
    if (c.type == SIDERAY_CHANNEL_UINT)
      drawn.uint_values.assign(static_cast<const uint32_t*>(c.values), static_cast<const uint32_t*>(c.values) + count);
    else
      drawn.values.assign(static_cast<const float*>(c.values), static_cast<const float*>(c.values) + count);
    channels.push_back(std::move(drawn));
  }
  return channels;
}

// Returns the names of channels that differ.
std::vector<std::string> differing(const std::vector<Drawn>& a, const std::vector<Drawn>& b) {
  std::vector<std::string> names;
  if (a.size() != b.size()) names.push_back("number of channels");
  for (size_t i = 0; i < std::min(a.size(), b.size()); ++i)
    if (!(a[i] == b[i])) names.push_back(a[i].name);
  return names;
}

struct Case {
  const char* name;
  const char* scene;
  void (*choose)(RenderOptions&);
};

const Case cases[] = {
    {"defaults", "panes?count=3", [](RenderOptions&) {}},
    {"shadow maps, distortion", "haze",
     [](RenderOptions& o) {
       o.shadows->method = SIDERAY_SHADOWS_MAP;
       o.translucency->method = SIDERAY_TRANSLUCENCY_RASTER;
     }},
    {"second wave, checked", "panes?count=3",
     [](RenderOptions& o) {
       o.translucency->cache_rate = SIDERAY_RATE_QUARTER;
       o.translucency->check = 1;
       o.picture.repeats = 1;
     }},
    {"lists", "crossing?layers=3", [](RenderOptions& o) { o.translucency->oit = SIDERAY_OIT_ABUFFER; }},
    {"peeled", "crossing?layers=3", [](RenderOptions& o) { o.translucency->oit = SIDERAY_OIT_PEEL; }},
    {"inexact shadows and occlusion", "forest?count=40",
     [](RenderOptions& o) {
       o.picture.ambient = 1;
       o.picture.aovs = SIDERAY_AOV_SHADOW | SIDERAY_AOV_INEXACT;
     }},
    {"reflections, every output", "frosted",
     [](RenderOptions& o) {
       o.picture.reflections = 1;
       o.picture.aovs = SIDERAY_AOV_Z | SIDERAY_AOV_NORMAL | SIDERAY_AOV_ALBEDO | SIDERAY_AOV_MATERIAL |
                        SIDERAY_AOV_ID | SIDERAY_AOV_MASK | SIDERAY_AOV_LAYERS | SIDERAY_AOV_SHADOW |
                        SIDERAY_AOV_HIT_DISTANCE | SIDERAY_AOV_MOTION;
     }},
    {"particles", "smoke?count=200",
     [](RenderOptions& o) {
       o.translucency->method = SIDERAY_TRANSLUCENCY_RAYTRACED;
       o.translucency->particles = 1;
     }},
    {"particles, rasterized", "smoke?count=200",
     [](RenderOptions& o) { o.translucency->method = SIDERAY_TRANSLUCENCY_RASTER; }},
    {"averaged, several positions", "edges",
     [](RenderOptions& o) {
       o.picture.taa = 1;
       o.picture.samples = 2;
     }},
    {"reference", "panes?count=2",
     [](RenderOptions& o) {
       o.reference = sideray_reference_defaults();
       o.reference->light_samples = 1;
     }}};

// Holds a built-in scene and a case's options.
struct Shot {
  explicit Shot(const Case& c) : scene(Scene::create().value()) {
    const scenes::Content content = scenes::load(c.scene);
    camera = content.cameras.empty() ? scenes::framing_camera(content, 16.0f / 9.0f) : content.cameras[0].camera;
    // A small sky, since filtering a large one for every case would take most of the time.
    const std::vector<float> sky = {0.2f, 0.3f, 0.6f, 0.3f, 0.3f, 0.5f, 0.2f, 0.1f, 0.1f, 0.1f, 0.1f, 0.2f};
    scene.set_environment(2, 2, sky.data(), 1.0f, 0.0f);
    scenes::fill(scene, content, scenes::select_ray_traced(content, "all", camera, 96, 54));
    options.picture.width = 96;
    options.picture.height = 54;
    c.choose(options);
  }
  // Draws a sequence of two frames where the case averages over time.
  std::vector<Drawn> draw(Renderer& renderer) {
    RenderOptions o = options;
    std::vector<Drawn> channels = channels_of(renderer.render(scene, camera, o).value());
    if (!o.picture.taa) return channels;
    o.picture.samples = 1;
    o.picture.continues = 1;
    return channels_of(renderer.render(scene, camera, o).value());
  }
  Scene scene;
  sideray_camera camera;
  RenderOptions options;
};

class HostedRenderer : public testing::TestWithParam<std::tuple<std::string, gl::Profile>> {
 protected:
  void SetUp() override {
    const auto& [name, profile] = GetParam();
    context = gl::open_context(name, profile);
    if (!context && profile == gl::Profile::core && gl::is_required(name)) FAIL() << "required context " << name;
    if (!context) GTEST_SKIP() << "no such context here: " << name;
    shaker = std::make_unique<gl::Shaker>(gl());
    ASSERT_EQ(gl::take_problems(*context), std::vector<std::string>{});
  }
  void TearDown() override { shaker.reset(); }

  const gl::Functions& gl() const { return context->functions(); }
  void shake(uint32_t seed) {
    shaker->random.seed(seed);
    shaker->shake_framebuffers();
    shaker->shake_pixel_transfer();
    shaker->shake_textures();
    shaker->shake_buffers();
    shaker->shake_draw();
    shaker->shake_stencil();
    shaker->shake_rest();
    shaker->shake_rasterization();
  }
  gl::State read() const {
    return gl::read_state(gl(), [this] { shaker->bind_stencil_framebuffer(); });
  }

  Result<Renderer> create_hosted() {
    sideray_host_gl host{sizeof(sideray_host_gl), &gl::Context::get_proc_address, context.get()};
    sideray_renderer_desc desc = sideray_renderer_defaults();
    desc.host = &host;
    desc.threads = 1;
    return Renderer::create(desc);
  }
  Renderer create_headless() const {
    sideray_renderer_desc desc = sideray_renderer_defaults();
    desc.device = context->info().id.c_str();
    desc.threads = 1;
    return Renderer::create(desc).value();
  }

  // Makes `call` in random state with a pending error of the host.
  void expect_untouched(uint32_t seed, const std::string& what, const std::function<void()>& call) {
    shake(seed);
    const gl::State before = read();
    ASSERT_EQ(gl::take_problems(*context), std::vector<std::string>{}) << "the test itself, " << what;
    call();
    ASSERT_EQ(gl::take_problems(*context), std::vector<std::string>{}) << what;
    ASSERT_EQ(gl::differences(before, read()), std::vector<std::string>{}) << what;
  }

  void expect_same_bits(const Case& c, uint32_t seed) {
    Shot shot(c);
    std::optional<Renderer> hosted;
    std::vector<Drawn> drawn;
    expect_untouched(++seed, std::string("create, ") + c.name, [&] { hosted.emplace(create_hosted().value()); });
    expect_untouched(++seed, c.name, [&] { drawn = shot.draw(*hosted); });
    expect_untouched(++seed, std::string("again, ") + c.name, [&] { drawn = shot.draw(*hosted); });
    expect_untouched(++seed, std::string("destroy, ") + c.name, [&] { hosted.reset(); });
    std::vector<Drawn> expected;
    {
      Renderer headless = create_headless();
      shot.draw(headless);
      expected = shot.draw(headless);
    }
    context->make_current();
    EXPECT_EQ(differing(drawn, expected), std::vector<std::string>{}) << c.name;
  }

  std::unique_ptr<gl::Context> context;
  std::unique_ptr<gl::Shaker> shaker;
};

INSTANTIATE_TEST_SUITE_P(All, HostedRenderer,
                         testing::Combine(testing::ValuesIn(gl::driver_contexts()),
                                          testing::Values(gl::Profile::core, gl::Profile::compatibility)),
                         gl::name_of_driver_and_profile);

// Each context draws a part of the cases; together they draw all.
TEST_P(HostedRenderer, LeavesTheStateAndDrawsTheSameBits) {
  const auto& [name, profile] = GetParam();
  const size_t share = (name == "osmesa" ? 2u : 0u) + (profile == gl::Profile::core ? 0u : 1u);
  for (size_t i = share; i < std::size(cases); i += 4) expect_same_bits(cases[i], static_cast<uint32_t>(4 * i));
}

using SlowHostedRenderer = HostedRenderer;
INSTANTIATE_TEST_SUITE_P(Slow, SlowHostedRenderer,
                         testing::Combine(testing::ValuesIn(gl::driver_contexts()),
                                          testing::Values(gl::Profile::core, gl::Profile::compatibility)),
                         gl::name_of_driver_and_profile);

TEST_P(SlowHostedRenderer, LeavesTheStateAndDrawsTheSameBitsInEveryCase) {
  uint32_t seed = 0;
  for (const Case& c : cases) expect_same_bits(c, seed += 4);
}

TEST_P(HostedRenderer, KeepsTheHostsErrorsAndTakesNone) {
  Shot shot(cases[0]);
  Renderer hosted = create_hosted().value();
  gl().Enable(~GLenum{0});
  shot.draw(hosted);
  EXPECT_EQ(gl().GetError(), static_cast<GLenum>(GL_INVALID_ENUM));
  EXPECT_EQ(gl().GetError(), static_cast<GLenum>(GL_NO_ERROR));
  gl::take_problems(*context);
}

TEST_P(HostedRenderer, RefusesToDrawWithinAQueryOfTheHost) {
  Shot shot(cases[0]);
  Renderer hosted = create_hosted().value();
  const gl::Query query(gl());
  gl().BeginQuery(GL_SAMPLES_PASSED, query.id());
  Result<Picture> picture = hosted.render(shot.scene, shot.camera, shot.options);
  gl().EndQuery(GL_SAMPLES_PASSED);
  ASSERT_FALSE(picture);
  EXPECT_EQ(picture.error().status, SIDERAY_INVALID_ARGUMENT);
  EXPECT_THAT(picture.error().message, testing::HasSubstr("GL_SAMPLES_PASSED"));
  EXPECT_TRUE(hosted.render(shot.scene, shot.camera, shot.options));
}

TEST_P(HostedRenderer, SaysWhatItRunsOn) {
  Renderer hosted = create_hosted().value();
  const sideray_device_info device = hosted.device();
  EXPECT_STREQ(device.gl, "host");
  EXPECT_STREQ(device.id, "host");
  EXPECT_EQ(device.renderer, context->info().renderer);
  EXPECT_EQ(device.usable, 1);
}

TEST(HostedRendererDescription, NeedsALoader) {
  const sideray_host_gl host{sizeof(sideray_host_gl), nullptr, nullptr};
  sideray_renderer_desc desc = sideray_renderer_defaults();
  desc.host = &host;
  Result<Renderer> renderer = Renderer::create(desc);
  ASSERT_FALSE(renderer);
  EXPECT_EQ(renderer.error().status, SIDERAY_INVALID_ARGUMENT);
  EXPECT_THAT(renderer.error().message, testing::HasSubstr("get_proc_address"));
}

}  // namespace
}  // namespace sideray::tests::hosted_renderer_test
