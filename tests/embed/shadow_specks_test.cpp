// Tests shadow masks from depth that a driver drew, not from computed depth, on convex objects and open ground, where
// every point that faces the light is lit. No such pixel may be dark, except the few known ones beside folds.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <glm/gtc/constants.hpp>
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
namespace {

struct Shape {
  std::string name;
  std::vector<glm::vec3> corners;
  std::vector<uint32_t> indices;
  glm::dvec3 eye, target;

  glm::dvec3 normal(uint32_t triangle) const {
    const auto at = [&](uint32_t k) { return glm::dvec3(corners[indices[3 * triangle + k]]); };
    return glm::normalize(glm::cross(at(1) - at(0), at(2) - at(0)));
  }
  void quad(uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
    for (const uint32_t k : {a, b, c, a, c, d}) indices.push_back(k);
  }
  // Adds a plane of cells x cells quads.
  void grid(glm::dvec3 corner, glm::dvec3 u, glm::dvec3 v, uint32_t cells) {
    const auto first = static_cast<uint32_t>(corners.size());
    for (uint32_t j = 0; j <= cells; ++j)
      for (uint32_t i = 0; i <= cells; ++i)
        corners.emplace_back(corner + u * (static_cast<double>(i) / cells) + v * (static_cast<double>(j) / cells));
    for (uint32_t j = 0; j < cells; ++j)
      for (uint32_t i = 0; i < cells; ++i) {
        const uint32_t a = first + j * (cells + 1) + i, b = a + cells + 1;
        quad(a, a + 1, b + 1, b);
      }
  }
};

// Returns a wall at distance `h`, seen at an angle.
Shape wall(double h) {
  Shape s{"wall of 4x4 quads", {}, {}, {0.3 * h, 1.1 * h, 0.2 * h}, {0.1 * h, 0.9 * h, -h}};
  s.grid({-1.5 * h, 0, -0.8 * h}, {3 * h, 0, 0}, {0, 2 * h, 0}, 4);
  return s;
}

Shape ground(double h, uint32_t cells) {
  Shape s{cells == 1 ? "floor of one quad" : "floor of quads", {}, {}, {0.1 * h, h, 0.3 * h}, {0, 0.2 * h, -3 * h}};
  s.grid({-20 * h, 0, 4 * h}, {40 * h, 0, 0}, {0, 0, -40 * h}, cells);
  return s;
}

Shape sphere(double h, uint32_t slices = 28, uint32_t stacks = 20) {
  Shape s{"sphere", {}, {}, {0.2 * h, 0.8 * h, h}, {0, 0.5 * h, 0}};
  for (uint32_t j = 0; j <= stacks; ++j)
    for (uint32_t i = 0; i < slices; ++i) {
      const double polar = glm::pi<double>() * j / stacks, turn = glm::two_pi<double>() * i / slices;
      s.corners.emplace_back(0.4 * h * glm::dvec3(std::sin(polar) * std::cos(turn), std::cos(polar), std::sin(polar) * std::sin(turn)) +
                             glm::dvec3(0, 0.5 * h, 0));
    }
  for (uint32_t j = 0; j < stacks; ++j)
    for (uint32_t i = 0; i < slices; ++i) {
      const uint32_t a = j * slices + i, b = j * slices + (i + 1) % slices, c = b + slices, d = a + slices;
      if (j > 0) for (const uint32_t k : {a, b, c}) s.indices.push_back(k);
      if (j + 1 < stacks) for (const uint32_t k : {a, c, d}) s.indices.push_back(k);
    }
  return s;
}

Shape box(double h) {
  Shape s{"box", {}, {}, {0.5 * h, 0.9 * h, h}, {0, 0.5 * h, 0}};
  const double r = 0.35 * h;
  const glm::dvec3 c(0, 0.5 * h, 0), x(2 * r, 0, 0), y(0, 2 * r, 0), z(0, 0, 2 * r), low = c - 0.5 * (x + y + z);
  s.grid(low + z, x, y, 1), s.grid(low + x, -x, y, 1), s.grid(low + x + z, -z, y, 1);
  s.grid(low, z, y, 1), s.grid(low + y + z, x, -z, 1), s.grid(low, x, z, 1);
  return s;
}

enum class Depth { d16, d24, d24s8, d32f, d32f_s8, d24_to_one, d32f_to_one, reversed_d24, reversed };

struct Format {
  const char* name;
  GLenum internal;
  bool stencil, zero_to_one, reversed;
};
Format format_of(Depth d) {
  switch (d) {
    case Depth::d16: return {"D16", GL_DEPTH_COMPONENT16, false, false, false};
    case Depth::d24: return {"D24", GL_DEPTH_COMPONENT24, false, false, false};
    case Depth::d24s8: return {"D24S8", GL_DEPTH24_STENCIL8, true, false, false};
    case Depth::d32f: return {"D32F", GL_DEPTH_COMPONENT32F, false, false, false};
    case Depth::d32f_s8: return {"D32F_S8", GL_DEPTH32F_STENCIL8, true, false, false};
    case Depth::d24_to_one: return {"D24, 0 to 1", GL_DEPTH_COMPONENT24, false, true, false};
    case Depth::d32f_to_one: return {"D32F, 0 to 1", GL_DEPTH_COMPONENT32F, false, true, false};
    case Depth::reversed_d24: return {"reversed D24", GL_DEPTH_COMPONENT24, false, true, true};
    default: return {"reversed D32F", GL_DEPTH_COMPONENT32F, false, true, true};
  }
}

// Facets within 3 degrees of the light's direction along them are left out: where one meets a facet that faces away,
// depth may give the normal of either, and at most a twentieth of the light is wrong.
constexpr double grazing = 0.05;

// Draws a shape in a depth format and asks for the mask of one directional light.
class SpeckHost {
 public:
  SpeckHost(int w, int h) : width(w), height(h), context_(gl::Context::create("auto", "")), gl(context_->functions()) {
    context_->make_current();
    program_ = gl::Program(gl, "shape",
                           "#version 330\nin vec3 position;\nuniform mat4 clip_from_world;\n"
                           "void main() { gl_Position = clip_from_world * vec4(position, 1.0); }\n",
                           "#version 330\nout uint result;\nvoid main() { result = uint(gl_PrimitiveID) + 1u; }\n");
    array_ = gl::VertexArray(gl), vertices_ = gl::Buffer(gl), indices_ = gl::Buffer(gl);
    color_ = gl::Renderbuffer(gl);
    gl.BindRenderbuffer(GL_RENDERBUFFER, color_.id());
    gl.RenderbufferStorage(GL_RENDERBUFFER, GL_R32UI, width, height);
  }
  ~SpeckHost() {
    color_.reset(), array_.reset(), vertices_.reset(), indices_.reset(), program_ = {};
    for (const std::string& error : context_->take_errors()) ADD_FAILURE() << error;
    context_->release_current();
  }

  bool gl_software() const { return gl.software; }
  bool supports(Depth depth) const { return !format_of(depth).zero_to_one || gl.clip_control; }

  float pushed_back = 0, bias = 0, bias_steps = 0;  // what is drawn, in steps; what is asked for
  std::optional<Shape> traced;                      // if not the drawn shape
  double facing = grazing;                          // cosine from which on a facet counts as lit

  struct Counts {
    size_t lit = 0, dark = 0, shaded = 0;
    double worst_steps = 0;
  };

  Counts count(const Shape& shape, Depth depth, double near, double far, glm::vec3 light) {
    const Format format = format_of(depth);
    const glm::mat4 eye_from_world(glm::lookAt(shape.eye, shape.target, glm::dvec3(0, 1, 0)));
    const double aspect = static_cast<double>(width) / height;
    const glm::mat4 clip_from_eye(format.reversed      ? reversed(0.8, aspect, near)
                                  : format.zero_to_one ? glm::perspectiveRH_ZO(0.8, aspect, near, far)
                                                       : glm::perspective(0.8, aspect, near, far));
    const glm::dmat4 clip = glm::dmat4(clip_from_eye) * glm::dmat4(eye_from_world);
    gl::Renderbuffer stored(gl);
    gl::Framebuffer framebuffer(gl);
    gl.BindRenderbuffer(GL_RENDERBUFFER, stored.id());
    gl.RenderbufferStorage(GL_RENDERBUFFER, format.internal, width, height);
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer.id());
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, color_.id());
    gl.FramebufferRenderbuffer(GL_FRAMEBUFFER, format.stencil ? GL_DEPTH_STENCIL_ATTACHMENT : GL_DEPTH_ATTACHMENT,
                               GL_RENDERBUFFER, stored.id());
    const std::vector<uint32_t> ids = draw(shape, clip_from_eye * eye_from_world, format);
    const std::vector<uint8_t> lit = trace(traced ? *traced : shape, clip, format, framebuffer.id(), light);
    std::vector<float> depths(ids.size());
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer.id());
    gl.ReadPixels(0, 0, width, height, GL_DEPTH_COMPONENT, GL_FLOAT, depths.data());
    Counts counts;
    const glm::dmat4 world = glm::inverse(clip);
    for (size_t i = 0; i < ids.size(); ++i) {
      if (ids[i] == 0) continue;
      const glm::dvec3 normal = shape.normal(ids[i] - 1);
      if (glm::dot(normal, glm::dvec3(light)) >= -facing) {
        ++counts.shaded;
        continue;
      }
      ++counts.lit;
      counts.dark += lit[i] == 0;
      counts.worst_steps = std::max(counts.worst_steps, off(shape, ids[i] - 1, world, clip, format, i, depths[i]));
    }
    gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
    return counts;
  }

 private:
  int width, height;
  size_t pixels() const { return static_cast<size_t>(width) * static_cast<size_t>(height); }
  static glm::dmat4 reversed(double fov, double aspect, double near) {
    const double f = 1.0 / std::tan(0.5 * fov);
    return {f / aspect, 0, 0, 0, 0, f, 0, 0, 0, 0, 0, -1, 0, 0, near, 0};
  }
  // Returns the error of the drawn depth against the triangle's plane, in 2^-24 of the depth, beyond what the slope
  // over 1/256 of a pixel explains.
  double off(const Shape& shape, uint32_t triangle, const glm::dmat4& world, const glm::dmat4& clip, const Format& format, size_t i, float stored) const {
    const auto depth_at = [&](double x, double y) {
      const glm::dvec2 ndc((x + 0.5) / static_cast<double>(width) * 2 - 1, (y + 0.5) / static_cast<double>(height) * 2 - 1);
      const auto at = [&](double z) { const glm::dvec4 p = world * glm::dvec4(ndc, z, 1); return glm::dvec3(p) / p.w; };
      const glm::dvec3 a = at(0.5), b = at(0.9), n = shape.normal(triangle), p0(shape.corners[shape.indices[3 * triangle]]);
      const glm::dvec3 p = a + (b - a) * (glm::dot(p0 - a, n) / glm::dot(b - a, n));
      const glm::dvec4 c = clip * glm::dvec4(p, 1);
      return format.zero_to_one ? c.z / c.w : 0.5 * c.z / c.w + 0.5;
    };
    const double x = static_cast<double>(i % static_cast<size_t>(width)), y = static_cast<double>(i / static_cast<size_t>(width)), d = depth_at(x, y);
    const double slope = std::abs(depth_at(x + 1, y) - d) + std::abs(depth_at(x, y + 1) - d);
    return std::max(0.0, std::abs(d - double{stored}) - slope / 512) * 0x1p24;
  }

  std::vector<uint32_t> draw(const Shape& shape, const glm::mat4& clip, const Format& format) {
    gl.Viewport(0, 0, width, height);
    gl.Enable(GL_DEPTH_TEST);
    if (gl.clip_control) gl.ClipControl(GL_LOWER_LEFT, format.zero_to_one ? GL_ZERO_TO_ONE : GL_NEGATIVE_ONE_TO_ONE);
    gl.DepthFunc(format.reversed ? GL_GREATER : GL_LESS);
    gl.ClearDepth(format.reversed ? 0.0 : 1.0);
    gl.Clear(GL_DEPTH_BUFFER_BIT);
    const uint32_t none[4] = {};
    gl.ClearBufferuiv(GL_COLOR, 0, none);
    program_.use();
    gl.UniformMatrix4fv(gl.GetUniformLocation(program_.id(), "clip_from_world"), 1, GL_FALSE, glm::value_ptr(clip));
    gl.BindVertexArray(array_.id());
    gl.BindBuffer(GL_ARRAY_BUFFER, vertices_.id());
    gl.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(shape.corners.size() * sizeof(glm::vec3)), shape.corners.data(), GL_STATIC_DRAW);
    gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_.id());
    gl.BufferData(GL_ELEMENT_ARRAY_BUFFER, static_cast<GLsizeiptr>(shape.indices.size() * 4), shape.indices.data(), GL_STATIC_DRAW);
    const auto place = static_cast<GLuint>(gl.GetAttribLocation(program_.id(), "position"));
    gl.VertexAttribPointer(place, 3, GL_FLOAT, GL_FALSE, 0, nullptr);
    gl.EnableVertexAttribArray(place);
    if (pushed_back != 0) gl.Enable(GL_POLYGON_OFFSET_FILL);
    gl.PolygonOffset(0, pushed_back);
    gl.DrawElements(GL_TRIANGLES, static_cast<GLsizei>(shape.indices.size()), GL_UNSIGNED_INT, nullptr);
    gl.Disable(GL_POLYGON_OFFSET_FILL);
    gl.BindVertexArray(0);
    gl.UseProgram(0);
    if (gl.clip_control) gl.ClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
    std::vector<uint32_t> ids(pixels());
    gl.ReadPixels(0, 0, width, height, GL_RED_INTEGER, GL_UNSIGNED_INT, ids.data());
    return ids;
  }

  std::vector<uint8_t> trace(const Shape& shape, const glm::dmat4& clip, const Format& format, uint32_t framebuffer,
                             glm::vec3 light) {
    Scene scene = Scene::create().value();
    sideray_mesh_desc mesh = sideray_mesh_defaults();
    mesh.vertex_count = static_cast<uint32_t>(shape.corners.size());
    mesh.positions.data = &shape.corners[0].x;
    mesh.index_count = static_cast<uint32_t>(shape.indices.size());
    mesh.indices = shape.indices.data();
    sideray_instance_desc instance{};
    instance.mesh = scene.add_mesh(mesh);
    sideray_material_desc white = sideray_material_defaults();
    white.double_sided = 1;
    instance.material = scene.add_material(white);
    for (const int k : {0, 4, 8}) instance.world_from_object[k] = 1.0;
    instance.visibility = SIDERAY_VISIBLE_ALL;
    scene.add_instances({&instance, 1});
    sideray_light sun = sideray_light_defaults();
    for (int k = 0; k < 3; ++k) sun.direction[k] = light[k];
    scene.set_lights({&sun, 1});
    scene.commit();
    Tracer tracer = Tracer::create(scene).value();
    const sideray_host_gl host{sizeof(host), gl::Context::get_proc_address, context_.get()};
    Service service = Service::create(tracer, host).value();
    FrameInputs in;
    set_matrices(in.frame.view, clip);
    in.frame.view.reversed_depth = format.reversed, in.frame.view.zero_to_one_depth = format.zero_to_one;
    in.frame.source.framebuffer = framebuffer;
    in.frame.source.width = width, in.frame.source.height = height;
    in.frame.source.mask = SIDERAY_MASK_NONE;
    in.layers.reset();
    in.masks = sideray_mask_inputs_defaults();
    in.masks->shadow_lights = 1;
    in.masks->denoise = 0;
    in.masks->shadow_bias = bias, in.masks->shadow_bias_steps = bias_steps;
    sideray_error error{};
    sideray_ticket ticket = 0;
    EXPECT_EQ(submit_frame(service.get(), in, ticket, &error), SIDERAY_OK) << error.message;
    EXPECT_EQ(sideray_service_wait(service.get(), ticket, -1, &error), SIDERAY_OK) << error.message;
    sideray_mask_outputs out{};
    out.size = sizeof(out);
    EXPECT_EQ(sideray_service_masks(service.get(), 0, &out, &error), SIDERAY_OK) << error.message;
    std::vector<uint8_t> lit(pixels());
    gl.BindTexture(GL_TEXTURE_2D_ARRAY, out.shadow_texture);
    gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
    gl.GetTexImage(GL_TEXTURE_2D_ARRAY, 0, GL_RED, GL_UNSIGNED_BYTE, lit.data());
    gl.BindTexture(GL_TEXTURE_2D_ARRAY, 0);
    return lit;
  }

  std::unique_ptr<gl::Context> context_;
  const gl::Functions& gl;
  gl::Program program_;
  gl::VertexArray array_;
  gl::Buffer vertices_, indices_;
  gl::Renderbuffer color_;
};

const glm::vec3 sun = glm::normalize(glm::vec3(0.5f, -0.6f, -0.6f));

std::vector<Shape> shapes(double h) {
  return {wall(h), ground(h, 1), ground(h, 16), sphere(h), box(h)};
}

// Counts with a near plane as in hosts that show rooms, and a far plane beyond the shape.
SpeckHost::Counts count_at(SpeckHost& host, const Shape& shape, Depth depth, double h) {
  return host.count(shape, depth, std::min(0.04, 0.2 * h), std::max(60.0, 50 * h), sun);
}

// Tests that pixels that face the light are lit, in each format, from 0.1 to 1000 m.
class Specks : public testing::TestWithParam<Depth> {};

TEST_P(Specks, AreNowhere) {
  SpeckHost host(256, 192);
  if (!host.supports(GetParam())) GTEST_SKIP() << "no clip control here";
  size_t lit = 0, shaded = 0;
  double worst = 0;
  for (const double h : {0.1, 1.0, 3.0, 10.0, 100.0, 1000.0})
    for (const Shape& shape : shapes(h)) {
      const SpeckHost::Counts counts = count_at(host, shape, GetParam(), h);
      EXPECT_EQ(counts.dark, 0u) << shape.name << ", " << h << " m";
      lit += counts.lit, shaded += counts.shaded;
      worst = std::max(worst, counts.worst_steps);
    }
  EXPECT_GT(lit, 1000000u);
  EXPECT_GT(shaded, 10000u);
  RecordProperty("worst_in_2^-24", std::to_string(worst));
}

std::string name_of(const testing::TestParamInfo<Depth>& info) {
  std::string name = format_of(info.param).name;
  std::erase_if(name, [](char c) { return c == ' ' || c == ','; });
  return name;
}
INSTANTIATE_TEST_SUITE_P(Formats, Specks, testing::Values(Depth::d24s8, Depth::d32f, Depth::reversed), name_of);

// Tests the other shapes, from 0.1 m to the horizon.
class FewSpecks : public testing::TestWithParam<Depth> {};

TEST_P(FewSpecks, AreNowhere) {
  SpeckHost host(128, 96);
  if (!host.supports(GetParam())) GTEST_SKIP() << "no clip control here";
  for (const double h : {0.1, 3.0, 1000.0})
    for (const Shape& shape : shapes(h)) {
      const SpeckHost::Counts counts = count_at(host, shape, GetParam(), h);
      EXPECT_EQ(counts.dark, 0u) << shape.name << ", " << h << " m";
      EXPECT_GT(counts.lit, 100u) << shape.name << ", " << h << " m";
    }
}
INSTANTIATE_TEST_SUITE_P(Formats, FewSpecks,
                         testing::Values(Depth::d16, Depth::d24, Depth::d32f_s8, Depth::d24_to_one, Depth::d32f_to_one,
                                         Depth::reversed_d24),
                         name_of);

// Tests a quad that reaches behind the eye. Clipping makes the error of its depth the largest, and larger pictures
// increase it.
class LargeFloors : public testing::TestWithParam<Depth> {};

TEST_P(LargeFloors, HaveNone) {
  SpeckHost host(640, 480);
  for (const double h : {3.0, 10.0}) {
    const SpeckHost::Counts counts = count_at(host, ground(h, 1), GetParam(), h);
    EXPECT_EQ(counts.dark, 0u) << h << " m";
    EXPECT_GT(counts.lit, 100000u) << h << " m";
  }
}
INSTANTIATE_TEST_SUITE_P(Formats, LargeFloors, testing::Values(Depth::d24s8, Depth::d32f), name_of);

// A known fault: beside a fold, where a facet shows fewer than three pixels in a row, depth gives the normal of neither
// face, and a lit pixel may be dark. Only light from other directions shows it.
TEST(SpecksBesideFolds, AreNoMoreThanKnown) {
  for (const Depth depth : {Depth::d24s8, Depth::d32f, Depth::reversed}) {
    SpeckHost host(256, 192);
    if (!host.supports(depth)) continue;
    size_t lit = 0, dark = 0;
    for (const glm::vec3& direction : {glm::vec3(-0.3f, -0.8f, 0.2f), glm::vec3(0.1f, -0.3f, -0.9f)})
      for (const Shape& shape : shapes(1.0)) {
        const SpeckHost::Counts counts = host.count(shape, depth, 0.04, 60.0, glm::normalize(direction));
        lit += counts.lit, dark += counts.dark;
      }
    std::printf("%s: %zu of %zu dark\n", format_of(depth).name, dark, lit);
    EXPECT_GT(lit, 200000u);
    EXPECT_LE(dark, 2u) << format_of(depth).name;
  }
}

// Tests all of it in a larger picture and at more distances; docs/embedding.md states the dark pixels.
class SlowSpecks : public testing::TestWithParam<Depth> {};

TEST_P(SlowSpecks, AreNowhere) {
  SpeckHost host(640, 480);
  if (!host.supports(GetParam())) GTEST_SKIP() << "no clip control here";
  size_t lit = 0, dark = 0, floors_lit = 0, floors_dark = 0;
  double worst = 0, worst_of_floors = 0;
  for (const double h : {0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0})
    for (const Shape& shape : shapes(h)) {
      const SpeckHost::Counts counts = count_at(host, shape, GetParam(), h);
      const bool floor = shape.name == "floor of one quad";
      (floor ? floors_lit : lit) += counts.lit, (floor ? floors_dark : dark) += counts.dark;
      double& most = floor ? worst_of_floors : worst;
      most = std::max(most, counts.worst_steps);
    }
  std::printf("%s: floors of one quad %zu of %zu dark, off by %.2f; others %zu of %zu, %.2f\n", format_of(GetParam()).name,
              floors_dark, floors_lit, worst_of_floors, dark, lit, worst);
  EXPECT_GT(lit + floors_lit, 9000000u);
  // A depth step of these formats spans metres on the farthest spheres, more than their facets.
  const size_t per_million = GetParam() == Depth::d16 ? 4 : GetParam() == Depth::reversed_d24 ? 1 : 0;
  EXPECT_LE(dark * 1000000, per_million * lit);
  EXPECT_EQ(floors_dark, 0u);
}
INSTANTIATE_TEST_SUITE_P(Slow, SlowSpecks,
                         testing::Values(Depth::d16, Depth::d24, Depth::d24s8, Depth::d32f, Depth::d32f_s8, Depth::d24_to_one,
                                         Depth::d32f_to_one, Depth::reversed_d24, Depth::reversed),
                         name_of);

// A host whose depth has a larger error than a driver's, here by glPolygonOffset, gives a bias, in steps or in metres.
TEST(ShadowBiases, CoverWhatTheDepthIsOffBy) {
  SpeckHost host(128, 96);
  host.pushed_back = 20;  // in units of the driver: 2^-23 here, so that 40 steps are it
  if (!host.gl_software()) GTEST_SKIP() << "drivers choose what a unit of glPolygonOffset is";
  const Shape s = wall(3.0);
  const auto dark = [&] { return host.count(s, Depth::d24s8, 0.04, 60.0, sun).dark; };
  EXPECT_GT(dark(), 1000u);
  host.bias_steps = 20;
  EXPECT_GT(dark(), 1000u);
  host.bias_steps = 40;
  EXPECT_EQ(dark(), 0u);
  host.bias_steps = 0;
  // A step is z^2 / near 2^24 there: 9 / 0.04 / 2^24 m, and less than 16 / 0.04 / 2^24 everywhere.
  host.bias = static_cast<float>(40 * 16 / 0.04 * 0x1p-24);
  EXPECT_EQ(dark(), 0u);
  host.bias *= 0.25f;
  EXPECT_GT(dark(), 1000u);
}

// A sphere whose traced triangles differ from the drawn ones shadows itself.
TEST(Tessellation, ThatIsTracedOtherwiseThanDrawnIsDark) {
  SpeckHost host(256, 192);
  host.facing = 0.2;
  const Shape drawn = sphere(3.0);
  const double radius = 0.4 * 3.0, apart = radius * (1 - std::cos(glm::pi<double>() / 28) * std::cos(glm::pi<double>() / 40));
  const auto dark = [&] {
    const SpeckHost::Counts counts = host.count(drawn, Depth::d24s8, 0.04, 60.0, sun);
    EXPECT_GT(counts.lit, 10000u);
    return static_cast<double>(counts.dark) / static_cast<double>(counts.lit);
  };
  EXPECT_EQ(dark(), 0.0);
  host.traced = sphere(3.0, 64, 64);
  EXPECT_GT(dark(), 0.5);
  host.bias_steps = 100;
  EXPECT_GT(dark(), 0.5) << "no tolerance of depth covers it";
  host.bias_steps = 0;
  host.bias = static_cast<float>(apart);
  EXPECT_LT(dark(), 0.01) << "a larger bias leaves as many";
  host.bias *= 0.5f;
  EXPECT_GT(dark(), 0.1);
}

}  // namespace
}  // namespace sideray::tests
