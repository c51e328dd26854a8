// Tests drivers of every age since OpenGL 2.1: the service works without what they lack, gives the same bits, and uses
// nothing that they do not have. Where it cannot work, it names what is missing.
#include <gmock/gmock.h>

#include <optional>
#include <thread>

#include "embed/faults/hiding_loader.h"
#include "embed/hosts/glass_host.h"
#include "gl/rasterizer.h"
#include "gl/resources/state_guard.h"
#include "model/failure.h"

namespace sideray::tests {
namespace {

using testing::HasSubstr;
using testing::IsEmpty;

const std::vector<std::string> textures_of_2_1{"EXT_texture_array", "ARB_texture_float", "ARB_texture_rg",
                                               "ARB_half_float_pixel"};

std::vector<std::string> with(std::vector<std::string> list, const std::vector<std::string>& more) {
  list.insert(list.end(), more.begin(), more.end());
  return list;
}

const std::vector<std::string> oldest = with(textures_of_2_1, {"EXT_framebuffer_object", "EXT_packed_depth_stencil"});

const std::vector<Driver> drivers{
    {"of_2_1", 21, with(textures_of_2_1, {"ARB_framebuffer_object", "ARB_map_buffer_range"})},
    {"of_2_1_with_ext_framebuffers", 21, oldest},
    {"of_2_1_with_ext_blits", 21,
     with(oldest, {"EXT_framebuffer_blit", "EXT_draw_buffers2", "ARB_color_buffer_float"})},
    {"of_2_1_with_integers", 21, with(oldest, {"EXT_texture_integer", "EXT_gpu_shader4"})},
    {"of_2_1_with_every_extension", 21, {}, true},
    {"of_3_0", 30, {}},
    {"of_3_0_without_sync", 30, {"ARB_sync"}, true},
    {"of_3_1", 31, {"ARB_compatibility"}},
    {"of_3_1_without_sync", 31, {"ARB_sync"}, true},
    {"of_3_2", 32, {}},
    {"of_3_2_without_samplers", 32, {"ARB_sampler_objects"}, true},
    {"of_3_3", 33, {}},
    {"of_4_3_without_buffer_storage", 43, {"ARB_buffer_storage"}, true},
    {"of_4_4_without_clip_control", 44, {"ARB_clip_control"}, true},
    {"of_4_5", 45, {}, true},
    {"without_sync_functions", 45, {}, true, {"glFenceSync"}},
    {"without_mapping_of_ranges", 45, {}, true, {"glMapBufferRange"}},
    {"without_sampler_functions", 45, {}, true, {"glBindSampler"}},
    {"without_vertex_array_functions", 45, {}, true, {"glBindVertexArray"}},
    {"without_viewport_functions", 45, {}, true, {"glViewportIndexedfv"}},
};

// A glass host whose service sees the given driver, by default the real one.
class FloorHost {
 public:
  explicit FloorHost(const Driver* driver) : glass_(gl::Profile::compatibility, make_loader(driver)), gl(glass_.gl) {
    depth_ = gl::Renderbuffer(gl), depth_texture_ = gl::Texture(gl), mask_ = gl::Texture(gl);
    gl.BindRenderbuffer(GL_RENDERBUFFER, depth_.id());
    gl.RenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH24_STENCIL8, GlassHost::width, GlassHost::height);
    gl.BindFramebuffer(GL_FRAMEBUFFER, glass_.framebuffer());
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, depth_.id());
    gl.ClearDepth(wall_depth());
    gl.ClearStencil(1);
    gl.Clear(GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
    fill_textures();
    light_scene();
  }
  // Expects that nothing hidden was used, and that there is no OpenGL error.
  void expect_clean() const {
    EXPECT_EQ(gl.GetError(), GLenum{GL_NO_ERROR});
    if (loader_) {
      EXPECT_THAT(loader_->used(), IsEmpty());
    }
  }

  FrameInputs stencil() const {
    FrameInputs in = glass_.inputs();
    in.frame.source.mask = SIDERAY_MASK_COUNT;
    return in;
  }
  FrameInputs texture() const {
    FrameInputs in = glass_.inputs();
    in.frame.source.depth_texture = depth_texture_.id();
    in.frame.source.mask = SIDERAY_MASK_TEXTURE;
    in.frame.source.mask_texture = mask_.id();
    return in;
  }
  FrameInputs renderbuffer() const {
    FrameInputs in = glass_.inputs();
    in.frame.source.depth_renderbuffer = depth_.id();
    in.frame.source.mask = SIDERAY_MASK_STENCIL;
    in.layers->cache_rate = SIDERAY_RATE_CHECKERBOARD;
    return in;
  }
  FrameInputs masks() const {
    FrameInputs in = stencil();
    in.masks = sideray_mask_inputs_defaults();
    in.masks->ao_rays = 4;
    in.masks->shadow_lights = 1;
    return in;
  }
  FrameInputs composite() const {
    FrameInputs in = stencil();
    in.layers->mode = SIDERAY_COMPOSITE;
    return in;
  }

  // Returns the bytes of the host's picture and of the service's textures.
  std::vector<std::string> answers(int glsl) {
    std::vector<std::string> result;
    const gl::Program program =
        glass_.program(glsl, "sideray_translucent(vec3(0.0, 0.0, 1.0), world, id) * sideray_ao()");
    for (const FrameInputs& in : {stencil(), texture(), renderbuffer(), masks()}) {
      glass_.trace(in);
      add(result, glass_.draw(program, glsl));
      add_textures(result);
    }
    glass_.trace(composite());
    add_textures(result);
    return result;
  }

  FrameOutputs latest() {
    FrameOutputs outputs;
    EXPECT_EQ(newest_outputs(glass_.service().get(), 0, outputs), SIDERAY_OK);
    return outputs;
  }
  std::string refusal(const FrameInputs& in) {
    sideray_error error{};
    sideray_ticket ticket = 0;
    EXPECT_EQ(submit_frame(glass_.service().get(), in, ticket, &error), SIDERAY_UNSUPPORTED);
    return error.message;
  }
  GlassHost& glass() { return glass_; }
  HidingLoader& loader() { return *loader_; }

 private:
  GlassHost::Loader make_loader(const Driver* driver) {
    if (!driver) return {};
    return [this, driver](gl::Context& context) { return loader_.emplace(context, *driver).host(); };
  }

  // Returns the depth of a wall behind the pane, in its shadow.
  static double wall_depth() {
    const glm::dvec4 clip = GlassHost::clip_from_world() * glm::dvec4(0, 0, -0.5, 1);
    return 0.5 + 0.5 * clip.z / clip.w;
  }
  void light_scene() {
    sideray_light sun{};
    sun.size = sizeof(sun);
    sun.direction[0] = 0.3f, sun.direction[2] = -1.0f;
    sun.angular_diameter_deg = 20.0f;
    for (float& c : sun.intensity) c = 1.0f;
    glass_.scene().set_lights({&sun, 1});
    glass_.scene().commit();
  }

  void fill_textures() const {
    constexpr int w = GlassHost::width, h = GlassHost::height;
    const std::vector<uint32_t> depth(size_t{w} * h, static_cast<uint32_t>(wall_depth() * 0xffffff) << 8 | 1u);
    std::vector<uint8_t> mask(size_t{w} * h, 1);
    std::fill_n(mask.begin(), w * 20, uint8_t{0});
    gl.BindTexture(GL_TEXTURE_2D, depth_texture_.id());
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH24_STENCIL8, w, h, 0, GL_DEPTH_STENCIL, GL_UNSIGNED_INT_24_8, depth.data());
    gl.BindTexture(GL_TEXTURE_2D, mask_.id());
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_R8, w, h, 0, GL_RED, GL_UNSIGNED_BYTE, mask.data());
    gl.BindTexture(GL_TEXTURE_2D, 0);
  }

  template <typename T>
  static void add(std::vector<std::string>& to, const std::vector<T>& values) {
    to.emplace_back(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  }
  void add_textures(std::vector<std::string>& to) {
    const FrameOutputs outputs = latest();
    const sideray_layer_outputs layers = outputs.layers.value_or(sideray_layer_outputs{});
    const sideray_mask_outputs masks = outputs.masks.value_or(sideray_mask_outputs{});
    const GLenum target = layers.mode == SIDERAY_CACHE ? GL_TEXTURE_2D_ARRAY : GL_TEXTURE_2D;
    const std::pair<GLenum, uint32_t> textures[] = {{target, layers.radiance_texture},
                                                    {target, layers.distance_texture},
                                                    {GL_TEXTURE_2D_ARRAY, masks.shadow_texture},
                                                    {GL_TEXTURE_2D, masks.ao_texture}};
    for (const auto& [kind, name] : textures) {
      if (name == 0) continue;
      std::vector<glm::vec4> texels(size_t{GlassHost::width} * GlassHost::height);
      gl.BindTexture(kind, name);
      gl.GetTexImage(kind, 0, GL_RGBA, GL_FLOAT, texels.data());
      gl.BindTexture(kind, 0);
      add(to, texels);
    }
  }

  std::optional<HidingLoader> loader_;
  GlassHost glass_;

 public:
  const gl::Functions& gl;

 private:
  gl::Renderbuffer depth_;
  gl::Texture depth_texture_, mask_;
};

class Floor : public testing::TestWithParam<Driver> {
 protected:
  void SetUp() override {
    const auto context = gl::Context::create("auto", "", gl::Profile::compatibility);
    if (context->functions().version < GetParam().version) GTEST_SKIP() << "this driver is older";
  }
};

bool has_multisampling(const gl::Functions& gl) {
  GLint samples = 0;
  gl.GetIntegerv(GL_MAX_SAMPLES, &samples);
  return samples >= 4;
}

INSTANTIATE_TEST_SUITE_P(Drivers, Floor, testing::ValuesIn(drivers),
                         [](const auto& suite) { return suite.param.name; });

TEST_P(Floor, GivesTheSameAnswers) {
  static const std::vector<std::string> expected = FloorHost(nullptr).answers(330);
  ASSERT_EQ(expected.size(), 4u + 2u + 2u + 2u + 4u + 2u);
  const Driver driver = GetParam();
  FloorHost host(&driver);
  const std::vector<std::string> answers = host.answers(driver.version < 30 ? 120 : 130);
  ASSERT_EQ(answers.size(), expected.size());
  for (size_t i = 0; i < answers.size(); ++i) {
    const auto [least, most] = std::minmax_element(expected[i].begin(), expected[i].end());
    EXPECT_NE(*least, *most) << "image " << i << " is one colour";
  }
  for (size_t i = 0; i < answers.size(); ++i) EXPECT_TRUE(answers[i] == expected[i]) << "image " << i;
  host.expect_clean();
}

// Polls several frames in flight, which a fence of any kind finishes.
TEST_P(Floor, AdvancesWithoutWaiting) {
  const Driver driver = GetParam();
  FloorHost host(&driver);
  sideray_service* service = host.glass().service().get();
  const FrameInputs in = host.stencil();
  sideray_ticket tickets[3] = {}, fourth = 0;
  for (sideray_ticket& ticket : tickets) ASSERT_EQ(submit_frame(service, in, ticket), SIDERAY_OK);
  EXPECT_EQ(submit_frame(service, in, fourth), SIDERAY_NOT_READY);
  FrameOutputs outputs;
  for (int polls = 0; polls < 10000 && outputs.ticket != tickets[2]; ++polls) {
    ASSERT_EQ(sideray_service_advance(service, nullptr), SIDERAY_OK);
    newest_outputs(service, 0, outputs);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_EQ(outputs.ticket, tickets[2]);
  host.expect_clean();
}

TEST_P(Floor, GuardsSaveWhatThereIs) {
  const Driver driver = GetParam();
  const auto context = gl::Context::create("auto", "", gl::Profile::compatibility);
  context->make_current();
  HidingLoader loader(*context, driver);
  const gl::Functions gl = gl::load_functions(&HidingLoader::get_proc_address, &loader);
  gl.Enable(GL_CULL_FACE);
  gl.BlendFunc(GL_DST_COLOR, GL_ONE);
  gl.ColorMask(GL_TRUE, GL_FALSE, GL_TRUE, GL_FALSE);
  gl.StencilMaskSeparate(GL_BACK, 0x3f);
  gl.PixelStorei(GL_PACK_ROW_LENGTH, 7);
  {
    const gl::FramebufferGuard framebuffers(gl);
    const gl::PixelTransferGuard transfer(gl);
    const gl::TextureGuard textures(gl, 0, 2);
    const gl::BufferGuard buffers(gl, 2);
    const gl::DrawGuard draw(gl);
    const gl::StencilGuard stencil(gl);
    EXPECT_FALSE(gl.IsEnabled(GL_CULL_FACE));
  }
  EXPECT_TRUE(gl.IsEnabled(GL_CULL_FACE));
  GLint factor = 0, mask = 0, row = 0;
  GLboolean colors[4] = {};
  gl.GetIntegerv(GL_BLEND_DST_RGB, &factor);
  gl.GetIntegerv(GL_STENCIL_BACK_WRITEMASK, &mask);
  gl.GetIntegerv(GL_PACK_ROW_LENGTH, &row);
  gl.GetBooleanv(GL_COLOR_WRITEMASK, colors);
  EXPECT_EQ(factor, GL_ONE);
  EXPECT_EQ(mask, 0x3f);
  EXPECT_EQ(row, 7);
  EXPECT_THAT(colors, testing::ElementsAre(1, 0, 1, 0));
  EXPECT_EQ(gl.GetError(), GLenum{GL_NO_ERROR});
  EXPECT_THAT(loader.used(), IsEmpty());
}

// Only one occlusion query can be active: the host's stays, and readback continues without a fence.
TEST(FloorWithoutSync, AHostsOcclusionQueryGoesOn) {
  const Driver driver{"", 21, oldest};
  FloorHost host(&driver);
  const gl::Functions& gl = host.gl;
  const gl::Query query(gl);
  gl.BeginQuery(GL_SAMPLES_PASSED, query.id());
  host.glass().trace(host.stencil());
  GLint under_way = 0;
  gl.GetQueryiv(GL_SAMPLES_PASSED, GL_CURRENT_QUERY, &under_way);
  EXPECT_EQ(static_cast<uint32_t>(under_way), query.id());
  gl.EndQuery(GL_SAMPLES_PASSED);
  GLuint samples = 1;
  gl.GetQueryObjectuiv(query.id(), GL_QUERY_RESULT, &samples);
  EXPECT_EQ(samples, 0u);
  host.expect_clean();
}

TEST(FloorWithoutSync, AQueryIsWaitedFor) {
  const Driver driver{"", 21, oldest};
  FloorHost host(&driver);
  sideray_service* service = host.glass().service().get();
  host.glass().trace(host.stencil());
  const sideray_ticket first = host.latest().ticket;
  host.loader().hold_queries(true);
  const FrameInputs in = host.stencil();
  sideray_ticket ticket = 0;
  ASSERT_EQ(submit_frame(service, in, ticket), SIDERAY_OK);
  EXPECT_EQ(sideray_service_wait(service, ticket, 30, nullptr), SIDERAY_NOT_READY);
  EXPECT_EQ(sideray_service_advance(service, nullptr), SIDERAY_OK);
  EXPECT_EQ(host.latest().ticket, first);
  host.loader().hold_queries(false);
  EXPECT_EQ(sideray_service_wait(service, ticket, -1, nullptr), SIDERAY_OK);
  EXPECT_EQ(host.latest().ticket, ticket);
  host.expect_clean();
}

// As a float the id would equal the next one.
TEST(FloorWithoutIntegers, AnIdThatNoFloatHoldsFailsTheFrame) {
  const Driver driver{"", 21, oldest};
  for (const Driver* met : {&driver, static_cast<const Driver*>(nullptr)}) {
    FloorHost host(met);
    FrameInputs in = host.stencil();
    in.layers->float_ids = met == nullptr;
    in.layers->max_layers = 2;
    host.glass().trace(in);
    const sideray_ticket before = host.latest().ticket;
    host.glass().add_pane(1u << 24);
    sideray_error error{};
    sideray_ticket ticket = 0;
    ASSERT_EQ(submit_frame(host.glass().service().get(), in, ticket, &error), SIDERAY_OK);
    EXPECT_EQ(sideray_service_wait(host.glass().service().get(), ticket, -1, &error), SIDERAY_UNSUPPORTED);
    EXPECT_THAT(error.message, HasSubstr("surface id 16777216"));
    EXPECT_EQ(host.latest().ticket, before) << "the last good one stays";
    host.expect_clean();
  }
}

TEST(FloorWithoutBlits, ReadsFramebuffersOfOneSampleAlone) {
  const Driver driver{"", 21, oldest};
  FloorHost host(&driver);
  if (!has_multisampling(host.gl)) GTEST_SKIP() << "no samples here";
  const gl::Renderbuffer depth(host.gl);
  host.gl.BindRenderbuffer(GL_RENDERBUFFER, depth.id());
  host.gl.RenderbufferStorageMultisample(GL_RENDERBUFFER, 4, GL_DEPTH24_STENCIL8, GlassHost::width, GlassHost::height);
  FrameInputs in = host.stencil();
  in.frame.source.depth_renderbuffer = depth.id();
  EXPECT_THAT(host.refusal(in), HasSubstr("EXT_framebuffer_blit"));
  host.glass().trace(host.stencil());
  host.expect_clean();
}

TEST(FloorWithBlits, CopiesASampleOfEachPixel) {
  const Driver driver{"", 21, with(oldest, {"EXT_framebuffer_blit"})};
  FloorHost host(&driver);
  const gl::Functions& gl = host.gl;
  if (!has_multisampling(gl)) GTEST_SKIP() << "no samples here";
  const gl::Renderbuffer depth(gl);
  const gl::Framebuffer around(gl);
  gl.BindRenderbuffer(GL_RENDERBUFFER, depth.id());
  gl.RenderbufferStorageMultisample(GL_RENDERBUFFER, 4, GL_DEPTH24_STENCIL8, GlassHost::width, GlassHost::height);
  gl.BindFramebuffer(GL_FRAMEBUFFER, around.id());
  gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, depth.id());
  gl.DrawBuffer(GL_NONE), gl.ReadBuffer(GL_NONE);
  gl.Clear(GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
  FrameInputs in = host.stencil();
  in.frame.source.framebuffer = around.id();
  host.glass().trace(in);
  const gl::Program program = host.glass().program(120, "sideray_translucent(vec3(0.0, 0.0, 1.0), world, id)");
  const GlassHost::Picture copied = host.glass().draw(program, 120);
  host.glass().trace(host.stencil());
  EXPECT_EQ(host.glass().draw(program, 120), copied);
  host.expect_clean();
}

// Returns the message for a driver that is too old, which lists all that it lacks.
std::string missing(const Driver& driver) {
  const auto context = gl::Context::create("auto", "", gl::Profile::compatibility);
  context->make_current();
  HidingLoader loader(*context, driver);
  try {
    gl::load_functions(&HidingLoader::get_proc_address, &loader);
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.status, SIDERAY_UNSUPPORTED);
    EXPECT_THAT(loader.used(), IsEmpty());
    return failure.what();
  }
  return "";
}

TEST(FloorRefuses, WhatLacksOneCapabilityByItsName) {
  const std::pair<const char*, std::vector<std::string>> cases[] = {
      {"texture arrays", {"EXT_texture_array"}},
      {"float textures", {"ARB_texture_float"}},
      {"textures of one channel", {"ARB_texture_rg"}},
      {"half floats", {"ARB_half_float_pixel"}},
      {"framebuffer objects", {"ARB_framebuffer_object", "EXT_framebuffer_object"}},
      {"packed depth and stencil", {"ARB_framebuffer_object", "EXT_packed_depth_stencil"}}};
  for (const auto& [name, lacking] : cases) {
    const std::string message = missing({"", 21, lacking, true});
    EXPECT_THAT(message, HasSubstr(name));
    EXPECT_THAT(message, HasSubstr("ask for a newer context or update the driver"));
    for (const auto& [other, extensions] : cases)
      if (std::string(other) != name) {
        EXPECT_THAT(message, testing::Not(HasSubstr(other)));
      }
  }
  EXPECT_EQ(missing({"", 21, {}, true}), "");
}

TEST(FloorRefuses, WhatLacksMuchNamingAllOfIt) {
  const std::string message = missing({"", 15, {}});
  for (const char* name : {"OpenGL \"1.5", "GLSL 1.20", "pixel buffers", "framebuffer objects", "texture arrays",
                           "float textures", "textures of one channel", "half floats"})
    EXPECT_THAT(message, HasSubstr(name));
  EXPECT_EQ(message.find('\n'), std::string::npos);
  EXPECT_LT(message.size(), sizeof(sideray_error::message));
}

TEST(FloorRefuses, ALoaderThatLacksWhatMustBeThere) {
  for (const char* name : {"glReadPixels", "glMapBuffer", "glBindFramebuffer", "glBlitFramebuffer"})
    EXPECT_THAT(missing({"", 45, {}, true, {name}}), HasSubstr(std::string("function ") + name + " not found"));
  EXPECT_EQ(missing({"", 21, oldest, false, {"glBlitFramebuffer"}}), "") << "needed by nothing there";
}

TEST(FloorOfTheRenderer, StaysWhereItWas) {
  const auto context = gl::Context::create("auto", "", gl::Profile::compatibility);
  context->make_current();
  HidingLoader loader(*context, {"", 32, {}, true});
  const gl::Functions gl = gl::load_functions(&HidingLoader::get_proc_address, &loader);
  try {
    const gl::Rasterizer rasterizer(gl);
    FAIL() << "no failure";
  } catch (const Failure& failure) {
    EXPECT_EQ(failure.status, SIDERAY_UNSUPPORTED);
    EXPECT_THAT(failure.what(), HasSubstr("3.3 or later is needed"));
  }
  const sideray_host_gl host = loader.host();
  sideray_renderer_desc desc = sideray_renderer_defaults();
  desc.host = &host;
  const Result<Renderer> renderer = Renderer::create(desc);
  ASSERT_FALSE(renderer);
  EXPECT_EQ(renderer.error().status, SIDERAY_UNSUPPORTED);
  EXPECT_THAT(renderer.error().message, HasSubstr("3.3 or later is needed"));
}

}  // namespace
}  // namespace sideray::tests
