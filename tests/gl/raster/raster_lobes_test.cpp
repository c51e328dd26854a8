// Compares clear coat, sheen, diffuse transmission, thin films and all texture slots in the passes with shading.h in
// C++.
#include <algorithm>
#include <cmath>

#include "gl/raster/raster_scene_builder.h"
#include "model/material_slots.h"
#include "shaders/shading/shading_cpp.h"

namespace sideray::gl::tests {
namespace {

using shading::SrSurface;

constexpr glm::vec3 sky(0.3f, 0.5f, 0.9f);
constexpr glm::vec3 eye(2.0f, 1.0f, 4.0f);

struct RasterLobes : RasterTest {};

// z of the albedo table and its terms, bilinear between its entries.
glm::vec3 albedo_at(float n_v, float roughness) {
  constexpr int size = model::AlbedoTable::size;
  const std::vector<glm::vec3>& values = model::albedo_table().values;
  const auto at = [&](int column, int row) {
    return values[static_cast<size_t>(std::clamp(row, 0, size - 1) * size + std::clamp(column, 0, size - 1))];
  };
  const float x = n_v * (size - 1), y = roughness * (size - 1);
  const int i = static_cast<int>(std::floor(x)), j = static_cast<int>(std::floor(y));
  const float u = x - std::floor(x), v = y - std::floor(y);
  return glm::mix(glm::mix(at(i, j), at(i + 1, j), u), glm::mix(at(i, j + 1), at(i + 1, j + 1), u), v);
}

sideray_light sun(glm::vec3 direction, float irradiance) {
  sideray_light light{};
  light.size = sizeof(light);
  light.type = SIDERAY_LIGHT_DIRECTIONAL;
  for (int c = 0; c < 3; ++c) light.direction[c] = direction[c], light.intensity[c] = irradiance;
  return light;
}

const std::vector<sideray_light>& suns() {
  static const std::vector<sideray_light> two = {sun({-0.3f, -0.5f, -0.8f}, 3), sun({0.2f, -0.4f, 0.9f}, 2)};
  return two;
}

// Returns the radiance from the surface at `position` toward the eye under the suns and a uniform sky; `s` has its
// film.
glm::vec3 expected_radiance(SrSurface s, glm::vec3 position) {
  const glm::vec3 to_eye = glm::normalize(eye - position);
  const float n_v = std::abs(glm::dot(s.normal, to_eye));
  const float alike = shading::sr_round_roughness(s), masked = shading::sr_round_cosine(s, to_eye);
  const glm::vec2 terms =
      shading::sr_brushed_terms(s, glm::vec2(albedo_at(n_v, alike)), glm::vec2(albedo_at(masked, alike)));
  s = shading::sr_seen(s, to_eye, terms, albedo_at(n_v, s.sheen_roughness).z);
  glm::vec3 sum = shading::sr_emitted(s);
  for (const sideray_light& light : suns()) {
    const glm::vec3 direction(light.direction[0], light.direction[1], light.direction[2]);
    sum += shading::sr_reflect_light(s, to_eye, -glm::normalize(direction)) * light.intensity[0];
  }
  return sum + shading::sr_environment(s, n_v, {sky, sky, sky, sky});
}

shading::SrMaterial factors_of(const sideray_material_desc& d) {
  const auto color = [](const float* c) { return glm::vec3(c[0], c[1], c[2]); };
  shading::SrMaterial m{};
  m.base_color = glm::vec4(color(d.base_color), d.base_color[3]);
  m.emissive = color(d.emissive);
  m.specular_color = color(d.specular_color);
  m.metallic = d.metallic, m.roughness = d.roughness, m.ior = d.ior, m.specular = d.specular;
  m.clearcoat = d.clearcoat, m.clearcoat_roughness = d.clearcoat_roughness;
  m.sheen_color = color(d.sheen_color), m.sheen_roughness = d.sheen_roughness;
  m.diffuse_transmission = d.diffuse_transmission;
  m.diffuse_transmission_color = color(d.diffuse_transmission_color);
  m.iridescence = d.iridescence, m.iridescence_ior = d.iridescence_ior;
  m.iridescence_thickness_min = d.iridescence_thickness_min;
  m.iridescence_thickness_max = d.iridescence_thickness_max;
  m.anisotropy = d.anisotropy;
  m.anisotropy_cosine = std::cos(d.anisotropy_rotation), m.anisotropy_sine = std::sin(d.anisotropy_rotation);
  m.alpha_mode = d.alpha_mode;
  m.unlit = d.unlit != 0;
  return m;
}

constexpr glm::vec3 one(1.0f);
constexpr shading::SrTexels no_texels{glm::vec4(1.0f),
                                      one,
                                      1.0f,
                                      1.0f,
                                      1.0f,
                                      1.0f,
                                      1.0f,
                                      1.0f,
                                      one,
                                      1.0f,
                                      1.0f,
                                      one,
                                      1.0f,
                                      1.0f,
                                      one,
                                      1.0f,
                                      1.0f,
                                      1.0f,
                                      0.0f,
                                      1.0f};

SrSurface filmed_surface(const sideray_material_desc& d, const shading::SrTexels& texels, glm::vec3 normal,
                         glm::vec3 coat_normal, glm::vec3 position) {
  const shading::SrMaterial m = factors_of(d);
  SrSurface s = shading::sr_surface(m, texels, normal, coat_normal);
  s = shading::sr_brushed(s, m, texels, {0, 0, 1}, {1, 0, 0, 1});
  return shading::sr_filmed(s, m, texels, glm::normalize(eye - position));
}

sideray_material_desc lobed(uint32_t lobes) {
  sideray_material_desc d = plain_material();
  d.base_color[0] = 0.8f, d.base_color[1] = 0.4f, d.base_color[2] = 0.2f;
  d.metallic = 0.3f, d.roughness = 0.6f, d.specular = 0.7f;
  d.emissive[1] = 0.25f;
  if (lobes & 1) d.clearcoat = 0.8f, d.clearcoat_roughness = 0.2f;
  if (lobes & 2) d.sheen_color[0] = 0.6f, d.sheen_color[2] = 0.9f, d.sheen_roughness = 0.5f;
  if (lobes & 4) d.diffuse_transmission = 0.6f, d.diffuse_transmission_color[2] = 0.3f;
  if (lobes & 8) {
    d.iridescence = 0.9f, d.iridescence_ior = 1.8f;
    d.iridescence_thickness_min = 150, d.iridescence_thickness_max = 420;
  }
  if (lobes & 16) d.anisotropy = 0.8f, d.anisotropy_rotation = 0.7f;
  return d;
}

// Half floats in the G-buffer: a step of 2^-11 in each of several factors.
void expect_close(glm::vec3 actual, glm::vec3 expected) {
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(actual[c], expected[c], 4e-3f * std::max(expected[c], 0.05f)) << "channel " << c;
}

struct Shown {
  glm::vec3 color, position;
};

// A quad across z = 0 in the middle of the picture; as BLEND with alpha 1 it goes through the translucent pass.
Shown show(RasterTest& test, Rasterizer& rasterizer, SceneBuilder& builder, sideray_material_desc d, bool translucent) {
  if (translucent) d.alpha_mode = SIDERAY_BLEND;
  builder.quad(builder.material(d), {0, 0, 0});
  builder.sky(sky);
  builder.scene.set_lights(suns().data(), suns().size());
  rasterizer.set_scene(builder.commit());
  rasterizer.resize(test.width, test.height);
  const RasterView view = rasterizer.make_view(camera_at(glm::dvec3(eye)), glm::vec2(0));
  rasterizer.set_view(view);
  rasterizer.gbuffer();
  rasterizer.light(false);
  rasterizer.translucency({});
  const glm::dvec4 p = view.local_from_clip * glm::dvec4(1.0 / test.width, 1.0 / test.height, 0.5, 1);
  const glm::dvec3 far_end = glm::dvec3(p / p.w), origin(eye);
  const glm::dvec3 along = far_end - origin;
  return {glm::vec3(rasterizer.read_color()[test.middle()]), glm::vec3(origin - along * (origin.z / along.z))};
}

TEST_F(RasterLobes, every_set_of_lobes_is_what_shading_h_says_in_both_passes) {
  for (const uint32_t lobes : {1u, 2u, 4u, 8u, 15u, 16u, 31u})
    for (const bool translucent : {false, true}) {
      SCOPED_TRACE(testing::Message() << "lobes " << lobes << (translucent ? ", translucent" : ", opaque"));
      SceneBuilder builder;
      const sideray_material_desc d = lobed(lobes);
      const Shown shown = show(*this, *rasterizer, builder, d, translucent);
      const glm::vec3 normal(0, 0, 1);
      const SrSurface s = filmed_surface(d, no_texels, normal, normal, shown.position);
      expect_close(shown.color, expected_radiance(s, shown.position));
    }
}

// Texel values of the slots in their order; all channels differ, so that a wrong channel shows.
glm::u8vec4 texel_of(size_t slot) {
  if (slot == 2) return {160, 128, 240, 255};  // leans to +x
  if (slot == 11) return {128, 90, 240, 255};  // leans to -y
  const auto k = static_cast<uint8_t>(5 * slot);
  return {static_cast<uint8_t>(250 - k), static_cast<uint8_t>(130 + k), static_cast<uint8_t>(90 + k),
          static_cast<uint8_t>(220 - k)};
}

void texture_every_slot(SceneBuilder& builder, sideray_material_desc& d) {
  for (size_t i = 0; i < model::material_slot_count; ++i) {
    if (i == 5 || i == 6) continue;  // transmission makes the surface a translucent one
    const glm::u8vec4 texel = texel_of(i);
    sideray_texture_slot& slot = d.*model::material_slots[i].slot;
    slot.texture = builder.scene.add_texture(1, 1, SIDERAY_RGBA8, &texel.x);
    slot.texture_from_uv[0] = slot.texture_from_uv[3] = 1;
  }
}

// The channels that glTF and its extensions name. `slots`: how many are read.
shading::SrTexels expected_texels(const sideray_material_desc& d, size_t slots) {
  const auto texel = [&](size_t i) { return i < slots ? glm::vec4(texel_of(i)) / 255.0f : glm::vec4(1.0f); };
  shading::SrTexels t = no_texels;
  t.base_color = texel(0);
  t.roughness = texel(1).y, t.metallic = texel(1).z;
  t.occlusion = 1.0f + d.occlusion_strength * (texel(3).x - 1.0f);
  t.emissive = glm::vec3(texel(4));
  t.specular = texel(7).w, t.specular_color = glm::vec3(texel(8));
  t.clearcoat = texel(9).x, t.clearcoat_roughness = texel(10).y;
  t.sheen_color = glm::vec3(texel(12)), t.sheen_roughness = texel(13).w;
  t.diffuse_transmission = texel(14).w, t.diffuse_transmission_color = glm::vec3(texel(15));
  t.iridescence = texel(16).x, t.iridescence_thickness = texel(17).y;
  if (slots > 18) {
    const glm::vec3 brushed(texel(18));
    t.anisotropy_along = brushed.x * 2.0f - 1.0f, t.anisotropy_across = brushed.y * 2.0f - 1.0f;
    t.anisotropy = brushed.z;
  }
  return t;
}

glm::vec3 expected_normal(size_t slot, float scale) {
  const glm::vec3 map = glm::vec3(texel_of(slot)) / 255.0f * 2.0f - 1.0f;
  return glm::normalize(glm::vec3(map.x * scale, map.y * scale, map.z));
}

void expect_textured(RasterTest& test, Rasterizer& rasterizer, size_t slots_read) {
  for (const bool translucent : {false, true}) {
    SCOPED_TRACE(translucent ? "translucent" : "opaque");
    SceneBuilder builder;
    sideray_material_desc d = lobed(31);
    d.normal_scale = 0.8f, d.clearcoat_normal_scale = 0.5f, d.occlusion_strength = 0.7f;
    texture_every_slot(builder, d);
    const Shown shown = show(test, rasterizer, builder, d, translucent);
    const glm::vec3 coat_normal = slots_read > 11 ? expected_normal(11, 0.5f) : glm::vec3(0, 0, 1);
    SrSurface s =
        filmed_surface(d, expected_texels(d, slots_read), expected_normal(2, 0.8f), coat_normal, shown.position);
    s.alpha = 1.0f;
    const float cover = translucent ? texel_of(0).w / 255.0f : 1.0f;
    expect_close(shown.color - sky * (1.0f - cover), expected_radiance(s, shown.position) * cover);
    EXPECT_EQ(rasterizer.leaves_textures_out(), slots_read < model::material_slot_count);
  }
}

TEST_F(RasterLobes, every_texture_slot_is_read_from_its_channels) {
  expect_textured(*this, *rasterizer, model::material_slot_count);
}

TEST_F(RasterLobes, with_sixteen_texture_units_extension_textures_give_way_to_factors) {
  Functions few = context->functions();
  few.texture_units = 16;
  Rasterizer limited(few);
  expect_textured(*this, limited, 8);  // units 8 to 15 hold slots 0 to 7
}

// A sheet between the eye and a light: the light comes through, unless something on its own side stands before it.
TEST_F(RasterLobes, light_from_behind_is_shadowed_on_its_own_side) {
  enum class Blocker { none, on_the_lights_side, on_the_eyes_side };
  for (const Blocker blocker : {Blocker::none, Blocker::on_the_lights_side, Blocker::on_the_eyes_side}) {
    SceneBuilder builder;
    sideray_material_desc d = plain_material();
    d.specular = 0, d.double_sided = 1;
    d.diffuse_transmission = 1, d.diffuse_transmission_color[1] = 0.5f, d.diffuse_transmission_color[2] = 0.25f;
    builder.quad(builder.material(d), {0, 0, 0}, 3);
    sideray_material_desc black = unlit({0, 0, 0, 1});
    black.double_sided = 1;
    const uint32_t blocking = builder.material(black);
    if (blocker == Blocker::on_the_lights_side) builder.quad(blocking, {0, 0, -1}, 0.5);
    if (blocker == Blocker::on_the_eyes_side) builder.quad(blocking, {0, 0, 1}, 0.2);
    const sideray_light light = sun({0, 0, 1}, 3);
    builder.scene.set_lights(&light, 1);
    // From aside, past the blocker.
    draw_opaque(builder.commit(), camera_at({4, 0, 4}), true);
    const glm::vec3 lit = glm::vec3(1.0f, 0.5f, 0.25f) * (3.0f / 3.14159265f);
    const glm::vec3 expected = blocker == Blocker::on_the_lights_side ? glm::vec3(0.0f) : lit;
    expect_near(rasterizer->read_color()[middle()], glm::vec4(expected, 1), 2e-3f);
  }
}

}  // namespace
}  // namespace sideray::gl::tests
