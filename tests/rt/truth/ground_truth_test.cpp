// Compares ground truth with and behind glass with all triangles in double precision, and with Snell's law on planes.
#include "rt/truth/ground_truth.h"

#include <gtest/gtest.h>

#include <map>

#include "rt/truth/brute_scene.h"

namespace sideray::rt {
namespace {

using namespace test;

// Pixels that come nearer to an edge, or to two surfaces at one distance, are left to rounding.
constexpr double certain = 1e-5;
constexpr double float_precision = 4e-6;

GroundTruthImage truth_of(const std::shared_ptr<const model::Snapshot>& snapshot, const BruteCamera& camera,
                       bool behind = true, uint32_t threads = 1) {
  Tracer tracer({.threads = threads, .isa = ""});
  tracer.set_scene(snapshot);
  GroundTruthRequest request;
  request.view = camera.view();
  request.depth_plane = {0, 0, -1, 0};
  request.depth_plane.w = -snapshot->origin.z;
  // The tracer's space begins at the snapshot's origin.
  request.view.clip_from_local = glm::translate(request.view.clip_from_local, snapshot->origin);
  request.view.local_from_clip = glm::translate(glm::dmat4(1.0), -snapshot->origin) * request.view.local_from_clip;
  request.width = camera.width, request.height = camera.height;
  request.behind = behind;
  return tracer.trace_ground_truth(request);
}

void expect_surface(const SeenSurface& seen, const SurfaceMet* expected, const DoubleRay& ray) {
  if (!expected) {
    EXPECT_EQ(seen.primitive, 0u);
    EXPECT_EQ(seen.surface, 0u);
    EXPECT_EQ(seen.z, INFINITY);
    return;
  }
  EXPECT_EQ(seen.surface, expected->surface);
  EXPECT_EQ(seen.primitive, expected->primitive);
  const double z = -(ray.origin + expected->distance * ray.direction).z;
  EXPECT_NEAR(static_cast<double>(seen.z), z, float_precision * z);
  EXPECT_NEAR(glm::dot(glm::dvec3(seen.normal), expected->normal), 1.0, 1e-5);  // flat meshes
}

TEST(GroundTruth, is_what_all_triangles_say) {
  for (const bool orthographic : {false, true})
    for (const uint32_t seed : {1u, 2u, 3u}) {
      BruteScene brute;
      brute.add_random(seed, 40);
      const BruteCamera camera{.width = 61, .height = 43, .orthographic = orthographic, .extent = orthographic ? 2.2 : 0.5};
      const GroundTruthImage image = truth_of(brute.scene.commit(), camera, false);
      int compared = 0, glass = 0;
      for (uint32_t y = 0; y < camera.height; ++y)
        for (uint32_t x = 0; x < camera.width; ++x) {
          const DoubleRay ray = camera.ray(x + 0.5, y + 0.5);
          const SurfacesMet hits = brute.hits(ray, camera.ray_near(ray), camera.ray_far(ray));
          if (hits.margin < certain) continue;
          const size_t texel = size_t{y} * camera.width + x;
          const SurfaceMet *opaque = hits.first(false), *translucent = hits.first(true);
          if (translucent && opaque && opaque->distance < translucent->distance) translucent = nullptr;
          expect_surface(image.glass[texel], translucent, ray);
          expect_surface(image.first[texel], translucent ? translucent : opaque, ray);
          ++compared, glass += translucent != nullptr;
        }
      EXPECT_GT(compared, 2550);  // of 2623
      EXPECT_GT(glass, 250);
    }
}

TEST(GroundTruth, near_and_far_planes_cut) {
  BruteScene brute;
  brute.add_random(5, 60, true);
  const BruteCamera camera{.width = 40, .height = 40, .near = 4.3, .far = 6.1};
  const GroundTruthImage image = truth_of(brute.scene.commit(), camera, false);
  int cut = 0;
  for (uint32_t y = 0; y < 40; ++y)
    for (uint32_t x = 0; x < 40; ++x) {
      const DoubleRay ray = camera.ray(x + 0.5, y + 0.5);
      const SurfacesMet hits = brute.hits(ray, camera.ray_near(ray), camera.ray_far(ray));
      if (hits.margin < certain) continue;
      const SurfaceMet* first = hits.all.empty() ? nullptr : &hits.all.front();
      expect_surface(image.first[size_t{y} * 40 + x], first, ray);
      const SurfacesMet uncut = brute.hits(ray, 0.0, 1e30);
      cut += !uncut.all.empty() && (!first || uncut.all.front().surface != first->surface);
    }
  EXPECT_GT(cut, 200);
}

// Where a bent path ends on the wall, by planes alone.
struct WallEnd {
  glm::dvec3 point;
  double length;
  int surfaces;
};

std::optional<WallEnd> end_on_wall(const ConvexSolid& solid, const DoubleRay& eye_ray, const TiledWall& wall) {
  const auto passage = solid.pass(eye_ray);
  if (!passage || passage->from_edge < 1e-4 || passage->out.direction.z > -1e-3) return std::nullopt;
  const double t = (wall.z - passage->out.origin.z) / passage->out.direction.z;
  const glm::dvec3 p = passage->out.origin + t * passage->out.direction;
  if (std::max(std::abs(p.x), std::abs(p.y)) > wall.half - 1e-4) return std::nullopt;
  return WallEnd{p, t, passage->surfaces};
}

// Compares the pixels whose path ends on the wall, which is surface 1. Returns how many had `least_turns` at least.
int compare_with_planes(const ConvexSolid& solid, const GroundTruthImage& image, const BruteCamera& camera,
                        const TiledWall& wall, int least_turns) {
  int compared = 0;
  for (uint32_t y = 0; y < camera.height; ++y)
    for (uint32_t x = 0; x < camera.width; ++x) {
      const DoubleRay ray = camera.ray(x + 0.5, y + 0.5);
      const auto end = end_on_wall(solid, ray, wall);
      if (!end) continue;
      const PathTruth& path = image.behind[size_t{y} * camera.width + x];
      EXPECT_EQ(path.state, PathState::surface);
      EXPECT_EQ(path.end.surface, 1u);
      EXPECT_EQ(path.turns, static_cast<uint32_t>(end->surfaces));
      EXPECT_NEAR(static_cast<double>(path.end.z), -wall.z, 1e-5);
      EXPECT_NEAR(static_cast<double>(path.end.normal.z), 1.0, 1e-6);
      const glm::dvec2 place = camera.place(end->point);
      EXPECT_NEAR(static_cast<double>(path.place.x), place.x, 2e-3);
      EXPECT_NEAR(static_cast<double>(path.place.y), camera.height - place.y, 2e-3);
      compared += end->surfaces >= least_turns;
    }
  return compared;
}

// A Dove prism's outline and a wedge's, seen along y: ../refraction has their light.
struct Prism {
  std::vector<glm::vec2> outline;
  int least_turns, least_compared;
};

ConvexSolid add_prism(const Prism& prism, TestScene& scene) {
  Triangles t = Triangles::column(prism.outline, -2, 2);
  for (glm::vec3& p : t.positions) p = {p.x, -p.z, p.y - 4};
  t.add_to(scene, solid_glass(1.5f));
  ConvexSolid solid;
  solid.faces = {{{0, 1, 0}, 2}, {{0, -1, 0}, 2}};
  for (size_t i = 0; i < prism.outline.size(); ++i) {
    const glm::dvec2 a(prism.outline[i]), b(prism.outline[(i + 1) % prism.outline.size()]);
    const glm::dvec3 n = glm::normalize(glm::dvec3(b.y - a.y, 0, a.x - b.x));
    solid.faces.push_back({n, glm::dot(n, glm::dvec3(a.x, 0, a.y - 4))});
  }
  return solid;
}

TEST(GroundTruth, paths_follow_snells_law_and_total_reflection) {
  const TiledWall wall{-9, 6};
  const Prism prisms[] = {{{{-1, -1}, {1, 0}, {-1, 1}}, 2, 200},
                          {{{-0.5f, -2.1f}, {0.5f, -1.1f}, {0.5f, 1.1f}, {-0.5f, 2.1f}}, 3, 30},
                          {{{-3, -0.5f}, {3, -0.5f}, {3, 0.5f}, {-3, 0.5f}}, 2, 1000}};
  for (const Prism& prism : prisms)
    for (const bool orthographic : {false, true}) {
      TestScene scene;
      wall.add_to(scene);
      const ConvexSolid solid = add_prism(prism, scene);
      const BruteCamera camera{
          .width = 40, .height = 40, .orthographic = orthographic, .extent = orthographic ? 1.6 : 0.35};
      const int compared = compare_with_planes(solid, truth_of(scene.commit(), camera), camera, wall, prism.least_turns);
      EXPECT_GT(compared, prism.least_compared) << prism.outline.size() << ' ' << orthographic;
    }
}

// The length of a path through a slab straight on is that of its parts.
TEST(GroundTruth, lengths_are_those_of_the_parts) {
  const TiledWall wall{-9, 6};
  TestScene scene;
  wall.add_to(scene);
  Triangles::box({-3, -3, -4}, {3, 3, -3}).add_to(scene, solid_glass(1.5f));
  const BruteCamera camera{.width = 31, .height = 31};
  const GroundTruthImage image = truth_of(scene.commit(), camera);
  for (uint32_t y = 0; y < 31; ++y)
    for (uint32_t x = 0; x < 31; ++x) {
      const DoubleRay ray = camera.ray(x + 0.5, y + 0.5);
      const double cosine = -ray.direction.z, inside = std::sqrt(1 - (1 - cosine * cosine) / 2.25);
      const PathTruth& path = image.behind[size_t{y} * 31 + x];
      ASSERT_EQ(path.turns, 2u);
      EXPECT_NEAR(static_cast<double>(path.length), 8 / cosine + 1 / inside, 1e-4);
    }
}

TEST(GroundTruth, nothing_bends_in_thin_walls_and_blended_surfaces) {
  const TiledWall wall{-9, 6};
  TestScene scene;
  wall.add_to(scene);
  scene.quad({-1, 0, -4}, {1, 0, 0}, {0, 4, 0}, glass());
  scene.quad({1, 0, -5}, {1, 0, 0}, {0, 4, 0}, blended(glm::vec3(0.5f), 0.7f));
  sideray_material_desc rough = glass();
  rough.roughness = 0.5f;
  scene.quad({0, 0, -6}, {4, 0, 0}, {0, 4, 0}, rough);
  const BruteCamera camera{.width = 20, .height = 20, .extent = 0.3};
  const GroundTruthImage image = truth_of(scene.commit(), camera);
  for (uint32_t y = 0; y < 20; ++y)
    for (uint32_t x = 0; x < 20; ++x) {
      const size_t texel = size_t{y} * 20 + x;
      const PathTruth& path = image.behind[texel];
      EXPECT_EQ(image.glass[texel].surface, x < 10 ? 2u : 3u);
      EXPECT_EQ(path.state, PathState::straight);
      EXPECT_EQ(path.turns, 0u);
      EXPECT_EQ(path.end.surface, 1u);
      EXPECT_EQ(path.place, glm::vec2(static_cast<float>(x) + 0.5f, 19.5f - static_cast<float>(y)));
      EXPECT_EQ(path.seen, PlaceState::visible);
    }
}

// A slab at 45 degrees moves what is seen to the side: beside the picture, behind a post, and into the sky.
TEST(GroundTruth, places_are_visible_hidden_or_outside) {
  TestScene scene;
  const uint32_t wall = scene.quad({0, 0, -9}, {3, 0, 0}, {0, 3, 0}, plain_material());
  const uint32_t post = scene.quad({0.5f, 0, -2}, {0.12f, 0, 0}, {0, 3, 0}, plain_material());
  const std::vector<glm::vec3> wedge{{-6, -6, -3}, {6, -6, -3}, {6, 6, -3}, {-6, 6, -3},
                                     {-6, -6, -3.2f}, {6, -6, -5}, {6, 6, -5}, {-6, 6, -3.2f}};
  Triangles glass;
  for (const auto& face : std::vector<std::vector<int>>{{0, 1, 2, 3}, {5, 4, 7, 6}, {4, 0, 3, 7}, {1, 5, 6, 2}, {3, 2, 6, 7}, {4, 5, 1, 0}}) {
    std::vector<glm::vec3> corners;
    for (const int i : face) corners.push_back(wedge[static_cast<size_t>(i)]);
    glass.polygon(corners);
  }
  glass.add_to(scene, solid_glass(1.5f));
  const BruteCamera camera{.width = 64, .height = 48, .extent = 0.35};
  const GroundTruthImage image = truth_of(scene.commit(), camera);
  // Faces of the wedge as planes, for Snell's law.
  const glm::dvec3 back = glm::normalize(glm::cross(glm::dvec3(wedge[7] - wedge[4]), glm::dvec3(wedge[5] - wedge[4])));
  int visible = 0, hidden = 0, outside = 0, sky = 0;
  for (uint32_t y = 0; y < 48; ++y)
    for (uint32_t x = 0; x < 64; ++x) {
      DoubleRay ray = camera.ray(x + 0.5, y + 0.5);
      const double at_post = (ray.direction * (-2 / ray.direction.z)).x;
      if (std::abs(at_post - 0.5) < 0.1201) continue;
      ray.origin = ray.direction * (-3 / ray.direction.z);
      ray.direction = *snell(ray.direction, {0, 0, 1}, 1.0, 1.5);
      const double t = glm::dot(back, glm::dvec3(wedge[4]) - ray.origin) / glm::dot(back, ray.direction);
      ray.origin += t * ray.direction;
      ray.direction = *snell(ray.direction, back.z > 0 ? back : -back, 1.5, 1.0);
      const glm::dvec3 p = ray.origin + ray.direction * ((-9 - ray.origin.z) / ray.direction.z);
      const PathTruth& path = image.behind[size_t{y} * 64 + x];
      const double edge = std::max(std::abs(p.x), std::abs(p.y)) - 3;
      if (std::abs(edge) < 1e-3) continue;
      const bool on_wall = edge < 0;
      EXPECT_EQ(path.state, on_wall ? PathState::surface : PathState::surroundings);
      EXPECT_EQ(path.end.surface, on_wall ? wall : 0u);
      sky += !on_wall;
      const glm::dvec2 place = on_wall ? camera.place(p) : camera.place(ray.direction);
      const double in_picture = std::min({place.x, place.y, 64 - place.x, 48 - place.y});
      const DoubleRay straight = camera.ray(place.x, place.y);
      const double past_post = std::abs((straight.direction * (-2 / straight.direction.z)).x - 0.5) - 0.12;
      const glm::dvec3 shown = straight.direction * (-9 / straight.direction.z);
      const double past_wall = std::max(std::abs(shown.x), std::abs(shown.y)) - 3;
      if (std::min({std::abs(in_picture), std::abs(past_post), std::abs(past_wall)}) < 1e-3) continue;
      EXPECT_NEAR(static_cast<double>(path.place.x), place.x, 2e-3);
      EXPECT_NEAR(static_cast<double>(path.place.y), 48 - place.y, 2e-3);
      const bool is_hidden = past_post < 0 || (!on_wall && past_wall < 0);
      const PlaceState expected =
          in_picture < 0 ? PlaceState::outside : is_hidden ? PlaceState::hidden : PlaceState::visible;
      EXPECT_EQ(path.seen, expected) << x << ' ' << y;
      visible += expected == PlaceState::visible, hidden += expected == PlaceState::hidden;
      outside += expected == PlaceState::outside;
    }
  EXPECT_GT(visible, 500);
  EXPECT_GT(hidden, 50);
  EXPECT_GT(outside, 20);
  EXPECT_GT(sky, 50);
  EXPECT_EQ(post, 2u);
}

// The eye in a box of glass: its first surface is the wall through which the path leaves it.
TEST(GroundTruth, paths_start_in_the_medium_that_the_eye_is_in) {
  const TiledWall wall{-9, 9};
  TestScene scene;
  wall.add_to(scene);
  Triangles::box({-2, -2, -3}, {2, 2, 1}).add_to(scene, solid_glass(1.33f));
  ConvexSolid solid = box_solid({-2, -2, -3}, {2, 2, 1});
  solid.ior = static_cast<double>(1.33f);
  const BruteCamera camera{.width = 30, .height = 30, .extent = 0.4};
  const GroundTruthImage image = truth_of(scene.commit(), camera);
  for (uint32_t y = 0; y < 30; ++y)
    for (uint32_t x = 0; x < 30; ++x) {
      const DoubleRay ray = camera.ray(x + 0.5, y + 0.5);
      const auto passage = solid.leave(ray, solid.faces.size(), {ray, glm::dvec3(1), 0, 1.0});
      const DoubleRay out = passage->out;
      const glm::dvec3 p = out.origin + out.direction * ((-9 - out.origin.z) / out.direction.z);
      const PathTruth& path = image.behind[size_t{y} * 30 + x];
      EXPECT_EQ(image.glass[size_t{y} * 30 + x].surface, 2u);
      EXPECT_NEAR(static_cast<double>(image.glass[size_t{y} * 30 + x].z), 3.0, 1e-5);
      ASSERT_EQ(path.turns, 1u);
      EXPECT_EQ(path.end.surface, 1u);
      EXPECT_NEAR(static_cast<double>(path.place.x), camera.place(p).x, 2e-3);
      EXPECT_NEAR(static_cast<double>(path.place.y), 30 - camera.place(p).y, 2e-3);
    }
}

// Textured alpha: a cut-out grid before a blended one before a wall. Where the alpha is 0 nothing is there.
TEST(GroundTruth, surfaces_are_absent_where_their_alpha_is) {
  constexpr uint32_t texels = 8;
  const auto is_there = [](uint32_t s, uint32_t t, bool cut_out) { return (cut_out ? s : s + t) % 2 == 0; };
  TestScene scene;
  for (const bool cut_out : {true, false}) {
    std::vector<uint8_t> rgba;
    for (uint32_t t = 0; t < texels; ++t)
      for (uint32_t s = 0; s < texels; ++s)
        rgba.insert(rgba.end(), {255, 255, 255, static_cast<uint8_t>(is_there(s, t, cut_out) ? 200 : 0)});
    sideray_material_desc m = plain_material();
    m.alpha_mode = cut_out ? SIDERAY_MASK : SIDERAY_BLEND;
    m.base_color_texture.texture = scene.scene.add_texture(texels, texels, SIDERAY_RGBA8, rgba.data());
    m.base_color_texture.filter = SIDERAY_NEAREST;
    scene.quad({0, 0, cut_out ? -3 : -5}, {2, 0, 0}, {0, 2, 0}, m);
  }
  scene.quad({0, 0, -9}, {9, 0, 0}, {0, 9, 0}, plain_material());
  const BruteCamera camera{.width = 50, .height = 50, .extent = 0.39};
  const GroundTruthImage image = truth_of(scene.commit(), camera);
  std::map<uint32_t, int> first_of;
  for (uint32_t y = 0; y < 50; ++y)
    for (uint32_t x = 0; x < 50; ++x) {
      const DoubleRay ray = camera.ray(x + 0.5, y + 0.5);
      double margin = 1.0;
      const auto meets = [&](double z, bool cut_out) {
        const glm::dvec3 p = ray.direction * (z / ray.direction.z);
        const double s = (p.x + 2) / 4 * texels, t = (2 - p.y) / 4 * texels;
        margin = std::min({margin, std::abs(s - std::round(s)), std::abs(t - std::round(t))});
        return is_there(static_cast<uint32_t>(s), static_cast<uint32_t>(t), cut_out);
      };
      const bool grid = meets(-3, true), pane = meets(-5, false);
      if (margin < 1e-4) continue;
      const size_t texel = size_t{y} * 50 + x;
      const uint32_t opaque = grid ? 1 : 3, glass = !grid && pane ? 2 : 0;
      EXPECT_EQ(image.glass[texel].surface, glass);
      EXPECT_EQ(image.first[texel].surface, glass != 0 ? glass : opaque);
      EXPECT_EQ(image.behind[texel].end.surface, opaque);
      ++first_of[glass != 0 ? glass : opaque];
    }
  EXPECT_GT(first_of[1], 800);
  EXPECT_GT(first_of[2], 400);
  EXPECT_GT(first_of[3], 400);
}

// Smooth normals of an instance that is turned, scaled unevenly and mirrored.
TEST(GroundTruth, normals_are_interpolated_and_transformed) {
  const std::vector<glm::vec3> corners{{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}},
      normals{glm::normalize(glm::vec3(-0.5f, -0.3f, 1)), glm::normalize(glm::vec3(0.6f, 0, 1)), {0, 0, 1}};
  const std::vector<uint32_t> indices{0, 1, 2};
  for (const double mirror : {1.0, -1.0}) {
    TestScene scene;
    sideray_mesh_desc mesh{};
    mesh.size = sizeof(mesh);
    mesh.vertex_count = mesh.index_count = 3;
    mesh.indices = indices.data();
    mesh.positions = {&corners[0].x, 0};
    mesh.normals = {&normals[0].x, 0};
    const glm::dmat4 place = glm::scale(glm::rotate(glm::translate(glm::dmat4(1.0), {0.1, 0, -3}), 0.4, {0.3, 1.0, 0.2}),
                                        {1.5 * mirror, 0.7, 2.0});
    sideray_instance_desc instance{};
    instance.mesh = scene.scene.add_mesh(mesh, nullptr);
    instance.material = scene.scene.add_material(blended(glm::vec3(0.5f), 0.5f));
    for (int c = 0; c < 4; ++c)
      for (int r = 0; r < 3; ++r) instance.world_from_object[3 * c + r] = place[c][r];
    instance.surface_id = 7, instance.visibility = SIDERAY_VISIBLE_ALL;
    scene.scene.add_instances(&instance, 1);
    const BruteCamera camera{.width = 24, .height = 24, .extent = 0.4};
    const GroundTruthImage image = truth_of(scene.commit(), camera);
    int compared = 0;
    for (uint32_t y = 0; y < 24; ++y)
      for (uint32_t x = 0; x < 24; ++x) {
        const SeenSurface& seen = image.glass[size_t{y} * 24 + x];
        if (seen.primitive == 0) continue;
        const DoubleRay ray = camera.ray(x + 0.5, y + 0.5);
        const glm::dmat4 to_object = glm::inverse(place);
        const glm::dvec3 o(to_object * glm::dvec4(ray.origin, 1)), d(to_object * glm::dvec4(ray.direction, 0));
        const glm::dvec3 p = o + d * (-o.z / d.z);
        const double third = (p.y + 1) / 2, second = (p.x + 1 - third) / 2;
        const glm::dvec3 n = glm::dvec3(normals[0]) * (1 - second - third) + glm::dvec3(normals[1]) * second +
                             glm::dvec3(normals[2]) * third;
        glm::dvec3 expected = glm::normalize(glm::transpose(glm::inverse(glm::dmat3(place))) * n);
        if (glm::dot(expected, ray.direction) > 0) expected = -expected;
        EXPECT_NEAR(glm::dot(glm::dvec3(seen.normal), expected), 1.0, 1e-6);
        ++compared;
      }
    EXPECT_GT(compared, 100);
  }
}

TEST(GroundTruth, is_the_same_for_any_number_of_threads) {
  const TiledWall wall{-9, 6};
  TestScene scene;
  wall.add_to(scene);
  Triangles::box({-1, -1, -4}, {1, 1, -3}).add_to(scene, solid_glass(1.5f));
  const auto snapshot = scene.commit();
  const BruteCamera camera{.width = 70, .height = 50};
  const GroundTruthImage one = truth_of(snapshot, camera, true, 1), three = truth_of(snapshot, camera, true, 3);
  for (size_t i = 0; i < one.behind.size(); ++i) {
    ASSERT_EQ(std::memcmp(&one.behind[i], &three.behind[i], sizeof(PathTruth)), 0);
    ASSERT_EQ(one.first[i].z, three.first[i].z);
  }
}

}  // namespace
}  // namespace sideray::rt
