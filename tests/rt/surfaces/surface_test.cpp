// Surfaces at hits: every texture slot, the side met, levels of detail by ray cones; and the light of coat, sheen and
// diffuse transmission against closed forms.
#include <gmock/gmock.h>

#include <array>
#include <cmath>
#include <cstring>
#include <functional>

#include "model/material_slots.h"
#include "rt/shading/hit_shader.h"
#include "rt/textures/environment_lookup.h"
#include "rt/tracer_scene.h"

namespace sideray::rt {
namespace {

using namespace test;

constexpr float pi = 3.14159265f;

Ray ray_along(glm::vec3 direction) {
  return {{0, 0, 0}, 0.0f, glm::normalize(direction), 1e30f};
}

constexpr glm::vec3 ahead(0, 0, -1);

// A quad at z = -3, instance 0, whose uv run along x and -y; looked at from the origin.
struct FacingQuad {
  FacingQuad() = default;
  explicit FacingQuad(const sideray_material_desc& material) { add(material); }

  void add(const sideray_material_desc& material) { scene.quad({0, 0, -3}, {1, 0, 0}, {0, 1, 0}, material); }
  sideray_texture texel(const std::array<uint8_t, 4>& rgba) {
    return scene.scene.add_texture(1, 1, SIDERAY_RGBA8, rgba.data());
  }

  static Hit hit(bool front) {
    Hit h{};
    h.distance = 3.0;
    h.u = h.v = 0.25f;
    h.front = front;
    return h;
  }

  SurfacePoint point(bool front = true) {
    const ShadingScene shading(scene.commit());
    return surface_point(shading, hit(front), ray_along(front ? ahead : -ahead), {});
  }

  glm::vec3 radiance(glm::vec3 direction = ahead, uint64_t* reflections = nullptr) {
    const ShadingScene shading(scene.commit());
    Intersector intersector("");
    intersector.set_scene(shading.snapshot);
    HitShader shader;
    shader.begin(shading, intersector);
    const SurfacePoint p = surface_point(shading, hit(true), ray_along(direction), {});
    glm::vec3 result(0.0f);
    shader.shade({&p, 1}, &result);
    if (reflections) *reflections = shader.rays_reflection;
    return result;
  }

  TestScene scene;
};

void expect_same(const shading::SrSurface& a, const shading::SrSurface& b, const char* what) {
  std::array<float, sizeof(a) / sizeof(float)> x, y;
  std::memcpy(x.data(), &a, sizeof(a));
  std::memcpy(y.data(), &b, sizeof(b));
  for (size_t i = 0; i < x.size(); ++i) EXPECT_NEAR(x[i], y[i], 2e-6f) << what << ", number " << i;
}

// Everything on, every factor different, so that each texture shows.
sideray_material_desc everything() {
  sideray_material_desc m = blended({0.9f, 0.7f, 0.5f}, 0.8f);
  m.metallic = 0.4f, m.roughness = 0.7f, m.transmission = 0.3f, m.thickness = 0.8f, m.specular = 0.9f;
  m.attenuation_distance = 2.0f;
  m.clearcoat = 0.6f, m.clearcoat_roughness = 0.5f, m.clearcoat_normal_scale = 1.0f, m.sheen_roughness = 0.8f;
  m.diffuse_transmission = 0.35f;
  m.iridescence = 0.8f, m.iridescence_ior = 1.7f;
  m.iridescence_thickness_min = 0.0f, m.iridescence_thickness_max = 350.0f;
  for (int c = 0; c < 3; ++c) {
    const float x = static_cast<float>(c);
    m.attenuation_color[c] = 0.9f - 0.2f * x, m.emissive[c] = 1.0f + x, m.specular_color[c] = 0.4f + 0.2f * x;
    m.sheen_color[c] = 0.2f + 0.1f * x, m.diffuse_transmission_color[c] = 0.9f - 0.3f * x;
  }
  return m;
}

// One texel, of linear values (51, 102, 153, 204) / 255 = (0.2, 0.4, 0.6, 0.8), in each slot in turn: as if the factors
// were multiplied by the channels that sideray.h names.
TEST(Surface, a_texture_scales_its_factor_in_every_slot) {
  using D = sideray_material_desc;
  constexpr float r = 0.2f, g = 0.4f, b = 0.6f, a = 0.8f;
  const auto times = [](float(&v)[3]) { v[0] *= r, v[1] *= g, v[2] *= b; };
  const std::vector<std::pair<sideray_texture_slot D::*, std::function<void(D&)>>> slots{
      {&D::base_color_texture,
       [](D& m) { m.base_color[0] *= r, m.base_color[1] *= g, m.base_color[2] *= b, m.base_color[3] *= a; }},
      {&D::metallic_roughness_texture, [](D& m) { m.roughness *= g, m.metallic *= b; }},
      {&D::emissive_texture, [&](D& m) { times(m.emissive); }},
      {&D::transmission_texture, [](D& m) { m.transmission *= r; }},
      {&D::thickness_texture, [](D& m) { m.thickness *= g; }},
      {&D::specular_texture, [](D& m) { m.specular *= a; }},
      {&D::specular_color_texture, [&](D& m) { times(m.specular_color); }},
      {&D::clearcoat_texture, [](D& m) { m.clearcoat *= r; }},
      {&D::clearcoat_roughness_texture, [](D& m) { m.clearcoat_roughness *= g; }},
      {&D::sheen_color_texture, [&](D& m) { times(m.sheen_color); }},
      {&D::sheen_roughness_texture, [](D& m) { m.sheen_roughness *= a; }},
      {&D::diffuse_transmission_texture, [](D& m) { m.diffuse_transmission *= a; }},
      {&D::diffuse_transmission_color_texture, [&](D& m) { times(m.diffuse_transmission_color); }},
      {&D::iridescence_texture, [](D& m) { m.iridescence *= r; }},
      {&D::iridescence_thickness_texture, [](D& m) { m.iridescence_thickness_max *= g; }},
  };
  ASSERT_EQ(slots.size() + 4, model::material_slot_count);  // and two normal maps, occlusion, and anisotropy
  const shading::SrSurface plain = FacingQuad(everything()).point().surface;
  for (const auto& [slot, scale] : slots) {
    const char* name = "";
    for (const model::MaterialSlot& s : model::material_slots)
      if (s.slot == slot) name = s.name;
    D scaled = everything();
    scale(scaled);
    const shading::SrSurface expected = FacingQuad(scaled).point().surface;
    FacingQuad textured;
    D with = everything();
    (with.*slot).texture = textured.texel({51, 102, 153, 204});
    textured.add(with);
    const shading::SrSurface seen = textured.point().surface;
    expect_same(seen, expected, name);
    EXPECT_NE(std::memcmp(&seen, &plain, sizeof(seen)), 0) << name << " has no effect";
  }
}

TEST(Surface, two_maps_in_one_image_are_both_read) {
  FacingQuad quad;
  sideray_material_desc m = plain_material();
  m.metallic = 1.0f;
  m.metallic_roughness_texture.texture = quad.texel({51, 102, 153, 204});
  m.occlusion_texture = m.metallic_roughness_texture;
  m.occlusion_strength = 0.5f;
  quad.add(m);
  const shading::SrSurface s = quad.point().surface;
  EXPECT_NEAR(s.roughness, 0.4f, 1e-6f);
  EXPECT_NEAR(s.metallic, 0.6f, 1e-6f);
  EXPECT_NEAR(s.occlusion, 1.0f + 0.5f * (0.2f - 1.0f), 1e-6f);
}

// Each of the two maps bends its own normal: u runs along +x, green is up the image, which is +y.
TEST(Surface, base_and_coat_have_normal_maps_of_their_own) {
  constexpr float half_code = 1.0f / 255.0f;  // what code 128 is off from 0
  constexpr float slanted = 2.0f * 218.0f / 255.0f - 1.0f;
  const glm::vec3 base = glm::normalize(glm::vec3(slanted, half_code, slanted)),
                  coat = glm::normalize(glm::vec3(0.5f * half_code, 0.5f * slanted, slanted));
  FacingQuad quad;
  sideray_material_desc m = plain_material();
  m.clearcoat = 1.0f, m.clearcoat_normal_scale = 0.5f;
  m.normal_texture.texture = quad.texel({218, 128, 218, 255});
  m.clearcoat_normal_texture.texture = quad.texel({128, 218, 218, 255});
  quad.add(m);
  for (const bool front : {true, false}) {
    const shading::SrSurface s = quad.point(front).surface;
    const float side = front ? 1.0f : -1.0f;
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(s.normal[c], side * base[c], 1e-6f);
      EXPECT_NEAR(s.coat_normal[c], side * coat[c], 1e-6f);
    }
  }
}

// A texture whose level k says k: the level must be log2 of the footprint in texels, the longer way.
TEST(Surface, the_cone_chooses_the_texture_level) {
  constexpr uint32_t size = 256;
  std::vector<uint8_t> texels(size_t{4} * size * size, 0);
  FacingQuad quad;
  sideray_material_desc m = plain_material();
  m.emissive[0] = 1.0f;
  m.emissive_texture.texture = quad.scene.scene.add_texture(size, size, SIDERAY_RGBA8, texels.data());
  m.emissive_texture.texture_from_uv[0] = 2.0f;  // 512 texels along x, 256 along y
  quad.add(m);
  model::Snapshot snapshot = *quad.scene.commit();
  model::Texture levels = *snapshot.textures[0];
  constexpr int code = 30;
  for (size_t k = 0; k < levels.levels.size(); ++k)
    std::ranges::fill(levels.levels[k].rgba, static_cast<uint8_t>(code * k));
  snapshot.textures[0] = std::make_shared<const model::Texture>(levels);
  const ShadingScene shading(std::make_shared<const model::Snapshot>(snapshot));
  for (const float width : {0.0005f, 0.002f, 0.01f, 0.02f, 0.05f, 0.3f, 5.0f, 100.0f})
    for (const float spread : {0.0f, 0.01f})
      for (const double slope : {0.0, 1.0, 3.0}) {
        const glm::vec3 direction(0, slope, -1);
        const double cosine = 1.0 / std::sqrt(1.0 + slope * slope);
        // The quad is two units wide; the footprint is longer along y, where the ray leans.
        const auto across = static_cast<double>(width + 3.0f * spread), along = across / cosine;
        const double level = std::clamp(std::log2(std::max(across * 512.0 / 2.0, along * 256.0 / 2.0)), 0.0, 8.0);
        const SurfacePoint p = surface_point(shading, FacingQuad::hit(true), ray_along(direction), {width, spread});
        EXPECT_NEAR(p.surface.emissive.x * 255.0f / code, level, 2e-5 * 8) << width << ' ' << spread << ' ' << slope;
        EXPECT_FLOAT_EQ(p.cone.width, width + 3.0f * spread);
      }
}

// Light from behind: E cos / pi of the colour that passes, whatever stands on the viewer's side.
TEST(Light, passes_a_diffuse_transmitter_from_behind) {
  sideray_material_desc leaf = blended({0.5f, 0.6f, 0.7f}, 1.0f);
  leaf.specular = 0.0f;
  leaf.diffuse_transmission = 0.75f;
  const glm::vec3 color(0.9f, 0.4f, 0.2f);
  for (int c = 0; c < 3; ++c) leaf.diffuse_transmission_color[c] = color[c];
  const glm::vec3 travel = glm::normalize(glm::vec3(0.3f, 0, 1));  // toward the viewer
  const glm::vec3 expected = color * (0.75f * 2.0f * travel.z / pi);
  FacingQuad open(leaf);
  open.scene.lights({directional_light(travel, 2.0f)});
  open.scene.quad({0, 0, -2}, {5, 0, 0}, {0, 5, 0}, plain_material());
  const glm::vec3 lit = open.radiance();
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(lit[c], expected[c], 1e-6f);
  open.scene.quad({0, 0, -4}, {5, 0, 0}, {0, 5, 0}, plain_material());
  EXPECT_EQ(open.radiance(), glm::vec3(0.0f));
  // From in front: what does not pass.
  FacingQuad front(leaf);
  front.scene.lights({directional_light(-travel, 2.0f)});
  const glm::vec3 reflected = front.radiance();
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(reflected[c], leaf.base_color[c] * 0.25f * 2.0f * travel.z / pi, 1e-6f);
}

// A uniform sky of radiance 1: nothing is lost, wherever the light goes.
TEST(Light, a_white_surface_under_a_white_sky_is_white) {
  const auto furnace = [](const std::function<void(sideray_material_desc&)>& change, glm::vec3 direction) {
    sideray_material_desc m = blended(glm::vec3(1), 1.0f);
    m.specular = 0.0f;
    change(m);
    FacingQuad quad(m);
    quad.scene.environment(glm::vec3(1));
    return quad.radiance(direction);
  };
  const auto white_sheen = [](sideray_material_desc& m) {
    for (float& c : m.sheen_color) c = 1.0f;
    m.sheen_roughness = 0.5f;
  };
  const auto passing = [](sideray_material_desc& m) {
    m.diffuse_transmission = 0.4f;
    for (float& c : m.diffuse_transmission_color) c = 1.0f;
  };
  for (const glm::vec3 direction : {glm::vec3(0, 0, -1), glm::vec3(1, 0, -1), glm::vec3(0, 6, -1)}) {
    const std::vector<std::function<void(sideray_material_desc&)>> all{
        [](sideray_material_desc&) {}, white_sheen, passing,
        [](sideray_material_desc& m) { m.clearcoat = 1.0f, m.clearcoat_roughness = 0.3f; },
        [&](sideray_material_desc& m) { white_sheen(m), passing(m), m.clearcoat = 0.7f; }};
    for (size_t i = 0; i < all.size(); ++i)
      for (int c = 0; c < 3; ++c) EXPECT_NEAR(furnace(all[i], direction)[c], 1.0f, 2e-5f) << i;
  }
}

// A black base: only the coat is seen, which is 0.04 straight on and mirrors by its own normal and roughness.
TEST(Light, the_coat_mirrors_what_stands_before_it) {
  sideray_material_desc m = blended(glm::vec3(0), 1.0f);
  m.specular = 0.0f;
  m.clearcoat = 1.0f;
  FacingQuad quad(m);
  quad.scene.quad({0, 0, 2}, {5, 0, 0}, {0, 5, 0}, glowing({1, 2, 3}));
  const glm::vec3 seen = quad.radiance();
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(seen[c], 0.04f * static_cast<float>(c + 1), 1e-5f);
}

// The base is a mirror bent by 45 degrees toward a red wall, the coat looks straight ahead at a blue one.
TEST(Light, base_and_coat_reflect_different_walls) {
  FacingQuad quad;
  sideray_material_desc m = mirror();
  m.clearcoat = 1.0f;
  m.normal_texture.texture = quad.texel({255, 128, 255, 255});  // 45 degrees toward +x
  quad.add(m);
  quad.scene.quad({0, 0, 2}, {4, 0, 0}, {0, 4, 0}, glowing({0, 0, 1}));
  quad.scene.quad({9, 0, -3}, {0, 4, 0}, {0, 0, 4}, glowing({1, 0, 0}));
  uint64_t rays = 0;
  const glm::vec3 seen = quad.radiance(ahead, &rays);
  EXPECT_NEAR(seen.z, 0.04f, 1e-5f);
  EXPECT_NEAR(seen.x, 0.96f, 1e-3f);
  EXPECT_EQ(rays, 4u);  // each looks for what is opaque, then for what is translucent
}

}  // namespace
}  // namespace sideray::rt
