// Compares screen-space distortion with its definition, on pictures whose undistorted form is known.
#include <cstring>

#include "gl/gl_contexts.h"
#include "gl/raster/raster_scene_builder.h"

namespace sideray::gl::tests {
namespace {

constexpr double tilt = 0.5;  // radians

// Adds nothing and hides nothing.
sideray_material_desc clear_air(float distortion) {
  sideray_material_desc d = unlit({0, 0, 0, 1}, SIDERAY_BLEND);
  d.blend_mode = SIDERAY_BLEND_ADDITIVE;
  d.double_sided = 1;
  d.distortion = distortion;
  return d;
}

// Two units of height; depth 0.1 to 100.
sideray_camera flat_camera(glm::dvec3 eye) {
  sideray_camera camera = camera_at(eye, eye - glm::dvec3(0, 0, 1));
  camera.orthographic = 1;
  camera.half_height = 1;
  camera.z_far = 100;
  return camera;
}

// Turned about the vertical: its normal is (sin tilt, 0, cos tilt), its width 2 size cos tilt.
glm::dmat4 tilted(glm::dvec3 center, double size, double angle = tilt) {
  return glm::scale(glm::rotate(glm::translate(glm::dmat4(1), center), angle, glm::dvec3(0, 1, 0)), glm::dvec3(size));
}

// Squares of different colours in front of nothing.
void add_pattern(SceneBuilder& builder) {
  for (int y = 0; y < 8; ++y)
    for (int x = 0; x < 12; ++x) {
      const glm::vec4 color(0.1f * static_cast<float>(x + 1), 0.12f * static_cast<float>(y + 1), (x + y) % 2, 1);
      builder.quad(builder.material(unlit(color)), {(x - 5.5) * 0.25, (y - 3.5) * 0.25, -1}, 0.125, 1);
    }
}

struct Distortion : RasterTest {
  std::vector<glm::vec4> picture(SceneBuilder& builder, const sideray_camera& camera, bool distorted,
                                 glm::vec2 jitter = glm::vec2(0)) {
    draw_opaque(builder.commit(), camera, false, jitter);
    if (distorted) rasterizer->distort();
    return rasterizer->read_color();
  }

  // `plain` read `pixels` to the right of (x, y), up to its border.
  glm::vec4 read(const std::vector<glm::vec4>& plain, uint32_t x, uint32_t y, double pixels) const {
    const double at = std::clamp(x + pixels, 0.0, width - 1.0), corner = std::floor(at);
    const auto share = static_cast<float>(at - corner);
    const auto left = static_cast<uint32_t>(corner);
    return glm::mix(plain[pixel(left, y)], plain[pixel(std::min(left + 1, width - 1), y)], share);
  }
};

// A pane over the whole picture moves all of it by distortion * sin(tilt) * height, 4.3 pixels, and keeps its border.
TEST_F(Distortion, MovesThePictureByItsDefinition) {
  const double pixels = 4.3;
  for (const glm::vec2 jitter : {glm::vec2(0), glm::vec2(0.25f, -0.375f)}) {
    SceneBuilder builder;
    add_pattern(builder);
    const std::vector<glm::vec4> plain = picture(builder, flat_camera({0, 0, 5}), true, jitter);
    const double distortion = pixels / (std::sin(tilt) * height);
    builder.quad(builder.material(clear_air(static_cast<float>(distortion))), tilted({0, 0, 1}, 3), 2);
    const std::vector<glm::vec4> moved = picture(builder, flat_camera({0, 0, 5}), true, jitter);
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; ++x) expect_near(moved[pixel(x, y)], read(plain, x, y, pixels), 2e-5f);
  }
}

// Seen from behind, the normal is turned toward the viewer: right of a viewer who looks along +z is -x.
TEST_F(Distortion, TakesTheNormalOnTheSideThatIsSeen) {
  SceneBuilder builder;
  for (int x = 0; x < 12; ++x)
    builder.quad(builder.material([&] {
      sideray_material_desc d = unlit({0.08f * static_cast<float>(x), 0, 0, 1});
      d.double_sided = 1;
      return d;
    }()),
                 {(x - 5.5) * 0.25, 0, 1}, 0.125, 1);
  sideray_camera camera = flat_camera({0, 0, -5});
  for (const int column : {0, 2})
    for (int r = 0; r < 3; ++r) camera.world_from_camera[3 * column + r] *= -1;
  const std::vector<glm::vec4> plain = picture(builder, camera, false);
  const float distortion = static_cast<float>(5.0 / (std::sin(tilt) * height));
  builder.quad(builder.material(clear_air(distortion)), tilted({0, 0, -1}, 3), 2);
  const std::vector<glm::vec4> moved = picture(builder, camera, true);
  // The normal turned around is (-sin, 0, -cos); right is (-1, 0, 0).
  for (uint32_t x = 0; x < width; ++x) expect_near(moved[pixel(x, height / 2)], read(plain, x, height / 2, 5.0), 2e-5f);
}

TEST_F(Distortion, OfSurfacesBehindEachOtherAddsUpInAnyOrder) {
  std::vector<glm::vec4> pictures[2];
  for (const bool swapped : {false, true}) {
    SceneBuilder builder;
    add_pattern(builder);
    const std::vector<glm::vec4> plain = picture(builder, flat_camera({0, 0, 5}), false);
    const auto strength = [&](double pixels) { return static_cast<float>(pixels / (std::sin(tilt) * height)); };
    builder.quad(builder.material(clear_air(strength(swapped ? 1.75 : 3.5))), tilted({0, 0, 1}, 3), 2);
    builder.quad(builder.material(clear_air(strength(swapped ? 3.5 : 1.75))), tilted({0, 0, 3}, 3), 3);
    // Behind the wall: hidden, it moves nothing.
    builder.quad(builder.material(clear_air(1)), tilted({0, 0, -9}, 3), 4);
    pictures[swapped] = picture(builder, flat_camera({0, 0, 5}), true);
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; ++x) expect_near(pictures[swapped][pixel(x, y)], read(plain, x, y, 5.25), 2e-5f);
  }
  EXPECT_EQ(0, std::memcmp(pictures[0].data(), pictures[1].data(), pictures[0].size() * sizeof(glm::vec4)));
}

// With a white post in front of the air and a black wall behind, the air must not show the post, and the post must not
// change.
TEST_F(Distortion, NeverShowsWhatIsInFront) {
  SceneBuilder builder;
  builder.quad(builder.material(unlit({0, 0, 0, 1})), {0, 0, -1}, 4, 1);
  builder.quad(builder.material(unlit({1, 1, 1, 1})), glm::scale(glm::translate(glm::dmat4(1), {0, 0, 3}), {0.2, 2, 1}),
               1);
  const std::vector<glm::vec4> plain = picture(builder, flat_camera({0, 0, 5}), false);
  builder.quad(builder.material(clear_air(static_cast<float>(7.5 / (std::sin(tilt) * height)))), tilted({0, 0, 1}, 3),
               2);
  EXPECT_EQ(picture(builder, flat_camera({0, 0, 5}), true), plain);
}

// The air shows displaced surfaces behind it, also those in front of a farther distorting surface.
TEST_F(Distortion, ShowsWhatIsBehindTheNearestDistortingSurface) {
  SceneBuilder builder;
  builder.quad(builder.material(unlit({0, 0, 0, 1})), {0, 0, -3}, 4, 1);
  builder.quad(builder.material(unlit({1, 1, 1, 1})), glm::scale(glm::translate(glm::dmat4(1), {0, 0, 0}), {0.2, 2, 1}),
               1);
  const std::vector<glm::vec4> plain = picture(builder, flat_camera({0, 0, 5}), false);
  const auto strength = [&](double pixels) { return static_cast<float>(pixels / (std::sin(tilt) * height)); };
  builder.quad(builder.material(clear_air(strength(4))), tilted({0, 0, 2}, 2, tilt), 2);
  builder.quad(builder.material(clear_air(strength(4))), tilted({0, 0, -1.5}, 2, tilt), 3);
  const std::vector<glm::vec4> moved = picture(builder, flat_camera({0, 0, 5}), true);
  const uint32_t y = height / 2;
  for (uint32_t x = 0; x < width; ++x) {
    const bool post = plain[pixel(x, y)].x == 1.0f;  // before the farther surface: moved by the nearer one alone
    expect_near(moved[pixel(x, y)], read(plain, x, y, post ? 4 : 8), 2e-5f);
  }
}

TEST_F(Distortion, FollowsCullRuleAndAlpha) {
  for (const int variant : {0, 1, 2}) {
    SceneBuilder builder;
    add_pattern(builder);
    const std::vector<glm::vec4> plain = picture(builder, flat_camera({0, 0, 5}), false);
    sideray_material_desc d = clear_air(0.2f);
    if (variant == 0) d.base_color[3] = 0.003f;  // absent, as everywhere
    if (variant == 1) d.double_sided = 0;        // seen from behind
    if (variant == 2) d.alpha_mode = SIDERAY_OPAQUE, d.distortion = 0;
    builder.quad(builder.material(d), tilted({0, 0, -9}, 0.01), 2);
    if (variant < 2) builder.quad(builder.material(d), tilted({0, 0, 1}, 3, tilt + (variant == 1 ? 3.14159265 : 0)), 3);
    EXPECT_EQ(picture(builder, flat_camera({0, 0, 5}), true), plain) << variant;
  }
}

class DistortionEverywhere : public EveryContext {};
INSTANTIATE_TEST_SUITE_P(All, DistortionEverywhere, testing::Values("device", "surfaceless", "osmesa"),
                         [](const auto& suite) { return suite.param; });

TEST_P(DistortionEverywhere, MovesThePictureByWholePixels) {
  constexpr uint32_t width = 48, height = 32, pixels = 5;
  Rasterizer rasterizer(gl());
  std::vector<glm::vec4> pictures[2];
  for (const bool distorted : {false, true}) {
    SceneBuilder builder;
    add_pattern(builder);
    const double distortion = distorted ? pixels / (std::sin(tilt) * height) : 0.0;
    builder.quad(builder.material(clear_air(static_cast<float>(distortion))), tilted({0, 0, 1}, 3), 2);
    rasterizer.set_scene(builder.commit());
    rasterizer.resize(width, height);
    rasterizer.set_view(rasterizer.make_view(flat_camera({0, 0, 5}), glm::vec2(0)));
    rasterizer.gbuffer();
    rasterizer.light(false);
    rasterizer.distort();
    rasterizer.translucency({});
    pictures[distorted] = rasterizer.read_color();
  }
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x)
      expect_near(pictures[1][y * width + x], pictures[0][y * width + std::min(x + pixels, width - 1)], 2e-5f);
}

int textures_made = 0, triangles_drawn = 0;
PFNGLTEXIMAGE2DPROC real_tex_image = nullptr;
PFNGLDRAWARRAYSPROC real_draw_arrays = nullptr;
void GLAD_API_PTR counting_tex_image(GLenum target, GLint level, GLint internal, GLsizei w, GLsizei h, GLint border,
                                     GLenum format, GLenum type, const void* texels) {
  ++textures_made;
  real_tex_image(target, level, internal, w, h, border, format, type, texels);
}
void GLAD_API_PTR counting_draw_arrays(GLenum mode, GLint first, GLsizei count) {
  ++triangles_drawn;
  real_draw_arrays(mode, first, count);
}

TEST_F(Distortion, CostsNothingWhereNothingDistorts) {
  Functions counted = context->functions();
  real_tex_image = counted.TexImage2D, real_draw_arrays = counted.DrawArrays;
  counted.TexImage2D = &counting_tex_image, counted.DrawArrays = &counting_draw_arrays;
  rasterizer = std::make_unique<Rasterizer>(counted);
  const auto cost = [&](float distortion, double x) {
    SceneBuilder builder;
    add_pattern(builder);
    builder.quad(builder.material(clear_air(distortion)), {x, 0, 1}, 0.5, 2);
    draw_opaque(builder.commit(), flat_camera({0, 0, 5}));
    textures_made = triangles_drawn = 0;
    rasterizer->distort();
    return std::pair(textures_made, triangles_drawn);
  };
  EXPECT_EQ(cost(0.0f, 0), std::pair(0, 0));
  EXPECT_EQ(cost(0.1f, 40), std::pair(0, 0)) << "it is out of view";
  EXPECT_EQ(cost(0.1f, 0), std::pair(2, 1)) << "offsets and copy, one pass over the screen";
  EXPECT_EQ(cost(0.1f, 0), std::pair(0, 1)) << "the same targets again";
  rasterizer.reset();
}

}  // namespace
}  // namespace sideray::gl::tests
