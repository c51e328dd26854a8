// Refracted rays against Snell, Beer and Lambert in closed form.
#include <gtest/gtest.h>

#include <algorithm>

#include "rt/refraction/refraction_scene.h"

namespace sideray::rt::refraction_test {
namespace {

using namespace test;

constexpr uint32_t size = 40;
constexpr double yfov = 0.5;
// Of halfs, of the arithmetic in floats behind them.
constexpr double half_precision = 1.0 / 1024;

struct Seen {
  CompositeImage image;
  Counters counters;
};

Seen trace(const std::shared_ptr<const model::Snapshot>& snapshot, const TraceView& view, bool refraction = true,
           uint32_t events = 0, uint32_t threads = 1) {
  Tracer tracer({.threads = threads, .isa = ""});
  tracer.set_scene(snapshot);
  TestFrame frame(view, size, size, events);
  frame.request.all_translucent = true;
  frame.request.refraction = refraction;
  Seen seen;
  seen.counters = tracer.trace_composite(frame.get(), seen.image);
  return seen;
}

ReferenceImage reference(const std::shared_ptr<const model::Snapshot>& snapshot, const TraceView& view,
                         uint32_t light_samples = 16) {
  Tracer tracer({.threads = 1, .isa = ""});
  tracer.set_scene(snapshot);
  ReferenceRequest request;
  request.views = {view};
  request.width = request.height = size;
  request.light_samples = light_samples;
  request.refraction = true;
  ReferenceImage image;
  tracer.trace_reference(request, image);
  return image;
}

// From `eye` along -z.
TraceView forward(glm::dvec3 eye) {
  return perspective(eye, eye + glm::dvec3(0, 0, -1), yfov, 1.0, 1e-3);
}

DoubleRay ray_of(glm::dvec3 eye, uint32_t x, uint32_t y) {
  const double h = std::tan(0.5 * yfov);
  const auto ndc = [](uint32_t i) { return (i + 0.5) / size * 2 - 1; };
  return {eye, glm::normalize(glm::dvec3(ndc(x) * h, ndc(y) * h, -1))};
}

void expect_color(glm::vec3 value, glm::dvec3 expected, double relative, uint32_t x, uint32_t y) {
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(static_cast<double>(value[c]), expected[c], relative * expected[c] + 1e-4) << x << ' ' << y;
}

// Compares every pixel whose path the solid's planes give with the wall's tile there. Returns how many were compared
// after `least_surfaces` or more.
int compare(const ConvexSolid& solid, const Seen& seen, glm::dvec3 eye, const TiledWall& wall, int least_surfaces = 2) {
  int compared = 0;
  for (uint32_t y = 0; y < size; ++y)
    for (uint32_t x = 0; x < size; ++x) {
      const auto passage = solid.pass(ray_of(eye, x, y));
      if (!passage || passage->from_edge < 1e-4) continue;
      const auto tile = wall.seen(passage->out, 1e-4);
      if (!tile) continue;
      const size_t texel = size_t{y} * size + x;
      EXPECT_EQ(rgb(seen.image.transmittance, texel), glm::vec3(0.0f));
      expect_color(rgb(seen.image.radiance, texel), *tile * passage->transmittance, 2 * half_precision, x, y);
      compared += passage->surfaces >= least_surfaces;
    }
  return compared;
}

TEST(Refraction, bends_by_snells_law_up_to_the_critical_angle) {
  const glm::vec3 normal(0, 1, 0);
  for (const auto& [from, to] : {std::pair(1.0f, 1.5f), {1.5f, 1.0f}, {1.5f, 1.33f}, {2.4f, 1.0f}}) {
    const double critical = from > to ? std::asin(static_cast<double>(to) / static_cast<double>(from)) : M_PI / 2;
    for (int i = 0; i <= 100; ++i) {
      const double angle = M_PI / 2 * 0.999 * i / 100;
      const glm::vec3 to_eye(-std::sin(angle), std::cos(angle), 0);
      const Bend b = bend(to_eye, normal, from, to);
      if (std::abs(angle - critical) < 1e-3) continue;
      ASSERT_EQ(b.total, angle > critical);
      const double sine = std::sin(angle) * (b.total ? 1.0 : static_cast<double>(from) / static_cast<double>(to));
      EXPECT_NEAR(static_cast<double>(b.direction.x), sine, 1e-5);
      EXPECT_EQ(b.direction.y > 0, b.total);
      EXPECT_NEAR(static_cast<double>(glm::length(b.direction)), 1.0, 1e-6);
    }
  }
  const Bend unbent = bend(glm::normalize(glm::vec3(1, 2, 3)), normal, 1.0f, 1.0f);
  EXPECT_EQ(unbent.direction, -glm::normalize(glm::vec3(1, 2, 3)));
}

TEST(Refraction, reflectance_between_media_is_fresnels) {
  EXPECT_NEAR(dielectric_reflectance(1.0f, 1.0f, 1.5f), 0.04f, 1e-6f);
  EXPECT_NEAR(dielectric_reflectance(1.0f, 1.5f, 1.33f), std::pow(0.17f / 2.83f, 2.0f), 1e-6f);
  EXPECT_NEAR(dielectric_reflectance(0.0f, 1.5f, 1.0f), 1.0f, 1e-6f);  // at the critical angle
  EXPECT_NEAR(dielectric_reflectance(0.3f, 1.4f, 1.4f), 0.0f, 1e-12f);
  // At Brewster's angle, tan = n, light in the plane of incidence is not reflected: half of the other is left.
  const float n = 1.5f, cosine = 1 / std::sqrt(1 + n * n), other = std::sqrt(1 - (1 - cosine * cosine) / (n * n));
  const float s = (cosine - n * other) / (cosine + n * other);
  EXPECT_NEAR(dielectric_reflectance(cosine, 1.0f, n), 0.5f * s * s, 1e-6f);
}

TEST(Refraction, the_medium_entered_last_counts) {
  TestScene scene;
  for (const float ior : {1.5f, 1.33f}) Triangles::box(glm::vec3(-1), glm::vec3(1)).add_to(scene, solid_glass(ior));
  scene.quad({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, solid_glass(2.0f));
  const RefractionScene media(scene.commit());
  const Hit into_glass{1, 0, 0, 0, 0, true}, out_of_glass{1, 0, 0, 0, 0, false}, into_liquid{1, 0, 0, 1, 0, true},
      out_of_liquid{1, 0, 0, 1, 0, false}, quad{1, 0, 0, 2, 0, false};
  MediumStack stack;
  const auto expect = [&](const Hit& hit, bool interface, float from, float to) {
    const Crossing c = cross(media, hit, false, stack);
    EXPECT_EQ(c.interface, interface);
    if (interface) {
      EXPECT_EQ(std::pair(c.ior_from, c.ior_to), std::pair(from, to));
    }
    EXPECT_EQ(media.ior(stack), to);
  };
  // Through a wall that the liquid overlaps, and out again on the other side.
  expect(into_glass, true, 1.0f, 1.5f);
  expect(into_liquid, true, 1.5f, 1.33f);
  expect(out_of_glass, false, 1.33f, 1.33f);
  expect(into_glass, true, 1.33f, 1.5f);
  expect(out_of_liquid, false, 1.5f, 1.5f);
  expect(out_of_glass, true, 1.5f, 1.0f);
  // A surface that closes nothing is entered, and left when met again.
  expect(quad, true, 1.0f, 2.0f);
  expect(quad, true, 2.0f, 1.0f);
  // The back of a solid that was never entered: the eye may be in it, a bent ray is not.
  expect(out_of_glass, false, 1.0f, 1.0f);
  const Crossing from_inside = cross(media, out_of_glass, true, stack);
  EXPECT_TRUE(from_inside.interface);
  EXPECT_EQ(from_inside.ior_from, 1.5f);
  EXPECT_EQ(from_inside.absorber, 0u);
}

TEST(Refraction, a_slab_displaces_and_absorbs_by_the_way_through_it) {
  const TiledWall wall{-9, 6};
  const glm::vec3 color(0.9f, 0.5f, 0.2f);
  for (const bool double_sided : {true, false}) {
    TestScene scene;
    wall.add_to(scene);
    sideray_material_desc m = solid_glass(1.5f, color, 0.7f);
    m.double_sided = double_sided;
    Triangles::box({-3, -3, -4}, {3, 3, -3}).add_to(scene, m);
    ConvexSolid solid = box_solid({-3, -3, -4}, {3, 3, -3});
    solid.absorption = -glm::log(glm::dvec3(color)) / static_cast<double>(0.7f);
    const glm::dvec3 eye(0.9, 0.4, 0);
    // The textbook's displacement, once, so that the planes' arithmetic is checked too.
    const DoubleRay ray = ray_of(eye, 3, 7);
    const glm::dvec3 straight = ray.origin + ray.direction * (4 / -ray.direction.z), out = solid.pass(ray)->out.origin;
    const double i = std::acos(-ray.direction.z), r = std::asin(std::sin(i) / 1.5);
    EXPECT_NEAR(glm::length(straight - out) * std::cos(i), std::sin(i - r) / std::cos(r), 1e-12);
    EXPECT_GT(compare(solid, trace(scene.commit(), forward(eye)), eye, wall), 900);
  }
}

TEST(Refraction, prisms_deviate_and_reflect_totally) {
  const TiledWall wall{-9, 6};
  struct Case {
    std::vector<glm::vec2> outline;  // seen along the prism's axis, y
    int least_surfaces;
  };
  // A wedge; a Dove prism, which reflects at its long side.
  const Case cases[] = {{{{-1, -1}, {1, 0}, {-1, 1}}, 2},
                        {{{-0.5f, -2.1f}, {0.5f, -1.1f}, {0.5f, 1.1f}, {-0.5f, 2.1f}}, 3}};
  for (const Case& c : cases) {
    TestScene scene;
    wall.add_to(scene);
    // Outline (x, y) becomes (x, z): turned about x.
    Triangles t = Triangles::column(c.outline, -2, 2);
    for (glm::vec3& p : t.positions) p = {p.x, -p.z, p.y - 4};
    t.add_to(scene, solid_glass(1.5f, glm::vec3(0.5f, 0.8f, 0.9f), 2.0f));
    ConvexSolid solid;
    solid.faces = {{{0, 1, 0}, 2}, {{0, -1, 0}, 2}};
    for (size_t i = 0; i < c.outline.size(); ++i) {
      const glm::dvec2 a(c.outline[i]), b(c.outline[(i + 1) % c.outline.size()]);
      const glm::dvec3 n = glm::normalize(glm::dvec3(b.y - a.y, 0, a.x - b.x));
      solid.faces.push_back({n, glm::dot(n, glm::dvec3(a.x, 0, a.y - 4))});
    }
    solid.absorption = -glm::log(glm::dvec3(glm::vec3(0.5f, 0.8f, 0.9f))) / 2.0;
    const glm::dvec3 eye(0.1, 0.2, 0);
    EXPECT_GT(compare(solid, trace(scene.commit(), forward(eye)), eye, wall, c.least_surfaces), 100);
  }
}

// Smooth normals over a tessellation: the sphere's own refraction, but for the facets' distance from it.
// Each channel is seen where its own index bends it to.
TEST(Refraction, a_prism_disperses) {
  constexpr double ior = 1.5, dispersion = 4, half = 6, z = -9, spread = 0.025 * (ior - 1) * dispersion;
  TestScene scene;
  // Columns, of a step of brightness each, alike in all channels.
  std::vector<uint8_t> rgba;
  constexpr uint32_t tiles = 64;
  for (uint32_t column = 0; column < tiles; ++column) {
    const auto value = static_cast<uint8_t>(3 + 4 * column);
    rgba.insert(rgba.end(), {value, value, value, 255});
  }
  sideray_material_desc m = glowing(glm::vec3(1.0f));
  m.emissive_texture.texture = scene.scene.add_texture(tiles, 1, SIDERAY_RGBA8, rgba.data());
  m.emissive_texture.filter = SIDERAY_NEAREST;
  scene.quad({0, 0, z}, {half, 0, 0}, {0, half, 0}, m);
  Triangles t = Triangles::column({{-1, -1}, {1, 0}, {-1, 1}}, -2, 2);
  for (glm::vec3& p : t.positions) p = {p.x, -p.z, p.y - 4};
  sideray_material_desc crystal = solid_glass(static_cast<float>(ior));
  crystal.dispersion = static_cast<float>(dispersion);
  t.add_to(scene, crystal);
  ConvexSolid solid;
  solid.faces = {{{0, 1, 0}, 2}, {{0, -1, 0}, 2}};
  const glm::dvec2 outline[] = {{-1, -1}, {1, 0}, {-1, 1}};
  for (int i = 0; i < 3; ++i) {
    const glm::dvec2 a = outline[i], b = outline[(i + 1) % 3];
    const glm::dvec3 n = glm::normalize(glm::dvec3(b.y - a.y, 0, a.x - b.x));
    solid.faces.push_back({n, glm::dot(n, glm::dvec3(a.x, 0, a.y - 4))});
  }
  solid.fresnel_ior = ior;
  const glm::dvec3 eye(0, 0, 0);
  const auto snapshot = scene.commit();
  const Seen seen = trace(snapshot, forward(eye));
  const ReferenceImage exact = reference(snapshot, forward(eye), 2);
  int compared = 0, apart = 0;
  for (uint32_t y = 0; y < size; ++y)
    for (uint32_t x = 0; x < size; ++x) {
      double places[3] = {};
      for (int c = 0; c < 3; ++c) {
        solid.ior = ior + (c - 1) * spread;
        const auto passage = solid.pass(ray_of(eye, x, y));
        if (!passage || passage->from_edge < 1e-4 || passage->out.direction.z > -1e-2) continue;
        const DoubleRay& out = passage->out;
        const double at = out.origin.x + out.direction.x * ((z - out.origin.z) / out.direction.z);
        const double column = (at + half) / (2 * half / tiles);
        if (column < 0 || column >= tiles || std::abs(column - std::round(column)) < 0.01) continue;
        places[c] = std::floor(column) + 1;
        const double expected = (3 + 4 * std::floor(column)) / 255 * passage->transmittance.y;
        const size_t texel = size_t{y} * size + x;
        EXPECT_NEAR(static_cast<double>(rgb(seen.image.radiance, texel)[c]), expected, 2e-3) << x << ' ' << y << ' ' << c;
        EXPECT_NEAR(static_cast<double>(exact.color[texel][c]), expected, 2e-3) << x << ' ' << y << ' ' << c;
        ++compared;
      }
      apart += places[0] > 0 && places[2] > 0 && places[0] != places[2];
    }
  EXPECT_GT(compared, 900);
  EXPECT_GT(apart, 200);
}

TEST(Refraction, a_tessellated_sphere_is_a_ball_lens) {
  constexpr int rings = 192;
  const glm::dvec3 center(0, 0, -4), eye(0.15, 0.1, 0);
  std::vector<glm::vec3> positions, normals;
  std::vector<uint32_t> indices;
  for (int i = 0; i <= rings; ++i)
    for (int k = 0; k <= 2 * rings; ++k) {
      const double a = M_PI * i / rings, b = M_PI * (k % (2 * rings)) / rings;
      const bool pole = i == 0 || i == rings;
      const glm::dvec3 n(pole ? 0 : std::sin(a) * std::cos(b), std::cos(a), pole ? 0 : std::sin(a) * std::sin(b));
      normals.emplace_back(n), positions.emplace_back(center + n);
    }
  for (uint32_t i = 0; i < rings; ++i)
    for (uint32_t k = 0; k < 2 * rings; ++k) {
      const uint32_t a = i * (2 * rings + 1) + k, b = a + 2 * rings + 1;
      if (i > 0) indices.insert(indices.end(), {a, a + 1, b});
      if (i + 1 < rings) indices.insert(indices.end(), {a + 1, b + 1, b});
    }
  TestScene scene;
  const TiledWall wall{-7, 6};
  wall.add_to(scene);
  sideray_mesh_desc mesh{};
  mesh.size = sizeof(mesh);
  mesh.vertex_count = static_cast<uint32_t>(positions.size());
  mesh.index_count = static_cast<uint32_t>(indices.size());
  mesh.indices = indices.data();
  mesh.positions = {&positions[0].x, 0};
  mesh.normals = {&normals[0].x, 0};
  sideray_instance_desc instance{};
  instance.mesh = scene.scene.add_mesh(mesh, nullptr);
  instance.material = scene.scene.add_material(solid_glass(1.5f));
  for (int d = 0; d < 3; ++d) instance.world_from_object[4 * d] = 1;
  instance.surface_id = 99, instance.visibility = SIDERAY_VISIBLE_ALL;
  scene.scene.add_instances(&instance, 1);
  const auto snapshot = scene.commit();
  ASSERT_TRUE(snapshot->instances.back().solid);
  const Seen seen = trace(snapshot, forward(eye));
  // A chord's sagitta moves a hit by that over the cosine, and the normal there by the square of the step's angle; the
  // lens of focal length 1.5 radii turns the latter into an offset on the wall that is 3 radii away. Ten times as much.
  const double step = M_PI / rings, margin = 10 * step * step;
  int compared = 0;
  for (uint32_t y = 0; y < size; ++y)
    for (uint32_t x = 0; x < size; ++x) {
      DoubleRay ray = ray_of(eye, x, y);
      const double middle = glm::dot(center - ray.origin, ray.direction);
      const double across2 = glm::dot(center - ray.origin, center - ray.origin) - middle * middle;
      if (across2 > 0.9 * 0.9) continue;
      ray.origin += ray.direction * (middle - std::sqrt(1 - across2));
      const glm::dvec3 n = ray.origin - center;
      const double through = 1 - schlick(-glm::dot(n, ray.direction), 1.5);
      ray.direction = *snell(ray.direction, n, 1.0, 1.5);
      ray.origin -= ray.direction * (2 * glm::dot(n, ray.direction));
      ray.direction = *snell(ray.direction, -(ray.origin - center), 1.5, 1.0);
      const auto tile = wall.seen(ray, margin);
      if (!tile) continue;
      expect_color(rgb(seen.image.radiance, size_t{y} * size + x), *tile * (through * through), 0.003, x, y);
      ++compared;
    }
  EXPECT_GT(compared, 500);
}

// Walls of glass around a liquid, which touches them or reaches into them: parallel plates in contact.
TEST(Refraction, liquid_in_a_glass_is_plates_in_contact) {
  const TiledWall wall{-9, 6};
  for (const float overlap : {0.0f, 0.02f, 0.1f}) {
    TestScene scene;
    wall.add_to(scene);
    Triangles glass = Triangles::box({-3, -3, -3.2f}, {3, 3, -3}),
              far_wall = Triangles::box({-3, -3, -4.2f}, {3, 3, -4});
    const auto count = static_cast<uint32_t>(glass.positions.size());
    glass.positions.insert(glass.positions.end(), far_wall.positions.begin(), far_wall.positions.end());
    for (const uint32_t i : far_wall.indices) glass.indices.push_back(count + i);
    const Triangles liquid = Triangles::box({-3, -3, -4 - overlap}, {3, 3, -3.2f + overlap});
    glass.add_to(scene, solid_glass(1.5f));
    liquid.add_to(scene, solid_glass(1.33f));
    const glm::dvec3 eye(0.2, 0.1, 0);
    const Seen seen = trace(scene.commit(), forward(eye));
    int compared = 0;
    for (uint32_t y = 0; y < size; ++y)
      for (uint32_t x = 0; x < size; ++x) {
        DoubleRay ray = ray_of(eye, x, y);
        // The medium entered last counts: liquid from its near face to the far wall's, glass from there on.
        const double in_liquid = 0.8 + static_cast<double>(overlap), in_glass = 1.2 - in_liquid;
        const double sine2 = 1 - ray.direction.z * ray.direction.z;
        const auto cosine = [&](double ior) { return std::sqrt(1 - sine2 / (ior * ior)); };
        const glm::dvec2 along = glm::dvec2(ray.direction);  // n sin(angle) is the same in every plate
        const glm::dvec2 offset =
            along * (3.0 / cosine(1) + in_glass / 1.5 / cosine(1.5) + in_liquid / 1.33 / cosine(1.33));
        const DoubleRay out{eye + glm::dvec3(offset, -4.2), ray.direction};
        const auto tile = wall.seen(out, 1e-4);
        if (!tile) continue;
        const double inner = static_cast<double>(dielectric_reflectance(static_cast<float>(cosine(1.33)), 1.5f, 1.33f));
        const double outer = schlick(cosine(1), 1.5);
        const double through = (1 - outer) * (1 - outer) * (1 - inner) * (1 - inner);
        expect_color(rgb(seen.image.radiance, size_t{y} * size + x), *tile * through, 2 * half_precision, x, y);
        ++compared;
      }
    EXPECT_GT(compared, 1000);
    EXPECT_EQ(seen.counters.layers_found, 4u * size * size);  // no gap of air was crossed
  }
}

TEST(Refraction, a_single_quad_is_never_left) {
  const TiledWall wall{-9, 6};
  const glm::dvec3 eye(0.3, 0.2, 0);
  for (const bool from_behind : {false, true}) {
    TestScene scene;
    wall.add_to(scene);
    scene.quad({0, 0, -3}, {from_behind ? -3.0f : 3.0f, 0, 0}, {0, 3, 0}, solid_glass(1.5f));
    const Seen seen = trace(scene.commit(), forward(eye));
    int compared = 0;
    for (uint32_t y = 0; y < size; ++y)
      for (uint32_t x = 0; x < size; ++x) {
        DoubleRay ray = ray_of(eye, x, y);
        ray.origin += ray.direction * (-3 / ray.direction.z);
        const double through = 1 - schlick(-ray.direction.z, 1.5);
        ray.direction = *snell(ray.direction, {0, 0, 1}, 1.0, 1.5);
        const auto tile = wall.seen(ray, 1e-4);
        if (!tile) continue;
        expect_color(rgb(seen.image.radiance, size_t{y} * size + x), *tile * through, 2 * half_precision, x, y);
        ++compared;
      }
    EXPECT_GT(compared, 1000);
  }
}

// The eye in a box of water: what is in it shows through the way to it, what is outside is bent on the way out.
TEST(Refraction, rays_start_in_the_medium_that_the_eye_is_in) {
  const glm::vec3 color(0.9f, 0.7f, 0.3f);
  ConvexSolid solid = box_solid({-2, -2, -3}, {2, 2, 1});
  solid.ior = static_cast<double>(1.33f);
  solid.absorption = -glm::log(glm::dvec3(color)) / 2.0;
  const glm::dvec3 eye(0.2, -0.1, 0);
  const TiledWall outside{-9, 6}, inside{-2, 1.9};
  for (const TiledWall* wall : {&outside, &inside}) {
    TestScene scene;
    wall->add_to(scene);
    Triangles::box({-2, -2, -3}, {2, 2, 1}).add_to(scene, solid_glass(1.33f, color, 2.0f));
    const ReferenceImage image = reference(scene.commit(), forward(eye), 1);
    int compared = 0;
    for (uint32_t y = 0; y < size; ++y)
      for (uint32_t x = 0; x < size; ++x) {
        const DoubleRay ray = ray_of(eye, x, y);
        glm::dvec3 through = glm::exp(solid.absorption * (-2.0 / -ray.direction.z));
        DoubleRay out = ray;
        if (wall == &outside) {
          const auto passage = solid.leave(ray, solid.faces.size(), {ray, glm::dvec3(1), 0, 1e30});
          if (!passage || passage->surfaces > 1) continue;
          through = passage->transmittance, out = passage->out;
        }
        const auto tile = wall->seen(out, 1e-4);
        if (!tile) continue;
        // The way out also reflects a little of the inside, which is black.
        expect_color(glm::vec3(image.color[size_t{y} * size + x]), *tile * through, 0.002, x, y);
        ++compared;
      }
    EXPECT_GT(compared, 1000);
  }
}

TEST(Refraction, index_one_bends_nothing) {
  TestScene scene;
  scene.environment({0.4f, 0.6f, 0.9f});
  Triangles::box({-1, -1, -4}, {1, 1, -3}).add_to(scene, solid_glass(1.0f));
  scene.quad({0.2f, 0, -5}, {2, 0, 0}, {0, 1, 0}, blended({0.8f, 0.3f, 0.2f}, 0.4f));
  scene.quad({0, 0.2f, -3.5f}, {0.5f, 0, 0}, {0, 0.5f, 0}, blended({0.2f, 0.3f, 0.9f}, 0.6f));
  const auto snapshot = scene.commit();
  for (const uint32_t events : {1u, 3u, 0u}) {
    const Seen on = trace(snapshot, forward(glm::dvec3(0)), true, events);
    const Seen off = trace(snapshot, forward(glm::dvec3(0)), false, events);
    EXPECT_EQ(on.image.transmittance, off.image.transmittance);
    EXPECT_EQ(on.counters.layers_found, off.counters.layers_found);
    for (size_t i = 0; i < size * size; ++i)
      expect_color(rgb(on.image.radiance, i), glm::dvec3(rgb(off.image.radiance, i)), half_precision, 0, 0);
  }
}

// Of a block of glass with dark panes in it, more than one traversal finds.
TEST(Refraction, surfaces_past_the_limit_vanish) {
  const TiledWall wall{-9, 6};
  TestScene scene;
  wall.add_to(scene);
  const glm::vec3 color(0.5f);
  Triangles::box({-3, -3, -4}, {3, 3, -3}).add_to(scene, solid_glass(1.5f, color, 1.0f));
  const sideray_material_desc pane = blended(glm::vec3(0), 0.9f);
  for (int i = 1; i <= 6; ++i) scene.quad({0, 0, -3.0f - 0.1f * static_cast<float>(i)}, {3, 0, 0}, {0, 3, 0}, pane);
  const glm::dvec3 eye(0);
  const Seen seen = trace(scene.commit(), forward(eye), true, 1);
  EXPECT_EQ(seen.counters.layers_found, uint64_t{size} * size);
  int compared = 0;
  for (uint32_t y = 0; y < size; ++y)
    for (uint32_t x = 0; x < size; ++x) {
      DoubleRay ray = ray_of(eye, x, y);
      ray.origin += ray.direction * (-3 / ray.direction.z);
      double through = 1 - schlick(-ray.direction.z, 1.5);
      ray.direction = *snell(ray.direction, {0, 0, 1}, 1.0, 1.5);
      through *= std::exp2(1 / ray.direction.z);  // the glass still ends where it ends
      const auto tile = wall.seen(ray, 1e-4);
      if (!tile) continue;
      expect_color(rgb(seen.image.radiance, size_t{y} * size + x), *tile * through, 2 * half_precision, x, y);
      ++compared;
    }
  EXPECT_GT(compared, 1000);
}

// What a solid absorbs by its thickness, without refraction, it absorbs once.
TEST(Refraction, off_a_solid_attenuates_once) {
  for (const bool closed : {true, false}) {
    TestScene scene;
    const sideray_material_desc m = solid_glass(1.0f, glm::vec3(0.25f), 1.0f);
    if (closed)
      Triangles::box({-3, -3, -4}, {3, 3, -3}).add_to(scene, m);
    else
      for (const float z : {-3.0f, -4.0f}) scene.quad({0, 0, z}, {3, 0, 0}, {0, 3, 0}, m);
    const Seen seen = trace(scene.commit(), forward(glm::dvec3(0)), false);
    EXPECT_NEAR(rgb(seen.image.transmittance, size * size / 2 + size / 2).x, closed ? 0.25f : 0.0625f, 1e-4f);
  }
}

// White surroundings, glass that absorbs nothing: whatever way light takes, it is white.
TEST(Refraction, glass_vanishes_in_a_furnace) {
  TestScene scene;
  scene.environment(glm::vec3(1.0f));
  Triangles t = Triangles::column({{-1, -0.6f}, {1.1f, -0.7f}, {0.2f, 0.9f}}, -4.5f, -3.2f);
  t.add_to(scene, solid_glass(1.5f));
  const auto snapshot = scene.commit();
  const Seen seen = trace(snapshot, forward(glm::dvec3(0.1, 0, 0)));
  // A path loses what the split sum's single scattering loses of each reflection, under 1 % of it, and ends below 1e-4
  // or after 256 surfaces; a solid's internal reflections meet one surface more, without what that one reflects again.
  for (size_t i = 0; i < size * size; ++i) {
    const glm::vec3 sum = rgb(seen.image.radiance, i) + rgb(seen.image.transmittance, i);
    EXPECT_NEAR(sum.x, 1.0f, 0.02f) << i % size << ' ' << i / size;
  }
  const ReferenceImage image = reference(snapshot, forward(glm::dvec3(0.1, 0, 0)), 64);
  double mean = 0;
  for (const glm::vec4& c : image.color) mean += static_cast<double>(c.x) / (size * size);
  EXPECT_NEAR(mean, 1.0, 0.01);
}

// Alpha covers what light is taken from, whether rays are bent or not.
TEST(Refraction, alpha_counts_what_the_surroundings_show_through) {
  TestScene scene;
  scene.environment(glm::vec3(1.0f));
  Triangles::box({-3, -3, -4}, {3, 3, -3}).add_to(scene, solid_glass(1.5f, glm::vec3(0.5f), 1.0f));
  const ReferenceImage image = reference(scene.commit(), forward(glm::dvec3(0)), 4);
  const ConvexSolid solid = [] {
    ConvexSolid s = box_solid({-3, -3, -4}, {3, 3, -3});
    s.absorption = glm::dvec3(std::log(2.0));
    return s;
  }();
  for (uint32_t i = 0; i < size; ++i) {
    const double through = solid.pass(ray_of(glm::dvec3(0), i, i))->transmittance.x;
    EXPECT_NEAR(static_cast<double>(image.color[i * size + i].w), 1 - through, 1e-4);
  }
}

TEST(Refraction, raytraced_without_a_limit_is_the_reference) {
  const TiledWall wall{-9, 6};
  TestScene scene;
  wall.add_to(scene);
  Triangles::column({{-1, -1}, {1, -0.8f}, {0.6f, 1}, {-0.9f, 0.8f}}, -4.5f, -3.2f)
      .add_to(scene, solid_glass(1.5f, glm::vec3(0.4f, 0.7f, 0.9f), 1.0f));
  const auto snapshot = scene.commit();
  const Seen seen = trace(snapshot, forward(glm::dvec3(0.1, 0, 0)));
  const ReferenceImage image = reference(snapshot, forward(glm::dvec3(0.1, 0, 0)), 64);
  double difference = 0, sum = 0;
  for (size_t i = 0; i < size * size; ++i) {
    if (rgb(seen.image.transmittance, i) != glm::vec3(0.0f)) continue;  // the wall itself is not in the composite
    for (int c = 0; c < 3; ++c) {
      difference += std::abs(static_cast<double>(rgb(seen.image.radiance, i)[c] - image.color[i][c]));
      sum += static_cast<double>(image.color[i][c]);
    }
  }
  EXPECT_LT(difference, 0.01 * sum);
}

TEST(Refraction, is_the_same_for_any_number_of_threads) {
  TestScene scene;
  scene.environment({0.4f, 0.6f, 0.9f});
  TiledWall{-9, 6}.add_to(scene);
  for (int i = 0; i < 3; ++i) {
    const auto x = static_cast<float>(i) - 1.0f;
    sideray_material_desc m = solid_glass(1.3f + 0.1f * static_cast<float>(i), glm::vec3(0.5f, 0.8f, 0.9f), 1.0f);
    m.roughness = 0.2f * static_cast<float>(i);
    Triangles::box({x - 0.4f, -0.5f, -4}, {x + 0.4f, 0.5f, -3}).add_to(scene, m);
  }
  const auto snapshot = scene.commit();
  const Seen one = trace(snapshot, forward(glm::dvec3(0)), true, 0, 1);
  const Seen four = trace(snapshot, forward(glm::dvec3(0)), true, 0, 4);
  EXPECT_EQ(one.image.radiance, four.image.radiance);
  EXPECT_EQ(one.image.transmittance, four.image.transmittance);
  EXPECT_EQ(one.counters.rays_primary, four.counters.rays_primary);
}

// Rough glass spreads what stands behind it in the reference, by as much light as smooth glass lets through.
TEST(Refraction, rough_glass_scatters_in_the_reference) {
  sideray_material_desc m = solid_glass(1.3f);
  double through[2], contrast[2];
  for (const int rough : {0, 1}) {
    TestScene scene;
    scene.environment(glm::vec3(0.0f));
    for (int i = -8; i < 8; ++i)
      scene.quad({0.5f * static_cast<float>(i) + 0.125f, 0, -9}, {0.125f, 0, 0}, {0, 9, 0}, glowing(glm::vec3(1.0f)));
    m.roughness = rough ? 0.35f : 0.0f;
    Triangles::box({-3, -3, -4}, {3, 3, -3}).add_to(scene, m);
    const ReferenceImage image = reference(scene.commit(), forward(glm::dvec3(0)), 2);
    double sum = 0, squares = 0;
    for (const glm::vec4& c : image.color) sum += static_cast<double>(c.x), squares += static_cast<double>(c.x * c.x);
    through[rough] = sum / (size * size);
    contrast[rough] = squares / (size * size) - through[rough] * through[rough];
  }
  EXPECT_NEAR(through[1], through[0], 0.1 * through[0]);
  EXPECT_LT(contrast[1], 0.5 * contrast[0]);
}

}  // namespace
}  // namespace sideray::rt::refraction_test
