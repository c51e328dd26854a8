// Tests that a glass ball whose drawn triangles differ from the traced ones keeps its raster look, without answers.
#include <gtest/gtest.h>

#include <glm/gtc/constants.hpp>

#include "embed/hosts/glass_host.h"

namespace sideray::tests::tessellation_test {
namespace {

// Returns corners of the triangles of a ball of radius 1.
std::vector<glm::vec3> ball(int slices, int stacks) {
  std::vector<glm::vec3> corners;
  const auto at = [&](int i, int j) {
    const double turn = glm::two_pi<double>() * (i % slices) / slices, polar = glm::pi<double>() * j / stacks;
    return glm::vec3(std::sin(polar) * std::cos(turn), std::cos(polar), std::sin(polar) * std::sin(turn));
  };
  for (int j = 0; j < stacks; ++j)
    for (int i = 0; i < slices; ++i)
      for (const auto& [a, b] : {std::pair{0, 0}, {0, 1}, {1, 1}, {0, 0}, {1, 1}, {1, 0}})
        corners.push_back(at(i + a, j + b));
  return corners;
}

class Tessellations : public testing::Test {
 protected:
  Tessellations() : gl(host.gl), depth_(gl), array_(gl), buffer_(gl) {
    host.attach(depth_);
  }

  void trace(const std::vector<glm::vec3>& corners) {
    sideray_mesh_desc mesh = sideray_mesh_defaults();
    mesh.vertex_count = static_cast<uint32_t>(corners.size());
    mesh.positions.data = &corners[0].x;
    sideray_instance_desc instance = host.pane_desc();
    instance.mesh = host.scene().add_mesh(mesh);
    const sideray_instance pane = host.pane();
    host.scene().replace_instances({&pane, 1}, {&instance, 1});
    host.scene().commit();
    host.trace(host.inputs());
  }

  // Returns the share of drawn pixels with the ball's emission instead of the fallback's blue.
  double answered(const std::vector<glm::vec3>& corners) {
    gl.BindFramebuffer(GL_FRAMEBUFFER, host.framebuffer());
    gl.Viewport(0, 0, GlassHost::width, GlassHost::height);
    gl.ClearColor(0, 0, 0, 0);
    gl.Clear(GL_COLOR_BUFFER_BIT);
    gl.Disable(GL_DEPTH_TEST);
    gl.Enable(GL_CULL_FACE);
    EXPECT_EQ(sideray_service_bind(host.service().get(), 0, program_.id(), 1, nullptr), SIDERAY_OK);
    program_.use();
    const glm::mat4 clip(GlassHost::clip_from_world());
    gl.UniformMatrix4fv(gl.GetUniformLocation(program_.id(), "clip_from_world"), 1, GL_FALSE, glm::value_ptr(clip));
    gl.Uniform1ui(gl.GetUniformLocation(program_.id(), "id"), GlassHost::glass_id);
    gl.BindVertexArray(array_.id());
    gl.BindBuffer(GL_ARRAY_BUFFER, buffer_.id());
    gl.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(corners.size() * sizeof(glm::vec3)), corners.data(),
                  GL_STATIC_DRAW);
    const auto place = static_cast<GLuint>(gl.GetAttribLocation(program_.id(), "position"));
    gl.VertexAttribPointer(place, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
    gl.EnableVertexAttribArray(place);
    gl.FrontFace(GL_CW);  // ball() winds so, seen from outside
    gl.DrawArrays(GL_TRIANGLES, 0, static_cast<GLsizei>(corners.size()));
    gl.FrontFace(GL_CCW);
    gl.Disable(GL_CULL_FACE);
    gl.BindVertexArray(0);
    gl.UseProgram(0);
    GlassHost::Picture picture(size_t{GlassHost::width} * GlassHost::height);
    gl.ReadPixels(0, 0, GlassHost::width, GlassHost::height, GL_RGBA, GL_FLOAT, picture.data());
    double drawn = 0, own = 0;
    for (const glm::vec4& c : picture) drawn += c.w > 0, own += c.w > 0 && c.y > 0.4f;
    EXPECT_GT(drawn, 500);
    return own / drawn;
  }

  GlassHost host;
  const gl::Functions& gl;

 private:
  gl::Program program_ = host.program(330, "sideray_translucent(vec3(0.0, 0.0, 1.0), world, id)");
  gl::Renderbuffer depth_;
  gl::VertexArray array_;
  gl::Buffer buffer_;
};

TEST_F(Tessellations, OfGlassAreTheSameOrTheRasterLookStays) {
  const std::vector<glm::vec3> drawn = ball(28, 28), finer = ball(64, 64);
  trace(drawn);
  EXPECT_GT(answered(drawn), 0.97);
  trace(finer);
  EXPECT_LT(answered(drawn), 0.1);
  EXPECT_GT(answered(finer), 0.97);
}

}  // namespace
}  // namespace sideray::tests::tessellation_test
