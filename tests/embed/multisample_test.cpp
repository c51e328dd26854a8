// Tests glass in multisampled targets: fragments at edges of triangles are shaded outside them, and must still find
// their layers.
#include <gtest/gtest.h>

#include <algorithm>
#include <glm/gtc/constants.hpp>

#include "embed/hosts/glass_host.h"

namespace sideray::tests {
namespace {

struct Solid {
  const char* name;
  std::vector<glm::vec3> corners;  // of triangles, three by three
};

void add_quad(std::vector<glm::vec3>& corners, glm::vec3 a, glm::vec3 b, glm::vec3 c, glm::vec3 d) {
  for (const glm::vec3& p : {a, b, c, a, c, d}) corners.push_back(p);
}

Solid sphere(int slices, int stacks) {
  Solid solid{"sphere", {}};
  const auto at = [&](int i, int j) {
    const float turn = glm::two_pi<float>() * static_cast<float>(i) / static_cast<float>(slices);
    const float polar = glm::pi<float>() * static_cast<float>(j) / static_cast<float>(stacks);
    return glm::vec3(std::sin(polar) * std::cos(turn), std::cos(polar), std::sin(polar) * std::sin(turn));
  };
  for (int j = 0; j < stacks; ++j)
    for (int i = 0; i < slices; ++i) add_quad(solid.corners, at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
  return solid;
}

Solid box(float turn = 0.5f, float tilt = 0.4f) {
  Solid solid{"box", {}};
  const auto turned = [turn, tilt](glm::vec3 p) {
    const glm::mat4 m = glm::rotate(glm::rotate(glm::mat4(1.0f), turn, glm::vec3(0, 1, 0)), tilt, glm::vec3(1, 0, 0));
    return glm::vec3(m * glm::vec4(0.7f * p, 1));
  };
  for (int axis = 0; axis < 3; ++axis)
    for (const float side : {-1.0f, 1.0f}) {
      glm::vec3 u(0), v(0), n(0);
      n[axis] = side, u[(axis + 1) % 3] = 1, v[(axis + 2) % 3] = 1;
      add_quad(solid.corners, turned(n - u - v), turned(n + u - v), turned(n + u + v), turned(n - u + v));
    }
  return solid;
}

// Draws an emissive solid of glass into a target of `samples`; fragments without an answer are blue.
class SampledHost {
 public:
  static constexpr int width = GlassHost::width, height = GlassHost::height;

  SampledHost(const Solid& solid, int samples)
      : gl(host.gl), count_(static_cast<GLsizei>(solid.corners.size())), color_(gl), depth_(gl), framebuffer_(gl), plain_(gl), resolved_(gl), buffer_(gl), array_(gl) {
    storage(color_, GL_RGBA16F, samples), storage(depth_, GL_DEPTH24_STENCIL8, samples), storage(plain_, GL_RGBA16F, 0);
    gl.BindFramebuffer(GL_FRAMEBUFFER, resolved_.id());
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, plain_.id());
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, color_.id());
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_STENCIL_ATTACHMENT, GL_RENDERBUFFER, depth_.id());
    gl.BindBuffer(GL_ARRAY_BUFFER, buffer_.id());
    gl.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(solid.corners.size() * sizeof(glm::vec3)),
                  solid.corners.data(), GL_STATIC_DRAW);
    replace_pane(solid);
  }

  static bool supports(int samples) {
    const auto context = gl::Context::create("auto", "");
    context->make_current();
    GLint most = 0;
    context->functions().GetIntegerv(GL_MAX_SAMPLES, &most);
    context->release_current();
    return most >= samples;
  }

  void trace(bool refraction = false) {
    FrameInputs in = host.inputs();
    in.frame.source.framebuffer = framebuffer_.id();
    in.frame.source.mask = SIDERAY_MASK_COUNT;
    in.layers->max_layers = 4;
    in.layers->refraction = refraction;
    begin();
    gl.Enable(GL_STENCIL_TEST);
    gl.StencilFunc(GL_ALWAYS, 0, 0xff);
    gl.StencilOp(GL_KEEP, GL_KEEP, GL_INCR);
    gl.ColorMask(0, 0, 0, 0);
    const gl::Program plain = host.program(330, "vec3(0)");
    draw(plain);
    gl.ColorMask(1, 1, 1, 1);
    gl.Disable(GL_STENCIL_TEST);
    host.trace(in);
  }

  void bend() {
    sideray_material_desc glass = sideray_material_defaults();
    glass.transmission = 1.0f, glass.thickness = 0.1f, glass.roughness = 0.0f;
    glass.double_sided = 1;
    host.scene().replace_material(host.pane_desc().material, glass);
    host.scene().commit();
  }

  struct Counts {
    size_t seen = 0, missed = 0;
  };
  // `aware` says that the snippet is told of the samples.
  Counts count(bool aware, const std::string& answer = "sideray_translucent(vec3(0.0, 0.0, 1.0), world, id)",
               const std::string& functions = "") {
    begin();
    const gl::Program program = host.program(330, answer, functions);
    EXPECT_EQ(sideray_service_bind(host.service().get(), 0, program.id(), 1, nullptr), SIDERAY_OK);
    program.use();
    if (!aware) gl.Uniform1i(gl.GetUniformLocation(program.id(), "sideray_multisampled"), 0);
    draw(program);
    gl.BindFramebuffer(GL_READ_FRAMEBUFFER, framebuffer_.id());
    gl.BindFramebuffer(GL_DRAW_FRAMEBUFFER, resolved_.id());
    gl.BlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
    gl.BindFramebuffer(GL_FRAMEBUFFER, resolved_.id());
    GlassHost::Picture picture(size_t{width} * height);
    gl.ReadPixels(0, 0, width, height, GL_RGBA, GL_FLOAT, picture.data());
    Counts counts;
    for (const glm::vec4& p : picture) counts.seen += p.w > 0, counts.missed += p.z > 0;
    return counts;
  }

 private:
  void storage(const gl::Renderbuffer& buffer, GLenum format, int samples) const {
    gl.BindRenderbuffer(GL_RENDERBUFFER, buffer.id());
    gl.RenderbufferStorageMultisample(GL_RENDERBUFFER, samples, format, width, height);
  }
  void begin() const {
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    gl.Viewport(0, 0, width, height);
    gl.Disable(GL_DEPTH_TEST);
    gl.ClearColor(0, 0, 0, 0);
    gl.ClearDepth(1.0);
    gl.ClearStencil(0);
    gl.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT | GL_STENCIL_BUFFER_BIT);
  }
  void draw(const gl::Program& program) const {
    program.use();
    const glm::mat4 clip(GlassHost::clip_from_world());
    gl.UniformMatrix4fv(gl.GetUniformLocation(program.id(), "clip_from_world"), 1, GL_FALSE, glm::value_ptr(clip));
    gl.Uniform1ui(gl.GetUniformLocation(program.id(), "id"), GlassHost::glass_id);
    gl.BindVertexArray(array_.id());
    gl.BindBuffer(GL_ARRAY_BUFFER, buffer_.id());
    const auto place = static_cast<GLuint>(gl.GetAttribLocation(program.id(), "position"));
    gl.VertexAttribPointer(place, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
    gl.EnableVertexAttribArray(place);
    gl.DrawArrays(GL_TRIANGLES, 0, count_);
    gl.DisableVertexAttribArray(place);
    gl.BindVertexArray(0);
    gl.UseProgram(0);
  }
  void replace_pane(const Solid& solid) {
    sideray_mesh_desc mesh = sideray_mesh_defaults();
    mesh.vertex_count = static_cast<uint32_t>(solid.corners.size());
    mesh.positions.data = &solid.corners[0].x;
    sideray_instance_desc instance = host.pane_desc();
    instance.mesh = host.scene().add_mesh(mesh);
    const sideray_instance pane = host.pane();
    host.scene().replace_instances({&pane, 1}, {&instance, 1});
    host.scene().commit();
  }

  GlassHost host;

 public:
  const gl::Functions& gl;

 private:
  GLsizei count_;
  gl::Renderbuffer color_, depth_;
  gl::Framebuffer framebuffer_;
  gl::Renderbuffer plain_;
  gl::Framebuffer resolved_;
  gl::Buffer buffer_;
  gl::VertexArray array_;
};

// Blue: a fragment has no answer.
const std::string look_through =
    "vec3 look(vec3 at, SIDERAY_UINT surface) {\n"
    "  vec3 radiance;\n"
    "  int answer = sideray_look_up(at, surface, radiance);\n"
    "  if (answer == SIDERAY_HIDDEN) discard;\n"
    "  return answer == SIDERAY_NOTHING ? vec3(0.0, 0.0, 1.0) : vec3(radiance.r, 1.0, 0.0);\n"
    "}\n";

class Multisampled : public testing::TestWithParam<int> {};

TEST_P(Multisampled, GlassHasNoWireframe) {
  if (!SampledHost::supports(GetParam())) GTEST_SKIP() << "no " << GetParam() << " samples here";
  for (const Solid& solid : {sphere(28, 20), sphere(12, 8), sphere(64, 48), box()}) {
    SampledHost host(solid, GetParam());
    host.trace();
    const SampledHost::Counts unaware = host.count(false), aware = host.count(true);
    RecordProperty(std::string(solid.name) + std::to_string(solid.corners.size() / 3),
                   std::to_string(unaware.missed) + " of " + std::to_string(aware.seen) + " pixels, without the term");
    EXPECT_GT(aware.seen, 1500u);
    EXPECT_EQ(aware.missed, 0u) << solid.name << " of " << solid.corners.size() / 3 << " triangles";
    if (GetParam() > 1) {
      EXPECT_GT(unaware.missed, aware.seen / 20) << "the term changes nothing";
    } else {
      EXPECT_EQ(unaware.missed, 0u);
    }
  }
}

// Refracting glass covers all of its pixels: its fragments have layers, and its back is hidden.
TEST_P(Multisampled, GlassThatBendsHasNoWireframe) {
  if (!SampledHost::supports(GetParam())) GTEST_SKIP() << "no " << GetParam() << " samples here";
  for (const Solid& solid : {sphere(28, 20), box()}) {
    SampledHost host(solid, GetParam());
    host.bend();
    host.trace(true);
    const SampledHost::Counts counts = host.count(true, "look(world, id)", look_through);
    EXPECT_GT(counts.seen, 1500u);
    EXPECT_EQ(counts.missed, 0u) << solid.name;
  }
}

// At a corner of an outline, only diagonal neighbours may hold the surface that covers a sample.
TEST(MultisampledCorners, HaveTheirLayers) {
  if (!SampledHost::supports(4)) GTEST_SKIP() << "no 4 samples here";
  size_t seen = 0;
  for (int k = 0; k < 24; ++k) {
    const float turn = 0.1f * static_cast<float>(k), tilt = 0.37f * static_cast<float>(k);
    SampledHost host(box(turn, tilt), 4);
    host.trace();
    const SampledHost::Counts straight = host.count(true);
    host.bend();
    host.trace(true);
    const SampledHost::Counts bent = host.count(true, "look(world, id)", look_through);
    EXPECT_EQ(straight.missed, 0u) << turn;
    EXPECT_EQ(bent.missed, 0u) << turn;
    seen += straight.seen;
  }
  EXPECT_GT(seen, 30000u);
}

INSTANTIATE_TEST_SUITE_P(Samples, Multisampled, testing::Values(0, 4, 8));

}  // namespace
}  // namespace sideray::tests
