#include <gmock/gmock.h>

#include <cmath>
#include <set>

#include "gl/raster/raster_scene_builder.h"
#include "gl/resources/objects.h"

namespace sideray::gl::tests {
namespace {

struct RasterOpaque : RasterTest {};

double along_of(const RasterView& view, float depth) {
  const double z = view.zero_to_one_depth ? double{depth} : 2.0 * double{depth} - 1.0;
  const glm::dvec4 p = view.local_from_clip * glm::dvec4(0, 0, z, 1);
  return -(view.view_from_local * (p / p.w)).z;
}

TEST_F(RasterOpaque, depth_of_a_tilted_plane_is_its_closed_form_within_the_bound) {
  SceneBuilder builder;
  const glm::dmat4 tilt = glm::scale(
      glm::rotate(glm::translate(glm::dmat4(1), glm::dvec3(0.3, 0, -40)), 1.2, glm::dvec3(0.2, 1, 0)), glm::dvec3(60));
  builder.quad(builder.material([] {
    sideray_material_desc d = plain_material();
    d.double_sided = 1;
    return d;
  }()),
               tilt, 7);
  const glm::dvec3 normal = glm::normalize(glm::dvec3(tilt[2])), point(tilt[3]);
  for (const float z_far : {0.0f, 500.0f}) {
    sideray_camera camera = camera_at({0, 0, 5});
    camera.z_far = z_far;
    const glm::vec2 jitter(0.25f, -0.4f);
    const RasterView view = draw_opaque(builder.commit(), camera, false, jitter);
    const std::vector<float> depth = rasterizer->read_depth();
    const Rasterizer::GBufferImages images = rasterizer->read_gbuffer();
    size_t covered = 0;
    std::set<uint32_t> triangles;
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; ++x) {
        if (images.ids[pixel(x, y)].y == 0) continue;
        ++covered;
        const double tan_half = std::tan(0.5 * double{camera.yfov});
        const auto ray_at = [&](double px, double py) {
          const double ndc_x = 2.0 * px / width - 1.0, ndc_y = 2.0 * py / height - 1.0;
          return glm::dvec3(ndc_x * tan_half * width / height, ndc_y * tan_half, -1.0);
        };
        const glm::dvec3 eye(0, 0, 5);
        const auto along_at = [&](double px, double py) {
          return glm::dot(point - eye, normal) / glm::dot(ray_at(px, py), normal);
        };
        const double px = x + 0.5 + double{jitter.x}, py = y + 0.5 + double{jitter.y};
        const double along = along_at(px, py);
        const double slope = std::max(std::abs(along_at(px + 1, py) - along), std::abs(along_at(px, py + 1) - along));
        // F8: half the format's step, the slope over a subpixel, and rounding.
        const double step =
            std::abs(along_of(view, std::nextafter(depth[pixel(x, y)], 2.0f)) - along_of(view, depth[pixel(x, y)]));
        const double bound = 0.5 * step + slope / 256.0 * 1.5 + std::ldexp(along, -21) * 2;
        EXPECT_NEAR(along_of(view, depth[pixel(x, y)]), along, bound) << x << "," << y;
        EXPECT_EQ(images.ids[pixel(x, y)].x, 7u);
        EXPECT_THAT(images.ids[pixel(x, y)].y, ::testing::AnyOf(1u, 2u));
        triangles.insert(images.ids[pixel(x, y)].y);
      }
    EXPECT_GT(covered, size_t{width} * height / 2);
    EXPECT_EQ(triangles.size(), 2u);
  }
}

TEST_F(RasterOpaque, shades_the_nearest_first) {
  // Each fills the view, is of another material, so that no two are one draw, and stands before the one added before
  // it.
  SceneBuilder builder;
  for (const double distance : {64.0, 32.0, 16.0, 8.0, 4.0})
    builder.quad(builder.material(unlit({1.0 / distance, 0, 0, 1})), {0, 0, -distance}, distance);
  const Functions& gl = context->functions();
  rasterizer->set_scene(builder.commit());
  rasterizer->resize(width, height);
  rasterizer->set_view(rasterizer->make_view(camera_at({0, 0, 0}, {0, 0, -1}), glm::vec2(0)));
  const Query query(gl);
  GLuint fragments = 0;
  gl.BeginQuery(GL_SAMPLES_PASSED, query.id());
  rasterizer->gbuffer();
  gl.EndQuery(GL_SAMPLES_PASSED);
  gl.GetQueryObjectuiv(query.id(), GL_QUERY_RESULT, &fragments);
  EXPECT_EQ(fragments, width * height);
}

TEST_F(RasterOpaque, of_equal_surfaces_in_one_place_the_first_is_seen_from_anywhere) {
  SceneBuilder builder;
  builder.quad(builder.material(unlit({1, 0, 0, 1})), {0, 0, 0}, 2, 1);
  builder.quad(builder.material(unlit({0, 1, 0, 1})), {0, 0, 0}, 2, 2);
  const std::shared_ptr<const model::Snapshot> snapshot = builder.commit();
  for (double z = 0.5; z < 40; z *= 1.3) {
    draw_opaque(snapshot, camera_at({0.1 * z, 0, z}, {0, 0, 0}));
    expect_near(rasterizer->read_color()[middle()], {1, 0, 0, 1}, 1e-3f);
  }
}

TEST_F(RasterOpaque, upper_left_is_upper_left) {
  SceneBuilder builder;
  builder.quad(builder.material(unlit({1, 0, 0, 1})), {-2, 1, 0}, 0.4);
  builder.quad(builder.material(unlit({0, 1, 0, 1})), {2, -1, 0}, 0.4);
  draw_opaque(builder.commit(), camera_at({0, 0, 5}));
  const std::vector<glm::vec4> color = rasterizer->read_color();
  glm::vec2 red(0), green(0);
  float reds = 0, greens = 0;
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      const glm::vec4 c = color[pixel(x, y)];
      if (c.x > 0.5f) red += glm::vec2(x, y), ++reds;
      if (c.y > 0.5f) green += glm::vec2(x, y), ++greens;
    }
  ASSERT_GT(reds, 10.0f);
  ASSERT_GT(greens, 10.0f);
  // Bottom row first: up is a larger y.
  EXPECT_LT(red.x / reds, green.x / greens);
  EXPECT_GT(red.y / reds, green.y / greens);
}

TEST_F(RasterOpaque, texture_rows_start_at_the_top) {
  SceneBuilder builder;
  const uint8_t texels[] = {255, 0, 0, 255, 0, 255, 0, 255, 0, 0, 255, 255, 255, 255, 255, 255};
  sideray_material_desc d = unlit({1, 1, 1, 1});
  d.base_color_texture.texture = builder.scene.add_texture(2, 2, SIDERAY_RGBA8, texels);
  d.base_color_texture.filter = SIDERAY_NEAREST;
  builder.quad(builder.material(d), {0, 0, 0});
  draw_opaque(builder.commit(), camera_at({0, 0, 5}));
  const std::vector<glm::vec4> color = rasterizer->read_color();
  expect_near(color[pixel(width / 2 - 6, height / 2 + 6)], {1, 0, 0, 1}, 1e-3f);
  expect_near(color[pixel(width / 2 + 6, height / 2 + 6)], {0, 1, 0, 1}, 1e-3f);
  expect_near(color[pixel(width / 2 - 6, height / 2 - 6)], {0, 0, 1, 1}, 1e-3f);
}

TEST_F(RasterOpaque, mirrored_instances_show_their_front) {
  for (const bool mirrored : {false, true})
    for (const bool from_behind : {false, true}) {
      SceneBuilder builder;
      builder.quad(builder.material(unlit({1, 1, 1, 1})),
                   glm::scale(glm::dmat4(1), glm::dvec3(mirrored ? -1 : 1, 1, 1)));
      draw_opaque(builder.commit(), camera_at({0, 0, from_behind ? -5 : 5}));
      EXPECT_EQ(rasterizer->read_color()[middle()].w, from_behind ? 0.0f : 1.0f) << mirrored << from_behind;
    }
}

TEST_F(RasterOpaque, normals_face_the_viewer_on_both_sides) {
  for (const int z : {5, -5}) {
    SceneBuilder builder;
    sideray_material_desc d = plain_material();
    d.double_sided = 1;
    builder.quad(builder.material(d), glm::scale(glm::dmat4(1), glm::dvec3(1, -1, 3)));
    draw_opaque(builder.commit(), camera_at({0, 0, z}));
    const glm::vec4 normal = rasterizer->read_gbuffer().normal_roughness[middle()];
    expect_near(normal, {0, 0, z > 0 ? 1 : -1, 1}, 1e-3f);
  }
}

TEST_F(RasterOpaque, edits_show_after_the_next_commit) {
  SceneBuilder builder;
  const uint32_t red = builder.material(unlit({1, 0, 0, 1}));
  builder.quad(red, {0, 0, 0});
  const auto first = builder.commit();
  draw_opaque(first, camera_at({0, 0, 5}));
  expect_near(rasterizer->read_color()[middle()], {1, 0, 0, 1}, 1e-3f);
  builder.quad(builder.material(unlit({0, 1, 0, 1})), {0, 0, 1});
  const double away[12] = {1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 100, 0};
  const uint32_t both[] = {1, 2};
  builder.scene.move_instances(&both[0], 1, away);
  const auto second = builder.commit();
  draw_opaque(second, camera_at({0, 0, 5}));
  expect_near(rasterizer->read_color()[middle()], {0, 1, 0, 1}, 1e-3f);
  builder.scene.move_instances(&both[1], 1, away);
  draw_opaque(builder.commit(), camera_at({0, 0, 5}));
  EXPECT_EQ(rasterizer->read_color()[middle()].w, 0.0f);
  draw_opaque(first, camera_at({0, 0, 5}));
  expect_near(rasterizer->read_color()[middle()], {1, 0, 0, 1}, 1e-3f);
}

TEST_F(RasterOpaque, pictures_far_from_the_origin_are_those_at_the_origin) {
  std::vector<float> depth[2];
  for (const bool far : {false, true}) {
    const glm::dvec3 offset = far ? glm::dvec3(1024.0 * 977, -1024.0 * 5, 1024.0 * 400) : glm::dvec3(0);
    SceneBuilder builder;
    builder.quad(builder.material(plain_material()),
                 glm::rotate(glm::translate(glm::dmat4(1), offset), 0.5, glm::dvec3(1, 1, 0)));
    draw_opaque(builder.commit(), camera_at(offset + glm::dvec3(0, 0, 5), offset));
    depth[far] = rasterizer->read_depth();
  }
  EXPECT_EQ(depth[0], depth[1]);
}

TEST_F(RasterOpaque, mask_leaves_out_what_is_below_the_cutoff) {
  SceneBuilder builder;
  const uint8_t texels[] = {255, 255, 255, 100, 255, 255, 255, 200};
  sideray_material_desc d = unlit({1, 1, 1, 1}, SIDERAY_MASK);
  d.base_color_texture.texture = builder.scene.add_texture(2, 1, SIDERAY_RGBA8, texels);
  d.base_color_texture.filter = SIDERAY_NEAREST;
  builder.quad(builder.material(d), {0, 0, 0});
  draw_opaque(builder.commit(), camera_at({0, 0, 5}));
  const std::vector<glm::vec4> color = rasterizer->read_color();
  EXPECT_EQ(color[pixel(width / 2 - 4, height / 2)].w, 0.0f);
  EXPECT_EQ(color[pixel(width / 2 + 4, height / 2)].w, 1.0f);
}

// Lambert under a directional light and a constant sky; no specular part, so that the closed form is exact.
TEST_F(RasterOpaque, diffuse_light_and_sky_are_their_closed_forms) {
  for (const bool orthographic : {false, true}) {
    SceneBuilder builder;
    sideray_material_desc d = plain_material();
    d.specular = 0;
    d.base_color[0] = 0.5f, d.base_color[1] = 0.25f;
    builder.quad(builder.material(d), {0, 0, 0});
    builder.sky({0.2f, 0.4f, 0.8f});
    sideray_light light{};
    light.size = sizeof(light);
    light.type = SIDERAY_LIGHT_DIRECTIONAL;
    light.direction[1] = -0.6f, light.direction[2] = -0.8f;
    for (float& c : light.intensity) c = 3;
    builder.scene.set_lights(&light, 1);
    sideray_camera camera = camera_at({0, 0, 5});
    camera.orthographic = orthographic;
    camera.half_height = 2;
    camera.z_far = 50;
    draw_opaque(builder.commit(), camera, true);
    const glm::vec3 albedo(0.5f, 0.25f, 1);
    const glm::vec3 expected = albedo * (3.0f * 0.8f / 3.14159265f) + albedo * glm::vec3(0.2f, 0.4f, 0.8f);
    expect_near(rasterizer->read_color()[middle()], glm::vec4(expected, 1), 2e-3f);
    expect_near(rasterizer->read_color()[pixel(1, 1)], {0.2f, 0.4f, 0.8f, 0}, 1e-3f);
  }
}

// A wall under an occluder: the edge of the shadow is where geometry puts it, and nothing else is shadowed.
TEST_F(RasterOpaque, shadow_edges_lie_where_they_should) {
  for (const sideray_light_type type : {SIDERAY_LIGHT_DIRECTIONAL, SIDERAY_LIGHT_POINT, SIDERAY_LIGHT_SPOT}) {
    SceneBuilder builder;
    sideray_material_desc d = plain_material();
    d.specular = 0;
    d.double_sided = 1;
    const uint32_t material = builder.material(d);
    builder.quad(material, {0, 0, 0}, 3);
    builder.quad(material, {0, 0, 1}, 0.5);
    sideray_light light{};
    light.size = sizeof(light);
    light.type = type;
    light.position[2] = 3;
    light.direction[2] = -1;
    light.inner_cone = 0.9f, light.outer_cone = 1.0f;
    for (float& c : light.intensity) c = 10;
    builder.scene.set_lights(&light, 1);
    // From the side of the occluder, so that it does not hide its shadow.
    width = height = 256;
    sideray_camera camera = camera_at({6, 0, 6}, {0.5, 0, 0});
    camera.yfov = 0.5f;
    const RasterView view = draw_opaque(builder.commit(), camera, true);
    const std::vector<glm::vec4> with = rasterizer->read_color();
    rasterizer->light(false);
    const std::vector<glm::vec4> without = rasterizer->read_color();
    const double edge = type == SIDERAY_LIGHT_DIRECTIONAL ? 0.5 : 0.75;  // half the shadow's width
    const double texel = 6.1 / (type == SIDERAY_LIGHT_DIRECTIONAL ? 2048 : 1024) * 2;
    size_t lit = 0, dark = 0;
    for (uint32_t y = 0; y < height; ++y)
      for (uint32_t x = 0; x < width; ++x) {
        const glm::dvec4 p =
            view.local_from_clip * glm::dvec4((2.0 * x + 1) / width - 1, (2.0 * y + 1) / height - 1, 0.5, 1);
        const glm::dvec3 eye(view.eye), direction = glm::dvec3(p / p.w) - eye;
        const glm::dvec3 on_occluder = eye + direction * ((1 - eye.z) / direction.z);
        if (std::max(std::abs(on_occluder.x), std::abs(on_occluder.y)) < 0.55) continue;
        const glm::dvec3 wall = eye + direction * (-eye.z / direction.z);
        const double outside = std::max(std::abs(wall.x), std::abs(wall.y)) - edge;
        if (std::max(std::abs(wall.x), std::abs(wall.y)) > 2.9 || without[pixel(x, y)].x == 0.0f) continue;
        if (outside > 3 * texel) {
          ++lit;
          EXPECT_EQ(with[pixel(x, y)], without[pixel(x, y)]) << "light " << type << " at " << wall.x << "," << wall.y;
        } else if (outside < -3 * texel) {
          ++dark;
          EXPECT_EQ(with[pixel(x, y)].x, 0.0f) << "light " << type << " at " << wall.x << "," << wall.y;
        }
      }
    EXPECT_GT(lit, 1000u);
    EXPECT_GT(dark, 300u);
  }
}

// Half of the occluder's texture is cut out: a wall behind it is dark behind the other half alone.
TEST_F(RasterOpaque, cut_out_texels_cast_no_shadow) {
  for (const sideray_light_type type : {SIDERAY_LIGHT_DIRECTIONAL, SIDERAY_LIGHT_POINT, SIDERAY_LIGHT_SPOT}) {
    SceneBuilder builder;
    sideray_material_desc wall = plain_material();
    wall.specular = 0;
    builder.quad(builder.material(wall), {0, 0, 0}, 3);
    const uint8_t texels[] = {255, 255, 255, 0, 255, 255, 255, 255};
    sideray_material_desc cut = unlit({1, 1, 1, 1}, SIDERAY_MASK);
    cut.base_color_texture.texture = builder.scene.add_texture(2, 1, SIDERAY_RGBA8, texels);
    cut.base_color_texture.filter = SIDERAY_NEAREST;
    builder.quad(builder.material(cut), {0, 0, 1}, 0.5);
    sideray_light light{};
    light.size = sizeof(light);
    light.type = type;
    light.position[2] = 3;
    light.direction[2] = -1;
    light.inner_cone = 0.9f, light.outer_cone = 1.0f;
    for (float& c : light.intensity) c = 10;
    builder.scene.set_lights(&light, 1);
    // Low from aside, where the occluder hides nothing of its shadow.
    const RasterView view = draw_opaque(builder.commit(), camera_at({0, -6, 2}), true);
    const std::vector<glm::vec4> color = rasterizer->read_color();
    const auto at = [&](double x) {
      const glm::dvec4 p = view.clip_from_local * glm::dvec4(x, 0, 0, 1);
      return color[pixel(static_cast<uint32_t>((p.x / p.w * 0.5 + 0.5) * width),
                         static_cast<uint32_t>((p.y / p.w * 0.5 + 0.5) * height))]
          .x;
    };
    EXPECT_GT(at(-0.25), 0.0f) << "light " << type;
    EXPECT_EQ(at(0.25), 0.0f) << "light " << type;
  }
}

TEST_F(RasterOpaque, a_plane_never_shadows_itself) {
  for (const sideray_light_type type : {SIDERAY_LIGHT_DIRECTIONAL, SIDERAY_LIGHT_POINT, SIDERAY_LIGHT_SPOT})
    for (const double angle : {0.0, 0.4, 0.9, 1.3, 1.5}) {
      SceneBuilder builder;
      sideray_material_desc d = plain_material();
      d.specular = 0;
      d.double_sided = 1;
      // Turned about an oblique axis, so that texels do not line up with it.
      const glm::dvec3 axis = glm::normalize(glm::dvec3(1, 0.7, 0));
      builder.quad(builder.material(d),
                   glm::scale(glm::rotate(glm::dmat4(1), 0.37, glm::dvec3(0, 0, 1)), glm::dvec3(4)));
      const glm::dvec3 to_light = glm::dvec3(glm::rotate(glm::dmat4(1), angle, axis) * glm::dvec4(0, 0, 1, 0));
      sideray_light light{};
      light.size = sizeof(light);
      light.type = type;
      for (int c = 0; c < 3; ++c) {
        light.position[c] = 5 * to_light[c];
        light.direction[c] = static_cast<float>(-to_light[c]);
        light.intensity[c] = 10;
      }
      light.inner_cone = 0.7f, light.outer_cone = 0.8f;
      builder.scene.set_lights(&light, 1);
      draw_opaque(builder.commit(), camera_at({0, 0, 9}), true);
      const std::vector<glm::vec4> with = rasterizer->read_color();
      rasterizer->light(false);
      const std::vector<glm::vec4> without = rasterizer->read_color();
      size_t shadowed = 0, lit = 0;
      for (size_t i = 0; i < with.size(); ++i) shadowed += with[i] != without[i], lit += without[i].x > 0;
      EXPECT_EQ(shadowed, 0u) << "light " << type << ", angle " << angle;
      EXPECT_GT(lit, 500u);
    }
}

}  // namespace
}  // namespace sideray::gl::tests
