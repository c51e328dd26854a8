// What a host's shader reads by sideray_irradiance(): the light that other surfaces throw, as the built-in renderer adds it, and
// black everywhere else.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/packing.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <sideray/sideray.hpp>

#include "embed/hosts/frame_outputs.h"
#include "gl/context/context.h"
#include "gl/resources/objects.h"
#include "gl/resources/program.h"

namespace sideray::tests::snippet_irradiance_test {
namespace {

constexpr int width = 96, height = 64;
constexpr uint32_t first_unit = 2;
constexpr float albedo = 0.5f;
using Picture = std::vector<glm::vec4>;

void add_quad(Scene& scene, const sideray_material_desc& material, glm::vec3 center, glm::vec3 u, glm::vec3 v) {
  const glm::vec3 positions[] = {center - u - v, center + u - v, center + u + v, center - u + v};
  const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
  sideray_mesh_desc mesh = sideray_mesh_defaults();
  mesh.vertex_count = 4;
  mesh.positions.data = &positions[0].x;
  mesh.index_count = 6;
  mesh.indices = indices;
  sideray_instance_desc instance{};
  instance.mesh = scene.add_mesh(mesh);
  instance.material = scene.add_material(material);
  for (const int i : {0, 4, 8}) instance.world_from_object[i] = 1;
  instance.visibility = SIDERAY_VISIBLE_ALL;
  scene.add_instances({&instance, 1});
}

// A matt wall at z = 0 that fills the picture, and a plate that shines red and stands on it, behind the picture's left edge.
Scene wall_and_glow() {
  Scene scene = Scene::create().value();
  sideray_material_desc matt = sideray_material_defaults(), glow = matt;
  matt.double_sided = glow.double_sided = 1;
  matt.metallic = matt.specular = glow.specular = 0;
  matt.roughness = 1;
  for (int c = 0; c < 3; ++c) matt.base_color[c] = albedo, glow.base_color[c] = 0, glow.emissive[c] = c == 0 ? 3.0f : 0.5f;
  add_quad(scene, matt, {0, 0, 0}, {10, 0, 0}, {0, 10, 0});
  add_quad(scene, glow, {-2.4f, 0, 1}, {0, 3, 0}, {0, 0, 1});
  const float black[12] = {};
  scene.set_environment(2, 2, black, 1, 0);
  scene.set_lights({});
  scene.commit();
  return scene;
}

glm::dmat4 clip_from_world() {
  return glm::perspective(0.9, double{width} / height, 0.1, 50.0) * glm::translate(glm::dmat4(1.0), glm::dvec3(0, 0, -3));
}

class SnippetIrradiance : public testing::Test {
 protected:
  void SetUp() override {
    context_ = gl::Context::create("auto", "");
    context_->make_current();
    const gl::Functions& gl = context_->functions();
    framebuffer_ = gl::Framebuffer(gl), color_ = gl::Renderbuffer(gl), depth_ = gl::Renderbuffer(gl);
    array_ = gl::VertexArray(gl);
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    attach(color_, GL_RGBA32F, GL_COLOR_ATTACHMENT0);
    attach(depth_, GL_DEPTH24_STENCIL8, GL_DEPTH_STENCIL_ATTACHMENT);
    // The wall's depth everywhere: it is parallel to the picture.
    const glm::dvec4 clip = clip_from_world() * glm::dvec4(0, 0, 0, 1);
    gl.ClearDepth(0.5 + 0.5 * clip.z / clip.w);
    gl.Clear(GL_DEPTH_BUFFER_BIT);
    const sideray_host_gl host{sizeof(host), gl::Context::get_proc_address, context_.get()};
    service_.emplace(Service::create(tracer_, host).value());
    program_ = std::make_unique<gl::Program>(
        gl, "host",
        "#version 330 core\nvoid main() { gl_Position = vec4(float(gl_VertexID & 1) * 4.0 - 1.0,\n"
        "float(gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0); }\n",
        std::string("#version 330 core\n") + sideray_glsl(330) +
            "out vec4 result;\nvoid main() { result = vec4(0.5 * sideray_irradiance(), 1.0); }\n");
  }

  void TearDown() override {
    service_.reset();
    program_.reset();
    array_ = {};
    framebuffer_.reset(), color_.reset(), depth_.reset();
    EXPECT_TRUE(context_->take_errors().empty());
    context_->release_current();
  }

  void attach(const gl::Renderbuffer& buffer, GLenum format, GLenum attachment) {
    const gl::Functions& gl = context_->functions();
    gl.BindRenderbuffer(GL_RENDERBUFFER, buffer.id());
    gl.RenderbufferStorage(GL_RENDERBUFFER, format, width, height);
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, buffer.id());
  }

  void trace(int x, int y, int w, int h) {
    FrameInputs in;
    const glm::dmat4 clip = clip_from_world(), world = glm::inverse(clip);
    std::memcpy(in.frame.view.clip_from_world, glm::value_ptr(clip), sizeof(in.frame.view.clip_from_world));
    std::memcpy(in.frame.view.world_from_clip, glm::value_ptr(world), sizeof(in.frame.view.world_from_clip));
    in.frame.source.framebuffer = framebuffer_.id();
    in.frame.source.mask = SIDERAY_MASK_NONE;
    in.frame.source.x = x, in.frame.source.y = y;
    in.frame.source.width = w, in.frame.source.height = h;
    in.layers.reset();
    in.irradiance = sideray_irradiance_inputs_defaults();
    sideray_ticket ticket = 0;
    sideray_error error{};
    ASSERT_EQ(submit_frame(service_->get(), in, ticket, &error), SIDERAY_OK) << error.message;
    ASSERT_EQ(sideray_service_wait(service_->get(), ticket, -1, &error), SIDERAY_OK) << error.message;
  }

  // Rows from the bottom.
  Picture draw() {
    const gl::Functions& gl = context_->functions();
    EXPECT_EQ(sideray_service_bind(service_->get(), 0, program_->id(), first_unit, nullptr), SIDERAY_OK);
    program_->use();
    gl.BindVertexArray(array_.id());
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    gl.Viewport(0, 0, width, height);
    gl.Disable(GL_DEPTH_TEST);
    gl.DrawArrays(GL_TRIANGLES, 0, 3);
    Picture picture(size_t{width} * height);
    gl.ReadPixels(0, 0, width, height, GL_RGBA, GL_FLOAT, picture.data());
    return picture;
  }

  std::unique_ptr<gl::Context> context_;
  Scene scene_ = wall_and_glow();
  Tracer tracer_ = Tracer::create(scene_).value();
  gl::Framebuffer framebuffer_;
  gl::Renderbuffer color_, depth_;
  gl::VertexArray array_;
  std::unique_ptr<gl::Program> program_;
  std::optional<Service> service_;
};

TEST_F(SnippetIrradiance, IsTheTexturesInItsRectangleAndBlackElsewhere) {
  for (const glm::vec4& texel : draw()) ASSERT_EQ(glm::vec3(texel), glm::vec3(0.0f)) << "before the first frame";
  constexpr int x0 = 8, y0 = 4, w = 72, h = 48;
  trace(x0, y0, w, h);
  sideray_irradiance_outputs outputs{};
  outputs.size = sizeof(outputs);
  ASSERT_EQ(sideray_service_irradiance(service_->get(), 0, &outputs, nullptr), SIDERAY_OK);
  EXPECT_EQ(glm::ivec4(outputs.x, outputs.y, outputs.width, outputs.height), glm::ivec4(x0, y0, w, h));
  Picture texels(size_t{w} * h);
  const gl::Functions& gl = context_->functions();
  gl.BindTexture(GL_TEXTURE_2D, outputs.irradiance_texture);
  gl.GetTexImage(GL_TEXTURE_2D, 0, GL_RGBA, GL_FLOAT, texels.data());
  gl.BindTexture(GL_TEXTURE_2D, 0);
  const Picture picture = draw();
  float most = 0.0f;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const bool inside = x >= x0 && y >= y0 && x < x0 + w && y < y0 + h;
      const glm::vec3 expected = inside ? 0.5f * glm::vec3(texels[static_cast<size_t>((y - y0) * w + x - x0)]) : glm::vec3(0.0f);
      ASSERT_EQ(glm::vec3(picture[static_cast<size_t>(y * width + x)]), expected) << x << ',' << y;
      most = std::max(most, expected.x);
    }
  EXPECT_GT(most, 0.1f);
}

// The wall has no other light, so that the renderer's picture is what the host's shader says.
TEST_F(SnippetIrradiance, IsWhatTheRendererAdds) {
  trace(0, 0, width, height);
  const Picture by_host = draw();
  context_->release_current();
  sideray_camera camera{};
  camera.size = sizeof(camera);
  for (const int i : {0, 4, 8}) camera.world_from_camera[i] = 1;
  camera.world_from_camera[11] = 3;
  camera.yfov = 0.9f;
  camera.z_near = 0.1f;
  RenderOptions options;
  options.picture.width = width, options.picture.height = height;
  options.picture.ambient = SIDERAY_AMBIENT_BOUNCE;
  options.picture.reflections = 0;
  {
    Renderer renderer = Renderer::create(sideray_renderer_defaults()).value();
    const sideray::Picture picture = renderer.render(scene_, camera, options).value();
    double sum = 0.0, difference = 0.0;
    for (size_t i = 0; i < picture.channel_count(); ++i) {
      const sideray_channel channel = picture.channel(i);
      const std::string name = channel.name;
      if (name != "R" && name != "G" && name != "B") continue;
      const int c = name == "R" ? 0 : name == "G" ? 1 : 2;
      const auto* values = static_cast<const float*>(channel.values);
      for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
          const double host = double{by_host[static_cast<size_t>((height - 1 - y) * width + x)][c]};
          sum += host;
          difference += std::abs(host - double{values[y * width + x]});
        }
    }
    EXPECT_GT(sum, 100.0);
    EXPECT_LT(difference, 0.01 * sum);
  }
  context_->make_current();
}

}  // namespace
}  // namespace sideray::tests::snippet_irradiance_test
