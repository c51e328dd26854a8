// Tests by closed forms: coplanar surfaces, shared edges and corners, and which instances a ray may hit.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <tuple>

#include "rt/embree/intersector_fixture.h"
#include "rt/kernel_sets.h"

namespace sideray::rt::test {
namespace {

std::vector<uint32_t> instances_of(const std::vector<Hit>& hits) {
  std::vector<uint32_t> result;
  for (const Hit& hit : hits) result.push_back(hit.instance);
  return result;
}

// Adds n x n cells of two triangles each over [-1, 1]^2 with random heights; edges are shared by indices.
uint32_t add_height_field(SceneBuilder& scene, std::mt19937& random, uint32_t n, float height) {
  std::uniform_real_distribution<float> uniform(-height, height);
  std::vector<glm::vec3> positions;
  std::vector<glm::uvec3> triangles;
  for (uint32_t y = 0; y <= n; ++y)
    for (uint32_t x = 0; x <= n; ++x) {
      const auto at = [n](uint32_t i) { return 2.0f * static_cast<float>(i) / static_cast<float>(n) - 1.0f; };
      positions.emplace_back(at(x), at(y), uniform(random));
    }
  for (uint32_t y = 0; y < n; ++y)
    for (uint32_t x = 0; x < n; ++x) {
      const uint32_t a = y * (n + 1) + x, b = a + 1, c = a + n + 1, d = c + 1;
      triangles.emplace_back(a, b, d);
      triangles.emplace_back(a, d, c);
    }
  return scene.add_mesh(positions, triangles);
}

glm::vec3 place(const glm::mat4x3& m, glm::vec3 p) {
  return m * glm::vec4(p, 1.0f);
}

Ray ray_to(glm::vec3 origin, glm::vec3 target) {
  return {origin, 0.0f, target - origin, INFINITY};
}

TEST(CoplanarSurfaces, AreAllFoundOnceInTheOrderOfTheirIds) {
  constexpr uint32_t surfaces = 40;
  std::mt19937 random(1);
  SceneBuilder scene;
  scene.add_material(true);
  // Squares of different sizes and meshes in one plane, so that the arithmetic differs from one to the next.
  for (uint32_t i = 0; i < surfaces; ++i) {
    const float size = std::uniform_real_distribution<float>(1.0f, 3.0f)(random);
    const uint32_t mesh = scene.add_mesh(square(size, 0.25f));
    scene.add_instance(mesh, 0).surface_id = 1 + (i * 7) % surfaces;
  }
  Intersector intersector("");
  intersector.set_scene(scene.snapshot);
  std::vector<Ray> rays;
  std::uniform_real_distribution<float> uniform(-0.9f, 0.9f);
  for (int i = 0; i < 1000; ++i) {
    const float ox = uniform(random), oy = uniform(random), x = uniform(random), y = uniform(random);
    rays.push_back(ray_to({3.0f * ox, 3.0f * oy, 5.0f}, {x, y, 0.0f}));
  }
  for (const uint32_t layers : {1u, 2u, 8u, 40u, 64u}) {
    const auto found = layers_of(intersector, rays, layers, true);
    for (const std::vector<Hit>& hits : found) {
      ASSERT_EQ(hits.size(), std::min(layers, surfaces));
      for (uint32_t k = 0; k < hits.size(); ++k)
        ASSERT_EQ(scene.snapshot->instances[hits[k].instance].surface_id, k + 1) << "layer " << k << " of " << layers;
    }
  }
}

TEST(CoplanarSurfaces, OfOneMeshAreAllFoundInTheOrderOfTheirPrimitives) {
  SceneBuilder scene;
  scene.add_material(true);
  std::vector<glm::vec3> positions;
  for (int i = 0; i < 5; ++i)
    for (const glm::vec3 p : {glm::vec3(-1, -1, 0), glm::vec3(3, -1, 0), glm::vec3(-1, 3, 0)}) positions.push_back(p);
  scene.add_instance(scene.add_mesh(positions), 0);
  Intersector intersector("");
  intersector.set_scene(scene.snapshot);
  const std::vector<Ray> rays{ray_to({0.1f, 0.2f, 5.0f}, {0.1f, 0.2f, 0.0f})};
  for (const std::vector<Hit>& hits : layers_of(intersector, rays, 8)) {
    ASSERT_EQ(hits.size(), 5u);
    for (uint32_t k = 0; k < 5; ++k) EXPECT_EQ(hits[k].primitive, k);
  }
}

// Squares of two triangles, all in one place: the ray through their diagonals meets each square once.
TEST(CoplanarSurfaces, StaySeparateWhereARayMeetsTheirEdges) {
  SceneBuilder scene;
  scene.add_material(true);
  std::vector<glm::vec3> positions;
  for (int i = 0; i < 5; ++i)
    for (const glm::vec3 p : {glm::vec3(-1, -1, 0), glm::vec3(1, -1, 0), glm::vec3(-1, 1, 0), glm::vec3(1, 1, 0),
                              glm::vec3(-1, 1, 0), glm::vec3(1, -1, 0)})
      positions.push_back(p);
  scene.add_instance(scene.add_mesh(positions), 0);
  Intersector intersector("");
  intersector.set_scene(scene.snapshot);
  for (const std::vector<Hit>& hits : layers_of(intersector, {ray_to({0.25f, -0.25f, 5.0f}, {0.25f, -0.25f, 0.0f})}, 8)) {
    ASSERT_EQ(hits.size(), 5u);
    for (uint32_t k = 0; k < 5; ++k) EXPECT_EQ(hits[k].primitive, 2 * k);
  }
}

// A ray through a surface's border misses it, whatever Embree finds. An edge that two surfaces share is no border.
TEST(Borders, AreMissedUnlessTheSurfaceGoesOn) {
  SceneBuilder scene;
  scene.add_material(true);
  const uint32_t square_mesh = scene.add_mesh(square(1.0f, 0.0f));
  glm::mat4x3 beside = SceneBuilder::identity;
  beside[3].x = 2.0f;
  scene.add_instance(square_mesh, 0), scene.add_instance(square_mesh, 0, beside);
  for (const char* isa : kernel_sets()) {
    Intersector intersector(isa);
    intersector.set_scene(scene.snapshot);
    const std::vector<Ray> rays{ray_to({0.3f, 0.2f, 5.0f}, {1.0f, 0.3f, 0.0f}), ray_to({0.3f, 0.2f, 5.0f}, {-1.0f, 0.3f, 0.0f}),
                                ray_to({0.3f, 0.2f, 5.0f}, {-1.0f + 1e-4f, 0.3f, 0.0f}),
                                ray_to({0.3f, 0.2f, 5.0f}, {1.0f, 1.0f, 0.0f})};
    const auto found = layers_of(intersector, rays, 4);
    EXPECT_EQ(found[0].size(), 2u) << isa << ": where they touch, both in that place";
    EXPECT_EQ(found[1].size(), 0u) << isa << ": at the border";
    EXPECT_EQ(found[2].size(), 1u) << isa << ": inside the border";
    EXPECT_EQ(found[3].size(), 0u) << isa << ": where they touch at the border";
  }
}

// Rays that begin, or end, within Embree's rounding of a square far from the origin: whether it counts is decided by the
// distance in double precision, for any hit as for the nearest, with every kernel.
TEST(RayEnds, AreComparedWithTheRecomputedDistance) {
  SceneBuilder scene;
  scene.add_material(false);
  std::mt19937 random(7);
  glm::mat4x3 m = random_transform(random, 1.0f, 1.0f, false);
  m[3] = {31.0f, -17.0f, 43.0f};
  scene.add_instance(scene.add_mesh(square(1.0f, 0.0f)), 0, m);
  std::uniform_real_distribution<float> unit(-0.7f, 0.7f);
  const glm::dvec3 p0(place(m, {-1, -1, 0})), p1(place(m, {1, -1, 0})), p2(place(m, {1, 1, 0}));
  const glm::dvec3 normal = glm::normalize(glm::cross(p1 - p0, p2 - p0));
  std::vector<Ray> rays;
  std::vector<bool> meets;
  for (int i = 0; i < 20000; ++i) {
    const float x = unit(random), y = std::min(x - 0.1f, unit(random));
    const glm::vec3 at = place(m, {x, y, 0.0f});
    const glm::vec3 d = glm::normalize(glm::vec3(unit(random), unit(random), unit(random)));
    if (std::abs(glm::dot(glm::dvec3(d), normal)) < 0.3) continue;
    const bool ends = random() % 2 == 0;
    const glm::vec3 origin = ends ? at - 3.0f * d : at;
    // What all three vertices agree on to 1e-7 or so: the plane of the corners in float.
    const double t = glm::dot(p0 - glm::dvec3(origin), normal) / glm::dot(glm::dvec3(d), normal);
    if (std::abs(ends ? t - 3.0 : t) < 1e-6) continue;  // not certain in this arithmetic
    rays.push_back({origin, 0.0f, d, ends ? 3.0f : 10.0f});
    meets.push_back(ends ? t <= 3.0 : t >= 0.0);
  }
  EXPECT_GT(std::count(meets.begin(), meets.end(), true), 500);
  EXPECT_GT(std::count(meets.begin(), meets.end(), false), 500);
  for (const char* isa : kernel_sets()) {
    Intersector intersector(isa);
    intersector.set_scene(scene.snapshot);
    std::vector<uint8_t> occluded(rays.size());
    std::vector<Hit> nearest(rays.size());
    intersector.occluded(rays, false, occluded.data(), OpaqueSet::all);
    intersector.nearest_opaque(rays, {.set = OpaqueSet::all}, nearest.data());
    size_t wrong = 0;
    for (size_t i = 0; i < rays.size(); ++i)
      wrong += (occluded[i] != 0) != meets[i] || (nearest[i].instance != no_instance) != meets[i];
    EXPECT_EQ(wrong, 0u) << isa;
  }
}

// A surface that may have holes is no wall, wherever rays hit it.
TEST(OpaqueSets, HaveWallsWithoutHoles) {
  SceneBuilder scene;
  scene.add_material(false);
  scene.add_material(false).discards = true;
  const uint32_t mesh = scene.add_mesh(square(1.0f, 0.0f));
  for (const uint32_t material : {0u, 1u}) {
    glm::mat4x3 place = SceneBuilder::identity;
    place[3].x = 3.0f * static_cast<float>(material);
    scene.add_instance(mesh, material, place);
  }
  const std::vector<Ray> rays{ray_to({0.3f, 0.2f, 5.0f}, {0.3f, 0.2f, 0.0f}),
                              ray_to({3.3f, 0.2f, 5.0f}, {3.3f, 0.2f, 0.0f})};
  for (const char* isa : kernel_sets()) {
    Intersector intersector(isa);
    intersector.set_scene(scene.snapshot);
    std::vector<uint8_t> occluded(rays.size());
    intersector.occluded(rays, false, occluded.data(), OpaqueSet::visible_in_reflection);
    EXPECT_EQ(occluded, (std::vector<uint8_t>{1, 1})) << isa;
    intersector.occluded(rays, false, occluded.data(), OpaqueSet::walls);
    EXPECT_EQ(occluded, (std::vector<uint8_t>{1, 0})) << isa;
  }
}

TEST(SharedEdges, GiveOneHitASurface) {
  std::mt19937 random(3);
  for (const float scale : {1e-3f, 1.0f, 1e3f}) {
    SceneBuilder scene;
    scene.add_material(true);
    const uint32_t mesh = add_height_field(scene, random, 24, 0.01f);
    const glm::mat4x3 m = random_transform(random, scale, scale, false);
    scene.add_instance(mesh, 0, m);
    // A second surface below: must be found behind the first, once.
    glm::mat4x3 below = m;
    below[3] = place(m, {0.0f, 0.0f, -0.5f});
    scene.add_instance(mesh, 0, below);
    Intersector intersector("");
    intersector.set_scene(scene.snapshot);

    std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
    const model::Mesh& field = *scene.snapshot->meshes[mesh];
    std::vector<Ray> at_edges, at_corners;
    for (int i = 0; i < 20000; ++i) {
      const glm::uvec3 t = field.triangles[random() % field.triangles.size()];
      const int first = static_cast<int>(random() % 3);
      const glm::vec3 a = field.positions[t[first]], b = field.positions[t[(first + 1) % 3]];
      if (std::max({std::abs(a.x), std::abs(a.y), std::abs(b.x), std::abs(b.y)}) > 0.7f) continue;
      const glm::vec3 eye(0.2f * uniform(random), 0.2f * uniform(random), 2.0f);
      at_edges.push_back(ray_to(place(m, eye), place(m, glm::mix(a, b, uniform(random)))));
      at_corners.push_back(ray_to(place(m, eye), place(m, a)));
    }
    for (const uint32_t layers : {1u, 2u, 4u, 8u}) {
      const uint32_t surfaces = std::min(layers, 2u);
      size_t missed_at_edges = 0, missed_at_corners = 0;
      for (const auto* rays : {&at_edges, &at_corners})
        for (const std::vector<Hit>& hits : layers_of(intersector, *rays, layers, true)) {
          ASSERT_LE(hits.size(), surfaces) << "scale " << scale << ", " << layers << " layers";
          if (hits.size() == 2) {
            ASSERT_THAT(instances_of(hits), testing::ElementsAre(0u, 1u));
          }
          (rays == &at_edges ? missed_at_edges : missed_at_corners) += hits.size() < surfaces;
        }
      // Holes are Embree's: 1e-6 of edges, 2 % of corners hit exactly.
      EXPECT_LE(missed_at_edges, 2u) << "scale " << scale << ", " << layers << " layers";
      EXPECT_LE(missed_at_corners, at_corners.size() / 10) << "scale " << scale << ", " << layers << " layers";
    }
  }
}

TEST(Culling, ShowsTheFrontOfSingleSidedSurfacesOnly) {
  glm::mat4x3 mirror = SceneBuilder::identity;
  mirror[0].x = -1.0f;
  for (const bool mirrored : {false, true})
    for (const bool cull : {false, true}) {
      SceneBuilder scene;
      scene.add_material(true).cull_back = cull;
      // Faces +z also where mirrored in x: glTF flips the winding that counts as front.
      scene.add_instance(scene.add_mesh(square(1.0f, 0.0f)), 0, mirrored ? mirror : SceneBuilder::identity);
      Intersector intersector("");
      intersector.set_scene(scene.snapshot);
      const std::vector<Ray> rays{ray_to({0.1f, 0.3f, 5.0f}, {0.1f, 0.3f, 0.0f}),
                                  ray_to({0.1f, 0.3f, -5.0f}, {0.1f, 0.3f, 0.0f})};
      const auto hits = layers_of(intersector, rays, 2);
      ASSERT_EQ(hits[0].size(), 1u) << "mirrored: " << mirrored;
      EXPECT_TRUE(hits[0][0].front);
      ASSERT_EQ(hits[1].size(), cull ? 0u : 1u) << "mirrored: " << mirrored;
      if (!cull) {
        EXPECT_FALSE(hits[1][0].front);
      }
    }
}

TEST(InstanceMasks, DecideWhichRaysMeetAnInstance) {
  SceneBuilder scene;
  scene.add_material(true);
  scene.add_material(true).traceable = false;  // multiply
  scene.add_material(false);
  const auto add = [&scene](uint32_t material, uint32_t visibility, uint32_t surface_id) {
    const auto z = static_cast<float>(scene.snapshot->instances.size());
    model::Instance& instance = scene.add_instance(scene.add_mesh(square(1.0f, -z)), material);
    instance.visibility = visibility, instance.surface_id = surface_id;
  };
  const uint32_t all = SIDERAY_VISIBLE_ALL;
  add(0, all & ~SIDERAY_VISIBLE_LAYERS, 1);
  add(0, all, 0);
  add(1, all, 3);
  add(0, SIDERAY_VISIBLE_LAYERS, 4);
  add(2, all & ~(SIDERAY_VISIBLE_REFLECTION | SIDERAY_VISIBLE_SHADOW), 5);
  add(2, SIDERAY_VISIBLE_SHADOW, 6);
  add(2, SIDERAY_VISIBLE_REFLECTION, 7);
  Intersector intersector("");
  intersector.set_scene(scene.snapshot);
  const std::vector<Ray> rays{ray_to({0.1f, 0.3f, 5.0f}, {0.1f, 0.3f, 0.0f})};
  EXPECT_THAT(instances_of(layers_of(intersector, rays, 8)[0]), testing::ElementsAre(3u));
  EXPECT_THAT(instances_of(layers_of(intersector, rays, 8, false, LayerSet::all_translucent)[0]),
              testing::ElementsAre(0u, 1u, 2u, 3u));
  Hit hit;
  intersector.nearest_opaque(rays, {}, &hit);
  EXPECT_EQ(hit.instance, 6u);
  // The shadow caster is at 10, in lengths of this ray at 10 / 5.
  for (const auto& [end, expected] : {std::tuple(1.9f, 0), std::tuple(2.1f, 1)}) {
    const std::vector<Ray> shadow{{rays[0].origin, 0.0f, rays[0].direction, end}};
    uint8_t occluded = 2;
    intersector.occluded(shadow, false, &occluded);
    EXPECT_EQ(occluded, expected) << end;
  }
}

TEST(VertexAlpha, IsRegardedWhereTheMaterialAloneDiscardsNothing) {
  SceneBuilder scene;
  scene.add_material(true);
  const uint32_t mesh = scene.add_mesh(square(1.0f, 0.0f));
  model::Mesh copy = *scene.snapshot->meshes[mesh];
  // Alpha is 1 at the left side and falls below 1/255 at the right third.
  for (size_t i = 0; i < copy.positions.size(); ++i) copy.colors[i].w = copy.positions[i].x < 0.0f ? 1.0f : -0.5f;
  copy.has_colors = true;
  scene.snapshot->meshes[mesh] = std::make_shared<model::Mesh>(copy);
  scene.add_instance(mesh, 0);
  Intersector intersector("");
  intersector.set_scene(scene.snapshot);
  const std::vector<Ray> rays{ray_to({0.2f, 0.0f, 5.0f}, {0.2f, 0.1f, 0.0f}),
                              ray_to({0.4f, 0.0f, 5.0f}, {0.4f, 0.1f, 0.0f})};
  const auto hits = layers_of(intersector, rays, 1);
  EXPECT_EQ(hits[0].size(), 1u);
  EXPECT_EQ(hits[1].size(), 0u);
}

}  // namespace
}  // namespace sideray::rt::test
