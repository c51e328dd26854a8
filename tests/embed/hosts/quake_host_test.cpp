// Tests a host in the style of old engines, which shadows OpenGL's state on the CPU, omits calls that would change
// nothing, and ends on any OpenGL error. It draws fifty frames with moving glass through the service.
#include <gmock/gmock.h>

#include <cmath>

#include "embed/hosts/small_host.h"
#include "gl/gl_contexts.h"

namespace sideray::tests::quake_host_test {
namespace {

constexpr int width = SmallHost::width, height = SmallHost::height;
constexpr uint32_t first_unit = 2;  // units 0 and 1 are the host's

enum StateBit : uint32_t { depth_test = 1, depth_write = 2, blend = 4, cull = 8, stencil = 16, color_write = 32 };

// GL_State() and GL_Bind(), which assume that the last value is still set.
class Shadow {
 public:
  explicit Shadow(const gl::Functions& table, bool trusts) : gl(table), trusts_(trusts) {}

  void state(uint32_t wanted) {
    const uint32_t changed = trusts_ ? wanted ^ bits_ : ~0u;
    const auto toggle = [&](uint32_t bit, GLenum capability) {
      if (changed & bit) wanted& bit ? gl.Enable(capability) : gl.Disable(capability);
    };
    toggle(depth_test, GL_DEPTH_TEST), toggle(blend, GL_BLEND), toggle(cull, GL_CULL_FACE);
    toggle(stencil, GL_STENCIL_TEST);
    if (changed & depth_write) gl.DepthMask(wanted & depth_write ? GL_TRUE : GL_FALSE);
    const GLboolean colors = wanted & color_write ? GL_TRUE : GL_FALSE;
    if (changed & color_write) gl.ColorMask(colors, colors, colors, colors);
    bits_ = wanted;
    die_of_errors();
  }
  void bind(uint32_t unit, uint32_t texture) {
    if (trusts_ && textures_[unit] == texture) return;
    select(unit);
    gl.BindTexture(GL_TEXTURE_2D, textures_[unit] = texture);
    die_of_errors();
  }
  void use(uint32_t program) {
    if (!trusts_ || program_ != program) gl.UseProgram(program_ = program);
    die_of_errors();
  }
  void target(uint32_t framebuffer) {
    if (!trusts_ || framebuffer_ != framebuffer) gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_ = framebuffer);
    die_of_errors();
  }
  void vertices(uint32_t array) {
    if (!trusts_ || array_ != array) gl.BindVertexArray(array_ = array);
    die_of_errors();
  }
  void die_of_errors() const { ASSERT_EQ(gl.GetError(), GLenum{GL_NO_ERROR}) << "the host dies"; }

 private:
  void select(uint32_t unit) {
    if (!trusts_ || unit_ != unit) gl.ActiveTexture(GL_TEXTURE0 + (unit_ = unit));
  }

  const gl::Functions& gl;
  bool trusts_;
  uint32_t bits_ = depth_write | color_write, textures_[2] = {}, program_ = 0, framebuffer_ = 0, array_ = 0, unit_ = 0;
};

class QuakeHost : public testing::TestWithParam<std::tuple<std::string, gl::Profile>> {
 protected:
  using Picture = std::vector<uint8_t>;

  void SetUp() override {
    const auto& [name, profile] = GetParam();
    auto context = gl::open_context(name, profile);
    if (!context && profile == gl::Profile::core && gl::is_required(name)) FAIL() << "required context " << name;
    if (!context) GTEST_SKIP() << "no such context here: " << name;
    host_.emplace(std::move(context));
  }
  void TearDown() override {
    if (!host_) return;
    EXPECT_EQ(gl::take_problems(host_->context()), std::vector<std::string>{});
    host_.reset();
  }

  struct Resources {
    explicit Resources(const gl::Functions& gl)
        : framebuffer(gl),
          color(gl),
          depth(gl),
          wall(gl),
          light(gl),
          array(gl),
          buffer(gl),
          world(gl, "world", vertex(),
                "#version 330\nuniform sampler2D wall, light;\nin vec2 uv;\nout vec4 c;\n"
                "void main() { c = texture(wall, uv) * texture(light, uv.yx); }\n"),
          glass(gl, "glass", vertex(),
                std::string("#version 330\n") + sideray_glsl(330) +
                    "in vec2 uv;\nin vec3 world;\nout vec4 c;\n"
                    "void main() { c = vec4(sideray_translucent(vec3(0.1, 0.0, 0.6), world, 5u), 0.5); }\n") {}
    static std::string vertex() {
      return "#version 330\nlayout(location = 0) in vec2 corner;\nuniform mat4 clip_from_world;\nuniform vec4 place;\n"
             "out vec2 uv;\nout vec3 world;\nvoid main() { uv = corner * 0.5 + 0.5; "
             "world = vec3(place.x + corner.x * place.w, place.y + corner.y * place.w, place.z); "
             "gl_Position = clip_from_world * vec4(world, 1.0); }\n";
    }
    gl::Framebuffer framebuffer;
    gl::Renderbuffer color, depth;
    gl::Texture wall, light;
    gl::VertexArray array;
    gl::Buffer buffer;
    gl::Program world, glass;
  };

  void load(const Resources& r) const {
    const gl::Functions& gl = host_->gl;
    gl.BindRenderbuffer(GL_RENDERBUFFER, r.color.id());
    gl.RenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, width, height);
    gl.BindRenderbuffer(GL_RENDERBUFFER, r.depth.id());
    gl.RenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH24_STENCIL8, width, height);
    gl.BindFramebuffer(GL_FRAMEBUFFER, r.framebuffer.id());
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, r.color.id());
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, r.depth.id());
    uint32_t texels[64] = {};
    for (uint32_t i = 0; i < 64; ++i) texels[i] = 0xff000000u | (i * 0x030201u) | ((i / 8 + i) % 2 ? 0x404040u : 0u);
    for (const gl::Texture* texture : {&r.wall, &r.light}) {
      gl.BindTexture(GL_TEXTURE_2D, texture->id());
      gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAX_LEVEL, 0);
      gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
      gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, 8, 8, 0, GL_RGBA, GL_UNSIGNED_BYTE, texels);
      std::reverse(std::begin(texels), std::end(texels));
    }
    constexpr float corners[] = {-1, -1, 1, -1, 1, 1, -1, -1, 1, 1, -1, 1};
    gl.BindVertexArray(r.array.id());
    gl.BindBuffer(GL_ARRAY_BUFFER, r.buffer.id());
    gl.BufferData(GL_ARRAY_BUFFER, sizeof(corners), corners, GL_STATIC_DRAW);
    gl.VertexAttribPointer(0, 2, GL_FLOAT, GL_FALSE, 0, nullptr);
    gl.EnableVertexAttribArray(0);
    // The shadow's initial state.
    gl.BindVertexArray(0), gl.BindFramebuffer(GL_FRAMEBUFFER, 0), gl.BindTexture(GL_TEXTURE_2D, 0);
    gl.Viewport(0, 0, width, height), gl.ClearDepth(1.0), gl.ClearStencil(0);
    gl.StencilFunc(GL_ALWAYS, 1, 0xff), gl.StencilOp(GL_KEEP, GL_KEEP, GL_REPLACE);
    gl.BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  }

  void draw_quad(const gl::Program& program, glm::vec4 place) const {
    const gl::Functions& gl = host_->gl;
    const glm::mat4 clip(SmallHost::clip_from_world());
    gl.UniformMatrix4fv(program.uniform("clip_from_world"), 1, GL_FALSE, glm::value_ptr(clip));
    program.set("place", place);
    gl.DrawArrays(GL_TRIANGLES, 0, 6);
  }

  // One frame with the pane at x.
  Picture frame(Shadow& s, const Resources& r, sideray_service* service, float x) {
    const gl::Functions& gl = host_->gl;
    const double pane[12] = {0.9, 0, 0, 0, 0.9, 0, 0, 0, 0.9, double{x}, 0, 1};
    host_->scene().move_instance(host_->pane(), pane);
    host_->scene().commit();
    s.target(r.framebuffer.id()), s.vertices(r.array.id());
    s.state(depth_test | depth_write | color_write);
    gl.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
    s.bind(0, r.wall.id()), s.bind(1, r.light.id()), s.use(r.world.id());
    draw_quad(r.world, {0, 0, 0, 5});
    s.state(depth_test | stencil);
    draw_quad(r.world, {x, 0, 1, 0.9f});
    FrameInputs in = host_->inputs();
    in.frame.source.framebuffer = r.framebuffer.id();
    in.masks = sideray_mask_inputs_defaults();
    in.masks->shadow_lights = 1;
    sideray_ticket ticket = 0;
    sideray_error error{};
    if (service) {
      EXPECT_EQ(submit_frame(service, in, ticket, &error), SIDERAY_OK) << error.message;
      s.die_of_errors();
    }
    s.bind(0, r.light.id());
    if (service) {
      EXPECT_EQ(sideray_service_advance(service, &error), SIDERAY_OK) << error.message;
      s.die_of_errors();
      EXPECT_EQ(sideray_service_wait(service, ticket, -1, &error), SIDERAY_OK) << error.message;
      s.die_of_errors();
    }
    s.use(r.world.id()), s.state(depth_test | blend | color_write);
    draw_quad(r.world, {-0.5f, 0.5f, 0.8f, 0.25f});
    const sideray_status bound =
        service ? sideray_service_bind(service, 0, r.glass.id(), first_unit, &error) : SIDERAY_OK;
    EXPECT_EQ(bound, SIDERAY_OK) << error.message;
    s.die_of_errors();
    s.use(r.glass.id()), s.state(depth_test | blend | color_write | cull);
    draw_quad(r.glass, {x, 0, 1, 0.9f});
    s.bind(1, r.wall.id()), s.use(r.world.id()), s.state(blend | color_write);
    draw_quad(r.world, {0.9f, -0.6f, 1.5f, 0.125f});
    s.bind(1, r.light.id());
    Picture picture(size_t{4} * width * height);
    gl.ReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, picture.data());
    s.die_of_errors();
    return picture;
  }

  std::vector<Picture> frames(bool trusts, bool traces) {
    const Resources resources(host_->gl);
    load(resources);
    resources.world.use(), resources.world.set("light", 1);
    host_->gl.UseProgram(0);
    const sideray_host_gl loader = host_->loader();
    sideray_service* service = nullptr;
    const sideray_status made =
        traces ? sideray_service_create(host_->tracer(), &loader, &service, nullptr) : SIDERAY_OK;
    EXPECT_EQ(made, SIDERAY_OK);
    // Without tracing, units and uniforms are those of a new program, as in a host without the service.
    if (!traces) separate_samplers(resources.glass);
    Shadow shadow(host_->gl, trusts);
    std::vector<Picture> pictures;
    for (int i = 0; i < 50; ++i)
      pictures.push_back(frame(shadow, resources, service, 0.3f * std::sin(0.2f * static_cast<float>(i))));
    sideray_service_destroy(service);
    shadow.die_of_errors();
    host_->gl.UseProgram(0), host_->gl.BindVertexArray(0);
    host_->gl.Disable(GL_DEPTH_TEST), host_->gl.Disable(GL_BLEND), host_->gl.Disable(GL_STENCIL_TEST);
    host_->gl.Disable(GL_CULL_FACE), host_->gl.DepthMask(GL_TRUE), host_->gl.ColorMask(1, 1, 1, 1);
    host_->gl.ActiveTexture(GL_TEXTURE1), host_->gl.BindTexture(GL_TEXTURE_2D, 0);
    host_->gl.ActiveTexture(GL_TEXTURE0), host_->gl.BindTexture(GL_TEXTURE_2D, 0);
    return pictures;
  }

  static void separate_samplers(const gl::Program& glass) {
    glass.use();
    int unit = static_cast<int>(first_unit);
    for (const char* name : {"sideray_radiance", "sideray_distance", "sideray_surface_id"}) glass.set(name, unit++);
  }

  std::optional<SmallHost> host_;
};

INSTANTIATE_TEST_SUITE_P(All, QuakeHost,
                         testing::Combine(testing::ValuesIn(gl::driver_contexts()),
                                          testing::Values(gl::Profile::core, gl::Profile::compatibility)),
                         gl::name_of_driver_and_profile);

// The shadowed state is right: pictures equal those of a host that sets everything each time.
TEST_P(QuakeHost, BelievesItsShadowOfTheState) {
  const std::vector<Picture> trusting = frames(true, true);
  if (HasFailure()) return;
  const std::vector<Picture> careful = frames(false, true), raster = frames(false, false);
  size_t traced = 0;
  for (size_t i = 0; i < trusting.size(); ++i) {
    EXPECT_EQ(trusting[i] == careful[i], true) << "frame " << i;
    traced += trusting[i] != raster[i];
  }
  EXPECT_EQ(traced, trusting.size()) << "frames that rays have a part in";
}

}  // namespace
}  // namespace sideray::tests::quake_host_test
