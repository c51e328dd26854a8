// Tests shading by the host: the callback's inputs, and the use of its results.
#include <gmock/gmock.h>

#include <algorithm>
#include <limits>

#include "rt/shading/host_shader_scene.h"

namespace sideray::rt {
namespace {

using namespace test;

CompositeImage composite_of(TestScene& scene, Shader& shader, bool refraction = false,
                            sideray_radiance_space space = SIDERAY_SPACE_LINEAR) {
  sideray_shader_desc desc = shader.desc();
  desc.radiance_space = space;
  scene.scene.set_shader(&desc);
  Tracer tracer({.threads = 2, .isa = ""});
  tracer.set_scene(scene.commit());
  TestFrame frame = frame_of(8);
  frame.request.refraction = refraction;
  CompositeImage image;
  tracer.trace_composite(frame.get(), image);
  return image;
}

// A rectangle whose every attribute is a linear function of where it is, turned, stretched and far from the origin.
struct Attributes {
  static constexpr glm::dvec3 center{4096.0, 0.0, -3.0};
  sideray_instance instance;

  explicit Attributes(TestScene& scene) {
    const std::vector<glm::vec3> positions{{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
    const std::vector<uint32_t> indices{0, 1, 2, 0, 2, 3};
    std::vector<glm::vec2> uv0, uv1;
    std::vector<glm::vec3> normals(4, glm::normalize(glm::vec3(0.3f, 0.0f, 1.0f)));
    std::vector<glm::vec4> tangents(4, glm::vec4(1, 0, 0, -1)), colors;
    for (const glm::vec3& p : positions) {
      uv0.emplace_back(2 * p.x + 1, p.y);
      uv1.emplace_back(0.5f * p.x + 0.25f * p.y, 0.5f - 0.5f * p.y);
      colors.emplace_back(0.5f + 0.5f * p.x, 0.5f, 0.5f - 0.5f * p.y, 1.0f);
    }
    sideray_mesh_desc mesh{};
    mesh.size = sizeof(mesh);
    mesh.vertex_count = 4, mesh.index_count = 6, mesh.indices = indices.data();
    mesh.positions = {&positions[0].x, 0}, mesh.normals = {&normals[0].x, 0};
    mesh.tangents = {&tangents[0].x, 0}, mesh.uv0 = {&uv0[0].x, 0}, mesh.uv1 = {&uv1[0].x, 0};
    mesh.colors = {&colors[0].x, 0};
    sideray_instance_desc desc{};
    desc.mesh = scene.scene.add_mesh(mesh, nullptr);
    desc.material = scene.scene.add_material(blended({0.5f, 0.25f, 1.0f}, 0.75f));
    for (int c = 0; c < 3; ++c) desc.world_from_object[3 * c + c] = c == 0 ? 2.0 : 1.0;
    for (int c = 0; c < 3; ++c) desc.world_from_object[9 + c] = center[c];
    desc.surface_id = 77, desc.visibility = SIDERAY_VISIBLE_ALL;
    desc.user = 0xfeedface12345678ull;
    scene.scene.add_instances(&desc, 1, &instance);
  }
};

TEST(HostShader, is_told_what_was_met) {
  TestScene scene;
  const Attributes attributes(scene);
  Shader shader{[](const Point&, Result&) {}};
  sideray_shader_desc desc = shader.desc();
  scene.scene.set_shader(&desc);
  const auto snapshot = scene.commit();
  ASSERT_NE(snapshot->origin, glm::dvec3(0));  // or positions in the world were not put to the test
  Tracer tracer({.threads = 2, .isa = ""});
  tracer.set_scene(snapshot);
  const glm::dvec3 eye = glm::dvec3(4096, 0, 0) - snapshot->origin;
  TestFrame frame(perspective(eye, eye - glm::dvec3(0, 0, 1), fov, 1.0), size, size, 2);
  LayerCache cache;
  const Counters counters = tracer.trace_cache(frame.get(), cache);
  EXPECT_EQ(counters.points_shaded, shader.points.size());
  ASSERT_GT(shader.points.size(), size * size / 2u);
  const double pixel = 2 * std::tan(0.5 * fov) / size;  // at distance 1 along the axis
  for (const Point& p : shader.points) {
    const glm::dvec3 at = dvec3(p.position) - Attributes::center, object(at.x / 2, at.y, at.z);
    ASSERT_NEAR(at.z, 0.0, 2e-6);
    const glm::dvec3 to_eye(p.to_eye[0], p.to_eye[1], p.to_eye[2]);
    ASSERT_LT(glm::length(at + double{p.distance} * to_eye - glm::dvec3(0, 0, 3)), 1e-5);
    ASSERT_NEAR(p.uv0[0], 2 * object.x + 1, 1e-5);
    ASSERT_NEAR(p.uv0[1], object.y, 1e-5);
    ASSERT_NEAR(p.uv1[0], 0.5 * object.x + 0.25 * object.y, 1e-5);
    ASSERT_NEAR(p.uv1[1], 0.5 - 0.5 * object.y, 1e-5);
    ASSERT_NEAR(p.color[0], 0.5 + 0.5 * object.x, 1e-5);
    ASSERT_NEAR(p.color[2], 0.5 - 0.5 * object.y, 1e-5);
    ASSERT_NEAR(p.base_color[0], 0.5f * p.color[0], 1e-6);
    ASSERT_NEAR(p.base_color[2], p.color[2], 1e-6);
    ASSERT_FLOAT_EQ(p.base_color[3], 0.75f);
    // Normals go by the inverse transpose: the x axis is stretched to twice its length.
    const glm::vec3 normal = glm::normalize(glm::vec3(0.15f, 0, 1));
    ASSERT_LT(glm::length(vec3(p.normal) - normal), 1e-5f);
    ASSERT_EQ(vec3(p.geometric_normal), glm::vec3(0, 0, 1));
    ASSERT_FLOAT_EQ(p.tangent[0], 1);
    ASSERT_FLOAT_EQ(p.tangent[3], -1);
    ASSERT_NEAR(p.footprint, pixel * double{p.distance}, 0.25 * pixel * double{p.distance});
    // uv0 grows by 1 for each world unit along x (twice a half): a pixel's longer diameter, in it, is no less than its
    // width, and no more than the slant makes of it.
    const glm::vec2 a(p.uv0_footprint[0], p.uv0_footprint[1]), b(p.uv0_footprint[2], p.uv0_footprint[3]);
    ASSERT_NEAR(std::max(glm::length(a), glm::length(b)), p.footprint, p.footprint * (1 / p.to_eye[2] - 1) + 1e-6f);
    const double u = 0.5 * (object.x + 1), v = 0.5 * (object.y + 1);  // of the rectangle
    ASSERT_EQ(p.primitive, u > v ? 0u : 1u) << "or the point is on the diagonal";
    ASSERT_NEAR(p.u, p.primitive == 0 ? u - v : u, 1e-5);
    ASSERT_NEAR(p.v, p.primitive == 0 ? v : v - u, 1e-5);
    ASSERT_EQ(p.instance, attributes.instance);
    ASSERT_EQ(p.material, 1u);
    ASSERT_EQ(p.surface_id, 77u);
    ASSERT_EQ(p.user, 0xfeedface12345678ull);
    ASSERT_EQ(p.bounce, 0u);
    ASSERT_EQ(p.front, 1);
    ASSERT_EQ(p.translucent, 1);
  }
}

// Light 0 behind a plate, light 1 of short range, light 2 not asked for, light 3 dark.
TEST(HostShader, is_told_which_lights_reach_the_point) {
  TestScene scene;
  scene.quad({0, 0, -4}, {50, 0, 0}, {0, 50, 0}, blended(glm::vec3(1), 0.5f));
  scene.quad({0, 0, -2}, {0.2f, 0, 0}, {0, 0.2f, 0}, plain_material(), SIDERAY_VISIBLE_SHADOW);
  const glm::dvec3 light(0.1, 0.05, 0);
  sideray_light near = point_light({1, 0, -4 + 0.1f}, 1.0f);
  near.range = 0.5f;
  scene.lights({point_light(light, 1.0f), near, point_light(light, 1.0f), point_light(light, 0.0f)});
  Shader shader{[](const Point&, Result&) {}};
  Counters counters;
  cache_of(
      scene, shader, [](sideray_shader_desc& d) { d.shadow_lights = 0b1011; }, 2, &counters);
  size_t shadowed = 0, reached = 0;
  for (const Point& p : shader.points) {
    const glm::dvec3 at = dvec3(p.position), crossing = light + (at - light) * 0.5;
    const bool dark = std::abs(crossing.x) < 0.2 && std::abs(crossing.y) < 0.2;
    const bool in_range = glm::length(at - glm::dvec3(1, 0, -4 + 0.1f)) < 0.5;
    ASSERT_EQ(p.lights, (dark ? 0u : 1u) | (in_range ? 2u : 0u) | 4u) << at.x << ", " << at.y;
    shadowed += dark, reached += in_range;
  }
  EXPECT_GT(shadowed, 10u);
  EXPECT_GT(reached, 5u);
  EXPECT_EQ(counters.rays_shadow, shader.points.size() + reached);
}

// Lambert's law under one shadowed light, and a constant.
TEST(HostShader, repeats_the_built_in_model) {
  TestScene scene;
  sideray_material_desc matte = blended({0.8f, 0.4f, 0.2f}, 0.5f);
  matte.specular = 0.0f;
  matte.emissive[2] = 0.125f;
  scene.quad({0, 0, -4}, {50, 0, 20}, {0, 50, 0}, matte);
  scene.quad({0.3f, 0, -2}, {0.4f, 0, 0}, {0, 0.4f, 0}, plain_material(), SIDERAY_VISIBLE_SHADOW);
  scene.lights({directional_light({0.1f, -0.2f, -1}, 3.0f)});
  const glm::vec3 to_light = -glm::normalize(glm::vec3(0.1f, -0.2f, -1));
  Shader shader{[&](const Point& p, Result& r) {
    const float cosine = std::max(glm::dot(vec3(p.normal), to_light), 0.0f);
    const float irradiance = (p.lights & 1u) ? 3.0f * cosine : 0.0f;
    for (int c = 0; c < 3; ++c) r.radiance[c] = p.emissive[c] + p.base_color[c] * irradiance / 3.14159265f;
  }};
  const LayerCache by_host = cache_of(scene, shader, [](sideray_shader_desc& d) { d.shadow_lights = 1; });
  scene.scene.set_shader(nullptr);
  Tracer tracer({.threads = 2, .isa = ""});
  tracer.set_scene(scene.commit());
  TestFrame frame = frame_of(2);
  LayerCache built_in;
  tracer.trace_cache(frame.get(), built_in);
  ASSERT_EQ(by_host.distance, built_in.distance);
  ASSERT_EQ(by_host.surface_id, built_in.surface_id);
  size_t dark = 0;
  for (size_t i = 0; i < size * size; ++i) {
    const glm::vec3 a = rgb(by_host.radiance, i), b = rgb(built_in.radiance, i);
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(a[c], b[c], 2 * half_rounding * b[c] + 1e-6f) << i;
    dark += a.x == 0.0f;
  }
  EXPECT_GT(dark, 5u);
  EXPECT_LT(dark, size * size / 2u);
}

// Red where the host is asked for what reflects, green for what is reflected.
TEST(HostShader, adds_what_its_surfaces_reflect) {
  TestScene scene;
  const glm::vec3 sky(0.25f);
  scene.quad({0, 0, -2}, {50, 0, 0}, {0, 50, 0}, mirror());
  scene.quad({0, 0, 2}, {0.5f, 0, 0}, {0, 0.5f, 0}, plain_material());               // behind the eye
  scene.quad({0.25f, 0, 1}, {0.25f, 0, 0}, {0, 5, 0}, blended(glm::vec3(1), 0.5f));  // before it, and before the sky
  scene.environment(sky);
  Shader shader{[](const Point& p, Result& r) {
    if (p.bounce == 0) {
      r.radiance[0] = 0.5f;
      set(r.reflectance, glm::vec3(0.5f, 0.5f, 1.0f));
    } else if (p.translucent) {
      set(r.radiance, glm::vec3(0, 0, 4)), set(r.transmittance, glm::vec3(0.25f)), r.alpha = 0.75f;
    } else {
      r.radiance[1] = 2.0f;
      set(r.reflectance, glm::vec3(1.0f));  // of the environment, for it is in a mirror
    }
  }};
  const auto change = [](sideray_shader_desc& d) { d.radiance_space = SIDERAY_SPACE_GAMMA22, d.radiance_scale = 2.0f; };
  const LayerCache cache = cache_of(scene, shader, change);
  const glm::vec3 seen_sky(std::pow(2 * sky.x, 1 / 2.2f));
  size_t behind = 0, plate = 0, bare = 0;
  for (uint32_t y = 0; y < size; ++y)
    for (uint32_t x = 0; x < size; ++x) {
      glm::dvec3 d = direction_of(x, y);
      d /= -d.z;
      const glm::dvec2 at_pane = glm::dvec2(d) * 5.0, at_plate = glm::dvec2(d) * 6.0;
      glm::vec3 reflected = seen_sky;
      if (std::abs(at_plate.x) < 0.5 && std::abs(at_plate.y) < 0.5) reflected += glm::vec3(0, 2, 0), ++plate;
      if (at_pane.x > 0 && at_pane.x < 0.5)
        reflected = reflected * 0.25f + glm::vec3(0, 0, 3), ++behind;
      else
        ++bare;
      const glm::vec3 expected = glm::vec3(0.5f, 0, 0) + glm::vec3(0.5f, 0.5f, 1.0f) * reflected;
      const glm::vec3 got = rgb(cache.radiance, texel_of(cache, x, y, 0));
      for (int c = 0; c < 3; ++c)
        ASSERT_NEAR(got[c], expected[c], half_rounding * expected[c] + 1e-5f) << x << ", " << y;
    }
  EXPECT_GT(behind, 20u);
  EXPECT_GT(plate, 5u);
  EXPECT_GT(bare, 20u);
}

TEST(HostShader, says_where_reflections_come_from) {
  TestScene scene;
  scene.quad({0, 0, -2}, {50, 0, 0}, {0, 50, 0}, mirror());
  scene.quad({0, 3, 0}, {50, 0, 0}, {0, 0, 50}, plain_material());
  Shader shader{[](const Point& p, Result& r) {
    if (p.bounce == 0)
      set(r.reflectance, glm::vec3(1.0f)), set(r.reflection, glm::vec3(0, 3, 3));
    else
      set(r.radiance, glm::vec3(static_cast<float>(p.position[0]) + 8, static_cast<float>(p.position[2]) + 8, 1));
  }};
  const LayerCache cache = cache_of(scene, shader);
  for (uint32_t y = 0; y < size; ++y)
    for (uint32_t x = 0; x < size; ++x) {
      const glm::dvec3 d = direction_of(x, y), p = d * (-2 / d.z);
      const glm::vec3 got = rgb(cache.radiance, texel_of(cache, x, y, 0));
      ASSERT_NEAR(got.x, p.x + 8, 16 * half_rounding);
      ASSERT_NEAR(got.y, p.z + (3 - p.y) + 8, 16 * half_rounding);
    }
}

TEST(HostShader, says_what_surfaces_cover_and_let_through) {
  TestScene scene;
  scene.quad({0, 0, -2}, {50, 0, 0}, {0, 50, 0}, blended(glm::vec3(1), 0.5f));
  scene.quad({0, 0, -3}, {50, 0, 0}, {0, 50, 0}, blended(glm::vec3(1), 0.5f));
  scene.quad({0, 0, -4}, {50, 0, 0}, {0, 50, 0}, blended(glm::vec3(1), 0.25f));
  Shader shader{[](const Point& p, Result& r) {
    set(r.radiance, glm::vec3(1, 2, 3));
    if (p.surface_id == 1) r.alpha = 0.125f, set(r.transmittance, glm::vec3(1, 0.5f, 0));
    if (p.surface_id == 2) r.alpha = 7.0f, set(r.transmittance, glm::vec3(-1, 0.5f, 2));  // held within 0 and 1
  }};
  const CompositeImage image = composite_of(scene, shader);
  // The last surface stays as its material has it: a quarter covered.
  const glm::vec3 first(0.125f), second = glm::vec3(1, 0.5f, 0), through = second * glm::vec3(0, 0.5f, 1);
  const glm::vec3 expected = glm::vec3(1, 2, 3) * (first + second + through * 0.25f);
  for (size_t i = 0; i < size * size; ++i) {
    const glm::vec3 c = rgb(image.radiance, i), t = rgb(image.transmittance, i);
    for (int k = 0; k < 3; ++k) {
      ASSERT_NEAR(c[k], expected[k], half_rounding * expected[k]);
      ASSERT_NEAR(t[k], through[k] * 0.75f, half_rounding);
    }
  }
}

// Surfaces behind one that the host declares opaque are not shaded.
TEST(HostShader, hides_what_is_behind) {
  TestScene scene;
  for (int k = 0; k < 12; ++k)
    scene.quad({0, 0, -2 - 0.1f * static_cast<float>(k)}, {50, 0, 0}, {0, 50, 0}, blended(glm::vec3(1), 0.5f));
  Shader shader{[](const Point& p, Result& r) {
    set(r.radiance, glm::vec3(static_cast<float>(p.surface_id)));
    r.alpha = 1.0f, set(r.transmittance, glm::vec3(0.0f));
  }};
  const CompositeImage image = composite_of(scene, shader);
  for (size_t i = 0; i < size * size; ++i) ASSERT_EQ(rgb(image.radiance, i), glm::vec3(1.0f));
  EXPECT_LT(shader.points.size(), 12u * size * size);
}

// The environment seen by refracted rays is converted to the host's space; the host shades their hits.
TEST(HostShader, shades_what_bent_rays_see) {
  TestScene scene;
  sideray_material_desc volume = glass();
  volume.thickness = 1.0f;
  scene.quad({0, 0, -2}, {50, 0, 0}, {0, 50, 0}, volume);
  scene.quad({0, -3, -5}, {50, 0, 0}, {0, 3, 0}, plain_material());
  scene.environment(glm::vec3(0.25f));
  Shader shader{[](const Point& p, Result& r) {
    if (p.bounce == 1) set(r.radiance, glm::vec3(0.75f));
  }};
  const CompositeImage linear = composite_of(scene, shader, true),
                       gamma = composite_of(scene, shader, true, SIDERAY_SPACE_GAMMA22);
  size_t sky = 0, plate = 0;
  for (size_t i = 0; i < size * size; ++i) {
    const float a = rgb(linear.radiance, i).x, b = rgb(gamma.radiance, i).x;
    const bool met = a > 0.5f;
    ASSERT_NEAR(b, met ? a : a * std::pow(0.25f, 1 / 2.2f) / 0.25f, 4 * half_rounding * b) << i;
    met ? ++plate : ++sky;
  }
  EXPECT_GT(sky, 50u);
  EXPECT_GT(plate, 50u);
}

ReflectionImage reflected(Shader& shader) {
  TestScene scene;
  scene.quad({0, 0, -4}, {50, 0, 0}, {0, 50, 0}, plain_material());
  scene.quad({0, 0, 2}, {0.5f, 0, 0}, {0, 0.5f, 0}, plain_material());
  scene.environment(glm::vec3(0.5f));
  sideray_shader_desc desc = shader.desc();
  desc.radiance_scale = 0.5f;
  scene.scene.set_shader(&desc);
  Tracer tracer({.threads = 2, .isa = ""});
  tracer.set_scene(scene.commit());
  DepthBuffer depth(size, size, 0.1f / 4, 0);
  const std::vector<glm::vec4> normals(size * size, glm::vec4(0, 0, 1, 0));
  ReflectionRequest request;
  request.view = perspective({0, 0, 0}, {0, 0, -1}, fov, 1.0);
  request.width = request.height = size;
  request.depth = depth.image();
  request.normals = NormalTexels(normals);
  request.max_roughness = 0.5f;
  ReflectionImage image;
  tracer.trace_reflections(request, image);
  return image;
}

TEST(HostShader, shades_what_opaque_surfaces_reflect) {
  Shader shader{[](const Point& p, Result& r) { set(r.radiance, glm::vec3(p.translucent ? 9.0f : 2.0f)); }};
  const ReflectionImage image = reflected(shader);
  size_t plate = 0;
  for (uint32_t y = 0; y < size; ++y)
    for (uint32_t x = 0; x < size; ++x) {
      glm::dvec3 d = direction_of(x, y);
      d *= 10 / -d.z;
      const bool met = std::abs(d.x) < 0.5 && std::abs(d.y) < 0.5;
      ASSERT_NEAR(rgb(image.radiance, size_t{y} * size + x).x, met ? 2.0f : 0.25f, 1e-3f);
      plate += met;
    }
  EXPECT_EQ(plate, shader.points.size());
  EXPECT_GT(plate, 3u);
}

TEST(HostShader, reads_what_is_no_number_as_black) {
  TestScene scene;
  scene.quad({0, 0, -2}, {50, 0, 0}, {0, 50, 0}, blended(glm::vec3(1), 0.5f));
  constexpr float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
  const std::vector<std::function<void(Result&)>> wrong{[](Result& r) { r.radiance[1] = nan; },
                                                        [](Result& r) { r.radiance[0] = inf; },
                                                        [](Result& r) { r.alpha = nan; },
                                                        [](Result& r) { r.transmittance[2] = -inf; },
                                                        [](Result& r) { r.reflectance[0] = nan; },
                                                        [](Result& r) { r.reflection[1] = inf; },
                                                        [](Result& r) { set(r.reflection, glm::vec3(0.0f)); }};
  for (size_t k = 0; k < wrong.size(); ++k) {
    // Left of the middle; the right half stays good.
    Shader shader{[&](const Point& p, Result& r) {
      set(r.radiance, glm::vec3(1.0f, -1.0f, 1.0f));
      if (p.position[0] < 0) wrong[k](r);
    }};
    Counters counters;
    const LayerCache cache = cache_of(scene, shader, {}, 2, &counters);
    EXPECT_EQ(counters.points_not_finite, size * size / 2u) << k;
    EXPECT_EQ(counters.points_shaded, size * size) << k;
    for (uint32_t x = 0; x < size; ++x) {
      const size_t texel = texel_of(cache, x, size / 3, 0);
      EXPECT_EQ(rgb(cache.radiance, texel), x < size / 2 ? glm::vec3(0) : glm::vec3(1, 0, 1)) << k;
      EXPECT_GT(cache.distance[texel], 0.0f) << k;  // it has an answer all the same
    }
  }
}

}  // namespace
}  // namespace sideray::rt
