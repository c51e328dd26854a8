// Tests the ready programs for hosts without shaders: they draw the fixed function's picture with the service's
// answers.
#include <gmock/gmock.h>

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_access.hpp>

#include "embed/hosts/glass_host.h"

namespace sideray::tests {
namespace {

// A host that draws its pane as in OpenGL 1.1: matrices, a light, a material, a texture.
class OldHost : public testing::Test {
 protected:
  OldHost() : gl(host.gl), depth_(gl), texture_(gl) {
    host.attach(depth_);
    const uint8_t texels[16] = {255, 255, 255, 255, 128, 128, 255, 255, 255, 64, 64, 255, 0, 255, 0, 128};
    gl.BindTexture(GL_TEXTURE_2D, texture_.id());
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, 2, 2, 0, GL_RGBA, GL_UNSIGNED_BYTE, texels);
    gl.MatrixMode(GL_PROJECTION);
    gl.LoadMatrixd(glm::value_ptr(glm::perspective(0.9, double{GlassHost::width} / GlassHost::height, 0.1, 50.0)));
    gl.MatrixMode(GL_MODELVIEW);
    gl.LoadMatrixd(glm::value_ptr(eye_from_world));
  }

  void light(glm::vec4 place = {1.0f, 2.0f, 2.0f, 1.0f}) const {
    const float at[] = {place.x, place.y, place.z, place.w}, color[] = {0.9f, 0.8f, 0.6f, 1.0f}, dim[] = {0.2f, 0.1f, 0.1f, 1.0f};
    const float glass[] = {0.4f, 0.6f, 0.5f, 0.5f}, gleam[] = {0.7f, 0.7f, 0.7f, 1.0f};
    gl.Enable(GL_LIGHTING);
    gl.Enable(GL_LIGHT0);
    gl.Lightfv(GL_LIGHT0, GL_POSITION, at);
    gl.Lightfv(GL_LIGHT0, GL_DIFFUSE, color);
    gl.Lightfv(GL_LIGHT0, GL_SPECULAR, color);
    gl.Lightfv(GL_LIGHT0, GL_AMBIENT, dim);
    gl.Lightf(GL_LIGHT0, GL_LINEAR_ATTENUATION, 0.2f);
    gl.Materialfv(GL_FRONT_AND_BACK, GL_AMBIENT_AND_DIFFUSE, glass);
    gl.Materialfv(GL_FRONT_AND_BACK, GL_SPECULAR, gleam);
    gl.Materialf(GL_FRONT_AND_BACK, GL_SHININESS, 12.0f);
  }

  // Sets which material colours follow glColor.
  void follow_colors(GLenum mode) {
    gl.ColorMaterial(GL_FRONT_AND_BACK, mode);
    gl.Enable(GL_COLOR_MATERIAL);
    colored_ = true;
  }
  // Generates world positions as texture coordinates of unit 7, as in docs/fixed-function.md.
  void generate_positions() const {
    gl.ActiveTexture(GL_TEXTURE7);
    gl.PushMatrix();
    gl.LoadMatrixd(glm::value_ptr(eye_from_world));
    const float planes[3][4] = {{1, 0, 0, 0}, {0, 1, 0, 0}, {0, 0, 1, 0}};
    const GLenum coordinates[] = {GL_S, GL_T, GL_R};
    const GLenum modes[] = {GL_TEXTURE_GEN_S, GL_TEXTURE_GEN_T, GL_TEXTURE_GEN_R};
    for (int i = 0; i < 3; ++i) {
      gl.TexGeni(coordinates[i], GL_TEXTURE_GEN_MODE, GL_EYE_LINEAR);
      gl.TexGenfv(coordinates[i], GL_EYE_PLANE, planes[i]);
      gl.Enable(modes[i]);
    }
    gl.PopMatrix();
    gl.ActiveTexture(GL_TEXTURE0);
  }
  // Does the same by the object's world matrix, independent of MODELVIEW.
  void generate_positions_of(const glm::dmat4& world_from_object) const {
    gl.ActiveTexture(GL_TEXTURE7);
    for (int i = 0; i < 3; ++i) {
      const glm::vec4 row(glm::row(world_from_object, i));
      gl.TexGeni(GL_S + static_cast<GLenum>(i), GL_TEXTURE_GEN_MODE, GL_OBJECT_LINEAR);
      gl.TexGenfv(GL_S + static_cast<GLenum>(i), GL_OBJECT_PLANE, glm::value_ptr(row));
      gl.Enable(GL_TEXTURE_GEN_S + static_cast<GLenum>(i));
    }
    gl.ActiveTexture(GL_TEXTURE0);
  }
  // A program without a vertex shader.
  uint32_t fragment_alone(float surface) const {
    const GLuint shader = gl.CreateShader(GL_FRAGMENT_SHADER), program = gl.CreateProgram();
    const char* const text = sideray_ready_fragment(SIDERAY_READY_GLASS_FRAGMENT);
    gl.ShaderSource(shader, 1, &text, nullptr);
    gl.CompileShader(shader);
    gl.AttachShader(program, shader);
    gl.LinkProgram(program);
    gl.DeleteShader(shader);
    GLint linked = 0;
    gl.GetProgramiv(program, GL_LINK_STATUS, &linked);
    EXPECT_EQ(linked, GL_TRUE);
    gl.UseProgram(program);
    gl.Uniform1i(gl.GetUniformLocation(program, "sideray_textured"), 1);
    gl.Uniform1f(gl.GetUniformLocation(program, "sideray_surface"), surface);
    gl.UseProgram(0);
    return program;
  }
  void expect_same(const GlassHost::Picture& ready, const GlassHost::Picture& fixed) const {
    size_t drawn = 0;
    for (size_t i = 0; i < fixed.size(); ++i) {
      drawn += fixed[i].w > 0;
      for (int c = 0; c < 4; ++c) ASSERT_NEAR(ready[i][c], std::min(fixed[i][c], 1.0f), 2.0f / 255) << i << " " << c;
    }
    EXPECT_GT(drawn, 1000u);
  }

  GlassHost::Picture draw(uint32_t program) const {
    gl.BindFramebuffer(GL_FRAMEBUFFER, host.framebuffer());
    gl.Viewport(0, 0, GlassHost::width, GlassHost::height);
    gl.Disable(GL_DEPTH_TEST);
    gl.ClearColor(0, 0, 0, 0);
    gl.Clear(GL_COLOR_BUFFER_BIT);
    gl.UseProgram(program);
    gl.ActiveTexture(GL_TEXTURE0);
    gl.BindTexture(GL_TEXTURE_2D, texture_.id());
    if (program == 0) gl.Enable(GL_TEXTURE_2D);
    gl.Begin(GL_QUADS);
    gl.Normal3f(0, 0, 1);
    const float corners[4][2] = {{-1, -1}, {1, -1}, {1, 1}, {-1, 1}};
    for (const auto& c : corners) {
      if (colored_) gl.Color4f(0.2f, 0.7f + 0.1f * c[0], 0.3f, 0.4f);
      gl.TexCoord2f(c[0] * 0.5f + 0.5f, c[1] * 0.5f + 0.5f);
      gl.Vertex3f(c[0], c[1], 0);
    }
    gl.End();
    gl.Disable(GL_TEXTURE_2D);
    gl.UseProgram(0);
    GlassHost::Picture picture(size_t{GlassHost::width} * GlassHost::height);
    gl.ReadPixels(0, 0, GlassHost::width, GlassHost::height, GL_RGBA, GL_FLOAT, picture.data());
    return picture;
  }

  gl::Program glass(float surface) const {
    gl::Program program(gl, "ready glass", sideray_ready_vertex(SIDERAY_READY_GLASS),
                        sideray_ready_fragment(SIDERAY_READY_GLASS));
    program.use();
    const auto place = [&](const char* name) { return gl.GetUniformLocation(program.id(), name); };
    const glm::mat4 world_from_eye(glm::inverse(eye_from_world));
    gl.UniformMatrix4fv(place("sideray_world_from_eye"), 1, GL_FALSE, glm::value_ptr(world_from_eye));
    gl.Uniform1i(place("sideray_lights"), 1);
    gl.Uniform1i(place("sideray_textured"), 1);
    gl.Uniform1f(place("sideray_surface"), surface);
    gl.UseProgram(0);
    return program;
  }

  GlassHost host{gl::Profile::compatibility};
  const gl::Functions& gl;
  const glm::dmat4 eye_from_world = glm::translate(glm::dmat4(1.0), glm::dvec3(0, 0, -3));

 private:
  gl::Renderbuffer depth_;
  gl::Texture texture_;
  bool colored_ = false;
};

TEST_F(OldHost, GlassWithoutAnswersIsThatOfTheFixedFunction) {
  light();
  const GlassHost::Picture fixed = draw(0);
  const gl::Program program = glass(0.0f);
  ASSERT_EQ(sideray_service_bind(host.service().get(), 0, program.id(), 1, nullptr), SIDERAY_OK);
  const GlassHost::Picture ready = draw(program.id());
  size_t drawn = 0;
  for (size_t i = 0; i < fixed.size(); ++i) {
    drawn += fixed[i].w > 0;
    for (int c = 0; c < 4; ++c) ASSERT_NEAR(ready[i][c], fixed[i][c], 2.0f / 255) << i << " " << c;
  }
  EXPECT_GT(drawn, 1000u);
}

// A light's position is homogeneous, and a directional light has no attenuation.
TEST_F(OldHost, LightsAreWhereTheFixedFunctionHasThem) {
  gl.Lightf(GL_LIGHT0, GL_CONSTANT_ATTENUATION, 1.5f);
  const gl::Program program = glass(0.0f);
  ASSERT_EQ(sideray_service_bind(host.service().get(), 0, program.id(), 1, nullptr), SIDERAY_OK);
  for (const glm::vec4 place : {glm::vec4(0.5f, 1, 1, 0.5f), glm::vec4(3, 6, 6, 3), glm::vec4(1, 2, 2, 0)}) {
    light(place);
    const GlassHost::Picture fixed = draw(0), ready = draw(program.id());
    size_t lit = 0;
    for (size_t i = 0; i < fixed.size(); ++i) {
      lit += fixed[i].x > 0.2f;
      for (int c = 0; c < 4; ++c) ASSERT_NEAR(ready[i][c], fixed[i][c], 2.0f / 255) << "w " << place.w << ", " << i << " " << c;
    }
    EXPECT_GT(lit, 500u) << "w " << place.w;
  }
}

TEST_F(OldHost, GlassFollowsColors) {
  const gl::Program program = glass(0.0f);
  ASSERT_EQ(sideray_service_bind(host.service().get(), 0, program.id(), 1, nullptr), SIDERAY_OK);
  const std::pair<GLenum, GLint> ways[] = {{GL_DIFFUSE, SIDERAY_FOLLOW_DIFFUSE},
                                           {GL_AMBIENT, SIDERAY_FOLLOW_AMBIENT},
                                           {GL_AMBIENT_AND_DIFFUSE, SIDERAY_FOLLOW_AMBIENT_AND_DIFFUSE},
                                           {GL_SPECULAR, SIDERAY_FOLLOW_SPECULAR},
                                           {GL_EMISSION, SIDERAY_FOLLOW_EMISSION}};
  for (const auto& [mode, bits] : ways) {
    light();
    const float black[] = {0, 0, 0, 1};
    gl.Materialfv(GL_FRONT_AND_BACK, GL_EMISSION, black);
    follow_colors(mode);
    const GlassHost::Picture fixed = draw(0);
    program.use();
    gl.Uniform1i(gl.GetUniformLocation(program.id(), "sideray_follows_color"), bits);
    SCOPED_TRACE(bits);
    expect_same(draw(program.id()), fixed);
    gl.Disable(GL_COLOR_MATERIAL);
  }
}

TEST_F(OldHost, GlassIsLitBySpots) {
  light({0.5f, 0.5f, 2, 1});
  const float down[] = {-0.2f, -0.2f, -1};
  gl.Lightfv(GL_LIGHT0, GL_SPOT_DIRECTION, down);
  gl.Lightf(GL_LIGHT0, GL_SPOT_CUTOFF, 89);
  gl.Lightf(GL_LIGHT0, GL_SPOT_EXPONENT, 6);
  gl.LightModeli(GL_LIGHT_MODEL_LOCAL_VIEWER, 1);
  const gl::Program program = glass(0.0f);
  program.use();
  gl.Uniform1i(gl.GetUniformLocation(program.id(), "sideray_local_viewer"), 1);
  ASSERT_EQ(sideray_service_bind(host.service().get(), 0, program.id(), 1, nullptr), SIDERAY_OK);
  const GlassHost::Picture fixed = draw(0);
  expect_same(draw(program.id()), fixed);
}

TEST_F(OldHost, AFragmentShaderAloneKeepsTheFixedFunction) {
  light();
  follow_colors(GL_DIFFUSE);
  generate_positions();
  const GlassHost::Picture fixed = draw(0);
  const uint32_t without = fragment_alone(0.0f);
  ASSERT_EQ(sideray_service_bind(host.service().get(), 0, without, 1, nullptr), SIDERAY_OK);
  expect_same(draw(without), fixed);
  FrameInputs in = host.inputs();
  in.layers->float_ids = 1;
  host.trace(in);
  const uint32_t with = fragment_alone(float{GlassHost::glass_id});
  ASSERT_EQ(sideray_service_bind(host.service().get(), 0, with, 1, nullptr), SIDERAY_OK);
  const GlassHost::Picture ready = draw(with);
  for (size_t i = 0; i < fixed.size(); ++i) {
    if (fixed[i].w == 0) continue;
    ASSERT_NEAR(ready[i].x, 0.25f, 1.0f / 255) << "the pane glows";
    ASSERT_NEAR(ready[i].y, 0.5f, 1.0f / 255);
    ASSERT_NEAR(ready[i].w, fixed[i].w, 1.0f / 255);
  }
  gl.DeleteProgram(without), gl.DeleteProgram(with);
}

// The refracted view replaces the picture: the wall behind the pane emits 0.25 and 0.5, most of which passes the glass.
TEST_F(OldHost, BentGlassReplacesWhatIsBehindIt) {
  light();
  generate_positions();
  host.bend_light();
  FrameInputs in = host.inputs();
  in.layers->float_ids = in.layers->refraction = 1;
  host.trace(in);
  const GlassHost::Picture fixed = draw(0);
  const uint32_t alone = fragment_alone(float{GlassHost::glass_id}), unnamed = fragment_alone(0.0f);
  const gl::Program whole = glass(float{GlassHost::glass_id});
  for (const uint32_t program : {alone, whole.id(), unnamed})
    ASSERT_EQ(sideray_service_bind(host.service().get(), 0, program, 1, nullptr), SIDERAY_OK);
  const GlassHost::Picture of_alone = draw(alone), of_whole = draw(whole.id());
  size_t bent = 0;
  for (size_t i = 0; i < fixed.size(); ++i) {
    if (fixed[i].w == 0) continue;
    ++bent;
    for (const glm::vec4& shown : {of_alone[i], of_whole[i]}) {
      ASSERT_NEAR(shown.x, 0.24f, 0.02f) << i;
      ASSERT_NEAR(shown.y, 0.48f, 0.03f);
      ASSERT_EQ(shown.w, 1.0f);
    }
  }
  EXPECT_GT(bent, 1000u);
  // Fragments without an id behind it, such as smoke, are not drawn.
  gl.LoadMatrixd(glm::value_ptr(glm::translate(eye_from_world, {0, 0, -1})));
  const GlassHost::Picture behind = draw(0), hidden = draw(unnamed);
  size_t covered = 0;
  for (size_t i = 0; i < fixed.size(); ++i) {
    if (fixed[i].w == 0 || behind[i].w == 0) continue;
    ++covered;
    ASSERT_EQ(hidden[i].w, 0.0f) << i;
  }
  EXPECT_GT(covered, 500u);
  gl.DeleteProgram(alone), gl.DeleteProgram(unnamed);
}

// Tests the way of docs/fixed-function.md for engines whose MODELVIEW is never the view alone. The pane is turned by a
// right angle and moved within its plane.
TEST_F(OldHost, PlacesComeFromTheObjectsMatrixToo) {
  FrameInputs in = host.inputs();
  in.layers->float_ids = 1;
  host.trace(in);
  const uint32_t program = fragment_alone(float{GlassHost::glass_id});
  ASSERT_EQ(sideray_service_bind(host.service().get(), 0, program, 1, nullptr), SIDERAY_OK);
  const GlassHost::Picture pane = draw(0);
  const glm::dmat4 world_from_object = glm::rotate(glm::translate(glm::dmat4(1.0), {0.5, 0.25, 0}), glm::half_pi<double>(), {0, 0, 1});
  generate_positions_of(world_from_object);
  gl.LoadMatrixd(glm::value_ptr(eye_from_world * world_from_object));
  const GlassHost::Picture moved = draw(0), ready = draw(program);
  size_t glowing = 0;
  for (size_t i = 0; i < pane.size(); ++i) {
    if (pane[i].w == 0 || moved[i].w == 0) continue;
    ++glowing;
    ASSERT_NEAR(ready[i].x, 0.25f, 1.0f / 255) << i;
    ASSERT_NEAR(ready[i].y, 0.5f, 1.0f / 255);
  }
  EXPECT_GT(glowing, 500u);
  gl.DeleteProgram(program);
}

// Ids of another type would be read as 0, without an OpenGL error, and no fragment would find its id.
TEST_F(OldHost, BindRefusesIdsOfAnotherType) {
  sideray_error error{};
  host.trace(host.inputs());  // integers
  const gl::Program old = glass(float{GlassHost::glass_id});
  EXPECT_EQ(sideray_service_bind(host.service().get(), 0, old.id(), 1, &error), SIDERAY_INVALID_ARGUMENT);
  EXPECT_THAT(error.message, testing::HasSubstr("reads floats (GLSL 1.20), and the newest layers hold integers: set float_ids"));
  const gl::Program young = host.program(330, "sideray_translucent(vec3(0.0), world, id)");
  EXPECT_EQ(sideray_service_bind(host.service().get(), 0, young.id(), 1, &error), SIDERAY_OK);
  FrameInputs in = host.inputs();
  in.layers->float_ids = 1;
  host.trace(in);
  EXPECT_EQ(sideray_service_bind(host.service().get(), 0, old.id(), 1, &error), SIDERAY_OK);
  EXPECT_EQ(sideray_service_bind(host.service().get(), 0, young.id(), 1, &error), SIDERAY_INVALID_ARGUMENT);
  EXPECT_THAT(error.message, testing::HasSubstr("leave float_ids of the layer inputs 0"));
}

TEST_F(OldHost, GlassTakesItsAnswers) {
  light();
  FrameInputs in = host.inputs();
  in.layers->float_ids = 1;
  host.trace(in);
  const GlassHost::Picture fixed = draw(0);
  const gl::Program program = glass(float{GlassHost::glass_id});
  ASSERT_EQ(sideray_service_bind(host.service().get(), 0, program.id(), 1, nullptr), SIDERAY_OK);
  const GlassHost::Picture ready = draw(program.id());
  for (size_t i = 0; i < fixed.size(); ++i) {
    if (fixed[i].w == 0) continue;
    ASSERT_GE(ready[i].y, 0.49f) << "the pane glows with 0.5";
    ASSERT_NEAR(ready[i].w, fixed[i].w, 2.0f / 255);
  }
}

TEST_F(OldHost, ShadowsMultiplyThePicture) {
  FrameInputs in = host.inputs();
  in.layers.reset();
  in.masks = sideray_mask_inputs_defaults();
  in.masks->ao_rays = 1;
  host.trace(in);
  const gl::Program program(gl, "ready shadows", sideray_ready_vertex(SIDERAY_READY_SHADOWS),
                            sideray_ready_fragment(SIDERAY_READY_SHADOWS));
  ASSERT_EQ(sideray_service_bind(host.service().get(), 0, program.id(), 1, nullptr), SIDERAY_OK);
  gl.BindFramebuffer(GL_FRAMEBUFFER, host.framebuffer());
  gl.Viewport(0, 0, GlassHost::width, GlassHost::height);
  gl.ClearColor(0.5f, 0.25f, 1.0f, 1.0f);
  gl.Clear(GL_COLOR_BUFFER_BIT);
  gl.Enable(GL_BLEND);
  gl.BlendFunc(GL_DST_COLOR, GL_ZERO);
  gl.Disable(GL_DEPTH_TEST);
  program.use();
  gl.Rectf(-1, -1, 1, 1);
  gl.UseProgram(0);
  gl.Disable(GL_BLEND);
  GlassHost::Picture picture(size_t{GlassHost::width} * GlassHost::height);
  gl.ReadPixels(0, 0, GlassHost::width, GlassHost::height, GL_RGBA, GL_FLOAT, picture.data());
  // No light has a mask, and nothing occludes the sky: the picture stays.
  EXPECT_THAT(picture, testing::Each(glm::vec4(0.5f, 0.25f, 1.0f, 1.0f)));
}

TEST(ReadyPrograms, AreOfTheOldestGlslThatThereIs) {
  for (const char* text : {sideray_ready_vertex(SIDERAY_READY_GLASS), sideray_ready_fragment(SIDERAY_READY_GLASS),
                           sideray_ready_vertex(SIDERAY_READY_SHADOWS), sideray_ready_fragment(SIDERAY_READY_SHADOWS),
                           sideray_ready_fragment(SIDERAY_READY_GLASS_FRAGMENT)})
    EXPECT_THAT(text, testing::StartsWith("#version 120\n"));
  EXPECT_EQ(sideray_glsl(110), nullptr);
}

}  // namespace
}  // namespace sideray::tests
