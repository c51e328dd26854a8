// A host that sees only a wall at z = 0, parallel to the picture, and covers the picture with its own shader. Test
// support.
#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <optional>
#include <string>

#include "embed/hosts/frame_outputs.h"
#include "embed/hosts/one_pane.h"
#include "gl/context/context.h"
#include "gl/resources/objects.h"
#include "gl/resources/program.h"

namespace sideray::tests {

class WallHost : public testing::Test {
 protected:
  static constexpr int width = 96, height = 64;
  static constexpr uint32_t first_unit = 2;

  // `color` is the picture's format.
  explicit WallHost(GLenum color) : context_(gl::Context::create("auto", "")) {
    context_->make_current();
    const gl::Functions& gl = context_->functions();
    framebuffer_ = gl::Framebuffer(gl), color_ = gl::Renderbuffer(gl), depth_ = gl::Renderbuffer(gl);
    array_ = gl::VertexArray(gl);
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    attach(color_, color, GL_COLOR_ATTACHMENT0);
    attach(depth_, GL_DEPTH24_STENCIL8, GL_DEPTH_STENCIL_ATTACHMENT);
    const glm::dvec4 wall = clip_from_world() * glm::dvec4(0, 0, 0, 1);
    gl.ClearDepth(0.5 + 0.5 * wall.z / wall.w);
    gl.Clear(GL_DEPTH_BUFFER_BIT);
  }

  void TearDown() override {
    service_.reset();
    program_.reset();
    array_ = {};
    framebuffer_.reset(), color_.reset(), depth_.reset();
    EXPECT_TRUE(context_->take_errors().empty());
    context_->release_current();
  }

  void serve(const Tracer& tracer) {
    const sideray_host_gl host{sizeof(host), gl::Context::get_proc_address, context_.get()};
    service_.emplace(Service::create(tracer, host).value());
  }

  // Makes a program that covers the picture; `statement` sets `result`.
  std::unique_ptr<gl::Program> make_program(const std::string& statement) {
    return std::make_unique<gl::Program>(context_->functions(), "host",
                                         "#version 330 core\nvoid main() { gl_Position = vec4(float(gl_VertexID & 1) * 4.0 - 1.0,\n"
                                         "float(gl_VertexID >> 1) * 4.0 - 1.0, 0.0, 1.0); }\n",
                                         std::string("#version 330 core\n") + sideray_glsl(330) + "out vec4 result;\nvoid main() { " + statement + " }\n");
  }

  static glm::dmat4 clip_from_world() { return clip_before_pane(double{width} / height); }

  // Returns a frame without jobs, whose rectangle shows the whole view.
  FrameInputs frame_of(int x, int y, int w, int h) const {
    FrameInputs in;
    set_matrices(in.frame.view, clip_from_world());
    in.frame.source.framebuffer = framebuffer_.id();
    in.frame.source.mask = SIDERAY_MASK_NONE;
    in.frame.source.x = x, in.frame.source.y = y;
    in.frame.source.width = w, in.frame.source.height = h;
    in.layers.reset();
    return in;
  }

  void trace(const FrameInputs& in) {
    sideray_ticket ticket = 0;
    sideray_error error{};
    ASSERT_EQ(submit_frame(service_->get(), in, ticket, &error), SIDERAY_OK) << error.message;
    ASSERT_EQ(sideray_service_wait(service_->get(), ticket, -1, &error), SIDERAY_OK) << error.message;
  }

  void attach(const gl::Renderbuffer& buffer, GLenum format, GLenum attachment) const {
    const gl::Functions& gl = context_->functions();
    gl.BindRenderbuffer(GL_RENDERBUFFER, buffer.id());
    gl.RenderbufferStorage(GL_RENDERBUFFER, format, width, height);
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, buffer.id());
  }

  std::unique_ptr<gl::Context> context_;
  gl::Framebuffer framebuffer_;
  gl::Renderbuffer color_, depth_;
  gl::VertexArray array_;
  std::optional<Service> service_;
  std::unique_ptr<gl::Program> program_;
};

}  // namespace sideray::tests
