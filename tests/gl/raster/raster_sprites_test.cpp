// Sprites of the rasterizer against what geometry and blending say of them.
#include <algorithm>
#include <cmath>

#include "gl/gl_contexts.h"
#include "gl/raster/raster_scene_builder.h"

namespace sideray::gl::tests {
namespace {

sideray_particles_desc plain_particles(sideray_blend_mode blend = SIDERAY_BLEND_ALPHA) {
  sideray_particles_desc d{};
  d.size = sizeof(d);
  d.columns = d.rows = 1;
  d.blend_mode = blend;
  return d;
}

sideray_sprite sprite_at(glm::dvec3 position, float side, glm::vec4 color) {
  sideray_sprite s{};
  for (int c = 0; c < 3; ++c) s.position[c] = position[c];
  s.width = s.height = side;
  for (int c = 0; c < 4; ++c) s.color[c] = color[c];
  return s;
}

void add_system(SceneBuilder& builder, const sideray_particles_desc& desc, const std::vector<sideray_sprite>& sprites) {
  builder.scene.set_sprites(builder.scene.add_particles(desc), sprites.data(), sprites.size());
}

struct RasterSpritesTest : RasterTest {
  std::vector<glm::vec4> draw(SceneBuilder& builder, const sideray_camera& camera, bool shadows = false) {
    view = draw_opaque(builder.commit(), camera, shadows);
    Translucency pass;
    pass.shadows = shadows;
    rasterizer->translucency(pass);
    return rasterizer->read_color();
  }
  // Of a pixel's centre, on the plane at `depth` before the camera: view-space x and y.
  glm::dvec2 on_plane(uint32_t x, uint32_t y, double depth) const {
    const double half = depth * std::tan(0.5 * double{view.yfov});
    return {((x + 0.5) / width * 2 - 1) * half * width / height, ((y + 0.5) / height * 2 - 1) * half};
  }
  RasterView view;
};

TEST_F(RasterSpritesTest, a_sprite_covers_the_square_that_the_camera_projects) {
  for (const double turn : {0.0, 0.3}) {
    SceneBuilder builder;
    sideray_sprite s = sprite_at({0.4, -0.2, 0}, 1.0f, {1, 1, 1, 1});
    s.width = 1.6f;
    s.rotation = static_cast<float>(turn);
    add_system(builder, plain_particles(), {s});
    const std::vector<glm::vec4> color = draw(builder, camera_at({0, 0, 5}));
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; ++x) {
        const glm::dvec2 p = on_plane(x, y, 5) - glm::dvec2(0.4, -0.2);
        const glm::dvec2 q(std::cos(turn) * p.x + std::sin(turn) * p.y, std::cos(turn) * p.y - std::sin(turn) * p.x);
        const double inside = std::min(0.8 - std::abs(q.x), 0.5 - std::abs(q.y));
        if (std::abs(inside) < 1e-3) continue;  // on an edge
        ASSERT_EQ(color[pixel(x, y)].w > 0.5f, inside > 0) << x << ", " << y;
      }
  }
}

TEST_F(RasterSpritesTest, blend_modes_are_their_closed_forms) {
  const glm::vec4 wall(0.25f, 0.5f, 0.75f, 1), c(0.8f, 0.2f, 0.4f, 0.25f), rgb(glm::vec3(c), 1.0f);
  const struct {
    sideray_blend_mode blend;
    glm::vec4 expected;
  } cases[] = {{SIDERAY_BLEND_ALPHA, rgb * 0.25f + wall * 0.75f},
               {SIDERAY_BLEND_PREMULTIPLIED, rgb + wall * 0.75f},
               {SIDERAY_BLEND_ADDITIVE, rgb * 0.25f + wall}};
  for (const auto& test : cases) {
    SceneBuilder builder;
    builder.quad(builder.material(unlit(wall)), {0, 0, -1}, 5, 1);
    add_system(builder, plain_particles(test.blend), {sprite_at({0, 0, 0}, 1, c)});
    const glm::vec4 color = draw(builder, camera_at({0, 0, 5}))[middle()];
    expect_near(color, glm::vec4(glm::vec3(test.expected), 1), 1e-3f);
  }
}

// 4 x 2 cells of one colour each; a cell's neighbours must not show at its edges, at no size.
TEST_F(RasterSpritesTest, cells_of_a_flip_book_keep_their_colours) {
  constexpr uint32_t cell_side = 8, columns = 4, rows = 2;
  const auto cell_color = [](uint32_t cell) { return glm::uvec3(cell & 1, (cell >> 1) & 1, (cell >> 2) & 1) * 255u; };
  std::vector<uint8_t> texels;
  for (uint32_t y = 0; y < rows * cell_side; ++y)
    for (uint32_t x = 0; x < columns * cell_side; ++x) {
      const glm::uvec3 c = cell_color(y / cell_side * columns + x / cell_side);
      for (int i = 0; i < 3; ++i) texels.push_back(static_cast<uint8_t>(c[i]));
      texels.push_back(255);
    }
  for (const float side : {0.1f, 0.3f, 1.0f, 3.0f})
    for (uint32_t cell = 0; cell < columns * rows; ++cell) {
      SceneBuilder builder;
      sideray_particles_desc d = plain_particles();
      d.texture = builder.scene.add_texture(columns * cell_side, rows * cell_side, SIDERAY_RGBA8, texels.data());
      d.columns = columns, d.rows = rows;
      sideray_sprite s = sprite_at({0, 0, 0}, side, {1, 1, 1, 1});
      s.cell = static_cast<float>(cell + 8 * (cell % 3)) + 0.7f;  // taken modulo 8, rounded down
      add_system(builder, d, {s});
      for (const glm::vec4& c : draw(builder, camera_at({0, 0, 5}))) {
        if (c.w == 0) continue;
        ASSERT_EQ(glm::vec3(c), glm::vec3(cell_color(cell)) / 255.0f) << "side " << side << " cell " << cell;
      }
    }
}

TEST_F(RasterSpritesTest, cells_stand_upright) {
  SceneBuilder builder;
  const uint8_t texels[] = {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 255};
  sideray_particles_desc d = plain_particles();
  d.texture = builder.scene.add_texture(2, 2, SIDERAY_RGBA8, texels);
  add_system(builder, d, {sprite_at({0, 0, 0}, 2, {1, 1, 1, 1})});
  const std::vector<glm::vec4> color = draw(builder, camera_at({0, 0, 5}));
  const uint32_t dx = 8, dy = 8, x = width / 2, y = height / 2;
  expect_near(color[pixel(x - dx, y + dy)], {1, 0, 0, 1}, 1e-3f);
  expect_near(color[pixel(x + dx, y + dy)], {0, 1, 0, 1}, 1e-3f);
  expect_near(color[pixel(x - dx, y - dy)], {0, 0, 1, 1}, 1e-3f);
  expect_near(color[pixel(x + dx, y - dy)], {1, 1, 1, 1}, 1e-3f);
}

// A wall that is leaned back: the gap before it varies over the sprite.
TEST_F(RasterSpritesTest, soft_sprites_fade_with_the_gap_along_the_view_axis) {
  for (const bool orthographic : {false, true}) {
    SceneBuilder builder;
    const double lean = 0.5, soft = 0.7;
    builder.quad(builder.material(unlit({0, 0, 0, 1})),
                 glm::rotate(glm::dmat4(1), -lean, glm::dvec3(1, 0, 0)) * glm::scale(glm::dmat4(1), glm::dvec3(6)));
    sideray_particles_desc d = plain_particles();
    d.soft_distance = static_cast<float>(soft);
    add_system(builder, d, {sprite_at({0, 0, 0}, 3, {1, 0.5f, 0.25f, 0.8f})});
    sideray_camera camera = camera_at({0, 0, 5});
    camera.orthographic = orthographic;
    camera.half_height = 2;
    if (orthographic) camera.z_far = 20;
    const std::vector<glm::vec4> color = draw(builder, camera);
    uint32_t faded = 0;
    for (uint32_t y = 0; y < height; ++y) {
      const double t = ((y + 0.5) / height * 2 - 1) * (orthographic ? 2.0 : std::tan(0.5 * double{view.yfov}));
      // The wall's point on the pixel's ray: z = -y tan(lean), y = t (perspective: times the depth).
      const double slope = std::tan(lean);
      const double depth = orthographic ? 5 + t * slope : 5 / (1 - t * slope);
      const double gap = depth - 5;
      if (std::abs(gap) < 1e-2 || (orthographic ? std::abs(t) : 5 * std::abs(t)) > 1.49) continue;
      const double alpha = gap < 0 ? 0 : 0.8 * std::min(gap / soft, 1.0);
      faded += gap > 0 && gap < soft;
      EXPECT_NEAR(double{color[pixel(width / 2, y)].x}, alpha, 2e-4) << "row " << y;
    }
    EXPECT_GT(faded, 3u);
  }
}

TEST_F(RasterSpritesTest, nothing_behind_is_infinitely_far) {
  SceneBuilder builder;
  sideray_particles_desc d = plain_particles();
  d.soft_distance = 10;
  add_system(builder, d, {sprite_at({0, 0, 0}, 1, {1, 0.5f, 0.25f, 0.5f})});
  expect_near(draw(builder, camera_at({0, 0, 5}))[middle()], {0.5f, 0.25f, 0.125f, 0.5f}, 1e-4f);
}

// Irradiance over pi of a light that shines along the view, and of an even sky: on a surface that faces the eye.
TEST_F(RasterSpritesTest, lit_sprites_are_diffuse_and_face_the_eye) {
  SceneBuilder builder;
  builder.sky(glm::vec3(0.5f));
  sideray_light light{};
  light.size = sizeof(light);
  light.type = SIDERAY_LIGHT_DIRECTIONAL;
  light.direction[0] = 0.6f, light.direction[2] = -0.8f;
  for (float& i : light.intensity) i = 2;
  builder.scene.set_lights(&light, 1);
  sideray_particles_desc d = plain_particles();
  d.lit = 1;
  add_system(builder, d, {sprite_at({0, 0, 0}, 1, {0.5f, 0.25f, 0.125f, 1})});
  const float lit = 2 * 0.8f / 3.14159265f + 0.5f;
  expect_near(draw(builder, camera_at({0, 0, 5}), true)[middle()], {0.5f * lit, 0.25f * lit, 0.125f * lit, 1}, 2e-3f);
}

TEST_F(RasterSpritesTest, lit_sprites_stand_in_shadows_and_cast_none) {
  for (const bool shaded : {false, true}) {
    SceneBuilder builder;
    sideray_light light{};
    light.size = sizeof(light);
    light.type = SIDERAY_LIGHT_DIRECTIONAL;
    light.direction[1] = -1;
    light.direction[2] = -1;
    for (float& i : light.intensity) i = 3;
    builder.scene.set_lights(&light, 1);
    builder.quad(builder.material(unlit({0, 0, 0, 1})), {0, 0, -3}, 1, 1);  // a receiver
    if (shaded) builder.quad(builder.material(plain_material()), {0, 2, 2}, 0.8, 2);
    sideray_particles_desc d = plain_particles();
    d.lit = 1;
    // The second one is nearer to the light and shades nothing.
    add_system(builder, d, {sprite_at({0, 0, 0}, 0.5f, {1, 1, 1, 1}), sprite_at({0, 3, 3}, 0.5f, {1, 1, 1, 1})});
    const float lit = shaded ? 0.0f : 3 / std::sqrt(2.0f) / 3.14159265f;
    EXPECT_NEAR(draw(builder, camera_at({0, 0, 5}), true)[middle()].x, lit, 2e-3f);
  }
}

// What a pixel sees: sprites and panes that cross no other, composed in double from the farthest on.
struct Fragment {
  double depth;
  glm::dvec3 added;
  double through;
};

// Sprites within, before and behind panes, in three systems, added in no order: every pixel is the sorted sum.
TEST_F(RasterSpritesTest, order_with_glass_is_the_sorted_truth_in_every_pixel) {
  SceneBuilder builder;
  struct Pane {
    double z;
    glm::vec4 color;
  };
  const Pane panes[] = {
      {0.9, {0.9f, 0.2f, 0.1f, 0.4f}}, {-0.6, {0.1f, 0.8f, 0.3f, 0.5f}}, {0.1, {0.2f, 0.3f, 0.9f, 0.3f}}};
  uint32_t id = 1;
  for (const Pane& p : panes) {
    sideray_material_desc d = unlit(p.color, SIDERAY_BLEND);
    d.double_sided = 1;
    builder.quad(builder.material(d), {0, 0, p.z}, 1.5, id++);
  }
  struct Placed {
    sideray_sprite sprite;
    sideray_blend_mode blend;
  };
  std::vector<Placed> all;
  uint32_t state = 7;
  const auto random = [&state] {
    state = state * 1664525u + 1013904223u;
    return static_cast<float>(state >> 8) / 16777216.0f;
  };
  for (const sideray_blend_mode blend : {SIDERAY_BLEND_ALPHA, SIDERAY_BLEND_ADDITIVE, SIDERAY_BLEND_PREMULTIPLIED}) {
    std::vector<sideray_sprite> sprites;
    for (int i = 0; i < 60; ++i) {
      const glm::dvec3 p(random() * 2.4f - 1.2f, random() * 2.4f - 1.2f, random() * 3.0f - 1.5f);
      sprites.push_back(sprite_at(p, 0.3f + 0.5f * random(), {random(), random(), random(), 0.1f + 0.6f * random()}));
      all.push_back({sprites.back(), blend});
    }
    add_system(builder, plain_particles(blend), sprites);
  }
  const std::vector<glm::vec4> color = draw(builder, camera_at({0, 0, 5}));
  size_t deepest = 0;
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      std::vector<Fragment> fragments;
      bool on_an_edge = false;
      const auto covers = [&](double depth, glm::dvec2 center, double half) {
        const glm::dvec2 q = glm::abs(on_plane(x, y, depth) - center);
        on_an_edge |= std::abs(std::max(q.x, q.y) - half) < 1e-3;
        return std::max(q.x, q.y) < half;
      };
      for (const Pane& p : panes)
        if (covers(5 - p.z, {0, 0}, 1.5))
          fragments.push_back({5 - p.z, glm::dvec3(p.color) * double{p.color.w}, 1 - double{p.color.w}});
      for (const Placed& p : all) {
        const sideray_sprite& s = p.sprite;
        const double depth = 5 - s.position[2], a = s.color[3];
        if (!covers(depth, {s.position[0], s.position[1]}, 0.5 * double{s.width})) continue;
        const glm::dvec3 c(s.color[0], s.color[1], s.color[2]);
        fragments.push_back({depth, p.blend == SIDERAY_BLEND_PREMULTIPLIED ? c : c * a,
                             p.blend == SIDERAY_BLEND_ADDITIVE ? 1.0 : 1.0 - a});
      }
      if (on_an_edge) continue;
      std::sort(fragments.begin(), fragments.end(),
                [](const Fragment& a, const Fragment& b) { return a.depth > b.depth; });
      glm::dvec3 truth(0);
      for (const Fragment& f : fragments) truth = truth * f.through + f.added;
      deepest = std::max(deepest, fragments.size());
      for (int c = 0; c < 3; ++c)
        // Thirty-odd additions and products in floats.
        ASSERT_NEAR(double{color[pixel(x, y)][c]}, truth[c], 1e-5) << x << ", " << y << " of " << fragments.size();
    }
  EXPECT_GE(deepest, 20u);
}

TEST_F(RasterSpritesTest, equally_far_sprites_lie_as_rays_meet_them) {
  SceneBuilder builder;
  add_system(builder, plain_particles(),
             {sprite_at({0, 0, 0}, 1, {1, 0, 0, 0.5f}), sprite_at({0, 0, 0}, 1, {0, 1, 0, 0.5f})});
  expect_near(draw(builder, camera_at({0, 0, 5}))[middle()], {0.5f, 0.25f, 0, 0.75f}, 1e-4f);
}

TEST_F(RasterSpritesTest, opaque_surfaces_hide_sprites_and_the_near_plane_cuts_them) {
  SceneBuilder builder;
  builder.quad(builder.material(unlit({0, 0, 1, 1})), {0, 0, 0}, 5, 1);
  add_system(builder, plain_particles(),
             {sprite_at({0, 0, -1}, 1, {1, 1, 1, 1}), sprite_at({0, 0, 4.95}, 1, {1, 1, 1, 1}),
              sprite_at({0, 0, 7}, 1, {1, 1, 1, 1})});
  expect_near(draw(builder, camera_at({0, 0, 5}))[middle()], {0, 0, 1, 1}, 1e-4f);
}

class SpriteContexts : public EveryContext {};
INSTANTIATE_TEST_SUITE_P(All, SpriteContexts, testing::Values("device", "surfaceless", "osmesa"),
                         [](const auto& name) { return name.param; });

// Cell, fade, light and blending at once, where a wall stands half of the soft distance behind.
TEST_P(SpriteContexts, EverySwitchAtOnceIsItsClosedForm) {
  Rasterizer rasterizer(gl());
  SceneBuilder builder;
  builder.sky(glm::vec3(0.5f));
  builder.quad(builder.material(unlit({0.25f, 0.5f, 1.0f, 1})), {0, 0, -1}, 5, 1);
  const uint8_t texels[] = {255, 0, 0, 255, 0, 255, 0, 255};
  sideray_particles_desc d = plain_particles();
  d.texture = builder.scene.add_texture(2, 1, SIDERAY_RGBA8, texels);
  d.columns = 2;
  d.lit = 1;
  d.soft_distance = 2;
  sideray_sprite s = sprite_at({0, 0, 0}, 2, {1, 0.8f, 1, 0.6f});
  s.cell = 1;
  add_system(builder, d, {s});
  rasterizer.set_scene(builder.commit());
  rasterizer.resize(32, 32);
  rasterizer.set_view(rasterizer.make_view(camera_at({0, 0, 5}), glm::vec2(0)));
  rasterizer.gbuffer();
  rasterizer.mask(MaskKind::stencil, TracedSet::all_translucent, true);
  const std::vector<uint8_t> stencil = rasterizer.read_stencil();
  EXPECT_EQ(stencil[16 * 32 + 16], 1);
  EXPECT_EQ(stencil[0], 0);
  rasterizer.light(false);
  rasterizer.translucency({});
  const float a = 0.6f * 0.5f;
  expect_near(rasterizer.read_color()[16 * 32 + 16],
              {(1 - a) * 0.25f, (1 - a) * 0.5f + a * 0.8f * 0.5f, (1 - a) * 1.0f, 1}, 1e-3f);
  EXPECT_TRUE(take_problems(*context).empty());
}

}  // namespace
}  // namespace sideray::gl::tests
