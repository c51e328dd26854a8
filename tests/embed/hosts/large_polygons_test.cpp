// Tests large polygons of glass, seen at grazing angles from near and far. The driver interpolates positions over them
// less exactly than rays compute them, and each fragment must still find its layer.
#include <gtest/gtest.h>

#include "embed/hosts/glass_host.h"

namespace sideray::tests::large_polygons_test {
namespace {

constexpr int width = 640, height = 360;
constexpr uint32_t below_id = GlassHost::glass_id + 1;

// Holds the eye above a floor at y = 0, the floor's size, and the range of the depth buffer.
struct Sight {
  float extent;
  double eye_height, pitch, near, far;
  GLenum depth;
};

class LargePolygons : public testing::Test {
 protected:
  LargePolygons() : gl(host.gl), color_(gl), depth_(gl), framebuffer_(gl), array_(gl), buffer_(gl) {
    gl.BindRenderbuffer(GL_RENDERBUFFER, color_.id());
    gl.RenderbufferStorage(GL_RENDERBUFFER, GL_RGBA32F, width, height);
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, color_.id());
  }

  static std::vector<glm::vec3> floor(float extent, float y) {
    const glm::vec3 a(-extent, y, -extent), b(-extent, y, extent), c(extent, y, extent), d(extent, y, -extent);
    return {a, b, c, a, c, d};
  }
  static glm::dmat4 clip(const Sight& sight) {
    const glm::dmat4 projection = glm::perspective(1.0, double{width} / height, sight.near, sight.far);
    const glm::dmat4 turned = glm::rotate(glm::rotate(glm::dmat4(1.0), sight.pitch, {1, 0, 0}), 0.3, {0, 1, 0});
    return projection * glm::translate(turned, {-0.37, -sight.eye_height, -0.21});
  }

  // Lays the pane at y = 0, and below it a second one, if there is a gap.
  void lay(float extent, float gap = 0) {
    std::vector<sideray_instance_desc> descs;
    for (const float y : gap > 0 ? std::vector<float>{0, -gap} : std::vector<float>{0}) {
      const std::vector<glm::vec3> corners = floor(extent, y);
      sideray_mesh_desc mesh = sideray_mesh_defaults();
      mesh.vertex_count = static_cast<uint32_t>(corners.size());
      mesh.positions.data = &corners[0].x;
      descs.push_back(host.pane_desc());
      descs.back().mesh = host.scene().add_mesh(mesh);
      descs.back().surface_id = y == 0 ? GlassHost::glass_id : below_id;
    }
    const sideray_instance pane = host.pane();
    host.scene().replace_instances({&pane, 1}, {&descs[0], 1});
    host.scene().remove_instances(below_);
    below_ = gap > 0 ? host.scene().add_instances({&descs[1], 1}) : std::vector<sideray_instance>{};
    host.scene().commit();
  }

  // Traces a frame; the depth buffer has an opaque floor at `ground` below the pane.
  void trace(const Sight& sight, float ground, uint32_t layers, sideray_match match) {
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    gl.BindRenderbuffer(GL_RENDERBUFFER, depth_.id());
    gl.RenderbufferStorage(GL_RENDERBUFFER, sight.depth, width, height);
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, depth_.id());
    gl.Viewport(0, 0, width, height);
    gl.ClearDepth(1.0);
    gl.DepthMask(GL_TRUE);
    gl.Clear(GL_DEPTH_BUFFER_BIT);
    gl.Enable(GL_DEPTH_TEST);
    draw(sight, -ground, GlassHost::glass_id);
    gl.DepthMask(GL_FALSE);
    FrameInputs in = host.inputs();
    GlassHost::set_view(in, clip(sight));
    in.frame.source.framebuffer = framebuffer_.id();
    in.frame.source.width = width;
    in.frame.source.height = height;
    in.layers->max_layers = layers;
    in.layers->match = match;
    host.trace(in);
  }

  void draw(const Sight& sight, float y, uint32_t id) {
    ASSERT_EQ(sideray_service_bind(host.service().get(), 0, program_.id(), 1, nullptr), SIDERAY_OK);
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    gl.Viewport(0, 0, width, height);
    gl.ClearColor(0, 0, 0, 0);
    gl.Clear(GL_COLOR_BUFFER_BIT);
    program_.use();
    const glm::mat4 matrix(clip(sight));
    gl.UniformMatrix4fv(gl.GetUniformLocation(program_.id(), "clip_from_world"), 1, GL_FALSE, glm::value_ptr(matrix));
    gl.Uniform1ui(gl.GetUniformLocation(program_.id(), "id"), id);
    const std::vector<glm::vec3> corners = floor(sight.extent, y);
    gl.BindVertexArray(array_.id());
    gl.BindBuffer(GL_ARRAY_BUFFER, buffer_.id());
    gl.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(corners.size() * sizeof(glm::vec3)), corners.data(), GL_STATIC_DRAW);
    const auto place = static_cast<GLuint>(gl.GetAttribLocation(program_.id(), "position"));
    gl.VertexAttribPointer(place, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
    gl.EnableVertexAttribArray(place);
    gl.DrawArrays(GL_TRIANGLES, 0, 6);
    gl.BindVertexArray(0);
    gl.UseProgram(0);
  }

  struct Found {
    size_t drawn = 0, own = 0, other = 0;
  };
  // Counts what fragments of the pane at y find.
  Found count(const Sight& sight, float y, uint32_t id) {
    draw(sight, y, id);
    GlassHost::Picture picture(size_t{width} * height);
    gl.ReadPixels(0, 0, width, height, GL_RGBA, GL_FLOAT, picture.data());
    Found found;
    for (const glm::vec4& c : picture) {
      if (c.w == 0) continue;
      ++found.drawn;
      found.own += c.x == static_cast<float>(id);
      found.other += c.x >= 0 && c.x != static_cast<float>(id);
    }
    return found;
  }

  GlassHost host;
  const gl::Functions& gl;

 private:
  // The id of the layer that the fragment takes, or -1.
  static constexpr const char* functions = R"(
float found_id() {
  int layer = sideray_find_layer(world, id);
  return layer < 0 ? -1.0 : float(texelFetch(sideray_surface_id, ivec3(sideray_pixel(), layer), 0).x);
}
)";
  gl::Program program_ = host.program(330, "vec3(found_id())", functions);
  std::vector<sideray_instance> below_;
  gl::Renderbuffer color_, depth_;
  gl::Framebuffer framebuffer_;
  gl::VertexArray array_;
  gl::Buffer buffer_;
};

TEST_F(LargePolygons, FindTheirLayersNearAndFar) {
  for (const GLenum depth : {GLenum{GL_DEPTH_COMPONENT24}, GLenum{GL_DEPTH_COMPONENT16}})
    for (const float extent : {4.0f, 40.0f, 400.0f, 4000.0f})
      for (const auto& [eye, pitch] : {std::pair{0.1, 0.0}, {0.1, 0.4}, {1.7, 0.4}}) {
        const Sight sight{extent, eye, pitch, 0.05, 5.0 * double{extent}, depth};
        lay(extent);
        trace(sight, 0.02f * static_cast<float>(eye), 1, SIDERAY_MATCH_ID);
        const Found found = count(sight, 0, GlassHost::glass_id);
        SCOPED_TRACE("extent " + std::to_string(extent) + ", eye " + std::to_string(eye) + ", pitch " + std::to_string(pitch));
        EXPECT_GT(found.drawn, 5000u);
        // A ray may miss the triangles, between or beside them, in a pixel that the rasterizer draws.
        EXPECT_LE(found.drawn - found.own, 3u);
      }
}

// The cache holds only the upper pane, so that any layer that a fragment of the lower one takes is wrong.
TEST_F(LargePolygons, OfPanesACentimetreApartNoneTakesTheOther) {
  for (const float extent : {40.0f, 400.0f, 4000.0f})
    for (const double pitch : {0.0, 0.4, 1.2}) {
      const Sight sight{extent, 1.7, pitch, 0.05, 5.0 * double{extent}, GL_DEPTH_COMPONENT24};
      lay(extent, 0.01f);
      trace(sight, 0.1f, 1, SIDERAY_MATCH_NEAREST);
      SCOPED_TRACE("extent " + std::to_string(extent) + ", pitch " + std::to_string(pitch));
      const Found upper = count(sight, 0, GlassHost::glass_id), lower = count(sight, -0.01f, below_id);
      EXPECT_LE(upper.drawn - upper.own, 3u);
      EXPECT_GT(lower.drawn, 5000u);
      EXPECT_LE(lower.own + lower.other, 0u);
    }
}

}  // namespace
}  // namespace sideray::tests::large_polygons_test
