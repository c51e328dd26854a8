#include <cstring>

#include "gl/raster/raster_scene_builder.h"
#include "gl/resources/objects.h"

namespace sideray::gl::tests {
namespace {

struct RasterTranslucent : RasterTest {
  // A pane before an unlit wall, seen at the picture's middle.
  glm::vec4 over_wall(const sideray_material_desc& pane, glm::vec4 wall) {
    SceneBuilder builder;
    builder.quad(builder.material(unlit(wall)), {0, 0, -1}, 5, 1);
    builder.quad(builder.material(pane), {0, 0, 0}, 1, 2);
    draw_opaque(builder.commit(), camera_at({0, 0, 5}));
    rasterizer->translucency({});
    return rasterizer->read_color()[middle()];
  }
};

sideray_material_desc pane(sideray_blend_mode blend, glm::vec4 color) {
  sideray_material_desc d = unlit(color, SIDERAY_BLEND);
  d.blend_mode = blend;
  return d;
}

TEST_F(RasterTranslucent, blend_modes_are_their_closed_forms) {
  const glm::vec4 wall(0.25f, 0.5f, 0.75f, 1), color(0.8f, 0.2f, 0.4f, 0.25f);
  const glm::vec4 c(glm::vec3(color), 1);
  expect_near(over_wall(pane(SIDERAY_BLEND_ALPHA, color), wall), c * 0.25f + wall * 0.75f, 1e-3f);
  expect_near(over_wall(pane(SIDERAY_BLEND_PREMULTIPLIED, color), wall),
              glm::vec4(glm::vec3(c) + glm::vec3(wall) * 0.75f, 1), 1e-3f);
  expect_near(over_wall(pane(SIDERAY_BLEND_ADDITIVE, color), wall),
              glm::vec4(glm::vec3(c) * 0.25f + glm::vec3(wall), 1), 1e-3f);
  expect_near(over_wall(pane(SIDERAY_BLEND_MULTIPLY, color), wall),
              glm::vec4(glm::vec3(wall) * (0.75f + 0.25f * glm::vec3(c)), 1), 1e-3f);
}

TEST_F(RasterTranslucent, straight_transmission_is_tint_times_what_is_not_reflected) {
  sideray_material_desc d = plain_material();
  d.base_color[0] = 0.5f;
  d.transmission = 1;
  d.roughness = 0;
  // Normal incidence: F = ((1.5 - 1) / (1.5 + 1))^2 = 0.04; nothing to reflect in black surroundings.
  const glm::vec4 wall(0.5f, 0.5f, 1.0f, 1);
  expect_near(over_wall(d, wall), glm::vec4(0.5f * 0.5f * 0.96f, 0.5f * 0.96f, 0.96f, 1), 1e-3f);
  // A rough surface lets through what its lobe does not reflect: the last entry of the table, of roughness 1 and n.v 1.
  d.roughness = 1;
  const glm::vec3 terms = model::albedo_table().values.back();
  const float lost = 1.0f / (terms.x + terms.y) - 1.0f;
  const float through = 1.0f - (0.04f * terms.x + terms.y) * (1.0f + 0.04f * lost);
  EXPECT_GT(through, 0.965f);
  expect_near(over_wall(d, wall), glm::vec4(0.5f * 0.5f * through, 0.5f * through, through, 1), 1e-3f);
}

TEST_F(RasterTranslucent, alpha_is_one_minus_the_mean_transmittance_over_sky) {
  SceneBuilder builder;
  uint32_t id = 0;
  for (const double z : {0.0, 0.5})
    builder.quad(builder.material(pane(SIDERAY_BLEND_ALPHA, {1, 1, 1, 0.25f})), {0, 0, z}, 1, ++id);
  draw_opaque(builder.commit(), camera_at({0, 0, 5}));
  rasterizer->translucency({});
  EXPECT_NEAR(rasterizer->read_color()[middle()].w, 1.0f - 0.75f * 0.75f, 1e-4f);
  EXPECT_EQ(rasterizer->read_color()[pixel(0, 0)].w, 0.0f);
}

TEST_F(RasterTranslucent, panes_are_sorted_and_hidden_ones_do_not_show) {
  SceneBuilder builder;
  builder.quad(builder.material(unlit({0, 0, 0, 1})), {0, 0, -1}, 5, 1);
  // Added in an order that is neither front to back nor back to front.
  builder.quad(builder.material(pane(SIDERAY_BLEND_ALPHA, {1, 0, 0, 0.5f})), {0, 0, 0.5}, 1, 2);
  builder.quad(builder.material(pane(SIDERAY_BLEND_ALPHA, {0, 0, 1, 0.5f})), {0, 0, 1.0}, 1, 3);
  builder.quad(builder.material(pane(SIDERAY_BLEND_ALPHA, {0, 1, 0, 0.5f})), {0, 0, 0.0}, 1, 4);
  builder.quad(builder.material(pane(SIDERAY_BLEND_ALPHA, {1, 1, 1, 0.5f})), {0, 0, -2}, 1, 5);
  draw_opaque(builder.commit(), camera_at({0, 0, 5}));
  rasterizer->translucency({});
  expect_near(rasterizer->read_color()[middle()], {0.25f, 0.125f, 0.5f, 1}, 1e-3f);
}

TEST_F(RasterTranslucent, a_two_sided_pane_is_blended_once_from_either_side) {
  for (const int z : {5, -5})
    for (const bool mirrored : {false, true}) {
      SceneBuilder builder;
      sideray_material_desc d = pane(SIDERAY_BLEND_ALPHA, {1, 1, 1, 0.25f});
      d.double_sided = 1;
      builder.quad(builder.material(d), glm::scale(glm::dmat4(1), glm::dvec3(mirrored ? -1 : 1, 1, 1)));
      draw_opaque(builder.commit(), camera_at({0, 0, z}));
      rasterizer->translucency({});
      expect_near(rasterizer->read_color()[middle()], {0.25f, 0.25f, 0.25f, 0.25f}, 1e-3f);
    }
}

// Objects at the same distance are composed as rays would hit them: the smaller surface id lies in front.
TEST_F(RasterTranslucent, equal_distances_put_the_smaller_surface_id_in_front) {
  for (const bool swapped : {false, true}) {
    SceneBuilder builder;
    builder.quad(builder.material(pane(SIDERAY_BLEND_ALPHA, {1, 0, 0, 0.5f})), {0, 0, 0}, 1, swapped ? 3 : 2);
    builder.quad(builder.material(pane(SIDERAY_BLEND_ALPHA, {0, 1, 0, 0.5f})), {0, 0, 0}, 1, swapped ? 2 : 3);
    draw_opaque(builder.commit(), camera_at({0, 0, 5}));
    rasterizer->translucency({});
    const glm::vec4 color = rasterizer->read_color()[middle()];
    EXPECT_EQ(color.x > color.y, !swapped);
  }
}

TEST_F(RasterTranslucent, count_mask_counts_panes_and_saturates) {
  for (const uint32_t count : {1u, 5u, 62u, 70u}) {
    SceneBuilder builder;
    const uint32_t material = builder.material(pane(SIDERAY_BLEND_ALPHA, {1, 1, 1, 0.1f}));
    for (uint32_t i = 0; i < count; ++i) builder.quad(material, {0, 0, -0.01 * i}, 1, i + 1);
    draw_opaque(builder.commit(), camera_at({0, 0, 5}));
    rasterizer->mask(MaskKind::count, TracedSet::visible_in_layers);
    const std::vector<uint8_t> stencil = rasterizer->read_stencil();
    EXPECT_EQ(stencil[middle()], std::min(count, mask_stencil_bits));
    EXPECT_EQ(stencil[pixel(0, 0)], 0);
    rasterizer->mask(MaskKind::stencil, TracedSet::visible_in_layers);
    EXPECT_EQ(rasterizer->read_stencil()[middle()], 1);
  }
}

TEST_F(RasterTranslucent, mask_follows_cull_rule_depth_alpha_and_set) {
  const auto counts = [&](const sideray_material_desc& d, double z, uint32_t surface_id, uint32_t visibility,
                          bool turned) {
    SceneBuilder builder;
    builder.quad(builder.material(unlit({1, 1, 1, 1})), {0, 0, -1}, 5, 1);
    glm::dmat4 m = glm::translate(glm::dmat4(1), glm::dvec3(0, 0, z));
    if (turned) m = glm::rotate(m, 3.14159265358979, glm::dvec3(0, 1, 0));
    builder.quad(builder.material(d), m, surface_id, visibility);
    draw_opaque(builder.commit(), camera_at({0, 0, 5}));
    std::array<int, 2> result{};
    for (const TracedSet set : {TracedSet::visible_in_layers, TracedSet::all_translucent}) {
      rasterizer->mask(MaskKind::count, set);
      result[set == TracedSet::all_translucent] = rasterizer->read_stencil()[middle()];
    }
    return result;
  };
  using Counts = std::array<int, 2>;
  const sideray_material_desc glass = pane(SIDERAY_BLEND_ALPHA, {1, 1, 1, 0.5f});
  EXPECT_EQ(counts(glass, 0, 2, SIDERAY_VISIBLE_ALL, false), (Counts{1, 1}));
  EXPECT_EQ(counts(glass, 0, 2, SIDERAY_VISIBLE_ALL, true), (Counts{0, 0}));
  sideray_material_desc two_sided = glass;
  two_sided.double_sided = 1;
  EXPECT_EQ(counts(two_sided, 0, 2, SIDERAY_VISIBLE_ALL, true), (Counts{1, 1}));
  EXPECT_EQ(counts(glass, -2, 2, SIDERAY_VISIBLE_ALL, false), (Counts{0, 0}));
  EXPECT_EQ(counts(glass, 0, 0, SIDERAY_VISIBLE_ALL, false), (Counts{0, 1}));
  EXPECT_EQ(counts(glass, 0, 2, SIDERAY_VISIBLE_REFLECTION, false), (Counts{0, 1}));
  EXPECT_EQ(counts(pane(SIDERAY_BLEND_MULTIPLY, {1, 1, 1, 0.5f}), 0, 2, SIDERAY_VISIBLE_ALL, false), (Counts{0, 1}));
  EXPECT_EQ(counts(pane(SIDERAY_BLEND_ALPHA, {1, 1, 1, 0.003f}), 0, 2, SIDERAY_VISIBLE_ALL, false), (Counts{0, 0}));
  EXPECT_EQ(counts(pane(SIDERAY_BLEND_ALPHA, {1, 1, 1, 0.005f}), 0, 2, SIDERAY_VISIBLE_ALL, false), (Counts{1, 1}));
}

// A cache of one layer that covers the frame, filled by hand.
struct HandMadeCache {
  HandMadeCache(const Functions& functions, uint32_t width, uint32_t height, const std::vector<float>& distances,
                uint32_t id, glm::vec4 color)
      : gl(functions), radiance(functions), distance(functions), surface_id(functions) {
    const size_t texels = size_t{width} * height;
    const std::vector<glm::vec4> colors(texels, color);
    const std::vector<uint32_t> ids(texels, id);
    const auto upload = [&](const Texture& texture, GLint internal, GLenum format, GLenum type, const void* data) {
      gl.BindTexture(GL_TEXTURE_2D_ARRAY, texture.id());
      gl.TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
      gl.TexParameteri(GL_TEXTURE_2D_ARRAY, GL_TEXTURE_MAG_FILTER, GL_NEAREST);
      gl.TexImage3D(GL_TEXTURE_2D_ARRAY, 0, internal, static_cast<GLsizei>(width), static_cast<GLsizei>(height), 1, 0,
                    format, type, data);
    };
    upload(radiance, GL_RGBA16F, GL_RGBA, GL_FLOAT, colors.data());
    upload(distance, GL_R32F, GL_RED, GL_FLOAT, distances.data());
    upload(surface_id, GL_R32UI, GL_RED_INTEGER, GL_UNSIGNED_INT, ids.data());
  }

  void bind(uint32_t program, uint32_t first_unit, glm::vec3 eye, int layers) const {
    const auto place = [&](const char* name, uint32_t unit, const Texture& texture) {
      gl.ActiveTexture(GL_TEXTURE0 + unit);
      gl.BindTexture(GL_TEXTURE_2D_ARRAY, texture.id());
      gl.Uniform1i(gl.GetUniformLocation(program, name), static_cast<GLint>(unit));
    };
    place("sideray_radiance", first_unit, radiance);
    place("sideray_distance", first_unit + 1, distance);
    place("sideray_surface_id", first_unit + 2, surface_id);
    gl.Uniform1i(gl.GetUniformLocation(program, "sideray_layers"), layers);
    gl.Uniform4f(gl.GetUniformLocation(program, "sideray_viewport"), 0, 0, 1, 1);
    gl.Uniform4f(gl.GetUniformLocation(program, "sideray_eye"), eye.x, eye.y, eye.z, 1);
    gl.Uniform4f(gl.GetUniformLocation(program, "sideray_near_plane"), 0, 0, -1, 0);  // the camera looks along -z
    gl.Uniform1i(gl.GetUniformLocation(program, "sideray_match"), SIDERAY_MATCH_ID);
    gl.Uniform1f(gl.GetUniformLocation(program, "sideray_subpixel"), 0x0.8p-8f);
  }

  const Functions& gl;
  Texture radiance, distance, surface_id;
};

// Distances from the eye to the plane z = 0 at every pixel centre.
std::vector<float> plane_distances(const RasterView& view, uint32_t width, uint32_t height) {
  std::vector<float> distances;
  for (uint32_t y = 0; y < height; ++y)
    for (uint32_t x = 0; x < width; ++x) {
      const glm::dvec4 p =
          view.local_from_clip * glm::dvec4((2.0 * x + 1) / width - 1, (2.0 * y + 1) / height - 1, 0.5, 1);
      const glm::dvec3 eye(view.eye), direction = glm::normalize(glm::dvec3(p / p.w) - eye);
      distances.push_back(static_cast<float>(-eye.z / direction.z));
    }
  return distances;
}

TEST_F(RasterTranslucent, matched_fragments_take_the_layer_and_are_counted) {
  SceneBuilder builder;
  const uint32_t material = builder.material(pane(SIDERAY_BLEND_ALPHA, {1, 0, 0, 0.5f}));
  builder.quad(material, {0, 0, 0}, 1, 2);
  builder.quad(material, {0, 0, -0.5}, 1, 3);  // not in the cache
  const RasterView view = draw_opaque(builder.commit(), camera_at({0, 0, 5}));
  const HandMadeCache cache(context->functions(), width, height, plane_distances(view, width, height), 2, {0, 0, 4, 1});
  Translucency pass;
  pass.traced = TracedSet::visible_in_layers;
  pass.count_fragments = true;
  pass.bind_cache = [&](uint32_t program, uint32_t first_unit) { cache.bind(program, first_unit, view.eye, 1); };
  const FragmentCounts counts = rasterizer->translucency(pass);
  expect_near(rasterizer->read_color()[middle()], {0.25f, 0, 2, 0.75f}, 1e-3f);
  // As many fragments as the mask counts; those of the nearer quad matched.
  rasterizer->mask(MaskKind::count, TracedSet::visible_in_layers);
  uint64_t masked = 0;
  for (const uint8_t s : rasterizer->read_stencil()) masked += s;
  EXPECT_EQ(counts.matched + counts.missed, masked);
  EXPECT_GT(counts.matched, counts.missed);
  EXPECT_GT(counts.missed, 0u);
}

TEST_F(RasterTranslucent, no_layers_is_plain_raster_bit_for_bit) {
  SceneBuilder builder;
  builder.sky({0.3f, 0.5f, 0.9f});
  sideray_material_desc glass = plain_material();
  glass.alpha_mode = SIDERAY_BLEND;
  glass.base_color[1] = 0.3f, glass.base_color[3] = 0.4f;
  glass.roughness = 0.2f;
  glass.double_sided = 1;
  const uint32_t material = builder.material(glass);
  for (uint32_t i = 0; i < 6; ++i)
    builder.quad(material,
                 glm::rotate(glm::translate(glm::dmat4(1), glm::dvec3(0.3 * i - 1, 0, -0.2 * i)), 0.4 * i,
                             glm::dvec3(0.3, 1, 0.1)),
                 i + 1);
  sideray_light light{};
  light.size = sizeof(light);
  light.type = SIDERAY_LIGHT_POINT;
  light.position[1] = 2, light.position[2] = 2;
  for (float& c : light.intensity) c = 5;
  builder.scene.set_lights(&light, 1);
  const auto snapshot = builder.commit();
  const auto draw = [&](Translucency pass) {
    draw_opaque(snapshot, camera_at({0, 0, 5}), true);
    rasterizer->translucency(pass);
    return rasterizer->read_color();
  };
  const std::vector<glm::vec4> plain = draw({});
  Translucency pass;
  pass.traced = TracedSet::visible_in_layers;
  const RasterView view = rasterizer->make_view(camera_at({0, 0, 5}), {});
  const HandMadeCache cache(context->functions(), width, height, plane_distances(view, width, height), 1, {0, 0, 4, 1});
  pass.bind_cache = [&](uint32_t program, uint32_t first_unit) { cache.bind(program, first_unit, view.eye, 0); };
  const std::vector<glm::vec4> no_layers = draw(pass);
  EXPECT_EQ(std::memcmp(plain.data(), no_layers.data(), plain.size() * sizeof(glm::vec4)), 0);
  pass.bind_cache = nullptr;
  const std::vector<glm::vec4> no_cache = draw(pass);
  EXPECT_EQ(std::memcmp(plain.data(), no_cache.data(), plain.size() * sizeof(glm::vec4)), 0);
}

TEST_F(RasterTranslucent, traced_composite_is_radiance_plus_transmitted_picture) {
  SceneBuilder builder;
  builder.quad(builder.material(unlit({0.5f, 0.5f, 0.5f, 1})), {0, 0, 0});
  draw_opaque(builder.commit(), camera_at({0, 0, 5}));
  const Functions& gl = context->functions();
  const std::vector<glm::vec4> radiance(size_t{width} * height, {0.25f, 0, 1, 1}),
      transmittance(size_t{width} * height, {0.5f, 0.25f, 0.75f, 1});
  Texture textures[2] = {Texture(gl), Texture(gl)};
  for (int i = 0; i < 2; ++i) {
    gl.BindTexture(GL_TEXTURE_2D, textures[i].id());
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_NEAREST);
    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA16F, static_cast<GLsizei>(width), static_cast<GLsizei>(height), 0, GL_RGBA,
                  GL_FLOAT, i == 0 ? radiance.data() : transmittance.data());
  }
  rasterizer->composite_traced(textures[0].id(), textures[1].id());
  const std::vector<glm::vec4> color = rasterizer->read_color();
  expect_near(color[middle()], {0.5f, 0.125f, 1.375f, 1}, 1e-3f);
  expect_near(color[pixel(0, 0)], {0.25f, 0, 1, 0.5f}, 1e-3f);
}

}  // namespace
}  // namespace sideray::gl::tests
