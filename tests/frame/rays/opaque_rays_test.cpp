// Tests `auto` ambient occlusion and reflections: which scenes have them, and that they cost others nothing.
#include <gmock/gmock.h>
#include <sideray/plan.h>

#include <map>
#include <string>
#include <vector>

#include "frame/frame.h"

namespace sideray::tests::opaque_rays_test {
namespace {

using testing::HasSubstr;

// Two quads, one above the other, under uniform surroundings and a sun.
struct Room {
  float surroundings = 1.0f, sun = 1.0f, lamp = 0.0f;
  float roughness = 1.0f;
  int texture_roughness = -1;  // 0 to 255; below 0: no texture
  bool has_dark_occlusion = false;  // by a black occlusion texture
  bool unlit = false;
  float alpha = 1.0f;
};

class Built {
 public:
  explicit Built(const Room& room) {
    const std::vector<float> rgb(24, room.surroundings);
    if (room.surroundings > 0) scene.set_environment(4, 2, rgb.data(), 1.0f, 0.0f);
    sideray_material_desc material = sideray_material_defaults();
    material.roughness = room.roughness;
    material.unlit = room.unlit;
    // White would reflect the surroundings' own radiance everywhere.
    for (int k = 0; k < 3; ++k) material.base_color[k] = 0.5f;
    material.base_color[3] = room.alpha;
    if (room.alpha < 1.0f) material.alpha_mode = SIDERAY_BLEND;
    if (room.texture_roughness >= 0) {
      const uint8_t texels[] = {0, 255, 255, 255, 0, static_cast<uint8_t>(room.texture_roughness), 255, 255};
      material.metallic_roughness_texture.texture = scene.add_texture(2, 1, SIDERAY_RGBA8, texels);
      material.metallic_roughness_texture.uv_set = 0;
    }
    if (room.has_dark_occlusion) {
      const uint8_t black[] = {0, 0, 0, 255};
      material.occlusion_texture.texture = scene.add_texture(1, 1, SIDERAY_RGBA8, black);
      material.occlusion_texture.uv_set = 0;
    }
    const sideray_material added = scene.add_material(material);
    const float corners[] = {-1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0};
    const uint32_t indices[] = {0, 1, 2, 0, 2, 3};
    sideray_mesh_desc mesh = sideray_mesh_defaults();
    mesh.vertex_count = 4, mesh.index_count = 6;
    mesh.positions = {corners, 0};
    mesh.indices = indices;
    const sideray_mesh quad = scene.add_mesh(mesh);
    for (const double away : {5.0, 3.0}) {
      sideray_instance_desc instance{};
      instance.mesh = quad;
      instance.material = added;
      for (int k = 0; k < 3; ++k) instance.world_from_object[4 * k] = away == 5.0 ? 4.0 : 1.0;
      if (away == 3.0) instance.world_from_object[9] = 1.5;  // else it hides what it is mirrored by
      instance.world_from_object[11] = -away;
      instance.surface_id = static_cast<uint32_t>(away);
      instance.visibility = SIDERAY_VISIBLE_ALL;
      scene.add_instances({&instance, 1});
    }
    sideray_light light = sideray_light_defaults();
    light.type = SIDERAY_LIGHT_DIRECTIONAL;
    for (float& c : light.intensity) c = room.sun;
    light.direction[0] = 0.3f, light.direction[1] = -0.4f, light.direction[2] = -0.87f;
    sideray_light lamp = sideray_light_defaults();
    lamp.type = SIDERAY_LIGHT_POINT;
    for (float& c : lamp.intensity) c = room.lamp;
    const sideray_light lights[] = {light, lamp};
    scene.set_lights(lights);
    scene.commit();
  }

  sideray_scene_facts facts() {
    sideray_scene_facts facts{};
    facts.size = sizeof(facts);
    check([&](sideray_error* error) { return sideray_plan_scene(scene.get(), &facts, error); });
    return facts;
  }

  Scene scene = Scene::create().value();
};

constexpr uint32_t width = 48, height = 32;

struct Drawn {
  std::map<std::string, std::vector<float>> planes;
  sideray_render_stats stats;
  uint64_t rays() const { return stats.rays_primary + stats.rays_reflection + stats.rays_shadow + stats.rays_ao; }
};

Renderer& renderer_of(const std::string& gl) {
  static std::map<std::string, Renderer> renderers;
  sideray_renderer_desc desc = sideray_renderer_defaults();
  desc.gl = gl.c_str();
  auto known = renderers.find(gl);
  if (known == renderers.end()) known = renderers.emplace(gl, Renderer::create(desc).value()).first;
  return known->second;
}

Drawn draw(Built& built, int32_t ao, int32_t reflections, bool is_reference = false, const std::string& gl = "auto") {
  RenderOptions options;
  options.picture.width = width, options.picture.height = height;
  options.picture.repeats = 1;
  options.picture.ambient = ao, options.picture.reflections = reflections;
  if (is_reference) {
    options.reference = sideray_reference_defaults();
    options.reference->light_samples = 4;
  }
  const Picture picture = renderer_of(gl).render(built.scene, sideray_camera_defaults(), options).value();
  Drawn drawn{{}, picture.stats()};
  for (size_t i = 0; i < picture.channel_count(); ++i) {
    const auto* values = static_cast<const float*>(picture.channel(i).values);
    drawn.planes[picture.channel(i).name].assign(values, values + size_t{width} * height);
  }
  return drawn;
}

struct Planned {
  int32_t ao, reflections;
  std::string trace, trace_ao;
};

Planned plan(Built& built, const RenderOptions& options = {}) {
  const sideray_render_options given = options.c();
  sideray_plan* plan = nullptr;
  check([&](sideray_error* error) { return sideray_plan_create(built.scene.get(), &given, &plan, error); });
  Planned planned{sideray_plan_ao(plan), sideray_plan_reflections(plan),
                  sideray_plan_pass_at(plan, SIDERAY_STAGE_TRACE)->reason,
                  sideray_plan_pass_at(plan, SIDERAY_STAGE_TRACE_AO)->reason};
  sideray_plan_release(plan);
  return planned;
}

TEST(OpaqueRays, AutoIsTheDefaultOfPictures) {
  EXPECT_EQ(sideray_render_defaults().ambient, SIDERAY_AMBIENT_AUTO);
  EXPECT_EQ(sideray_render_defaults().reflections, SIDERAY_REFLECTIONS_AUTO);
}

TEST(OpaqueRays, AoIsTracedWhereTheSurroundingsSendLight) {
  const auto ao = [](const Room& room) {
    Built built(room);
    const Planned planned = plan(built);
    EXPECT_EQ(planned.ao, built.facts().auto_ao);
    return planned.ao ? "" : planned.trace_ao;
  };
  EXPECT_EQ(ao({}), "");
  EXPECT_EQ(ao({.sun = 0.0f}), "");
  EXPECT_THAT(ao({.surroundings = 0.0f}), HasSubstr("no light comes from the surroundings"));
  EXPECT_THAT(ao({.surroundings = 0.0f, .sun = 0.0f}), HasSubstr("no light comes from the surroundings"));
  EXPECT_EQ(ao({.surroundings = 1e-3f, .sun = 100.0f}), "") << "what hides a faint sky is lit by the sun, and bounces that";
  EXPECT_EQ(ao({.lamp = 1e4f}), "");
}

TEST(OpaqueRays, ReflectionsAreTracedWhereSomethingMirrors) {
  const auto mirrors = [](const Room& room) {
    Built built(room);
    const Planned planned = plan(built);
    const sideray_scene_facts facts = built.facts();
    EXPECT_EQ(planned.reflections, facts.auto_reflections);
    EXPECT_EQ(facts.glossy_objects, planned.reflections ? 2u : 0u);
    EXPECT_NE(planned.reflections, testing::Value(planned.trace, HasSubstr("no opaque surface is smooth enough")));
    return planned.reflections != 0;
  };
  EXPECT_FALSE(mirrors({.roughness = 1.0f}));
  EXPECT_FALSE(mirrors({.roughness = 0.51f}));
  EXPECT_TRUE(mirrors({.roughness = 0.5f}));
  EXPECT_TRUE(mirrors({.surroundings = 0.0f, .roughness = 0.0f})) << "objects are mirrored without surroundings";
  EXPECT_FALSE(mirrors({.roughness = 0.0f, .unlit = true}));
  EXPECT_FALSE(mirrors({.roughness = 0.0f, .alpha = 0.5f})) << "layers reflect by themselves";
  // The smoothest texel decides.
  EXPECT_TRUE(mirrors({.roughness = 1.0f, .texture_roughness = 127}));
  EXPECT_FALSE(mirrors({.roughness = 1.0f, .texture_roughness = 129}));
  EXPECT_TRUE(mirrors({.roughness = 0.9f, .texture_roughness = 140}));
}

TEST(OpaqueRays, WhereTheyHaveNoUseNothingIsPaid) {
  Built built({.surroundings = 0.0f, .sun = 0.0f});
  const Drawn off = draw(built, 0, 0), automatic = draw(built, SIDERAY_AMBIENT_AUTO, SIDERAY_REFLECTIONS_AUTO);
  EXPECT_EQ(automatic.planes, off.planes);
  EXPECT_EQ(automatic.rays(), off.rays());
  EXPECT_EQ(automatic.stats.rays_ao + automatic.stats.rays_bounce + automatic.stats.rays_reflection, 0u);
  EXPECT_EQ(automatic.stats.bytes_readback, off.stats.bytes_readback);
  EXPECT_EQ(automatic.stats.bytes_upload, off.stats.bytes_upload);
  EXPECT_EQ(off.rays(), 0u);
}

TEST(OpaqueRays, WhereTheyHaveAutoIsOn) {
  Built built({.roughness = 0.2f});
  const Drawn on = draw(built, SIDERAY_AMBIENT_BOUNCE, 1), automatic = draw(built, SIDERAY_AMBIENT_AUTO, SIDERAY_REFLECTIONS_AUTO);
  EXPECT_EQ(automatic.planes, on.planes);
  EXPECT_EQ(automatic.rays(), on.rays());
  EXPECT_GT(automatic.stats.rays_ao, 0u);
  EXPECT_GT(automatic.stats.rays_bounce, 0u);
  EXPECT_GT(automatic.stats.rays_reflection, 0u);
  EXPECT_NE(automatic.planes, draw(built, 0, SIDERAY_REFLECTIONS_AUTO).planes);
  EXPECT_NE(automatic.planes, draw(built, SIDERAY_AMBIENT_AUTO, 0).planes);
}

// Rays find what an occlusion texture stands in for, on surfaces and on what lights them; elsewhere it darkens.
TEST(OpaqueRays, OcclusionTexturesHaveNoEffectWhereLightBounces) {
  Built plain({.roughness = 0.4f}), occluded({.roughness = 0.4f, .has_dark_occlusion = true});
  for (const std::string gl : {"auto", "none"})
    for (const int32_t reflections : {0, 1}) {
      const auto drawn = [&](Built& built, int32_t ambient) { return draw(built, ambient, reflections, false, gl).planes; };
      EXPECT_EQ(drawn(plain, SIDERAY_AMBIENT_BOUNCE), drawn(occluded, SIDERAY_AMBIENT_BOUNCE)) << gl << reflections;
      EXPECT_NE(drawn(plain, SIDERAY_AMBIENT_AO), drawn(occluded, SIDERAY_AMBIENT_AO)) << gl << reflections;
    }
}

// Options that are on stay on in any scene.
TEST(OpaqueRays, WhatIsAskedForIsTraced) {
  Built built({.surroundings = 0.0f});
  RenderOptions options;
  options.picture.ambient = options.picture.reflections = 1;
  EXPECT_EQ(plan(built, options).ao, 1);
  EXPECT_EQ(plan(built, options).reflections, 1);
  EXPECT_GT(draw(built, 1, 1).stats.rays_ao, 0u);
}

TEST(OpaqueRays, AReferenceTakesAutoForOff) {
  Built built({.roughness = 0.2f});
  const Drawn off = draw(built, 0, 0, true), automatic = draw(built, SIDERAY_AMBIENT_AUTO, SIDERAY_REFLECTIONS_AUTO, true);
  EXPECT_EQ(automatic.planes, off.planes);
  EXPECT_NE(automatic.planes, draw(built, 0, 1, true).planes);
  RenderOptions options;
  options.reference = sideray_reference_defaults();
  EXPECT_EQ(plan(built, options).ao + plan(built, options).reflections, 0);
}

}  // namespace
}  // namespace sideray::tests::opaque_rays_test
