// Tests a host's mistakes: messages name them, nothing is changed, and the picture can show which fragments have no
// answer and why.
#include <gmock/gmock.h>

#include <thread>

#include "embed/hosts/glass_host.h"

namespace sideray::tests {
namespace {

using testing::AllOf;
using testing::HasSubstr;

class Mistakes : public testing::TestWithParam<gl::Profile> {
 protected:
  Mistakes() { host.attach(depth_); }

  sideray_status submit(const FrameInputs& in) {
    error = {};
    return submit_frame(host.service().get(), in, ticket, &error);
  }

  // Draws as GlassHost::draw() does, but with the depth test.
  void draw_with_depth(const gl::Program& program) {
    gl.Enable(GL_DEPTH_TEST);
    program.use();
    const glm::mat4 matrix(GlassHost::clip_from_world());
    gl.UniformMatrix4fv(gl.GetUniformLocation(program.id(), "clip_from_world"), 1, GL_FALSE, glm::value_ptr(matrix));
    host.draw_pane(program);
    gl.UseProgram(0);
    gl.Disable(GL_DEPTH_TEST);
  }

  GlassHost host{GetParam()};
  const gl::Functions& gl = host.gl;
  sideray_error error{};
  sideray_ticket ticket = 0;

 private:
  gl::Renderbuffer depth_{gl};
};

TEST_P(Mistakes, AFramebufferThatIsNotThereIsNamed) {
  FrameInputs in = host.inputs();
  in.frame.source.framebuffer = 999;
  EXPECT_EQ(submit(in), SIDERAY_INVALID_ARGUMENT);
  EXPECT_THAT(error.message, HasSubstr("framebuffer 999"));
  EXPECT_FALSE(gl.IsFramebuffer(999)) << "asking must not make one";
  EXPECT_EQ(gl.GetError(), GLenum{GL_NO_ERROR});
  host.trace(host.inputs());
}

TEST_P(Mistakes, ARectangleBeyondTheDepthIsRefused) {
  FrameInputs in = host.inputs();
  in.frame.source.x = 1;
  EXPECT_EQ(submit(in), SIDERAY_INVALID_ARGUMENT);
  EXPECT_THAT(error.message, AllOf(HasSubstr("rectangle"), HasSubstr("96x64")));
  in.frame.source.x = 0, in.frame.source.height = GlassHost::height + 1;
  EXPECT_EQ(submit(in), SIDERAY_INVALID_ARGUMENT);
  in.frame.source.y = 16, in.frame.source.height = GlassHost::height - 16;
  host.trace(in);
}

TEST_P(Mistakes, ARectangleBeyondATextureIsRefused) {
  if (gl.version < 45) GTEST_SKIP() << "textures do not tell their size here";
  gl::Texture depth(gl);
  gl.BindTexture(GL_TEXTURE_2D, depth.id());
  gl.TexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT24, 80, 64, 0, GL_DEPTH_COMPONENT, GL_FLOAT, nullptr);
  gl.BindTexture(GL_TEXTURE_2D, 0);
  FrameInputs in = host.inputs();
  in.frame.source.depth_texture = depth.id();
  EXPECT_EQ(submit(in), SIDERAY_INVALID_ARGUMENT);
  EXPECT_THAT(error.message, HasSubstr("80x64"));
  in.frame.source.width = 80;
  EXPECT_EQ(submit(in), SIDERAY_OK) << error.message;
  EXPECT_EQ(sideray_service_wait(host.service().get(), ticket, -1, &error), SIDERAY_OK) << error.message;
}

// A submitted frame survives calls from threads without a context.
TEST_P(Mistakes, AThreadWithoutContextIsToldSo) {
  sideray_service* const service = host.service().get();
  const gl::Program program = host.program(330, "vec3(1.0)");
  const FrameInputs in = host.inputs();
  ASSERT_EQ(submit(in), SIDERAY_OK) << error.message;
  std::vector<sideray_error> errors(5);
  std::thread elsewhere([&] {
    sideray_ticket other = 0;
    submit_frame(service, in, other, &errors[0]);
    sideray_service_wait(service, ticket, -1, &errors[1]);
    sideray_service_advance(service, &errors[2]);
    sideray_service_bind(service, 0, program.id(), 1, &errors[3]);
    const sideray_host_gl loader{sizeof(loader), gl::Context::get_proc_address, &host.context()};
    sideray_service* made = nullptr;
    sideray_service_create(host.tracer().get(), &loader, &made, &errors[4]);
    EXPECT_EQ(made, nullptr);
  });
  elsewhere.join();
  for (const sideray_error& e : errors) {
    EXPECT_NE(e.status, SIDERAY_OK);
    EXPECT_THAT(e.message, HasSubstr("context is current")) << &e - errors.data();
  }
  EXPECT_EQ(sideray_service_wait(service, ticket, -1, &error), SIDERAY_OK) << error.message;
}

TEST_P(Mistakes, StructsWithoutTheirSizeAreNamed) {
  sideray_light light = sideray_light_defaults();
  light.size = 0;
  EXPECT_EQ(sideray_scene_set_lights(host.scene().get(), &light, 1, &error), SIDERAY_INVALID_ARGUMENT);
  EXPECT_THAT(error.message, AllOf(HasSubstr("light 0"), HasSubstr("sizeof"), testing::Not(HasSubstr("default"))));
  host.trace(host.inputs());
  sideray_frame_stats stats{};
  EXPECT_EQ(sideray_service_stats(host.service().get(), 1, &stats, &error), SIDERAY_INVALID_ARGUMENT);
  EXPECT_THAT(error.message, AllOf(HasSubstr("statistics"), HasSubstr("sizeof"), testing::Not(HasSubstr("default"))));
  const sideray_host_gl loader{0, gl::Context::get_proc_address, &host.context()};
  sideray_service* made = nullptr;
  EXPECT_EQ(sideray_service_create(host.tracer().get(), &loader, &made, &error), SIDERAY_INVALID_ARGUMENT);
  EXPECT_THAT(error.message, AllOf(HasSubstr("host"), HasSubstr("sizeof"), testing::Not(HasSubstr("default"))));
}

// With a wrong depth convention no drawn point is on a surface of the scene, which one counter shows.
TEST_P(Mistakes, ADepthConventionThatIsWrongIsCounted) {
  const sideray_material opaque = host.scene().add_material([] {
    sideray_material_desc desc = sideray_material_defaults();
    desc.double_sided = 1;
    return desc;
  }());
  sideray_instance_desc wall = host.pane_desc();
  wall.material = opaque;
  host.scene().replace_instances(std::array{host.pane()}, std::array{wall});
  host.scene().commit();
  gl.BindFramebuffer(GL_FRAMEBUFFER, host.framebuffer());
  gl.Viewport(0, 0, GlassHost::width, GlassHost::height);
  gl.Clear(GL_DEPTH_BUFFER_BIT);
  const gl::Program program = host.program(330, "vec3(1.0)");
  draw_with_depth(program);
  FrameInputs in = host.inputs();
  in.layers.reset();
  in.masks = sideray_mask_inputs_defaults();
  in.masks->ao_rays = 1;
  const auto astray = [&] {
    EXPECT_EQ(submit(in), SIDERAY_OK) << error.message;
    EXPECT_TRUE(host.service().wait(ticket));
    return host.service().stats(ticket);
  };
  EXPECT_EQ(astray().mask_pixels_checked, 0u) << "nobody asked";
  in.masks->checks_surfaces = 1;
  sideray_frame_stats stats = astray();
  EXPECT_GT(stats.mask_pixels_checked, 100u);
  EXPECT_EQ(stats.mask_pixels_astray, 0u);
  in.frame.view.zero_to_one_depth = 1;
  stats = astray();
  EXPECT_EQ(stats.mask_pixels_astray, stats.mask_pixels_checked);
}

TEST(ViewFromMatrices, IsThatOfTheEngine) {
  const glm::dmat4 projection = glm::perspective(0.9, 1.5, 0.1, 50.0);
  const glm::dmat4 modelview = glm::lookAt(glm::dvec3(1, 2, 3), glm::dvec3(0), glm::dvec3(0, 1, 0));
  sideray_error error{};
  sideray_view view{};
  const auto make = [&](const glm::dmat4& p, const glm::dmat4& m) {
    error = {};
    return sideray_view_from_matrices(glm::value_ptr(p), glm::value_ptr(m), &view, &error);
  };
  ASSERT_EQ(make(projection, modelview), SIDERAY_OK) << error.message;
  const glm::dmat4 product = glm::make_mat4(view.world_from_clip) * projection * modelview;
  for (int c = 0; c < 4; ++c)
    for (int r = 0; r < 4; ++r) EXPECT_NEAR(product[c][r], c == r ? 1 : 0, 1e-9);
  EXPECT_EQ(make(glm::ortho(-1.0, 1.0, -1.0, 1.0), modelview), SIDERAY_OK) << error.message;
  // The projection of a left-handed engine, whose view looks along +z.
  EXPECT_EQ(make(glm::perspectiveLH(0.9, 1.5, 0.1, 50.0), modelview), SIDERAY_OK) << error.message;
  EXPECT_EQ(make(projection, glm::transpose(modelview)), SIDERAY_INVALID_ARGUMENT);
  EXPECT_THAT(error.message, AllOf(HasSubstr("modelview"), HasSubstr("transposed")));
  EXPECT_EQ(make(glm::transpose(projection), modelview), SIDERAY_INVALID_ARGUMENT);
  EXPECT_THAT(error.message, AllOf(HasSubstr("projection"), HasSubstr("transposed")));
  EXPECT_EQ(make(projection * modelview, glm::dmat4(1)), SIDERAY_INVALID_ARGUMENT);
  EXPECT_EQ(make(projection, glm::dmat4(0)), SIDERAY_INVALID_ARGUMENT);
}

TEST_P(Mistakes, TwoSurfacesOfOneNumberAreRefusedAtCommit) {
  sideray_instance_desc twin = host.pane_desc();
  const sideray_instance second = host.scene().add_instances({&twin, 1}).front();
  EXPECT_EQ(sideray_scene_commit(host.scene().get(), &error), SIDERAY_INVALID_ARGUMENT);
  EXPECT_THAT(error.message, AllOf(HasSubstr("surface_id 5"), HasSubstr("instances 1 and 2")));
  host.trace(host.inputs());  // what was committed before
  // Two instances may swap their ids.
  const uint32_t swapped[] = {6, 5};
  const sideray_instance both[] = {host.pane(), second};
  host.scene().renumber_instances(both, swapped);
  host.scene().commit();
  // Surfaces that have no fragments may share an id.
  twin.surface_id = 5, twin.visibility = SIDERAY_VISIBLE_REFLECTION;
  host.scene().add_instances({&twin, 1});
  twin.surface_id = 0, twin.visibility = SIDERAY_VISIBLE_ALL;
  host.scene().add_instances({&twin, 1});
  host.scene().add_instances({&twin, 1});
  host.scene().commit();
}

INSTANTIATE_TEST_SUITE_P(Profiles, Mistakes, testing::Values(gl::Profile::core, gl::Profile::compatibility),
                         [](const auto& p) { return p.param == gl::Profile::core ? "Core" : "Compatibility"; });

// Tests the reasons for missing answers by colour and by count, in every GLSL version.
class Misses : public testing::TestWithParam<int> {
 protected:
  Misses() { host.attach(depth_); }
  bool skipped() const { return GetParam() > 10 * gl.version; }
  int version() const { return skipped() ? 120 : GetParam(); }

  void trace(uint32_t max_layers = 1, sideray_mask_source mask = SIDERAY_MASK_NONE) {
    FrameInputs in = host.inputs();
    in.layers->float_ids = GetParam() < 130;
    in.layers->max_layers = max_layers;
    in.frame.source.mask = mask;
    host.trace(in);
  }
  // Counts the pane's fragments for each reason, by occlusion queries.
  std::vector<uint32_t> count(const gl::Program& counter, glm::vec3 offset) {
    std::vector<uint32_t> counts;
    for (int reason = 0; reason <= 6; ++reason) {
      counter.use();
      gl.Uniform1i(gl.GetUniformLocation(counter.id(), "reason"), reason);
      gl::Query query(gl);
      gl.BeginQuery(GL_SAMPLES_PASSED, query.id());
      host.draw(counter, GetParam(), GlassHost::clip_from_world(), offset);
      gl.EndQuery(GL_SAMPLES_PASSED);
      gl.GetQueryObjectuiv(query.id(), GL_QUERY_RESULT, &counts.emplace_back());
    }
    return counts;
  }
  // Counts the fragments of this colour with SIDERAY_DEBUG.
  size_t colored(glm::vec3 color, glm::vec3 offset = glm::vec3(0)) {
    const GlassHost::Picture picture = host.draw(debug_, GetParam(), GlassHost::clip_from_world(), offset);
    return static_cast<size_t>(std::count(picture.begin(), picture.end(), glm::vec4(color, 1)));
  }
  // Expects this reason for all fragments, except outside the traced picture; so, too, by look-ups of moving fragments.
  void expect_all(size_t reason, glm::vec3 color, glm::vec3 offset = glm::vec3(0)) {
    const std::vector<uint32_t> counts = count(counter_, offset);
    EXPECT_EQ(count(moving_counter_, offset), counts);
    EXPECT_GT(counts[reason], 900u);
    for (size_t i = 0; i < counts.size(); ++i)
      if (i != reason && !(i == 3 && offset.z > 0)) {
        EXPECT_EQ(counts[i], 0u) << i;
      }
    EXPECT_EQ(colored(color, offset), counts[reason]);
  }

  GlassHost host{gl::Profile::compatibility};
  const gl::Functions& gl = host.gl;

 private:
  gl::Renderbuffer depth_{gl};
  gl::Program make_counter(const std::string& explain) const {
    return host.program(version(), "counted(world, id)",
                        "uniform int reason;\n"
                        "vec3 counted(vec3 at, SIDERAY_UINT surface) {\n"
                        "  if (" + explain + "(at, surface) != reason) discard;\n"
                        "  return vec3(0.0);\n}\n");
  }
  gl::Program counter_ = make_counter("sideray_explain"), moving_counter_ = make_counter("sideray_explain_moving");
  gl::Program debug_ = host.program(version(), "sideray_translucent(vec3(0.5), world, id)", "", {"SIDERAY_DEBUG"});
};

TEST_P(Misses, AreSeenAndCounted) {
  if (skipped()) GTEST_SKIP() << "no such context here";
  expect_all(1, glm::vec3(0.5f));  // nothing is bound yet: the host's own colour
  trace();
  expect_all(0, {0.25f, 0.5f, 0});
  expect_all(5, {1, 1, 0}, {0, 0, 0.4f});   // it is drawn before where rays hit it
  expect_all(2, {0, 1, 1}, {0, 0, -0.4f});  // and behind it, where the only layer is used
  trace(2);
  expect_all(5, {1, 1, 0}, {0, 0, -0.4f});
  trace(1, SIDERAY_MASK_STENCIL);  // nothing was drawn into it
  expect_all(3, {0, 0, 1});
  const uint32_t other = 77;
  const sideray_instance pane = host.pane();
  host.scene().renumber_instances({&pane, 1}, {&other, 1});
  host.scene().commit();
  trace();
  expect_all(4, {1, 0, 1});
  trace(2);
  expect_all(6, {1, 0, 0}, {0, 0, -0.4f});
}

INSTANTIATE_TEST_SUITE_P(Versions, Misses, testing::Values(120, 130, 450));

}  // namespace
}  // namespace sideray::tests
