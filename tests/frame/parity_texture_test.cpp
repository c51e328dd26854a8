// Compares the tracer's texture and environment lookups with the rasterizer's samplers and shaders, on the driver.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <random>

#include "gl/context/context.h"
#include "gl/resources/program.h"
#include "gl/scene/raster_lights.h"
#include "gl/scene/raster_scene.h"
#include "model/material_slots.h"
#include "model/scene.h"
#include "rt/textures/environment_lookup.h"
#include "rt/textures/texture_sample.h"

namespace sideray::tests::parity_texture_test {
namespace {

struct LookUp {
  glm::vec4 uv;  // both sets
  float level;
};

constexpr int columns = 64, most_rows = 128;

constexpr const char* vertex_text = R"(
layout(location = 0) in vec4 in_uv;
layout(location = 1) in float in_level;
out vec4 v_uv;
out vec4 v_color;
flat out float v_level;
void main() {
  ivec2 pixel = ivec2(gl_VertexID % 64, gl_VertexID / 64);
  gl_Position = vec4((vec2(pixel) + 0.5) / vec2(32.0, 64.0) - 1.0, 0.0, 1.0);
  v_uv = in_uv;
  v_color = vec4(1.0);
  v_level = in_level;
}
)";

// Draws one point for each lookup, and returns the colours.
class PointDrawer {
 public:
  explicit PointDrawer(const gl::Functions& functions)
      : gl_(functions), target_(functions), framebuffer_(functions), buffer_(functions), array_(functions) {
    gl_.BindTexture(GL_TEXTURE_2D, target_.id());
    gl_.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA32F, columns, most_rows, 0, GL_RGBA, GL_FLOAT, nullptr);
    gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    gl_.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, target_.id(), 0);
    gl_.BindVertexArray(array_.id());
    gl_.BindBuffer(GL_ARRAY_BUFFER, buffer_.id());
    constexpr GLsizei stride = sizeof(LookUp);
    gl_.EnableVertexAttribArray(0);
    gl_.VertexAttribPointer(0, 4, GL_FLOAT, GL_FALSE, stride, nullptr);
    gl_.EnableVertexAttribArray(1);
    gl_.VertexAttribPointer(1, 1, GL_FLOAT, GL_FALSE, stride, reinterpret_cast<const void*>(sizeof(glm::vec4)));
  }

  std::vector<glm::vec4> draw(const gl::Program& program, const std::vector<LookUp>& points) {
    gl_.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_.id());
    gl_.Viewport(0, 0, columns, most_rows);
    gl_.BindVertexArray(array_.id());
    gl_.BindBuffer(GL_ARRAY_BUFFER, buffer_.id());
    gl_.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(points.size() * sizeof(LookUp)), points.data(),
                   GL_STREAM_DRAW);
    program.use();
    gl_.DrawArrays(GL_POINTS, 0, static_cast<GLsizei>(points.size()));
    std::vector<glm::vec4> colors(size_t{columns} * most_rows);
    gl_.ReadPixels(0, 0, columns, most_rows, GL_RGBA, GL_FLOAT, colors.data());
    colors.resize(points.size());
    return colors;
  }

 private:
  const gl::Functions& gl_;
  gl::Texture target_;
  gl::Framebuffer framebuffer_;
  gl::Buffer buffer_;
  gl::VertexArray array_;
};

struct ParityTexture : ::testing::Test {
  void SetUp() override {
    context = gl::Context::create("auto", "");
    context->make_current();
  }
  void TearDown() override {
    EXPECT_EQ(context->functions().GetError(), unsigned{GL_NO_ERROR});
    context->release_current();
  }
  std::unique_ptr<gl::Context> context;
};

// Adds noise of codes 96..159, for which two codes cover the drivers' errors: truncated 8-bit weights in s, t and level
// make 3 * 63 / 256 = 0.74 codes, an sRGB decode off by half a code 0.61 at the curve's slope of 1.22 at 159, the
// rounded result half a code. A wrong texel differs by 21 codes on average.
uint32_t add_noise(model::Scene& scene, uint32_t width, uint32_t height, sideray_texel_format format) {
  std::mt19937 random(width * 1000 + height);
  std::vector<uint8_t> texels(size_t{4} * width * height);
  for (uint8_t& t : texels) t = static_cast<uint8_t>(96 + random() % 64);
  return scene.add_texture(width, height, format, texels.data());
}

// Returns slots with every filter and every wrap in u and v, in turn plain on one uv set and with a texture transform
// on the other.
std::vector<sideray_texture_slot> every_kind_of_slot(uint32_t texture) {
  const float turn = 0.7f, c = std::cos(turn), s = std::sin(turn);
  const float turned[6] = {1.5f * c, -1.5f * s, 0.5f * s, 0.5f * c, 0.25f, -0.4f}, plain[6] = {1, 0, 0, 1, 0, 0};
  std::vector<sideray_texture_slot> slots;
  for (const sideray_filter filter : {SIDERAY_NEAREST, SIDERAY_BILINEAR, SIDERAY_TRILINEAR})
    for (const sideray_wrap wrap_u : {SIDERAY_REPEAT, SIDERAY_MIRROR, SIDERAY_CLAMP})
      for (const sideray_wrap wrap_v : {SIDERAY_REPEAT, SIDERAY_MIRROR, SIDERAY_CLAMP}) {
        const bool transformed = slots.size() % 2 == 1;
        sideray_texture_slot slot{};
        slot.texture = texture;
        slot.uv_set = transformed ? 1 : 0;
        slot.wrap_u = wrap_u, slot.wrap_v = wrap_v, slot.filter = filter;
        std::copy_n(transformed ? turned : plain, 6, slot.texture_from_uv);
        slots.push_back(slot);
      }
  return slots;
}

sideray_material_desc with_base_color(const sideray_texture_slot& slot) {
  sideray_material_desc d = sideray_material_defaults();
  d.base_color_texture = slot;
  return d;
}

std::vector<LookUp> random_look_ups(size_t count, float last_level) {
  std::mt19937 random(1);
  const auto number = [&](float low, float high) {
    return low + (high - low) * static_cast<float>(random() >> 8) * 0x1p-24f;
  };
  std::vector<LookUp> points;
  for (size_t i = 0; i < count; ++i) {
    const float level = number(0, last_level + 0.5f);
    points.push_back({{number(-2.5f, 2.5f), number(-2.5f, 2.5f), number(-2.5f, 2.5f), number(-2.5f, 2.5f)},
                      i % 4 == 0 ? std::floor(level) : level});
  }
  return points;
}

// A driver must place look-ups to 1/256 of a texel only (the subtexel bits of its texture units).
constexpr float subtexel = 1.0f / 256.0f;

float largest(glm::vec4 v) {
  return std::max({v.x, v.y, v.z, v.w});
}

// Returns whether NEAREST would take another texel a subtexel step away, so that either is right.
bool is_between_texels(const model::Texture& texture, const sideray_texture_slot& slot, glm::vec2 uv) {
  const float* m = slot.texture_from_uv;
  const glm::vec2 size(texture.levels[0].width, texture.levels[0].height);
  const glm::vec2 texel = size * glm::vec2(m[0] * uv.x + m[2] * uv.y + m[4], m[1] * uv.x + m[3] * uv.y + m[5]);
  const glm::vec2 off = glm::abs(texel - glm::round(texel));
  return std::min(off.x, off.y) <= subtexel;
}

struct WorstLookUp {
  float off = 0, level = 0;
  glm::vec2 uv{0};  // as the vertices have it
  sideray_texture_slot slot{};
  glm::vec4 driver{0}, tracer{0};
  int compared = 0;
};

std::ostream& operator<<(std::ostream& out, const WorstLookUp& w) {
  out << w.off * 255 << " of 255 (" << w.compared << " compared) at uv " << w.uv.x << " " << w.uv.y << ", level "
      << w.level << ", wrap " << w.slot.wrap_u << " " << w.slot.wrap_v << ", uv set " << w.slot.uv_set;
  for (const auto& [name, c] : {std::pair{"driver", w.driver}, std::pair{"tracer", w.tracer}})
    out << ", " << name << " " << c.x << " " << c.y << " " << c.z << " " << c.w;
  return out;
}

// Returns the largest difference over slots and points, by filter.
std::array<WorstLookUp, 3> worst_differences(const gl::Functions& functions, const model::Snapshot& snapshot,
                                             gl::RasterScene& scene, const std::vector<LookUp>& points) {
  const gl::Program program(functions, "texel parity", gl::assemble_shader({{}, {}}) + vertex_text,
                            gl::assemble_shader({{"shading.h", "raster_material.glsl"}, {"SR_MAPS 1", "SR_LOBES 0"}}) +
                                "flat in float v_level;\nout vec4 o_color;\n"
                                "void main() { o_color = textureLod(base_color_map, map_position(0), v_level); }\n");
  program.use();
  program.set("base_color_map", static_cast<int>(gl::unit::material));
  program.set_block("Material", gl::block::material);
  PointDrawer drawer(functions);
  std::array<WorstLookUp, 3> worst{};
  for (uint32_t m = 0; m < snapshot.materials.size(); ++m) {
    const sideray_texture_slot& slot = snapshot.materials[m].desc.base_color_texture;
    scene.bind_material(m, gl::base_color_map);
    const std::vector<glm::vec4> colors = drawer.draw(program, points);
    for (size_t i = 0; i < points.size(); ++i) {
      const glm::vec2 uv = slot.uv_set == 0 ? glm::vec2(points[i].uv) : glm::vec2(points[i].uv.z, points[i].uv.w);
      const model::Texture& texture = *snapshot.textures[slot.texture - 1];
      if (slot.filter == SIDERAY_NEAREST && is_between_texels(texture, slot, uv)) continue;
      const glm::vec4 tracer = rt::sample(texture, slot, uv, points[i].level);
      WorstLookUp& w = worst[static_cast<size_t>(slot.filter)];
      const int compared = w.compared + 1;
      if (const float off = largest(glm::abs(colors[i] - tracer)); off >= w.off)
        w = {off, points[i].level, uv, slot, colors[i], tracer, compared};
      w.compared = compared;
    }
  }
  return worst;
}

TEST_F(ParityTexture, texels_at_an_explicit_level_are_the_drivers) {
  struct Image {
    uint32_t width, height;
    sideray_texel_format format;
  };
  for (const auto& [w, h, format] : {Image{64, 64, SIDERAY_RGBA8}, Image{37, 19, SIDERAY_RGBA8},
                                     Image{37, 19, SIDERAY_RGBA8_SRGB}, Image{1, 7, SIDERAY_RGBA8}}) {
    model::Scene scene;
    for (const sideray_texture_slot& slot : every_kind_of_slot(add_noise(scene, w, h, format)))
      scene.add_material(with_base_color(slot));
    scene.commit();
    const auto snapshot = scene.snapshot();
    gl::RasterScene raster(context->functions());
    raster.set_snapshot(snapshot);
    const auto last = static_cast<float>(snapshot->textures[0]->levels.size() - 1);
    const std::array<WorstLookUp, 3> worst =
        worst_differences(context->functions(), *snapshot, raster, random_look_ups(size_t{columns} * 16, last));
    std::cout << "  " << w << "x" << h << (format == SIDERAY_RGBA8 ? " linear" : " sRGB") << "\n    nearest "
              << worst[SIDERAY_NEAREST] << "\n    bilinear " << worst[SIDERAY_BILINEAR] << "\n    trilinear "
              << worst[SIDERAY_TRILINEAR] << "\n";
    for (const WorstLookUp& found : worst) {
      EXPECT_GT(found.compared, 9 * columns * 14) << "of nine slots' look-ups too few say something";
      EXPECT_LE(found.off, 2.0f / 255.0f) << found;
    }
    EXPECT_LE(worst[SIDERAY_NEAREST].off, 1e-4f) << "of a texel, which is decoded";
  }
}

// Sets a sky with bright spots at the seam and the poles, where lookups are most likely to differ.
void set_spotted_sky(model::Scene& scene) {
  constexpr uint32_t width = 128, height = 64;
  std::mt19937 random(5);
  std::vector<float> rgb;
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      const bool spot = (x < 3 && y > 30 && y < 34) || y == 0 || (y == height - 1 && x % 2 == 0);
      for (int c = 0; c < 3; ++c) rgb.push_back(spot ? 8.0f : static_cast<float>(random() % 1000) * 1e-3f);
    }
  scene.set_environment(width, height, rgb.data(), 1.0f, 0.0f);
}

// Returns directions over the sphere, a third of them near the seam and a third near the poles; w is unused.
std::vector<LookUp> directions(size_t count) {
  std::mt19937 random(2);
  std::normal_distribution<float> normal;
  std::vector<LookUp> points;
  for (size_t i = 0; i < count; ++i) {
    glm::vec3 d(normal(random), normal(random), normal(random));
    if (i % 3 == 1) d.x *= 0.01f, d.z = std::abs(d.z);
    if (i % 3 == 2) d.x *= 0.01f, d.z *= 0.01f;
    points.push_back({glm::vec4(glm::normalize(d), 0), i % 5 == 0 ? 1.0f : static_cast<float>(i % 101) * 0.01f});
  }
  return points;
}

TEST_F(ParityTexture, environments_and_albedos_are_read_alike) {
  model::Scene scene;
  set_spotted_sky(scene);
  scene.commit();
  const auto snapshot = scene.snapshot();
  gl::RasterScene raster(context->functions());
  raster.set_snapshot(snapshot);
  PointDrawer drawer(context->functions());
  const std::vector<LookUp> points = directions(size_t{columns} * most_rows);
  const auto draw = [&](const char* expression) {
    const gl::Program program(context->functions(), "environment parity", gl::assemble_shader({{}, {}}) + vertex_text,
                              gl::assemble_shader({{"shading.h", "raster_lighting.glsl"}, {"SR_LOBES 0"}}) +
                                  "in vec4 v_uv;\nflat in float v_level;\nout vec4 o_color;\nvoid main() { o_color = " +
                                  expression + "; }\n");
    program.use();
    program.set("environment_specular", static_cast<int>(gl::unit::environment_specular));
    program.set("environment_irradiance", static_cast<int>(gl::unit::environment_irradiance));
    program.set("albedo_terms", static_cast<int>(gl::unit::albedo_terms));
    program.set("environment_last_level", raster.textures().environment_last_level());
    raster.textures().bind_environment();
    return drawer.draw(program, points);
  };
  const std::vector<glm::vec4> specular = draw("vec4(environment_radiance(v_uv.xyz, v_uv.xyz, v_level), 1.0)");
  const std::vector<glm::vec4> irradiance = draw("textureLod(environment_irradiance, sr_latlong(v_uv.xyz), 0.0)");
  const std::vector<glm::vec4> albedo = draw("vec4(albedos(abs(v_uv.y), v_level), 1.0)");
  float worst_specular = 0, worst_irradiance = 0, worst_albedo = 0;
  for (size_t i = 0; i < points.size(); ++i) {
    const glm::vec3 d(points[i].uv);
    const auto off = [](glm::vec3 a, glm::vec3 b) {
      const glm::vec3 difference = glm::abs(a - b);
      return std::max({difference.x, difference.y, difference.z});
    };
    worst_specular =
        std::max(worst_specular,
                 off(glm::vec3(specular[i]), rt::environment_specular(*snapshot->environment, d, points[i].level)));
    worst_irradiance = std::max(worst_irradiance,
                                off(glm::vec3(irradiance[i]), rt::environment_irradiance(*snapshot->environment, d)));
    worst_albedo = std::max(
        worst_albedo,
        off(glm::vec3(albedo[i]), rt::albedo_and_sheen(model::albedo_table(), std::abs(d.y), points[i].level)));
  }
  std::cout << "  worst: prefiltered radiance " << worst_specular << ", irradiance " << worst_irradiance
            << ", albedo terms " << worst_albedo << "\n";
  // Weights of 8 bits between texels up to 8 apart, in two directions and between levels; irradiance varies by less
  // than 1 from texel to texel, albedos by less than 0.2.
  EXPECT_LE(worst_specular, 3 * 8.0f / 256.0f);
  EXPECT_LE(worst_irradiance, 2 * 1.0f / 256.0f);
  EXPECT_LE(worst_albedo, 2 * 0.2f / 256.0f);
}

}  // namespace
}  // namespace sideray::tests::parity_texture_test
