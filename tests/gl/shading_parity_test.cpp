// shading.h as GLSL on a driver against shading.h as C++, step by step, over thousands of materials, angles and lights.
#include <gmock/gmock.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <glm/gtc/constants.hpp>
#include <iostream>
#include <iterator>

#include "gl/gl_contexts.h"
#include "shaders/shading/shading_cpp.h"

namespace sideray::shading {
#define SR_FN inline
#include "gl/shading_case.h"
#undef SR_FN
}  // namespace sideray::shading

namespace sideray::gl {
namespace {

constexpr int inputs = 31, outputs = 8, columns = 64, rows = 256, cases = columns * rows;
constexpr const char* output_names[outputs] = {"reflected light, faces",  "environment, cover",  "through, alpha",
                                               "irradiance, below sheen", "to light, distance",  "emitted, coat share",
                                               "normal bent by a map",    "lat-long, dominant"};

using Case = std::array<glm::vec4, inputs>;
using Result = std::array<glm::vec4, outputs>;

// Numbers from a counter (PCG hash, Jarzynski and Olano 2020), so that a case is the same wherever it is made.
class Numbers {
 public:
  explicit Numbers(uint32_t which) : state_(which * 2891336453u + 1u) {}
  float operator()() {
    state_ = state_ * 747796405u + 2891336453u;
    const uint32_t word = ((state_ >> ((state_ >> 28u) + 4u)) ^ state_) * 277803737u;
    return static_cast<float>(((word >> 22u) ^ word) >> 8) * 0x1p-24f;
  }
  float between(float low, float high) { return low + (high - low) * (*this)(); }
  float unit() {  // 0, 1 or between, so that the ends are hit often
    const float kind = (*this)();
    return kind < 0.25f ? 0.0f : kind < 0.5f ? 1.0f : (*this)();
  }
  glm::vec3 color() { return {unit(), (*this)(), unit()}; }
  glm::vec3 direction() {
    const float z = between(-1, 1), azimuth = between(0, glm::two_pi<float>()), r = std::sqrt(1 - z * z);
    return {r * std::cos(azimuth), r * std::sin(azimuth), z};
  }
  glm::vec3 direction_about(glm::vec3 axis, float spread) { return glm::normalize(axis + direction() * spread); }

 private:
  uint32_t state_;
};

void make_material(Numbers& n, Case& t) {
  t[0] = glm::vec4(n.color(), n.unit());
  t[1] = glm::vec4(n.color() * 4.0f, n.unit());
  t[2] = glm::vec4(n.color() * 2.0f, n.unit());
  t[3] = glm::vec4(n.color(), n.unit());
  t[4] = glm::vec4(n.between(1, 2.5f), n.between(0, 3), n.unit(), n.unit());
  t[5] = glm::vec4(n.unit(), n.unit(), n.unit(), std::floor(n.between(0, 3)));
  t[6] = glm::vec4(n.color() * n.unit(), n() < 0.05f ? 1.0f : 0.0f);
  t[7] = glm::vec4(n.color(), std::floor(n.between(0, 4)));
  for (int i = 8; i <= 14; ++i) t[static_cast<size_t>(i)] = glm::vec4(n(), n(), n(), n.unit());
}

// Half of the materials have a thin film; of some textures make none of it.
void make_film(Numbers& n, Case& t) {
  t[15].w = n() < 0.5f ? 0.0f : n.unit();
  t[16].w = n.between(1, 2.5f);
  t[17].w = n() < 0.25f ? 0.0f : n.between(0, 1500);
  t[18].w = n.between(0, 1500);
  t[27].w = n.unit(), t[30].w = n.unit();
}

// A third of the lights stand where the eye sees their highlight, in the base or in the coat.
void make_directions(Numbers& n, Case& t) {
  const glm::vec3 normal = n.direction(), coat_normal = n.direction_about(normal, 0.4f);
  glm::vec3 to_eye = n.direction();
  if (glm::dot(to_eye, normal) < 0) to_eye = -to_eye;
  const float kind = n(), roughness = t[2].w * t[10].x;
  glm::vec3 to_light = n.direction();
  if (kind < 0.17f) to_light = n.direction_about(glm::reflect(-to_eye, normal), 0.002f + roughness * roughness);
  if (kind > 0.83f) to_light = n.direction_about(glm::reflect(-to_eye, coat_normal), 0.01f);
  t[15] = glm::vec4(normal, 0), t[16] = glm::vec4(coat_normal, 0);
  t[17] = glm::vec4(to_eye, 0), t[18] = glm::vec4(to_light, 0);
}

void make_light(Numbers& n, Case& t) {
  const glm::vec3 position = n.direction() * n.between(0, 3), at = position + n.direction() * n.between(0.5f, 5);
  const float outer = n.between(0.2f, 1.5f), inner = outer * n.between(0, 0.8f);
  t[19] = glm::vec4(at, n() < 0.5f ? 0.0f : n.between(1, 6));
  t[20] = glm::vec4(n.direction_about(glm::normalize(position - at), 0.8f), std::cos(inner));
  t[21] = glm::vec4(n.color() * 5.0f, std::cos(outer));
  t[22] = glm::vec4(position, std::floor(n.between(0, 3)));
}

Case make_case(uint32_t which) {
  Numbers n(which);
  Case t{};
  make_material(n, t);
  make_directions(n, t);
  make_light(n, t);
  for (int i = 23; i <= 26; ++i) t[static_cast<size_t>(i)] = glm::vec4(n.color() * 3.0f, n());
  const glm::vec3 normal = n.direction(), side = n.direction();
  t[27] = glm::vec4(normal, 0);
  t[28] = glm::vec4(glm::normalize(glm::cross(normal, side)), n() < 0.1f ? 0.0f : n() < 0.5f ? -1.0f : 1.0f);
  t[29] = glm::vec4(n.between(-0.8f, 0.8f), n.between(-0.8f, 0.8f), n.between(0.2f, 1), n.between(0, 2));
  t[30] = glm::vec4(n.direction(), 0);
  make_film(n, t);
  return t;
}

Result evaluate_cpp(Case t) {
  const shading::ShadingResult r = shading::sr_evaluate(t.data());
  return {r.reflected_faces,   r.environment_cover,  r.through_alpha, r.irradiance_below_sheen,
          r.to_light_distance, r.emitted_coat_share, r.perturbed,     r.latlong_dominant};
}

std::string fragment_text() {
  std::ifstream file(SIDERAY_SOURCE_DIR "/tests/gl/shading_case.h");
  const std::string evaluation((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  std::string text = assemble_shader({{"shading.h"}, {}}) + evaluation + "uniform sampler2D cases;\n";
  const char* members[outputs] = {"reflected_faces",   "environment_cover",  "through_alpha", "irradiance_below_sheen",
                                  "to_light_distance", "emitted_coat_share", "perturbed",     "latlong_dominant"};
  for (int i = 0; i < outputs; ++i)
    text += "layout(location = " + std::to_string(i) + ") out vec4 o_" + members[i] + ";\n";
  text +=
      "void main() {\n"
      "  vec4 t[31];\n"
      "  ivec2 first = ivec2(gl_FragCoord.xy) * ivec2(31, 1);\n"
      "  for (int i = 0; i < 31; ++i) t[i] = texelFetch(cases, first + ivec2(i, 0), 0);\n"
      "  ShadingResult r = sr_evaluate(t);\n";
  for (const char* member : members) text += std::string("  o_") + member + " = r." + member + ";\n";
  return text + "}\n";
}

Texture make_texture(const Functions& gl, int width, const void* texels) {
  Texture texture(gl);
  gl.BindTexture(GL_TEXTURE_2D, texture.id());
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
  gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
  gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, width, rows, 0, GL_RGBA, GL_FLOAT, texels);
  return texture;
}

// outputs images of `cases` values each.
std::vector<std::vector<glm::vec4>> evaluate_glsl(const Functions& gl, const std::vector<Case>& given) {
  const Program program(gl, "shading parity", assemble_shader({{"raster_screen.vert.glsl"}, {}}), fragment_text());
  std::vector<Texture> targets;
  Framebuffer framebuffer(gl);
  gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer.id());
  std::vector<GLenum> points;
  for (int i = 0; i < outputs; ++i) {
    targets.push_back(make_texture(gl, columns, nullptr));
    points.push_back(static_cast<GLenum>(GL_COLOR_ATTACHMENT0 + i));
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, points.back(), GL_TEXTURE_2D, targets.back().id(), 0);
  }
  gl.DrawBuffers(outputs, points.data());
  EXPECT_EQ(gl.CheckFramebufferStatus(GL_FRAMEBUFFER), unsigned{GL_FRAMEBUFFER_COMPLETE});
  const Texture texture = make_texture(gl, columns * inputs, given.data());
  const VertexArray screen(gl);
  gl.BindVertexArray(screen.id());
  gl.Viewport(0, 0, columns, rows);
  program.use();
  gl.DrawArrays(GL_TRIANGLES, 0, 3);
  std::vector<std::vector<glm::vec4>> results(outputs, std::vector<glm::vec4>(cases));
  for (size_t i = 0; i < outputs; ++i) {
    gl.ReadBuffer(points[i]);
    gl.ReadPixels(0, 0, columns, rows, GL_RGBA, GL_FLOAT, results[i].data());
  }
  return results;
}

struct Worst {
  float excess = 0;  // |a - b| over what is allowed
  int at = 0, channel = 0;
  float glsl = 0, cpp = 0;
};

struct ShadingParity : EveryContext {};

TEST_P(ShadingParity, glsl_and_cpp_agree_within_a_thousandth) {
  std::vector<Case> given;
  for (uint32_t i = 0; i < cases; ++i) given.push_back(make_case(i));
  const auto glsl = evaluate_glsl(gl(), given);
  std::array<Worst, outputs> worst{};
  int lit = 0;
  for (int i = 0; i < cases; ++i) {
    const Result cpp = evaluate_cpp(given[static_cast<size_t>(i)]);
    lit += cpp[0].y > 0.01f;
    for (size_t o = 0; o < outputs; ++o)
      for (int c = 0; c < 4; ++c) {
        const float a = glsl[o][static_cast<size_t>(i)][c], b = cpp[o][c];
        float excess = std::abs(a - b) / (1e-3f * std::max(std::abs(b), 0.01f));
        if (std::isnan(excess)) excess = INFINITY;
        if (excess > worst[o].excess) worst[o] = {excess, i, c, a, b};
      }
  }
  for (size_t o = 0; o < outputs; ++o) {
    const Worst& w = worst[o];
    std::cout << "  " << output_names[o] << ": worst " << w.excess << " of the bound, case " << w.at << " channel "
              << w.channel << ", GLSL " << w.glsl << ", C++ " << w.cpp << "\n";
    EXPECT_LE(w.excess, 1.0f) << output_names[o];
  }
  EXPECT_GT(lit, cases / 4);
  EXPECT_THAT(take_problems(*context), testing::IsEmpty());
}

INSTANTIATE_TEST_SUITE_P(All, ShadingParity, testing::Values("device", "surfaceless", "osmesa"),
                         [](const auto& suite) { return suite.param; });

}  // namespace
}  // namespace sideray::gl
