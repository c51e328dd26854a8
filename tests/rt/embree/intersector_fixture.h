// Snapshots put together by hand, and a tracer to compare with: every triangle, long double, no acceleration structure.
#pragma once

#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <random>
#include <vector>

#include "model/snapshot.h"
#include "rt/embree/intersector.h"

namespace sideray::rt::test {

struct SceneBuilder {
  std::shared_ptr<model::Snapshot> snapshot = std::make_shared<model::Snapshot>();

  uint32_t add_mesh(std::vector<glm::vec3> positions, std::vector<glm::uvec3> triangles);
  // Every three positions are a triangle.
  uint32_t add_mesh(std::vector<glm::vec3> positions);
  uint32_t add_texture(uint32_t width, uint32_t height, const std::vector<uint8_t>& alpha);
  model::Material& add_material(bool translucent);  // the last one of snapshot->materials; white, double-sided
  uint32_t last_material() const { return static_cast<uint32_t>(snapshot->materials.size() - 1); }
  model::Instance& add_instance(uint32_t mesh, uint32_t material, const glm::mat4x3& local_from_object = identity);

  static const glm::mat4x3 identity;
};

// A square of two triangles in the plane z, [-size, size]^2, facing +z.
std::vector<glm::vec3> square(float size, float z);

// Triangles around the origin, about `size` large within a cube of half width 1, divided by `scale`.
std::vector<glm::vec3> triangle_soup(std::mt19937& random, size_t triangles, float size, float scale);

// Rotation, scale of about `scale` a bit different for each axis, translation within `reach`; mirrored where asked.
glm::mat4x3 random_transform(std::mt19937& random, float scale, float reach, bool mirrored);

// Instances of soups, scaled 1e-3 to 1e3, every other one mirrored, all of about the same size in local space.
SceneBuilder soup_scene(std::mt19937& random, size_t instances, size_t triangles, bool translucent);

std::vector<Ray> random_rays(std::mt19937& random, size_t count);

struct BruteHit {
  double distance;
  uint32_t instance, primitive;
  bool front;
};

struct BruteResult {
  std::vector<BruteHit> hits;  // in the total order, all of them
  bool ambiguous;              // within rounding of an edge, of the ray's ends, of a texel, or of another hit
};

// `translucent`: with cull rule and discards, else the opaque surfaces with discards only.
BruteResult brute_force(const model::Snapshot& snapshot, const Ray& ray, bool translucent);

bool same_bits(const Hit& a, const Hit& b);

// As nearest_layers, with the hits of each ray in a vector of its own.
std::vector<std::vector<Hit>> layers_of(const Intersector& intersector, const std::vector<Ray>& rays, uint32_t layers,
                                        bool coherent = false, LayerSet set = LayerSet::visible_in_layers);

}  // namespace sideray::rt::test
