// A host with one pane of glass, in a context of either profile, with depth in any place, a program of any GLSL
// version, and its own fallback colour. Test support.
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <functional>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>
#include <optional>
#include <sideray/sideray.hpp>
#include <string>
#include <vector>

#include "embed/hosts/frame_outputs.h"
#include "embed/hosts/one_pane.h"
#include "gl/context/context.h"
#include "gl/resources/objects.h"
#include "gl/resources/program.h"

namespace sideray::tests {

class GlassHost {
 public:
  static constexpr int width = 96, height = 64;
  static constexpr uint32_t glass_id = 5;
  using Picture = std::vector<glm::vec4>;

  using Loader = std::function<sideray_host_gl(gl::Context&)>;

  // `loader` replaces the context's loader for the service.
  explicit GlassHost(gl::Profile profile = gl::Profile::core, const Loader& loader = {})
      : context_(gl::Context::create("auto", "", profile)), gl(context_->functions()) {
    context_->make_current();
    color_ = gl::Renderbuffer(gl), framebuffer_ = gl::Framebuffer(gl);
    gl.BindRenderbuffer(GL_RENDERBUFFER, color_.id());
    gl.RenderbufferStorage(GL_RENDERBUFFER, GL_RGBA32F, width, height);
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, color_.id());
    create_scene();
    create_quad();
    tracer_.emplace(sideray::Tracer::create(*scene_).value());
    const sideray_host_gl host =
        loader ? loader(*context_) : sideray_host_gl{sizeof(host), gl::Context::get_proc_address, context_.get()};
    service_.emplace(sideray::Service::create(*tracer_, host).value());
  }
  ~GlassHost() {
    service_.reset();
    buffer_.reset(), array_.reset(), color_.reset(), framebuffer_.reset();
    for (const std::string& error : context_->take_errors()) ADD_FAILURE() << error;
    context_->release_current();
  }

  // Binds the framebuffer, attaches `depth` and clears it: the content of a new renderbuffer is undefined, and on
  // NVIDIA its stencil marks pixels.
  void attach(const gl::Renderbuffer& depth) const {
    gl.BindRenderbuffer(GL_RENDERBUFFER, depth.id());
    gl.RenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH24_STENCIL8, width, height);
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, depth.id());
    gl.ClearDepth(1.0);
    gl.ClearStencil(0);
    gl.Clear(GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
  }

  static glm::dmat4 clip_from_world(double eye_x = 0) { return clip_before_pane(double{width} / height, eye_x); }

  // Returns inputs that trace all of the pane, whatever the mask.
  FrameInputs inputs() const {
    FrameInputs in;
    set_view(in, clip_from_world());
    in.frame.source.framebuffer = framebuffer_.id();
    in.frame.source.width = width;
    in.frame.source.height = height;
    in.layers->max_layers = 1;
    in.frame.source.mask = SIDERAY_MASK_NONE;
    return in;
  }
  static void set_view(FrameInputs& in, const glm::dmat4& clip) { set_matrices(in.frame.view, clip); }

  void trace(const FrameInputs& in) {
    sideray_error error{};
    sideray_ticket ticket = 0;
    ASSERT_EQ(submit_frame(service_->get(), in, ticket, &error), SIDERAY_OK) << error.message;
    ASSERT_EQ(sideray_service_wait(service_->get(), ticket, -1, &error), SIDERAY_OK) << error.message;
  }

  // Returns a program. `answer` is the expression of its colour, of `world`, `id` and, where the pane has moved,
  // `before`; `functions` are those that it calls.
  gl::Program program(int version, const std::string& answer, const std::string& functions = "",
                      const std::vector<std::string>& defines = {}) const {
    const bool old = version < 130;
    const std::string head = "#version " + std::to_string(version) + "\n", in = old ? "attribute" : "in";
    const std::string vertex = head + in + " vec3 position;\nuniform mat4 clip_from_world;\nuniform vec3 offset;\n" +
                               (old ? "varying" : "out") + " vec3 world, before;\n" +
                               "void main() { before = position; world = position + offset; "
                               "gl_Position = clip_from_world * vec4(world, 1.0); }\n";
    const std::string fragment = head + sideray_glsl(version) + (old ? "varying" : "in") + " vec3 world, before;\n" +
                                 (old ? "" : "out vec4 result;\n") + "uniform " + (old ? "float" : "uint") +
                                 " id;\n" + functions + "void main() { " + (old ? "gl_FragColor" : "result") + " = vec4(" + answer +
                                 ", 1.0); }\n";
    return gl::Program(gl, "glass of GLSL " + std::to_string(version), vertex, fragment, defines);
  }

  Picture draw(const gl::Program& p, int version, const glm::dmat4& clip = clip_from_world(),
               glm::vec3 offset = glm::vec3(0)) {
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    gl.Viewport(0, 0, width, height);
    gl.Disable(GL_DEPTH_TEST);
    gl.ClearColor(0, 0, 0, 0);
    gl.Clear(GL_COLOR_BUFFER_BIT);
    EXPECT_EQ(sideray_service_bind(service_->get(), 0, p.id(), 1, nullptr), SIDERAY_OK);
    p.use();
    const glm::mat4 matrix(clip);
    gl.UniformMatrix4fv(gl.GetUniformLocation(p.id(), "clip_from_world"), 1, GL_FALSE, glm::value_ptr(matrix));
    gl.Uniform3fv(gl.GetUniformLocation(p.id(), "offset"), 1, glm::value_ptr(offset));
    const GLint id = gl.GetUniformLocation(p.id(), "id");
    if (version < 130)
      gl.Uniform1f(id, float{glass_id});
    else
      gl.Uniform1ui(id, glass_id);
    draw_pane(p);
    gl.UseProgram(0);
    Picture picture(size_t{width} * height);
    gl.ReadPixels(0, 0, width, height, GL_RGBA, GL_FLOAT, picture.data());
    return picture;
  }

  // Draws the pane with a program that is in use.
  void draw_pane(const gl::Program& p) const {
    gl.BindVertexArray(array_.id());
    const auto place = gl.GetAttribLocation(p.id(), "position");
    gl.BindBuffer(GL_ARRAY_BUFFER, buffer_.id());
    gl.VertexAttribPointer(static_cast<GLuint>(place), 3, GL_FLOAT, GL_FALSE, 0, nullptr);
    gl.EnableVertexAttribArray(static_cast<GLuint>(place));
    gl.DrawArrays(GL_TRIANGLES, 0, 6);
    gl.DisableVertexAttribArray(static_cast<GLuint>(place));
    gl.BindVertexArray(0);
  }

  gl::Context& context() { return *context_; }
  // Adds a pane nearer to the eye.
  void add_pane(uint32_t surface_id) {
    sideray_instance_desc instance = pane_desc_;
    instance.surface_id = surface_id;
    instance.world_from_object[11] = 0.5;
    scene_->add_instances({&instance, 1});
    scene_->commit();
  }
  // Makes the pane refract, in front of a wall that emits as the pane did.
  void bend_light() {
    sideray_material_desc glass = sideray_material_defaults();
    glass.transmission = 1.0f, glass.thickness = 0.1f, glass.roughness = 0.0f;
    glass.double_sided = 1;
    scene_->replace_material(pane_desc_.material, glass);
    sideray_material_desc shining = sideray_material_defaults();
    shining.emissive[0] = 0.25f, shining.emissive[1] = 0.5f;
    shining.double_sided = 1;
    sideray_instance_desc wall = pane_desc_;
    wall.material = scene_->add_material(shining);
    wall.surface_id = glass_id + 1;
    for (int i : {0, 4, 8}) wall.world_from_object[i] = 20.0;
    wall.world_from_object[11] = -2.0;
    scene_->add_instances({&wall, 1});
    scene_->commit();
  }
  uint32_t framebuffer() const { return framebuffer_.id(); }
  sideray::Service& service() { return *service_; }
  sideray::Tracer& tracer() { return *tracer_; }
  sideray::Scene& scene() { return *scene_; }
  sideray_instance pane() const { return pane_; }
  const sideray_instance_desc& pane_desc() const { return pane_desc_; }

 private:
  static constexpr float corners[18] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, -1, 0, 1, 1, 0, -1, 1, 0};

  // The pane is emissive, so that lights and shadows change nothing.
  void create_scene() {
    scene_.emplace(sideray::Scene::create().value());
    sideray_mesh_desc mesh = sideray_mesh_defaults();
    mesh.vertex_count = 6;
    mesh.positions.data = corners;
    sideray_material_desc material = sideray_material_defaults();
    material.alpha_mode = SIDERAY_BLEND;
    material.base_color[3] = 0.5f;
    material.emissive[0] = 0.25f, material.emissive[1] = 0.5f;
    material.double_sided = 1;
    sideray_instance_desc& instance = pane_desc_;
    instance.mesh = scene_->add_mesh(mesh);
    instance.material = scene_->add_material(material);
    for (int i : {0, 4, 8}) instance.world_from_object[i] = 1.0;
    instance.surface_id = glass_id;
    instance.visibility = SIDERAY_VISIBLE_ALL;
    pane_ = scene_->add_instances({&instance, 1}).front();
    scene_->commit();
  }
  void create_quad() {
    array_ = gl::VertexArray(gl), buffer_ = gl::Buffer(gl);
    gl.BindBuffer(GL_ARRAY_BUFFER, buffer_.id());
    gl.BufferData(GL_ARRAY_BUFFER, sizeof(corners), corners, GL_STATIC_DRAW);
  }

  std::unique_ptr<gl::Context> context_;

 public:
  const gl::Functions& gl;

 private:
  gl::Framebuffer framebuffer_;
  gl::Renderbuffer color_;
  gl::VertexArray array_;
  gl::Buffer buffer_;
  std::optional<sideray::Scene> scene_;
  sideray_instance_desc pane_desc_{};
  sideray_instance pane_ = 0;
  std::optional<sideray::Tracer> tracer_;
  std::optional<sideray::Service> service_;
};

}  // namespace sideray::tests
