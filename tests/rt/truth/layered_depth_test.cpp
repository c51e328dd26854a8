// Compares straight layers of pixels with all triangles in double precision, and refracted ones with the ends of the
// same paths.
#include "rt/truth/layered_depth.h"

#include <gtest/gtest.h>

#include "rt/truth/brute_scene.h"
#include "rt/truth/ground_truth.h"

namespace sideray::rt::layered_depth_test {
namespace {

using namespace test;

// Pixels that come nearer to an edge, or to two surfaces at one distance, are left to rounding.
constexpr double certain = 1e-5;
constexpr double float_precision = 4e-6;

struct Layers {
  uint32_t width, most;
  std::vector<uint32_t> counts, surfaces, primitives;
  std::vector<float> z, distance, normals, geometric;
  std::vector<uint8_t> kinds, faces;

  Layers(uint32_t w, uint32_t h, uint32_t layers)
      : width(w), most(layers), counts(size_t{w} * h, 99), surfaces(counts.size() * layers, 99),
        primitives(surfaces.size(), 99), z(surfaces.size(), NAN), distance(z), normals(3 * z.size(), NAN),
        geometric(normals), kinds(z.size(), 99), faces(kinds) {}
  glm::dvec3 normal(const std::vector<float>& of, size_t i) const { return {of[3 * i], of[3 * i + 1], of[3 * i + 2]}; }
};

TraceView view_of(const BruteCamera& camera, const model::Snapshot& snapshot) {
  TraceView view = camera.view();
  // The tracer's space begins at the snapshot's origin.
  view.clip_from_local = glm::translate(view.clip_from_local, snapshot.origin);
  view.local_from_clip = glm::translate(glm::dmat4(1.0), -snapshot.origin) * view.local_from_clip;
  return view;
}

Layers trace(const std::shared_ptr<const model::Snapshot>& snapshot, const BruteCamera& camera, uint32_t layers,
             sideray_layer_path path, uint32_t threads = 1) {
  Tracer tracer({.threads = threads, .isa = ""});
  tracer.set_scene(snapshot);
  Layers found(camera.width, camera.height, layers);
  LayeredDepthRequest request{view_of(camera, *snapshot), {0, 0, -1, -snapshot->origin.z}, {}};
  sideray_layered_depth_desc& wanted = request.wanted;
  wanted.width = camera.width, wanted.height = camera.height, wanted.layers = layers, wanted.path = path;
  wanted.counts = found.counts.data(), wanted.z = found.z.data(), wanted.distance = found.distance.data();
  wanted.normals = found.normals.data(), wanted.geometric_normals = found.geometric.data();
  wanted.surface_ids = found.surfaces.data(), wanted.primitives = found.primitives.data();
  wanted.kinds = found.kinds.data(), wanted.faces = found.faces.data();
  tracer.trace_layered_depth(request);
  return found;
}

void expect_nothing(const Layers& found, size_t i) {
  EXPECT_EQ(found.z[i], INFINITY);
  EXPECT_EQ(found.distance[i], INFINITY);
  EXPECT_EQ(found.surfaces[i] + found.primitives[i] + found.kinds[i] + found.faces[i], 0u);
  EXPECT_EQ(found.normal(found.normals, i), glm::dvec3(0.0));
  EXPECT_EQ(found.normal(found.geometric, i), glm::dvec3(0.0));
}

void expect_layer(const Layers& found, size_t i, const SurfaceMet& expected, const DoubleRay& ray) {
  EXPECT_EQ(found.surfaces[i], expected.surface);
  EXPECT_EQ(found.primitives[i] + 1, expected.primitive);
  EXPECT_EQ(found.faces[i], expected.face);
  EXPECT_EQ(found.kinds[i], expected.kind);
  const double z = -(ray.origin + expected.distance * ray.direction).z;
  EXPECT_NEAR(static_cast<double>(found.z[i]), z, float_precision * z);
  EXPECT_NEAR(static_cast<double>(found.distance[i]), expected.distance, float_precision * z);
  EXPECT_NEAR(glm::dot(found.normal(found.geometric, i), expected.normal), 1.0, 1e-6);
  EXPECT_NEAR(glm::dot(found.normal(found.normals, i), expected.normal), 1.0, 1e-5);  // flat meshes
}

TEST(LayeredDepth, straight_layers_are_what_all_triangles_say) {
  for (const bool orthographic : {false, true})
    for (const uint32_t most : {2u, 12u}) {
      BruteScene brute;
      brute.add_random(7, 90);
      for (int i = 0; i < 6; ++i) {  // seen from behind, and not double sided
        sideray_material_desc m = i % 2 == 0 ? plain_material() : blended({1, 1, 1}, 0.5f);
        m.double_sided = 0;
        const float z = -3.4f - 0.5f * static_cast<float>(i);
        brute.add({{-1, -1, z}, {1, -1, z + 0.1f}, {1, 1, z}, {-1, 1, z - 0.1f}}, {0, 2, 1, 0, 3, 2}, m);
      }
      const BruteCamera camera{.width = 61, .height = 43, .orthographic = orthographic, .extent = orthographic ? 2.2 : 0.5};
      const Layers found = trace(brute.scene.commit(), camera, most, SIDERAY_LAYERS_STRAIGHT);
      uint32_t compared = 0, hidden_backs = 0, cut = 0;
      for (uint32_t y = 0; y < camera.height; ++y)
        for (uint32_t x = 0; x < camera.width; ++x) {
          const DoubleRay ray = camera.ray(x + 0.5, y + 0.5);
          const SurfacesMet hits = brute.hits(ray, camera.ray_near(ray), camera.ray_far(ray), true);
          if (hits.margin < certain) continue;
          const size_t pixel = size_t{camera.height - 1 - y} * camera.width + x;
          const auto expected = std::min<size_t>(hits.all.size(), most);
          ASSERT_EQ(found.counts[pixel], expected);
          for (uint32_t k = 0; k < most; ++k)
            if (k < expected) {
              expect_layer(found, pixel * most + k, hits.all[k], ray);
              hidden_backs += hits.all[k].face == SIDERAY_FACE_HIDDEN_BACK;
            } else {
              expect_nothing(found, pixel * most + k);
            }
          ++compared, cut += hits.all.size() > most;
        }
      EXPECT_GT(compared, 2500u);  // of 2623
      EXPECT_GT(hidden_backs, 300u);
      EXPECT_EQ(cut > 500, most == 2);
    }
}

TEST(LayeredDepth, more_surfaces_than_a_round_finds_and_coplanar_ones) {
  BruteScene brute;
  sideray_material_desc opaque = plain_material(), pane = blended({1, 1, 1}, 0.5f);
  for (int i = 0; i < 20; ++i)
    for (const sideray_material_desc& m : {opaque, pane, opaque})
      brute.add({{-1, -1, -3.0f - static_cast<float>(i)}, {9, -1, -3.0f - static_cast<float>(i)}, {-1, 9, -3.0f - static_cast<float>(i)}},
                {0, 1, 2}, m);
  const BruteCamera camera{.width = 3, .height = 3, .extent = 0.001};
  const Layers found = trace(brute.scene.commit(), camera, 64, SIDERAY_LAYERS_STRAIGHT);
  for (size_t pixel = 0; pixel < 9; ++pixel) {
    ASSERT_EQ(found.counts[pixel], 60u);
    for (uint32_t k = 0; k < 60; ++k) {
      EXPECT_EQ(found.surfaces[pixel * 64 + k], k + 1);
      EXPECT_NEAR(found.z[pixel * 64 + k], 3 + k / 3, 1e-4);
      EXPECT_EQ(found.kinds[pixel * 64 + k], k % 3 == 1 ? SIDERAY_KIND_BLEND : SIDERAY_KIND_OPAQUE);
    }
  }
}

// Volumes and thin panes before a wall: the last layer is where GroundTruth says that the path ends, and the first what it sees.
TEST(LayeredDepth, bent_layers_lead_to_the_ends_of_the_paths) {
  BruteScene brute;
  sideray_material_desc volume = glass();
  volume.thickness = 0.2f, volume.ior = 1.5f, volume.double_sided = 0;
  const std::vector<glm::vec3> box = {{-1, -1, -1}, {1, -1, -1}, {1, 1, -1}, {-1, 1, -1}, {-1, -1, 1}, {1, -1, 1}, {1, 1, 1}, {-1, 1, 1}};
  const std::vector<uint32_t> sides = {0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4, 2, 3, 7, 2, 7, 6, 1, 2, 6, 1, 6, 5, 0, 4, 7, 0, 7, 3};
  glm::dmat4 place = glm::translate(glm::dmat4(1.0), {0.1, 0.2, -5});
  place = glm::rotate(place, 0.7, glm::normalize(glm::dvec3(1, 2, 0.3)));
  brute.add(box, sides, volume, place);
  brute.add({{-2, -2, -3}, {1, -2, -3.2f}, {1, 2, -3.4f}}, {0, 1, 2}, glass());
  brute.add({{-9, -9, -9}, {9, -9, -9}, {9, 9, -9}, {-9, 9, -9}}, {0, 1, 2, 0, 2, 3}, plain_material());
  const auto snapshot = brute.scene.commit();
  const BruteCamera camera{.width = 50, .height = 40};
  Tracer tracer({.threads = 1, .isa = ""});
  tracer.set_scene(snapshot);
  GroundTruthRequest request{view_of(camera, *snapshot), {0, 0, -1, -snapshot->origin.z}, 50, 40, true};
  const GroundTruthImage truth = tracer.trace_ground_truth(request);
  const Layers found = trace(snapshot, camera, 64, SIDERAY_LAYERS_BENT);
  const Layers parallel = trace(snapshot, camera, 64, SIDERAY_LAYERS_BENT, 3);
  EXPECT_EQ(found.z, parallel.z);
  EXPECT_EQ(found.normals, parallel.normals);
  uint32_t bent = 0;
  for (uint32_t y = 0; y < 40; ++y)
    for (uint32_t x = 0; x < 50; ++x) {
      const size_t pixel = size_t{39 - y} * 50 + x, texel = size_t{y} * 50 + x;
      const PathTruth& path = truth.behind[texel];
      const uint32_t count = found.counts[pixel];
      ASSERT_GT(count, 0u);
      const size_t last = pixel * 64 + count - 1;
      EXPECT_EQ(found.surfaces[pixel * 64], truth.first[texel].surface);
      EXPECT_EQ(found.z[pixel * 64], truth.first[texel].z);
      if (path.state == PathState::surroundings || path.state == PathState::unfinished) continue;
      EXPECT_EQ(found.surfaces[last], path.end.surface);
      EXPECT_EQ(found.kinds[last], SIDERAY_KIND_OPAQUE);
      EXPECT_EQ(found.z[last], path.end.z);
      EXPECT_EQ(found.distance[last], path.length);
      uint32_t turns = 0;
      for (uint32_t k = 0; k + 1 < count; ++k) {
        turns += found.kinds[pixel * 64 + k] == SIDERAY_KIND_VOLUME;
        EXPECT_LE(found.distance[pixel * 64 + k], found.distance[pixel * 64 + k + 1]);
      }
      EXPECT_EQ(turns, path.turns);
      bent += turns > 0;
    }
  EXPECT_GT(bent, 100u);
  // What is not wanted is left out, from the end.
  const Layers two = trace(snapshot, camera, 2, SIDERAY_LAYERS_BENT);
  for (size_t pixel = 0; pixel < found.counts.size(); ++pixel) {
    ASSERT_EQ(two.counts[pixel], std::min(found.counts[pixel], 2u));
    for (uint32_t k = 0; k < two.counts[pixel]; ++k) EXPECT_EQ(two.z[2 * pixel + k], found.z[64 * pixel + k]);
  }
}

}  // namespace
}  // namespace sideray::rt::layered_depth_test
