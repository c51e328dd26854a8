// Samples points of emissive surfaces in proportion to the light that a point may receive from them: a tree of boxes
// bounds power, distance and orientation (Conty Estevez and Kulla 2018, "Importance Sampling of Many Lights with
// Adaptive Tree Splitting"). Immutable once made; any thread may use it.
#pragma once

#include <atomic>
#include <glm/glm.hpp>
#include <memory>
#include <mutex>
#include <span>
#include <utility>
#include <vector>

#include "model/snapshot.h"
#include "rt/base/ray.h"

namespace sideray::rt {

// Describes the point that is lit.
struct LitPoint {
  glm::vec3 position{0.0f};
  glm::vec3 normal{0.0f};   // unit
  bool from_behind = false;  // light from the back counts too
};

class EmitterSampler {
 public:
  EmitterSampler() = default;
  // Keeps the emitters' meshes alive, not the snapshot, because it may serve later ones. Surfaces with holes, and those
  // invisible in reflections, are left out: only random rays find them.
  explicit EmitterSampler(const model::Snapshot& snapshot);

  struct Sample {
    Hit hit;         // as a ray from the point would return it
    Ray ray;         // unit, from the point to the emitter
    float density;   // per steradian; 0 = nothing is sampled
  };
  // Samples an emitter for a point, without regard to occlusion. `u` is a point of the unit square. Must not be called
  // if nothing emits.
  Sample sample(const LitPoint& point, float choice, glm::vec2 u) const;
  // Returns the density of sampling `hit`, which a ray from the point in this unit direction found; 0 if it is never
  // sampled.
  float density(const LitPoint& point, const Hit& hit, glm::vec3 direction) const;

  // Returns whether the hit side of the surface is sampled.
  bool samples(const Hit& hit) const;

  bool empty() const { return triangles_.empty(); }
  // Returns whether the same surfaces emit in the snapshot, so that the sampler is right for it, too.
  bool is_alike(const model::Snapshot& snapshot) const { return shining_ == shining_in(snapshot); }

 private:
  struct Triangle {
    glm::vec3 corner, edge1, edge2, normal;  // of the front face, unit; local space
    float area, power;
    uint32_t instance, primitive;
    uint32_t node;   // its leaf
    bool two_sided;  // false: its back is not sampled
  };
  struct Node {
    glm::vec3 center, half;  // of its box
    glm::vec3 axis;          // its triangles' normals are within a cone about it
    float cosine;            // of the cone's half angle
    float power;
    bool two_sided;
    uint32_t parent;
    uint32_t first, count;   // a leaf's triangles; count 0: `first` is the first child, followed by the other
  };
  struct Building;
  struct Box;
  struct Bin;
  // Describes an emissive instance.
  struct Shining {
    uint32_t instance;
    std::shared_ptr<const model::Mesh> mesh;
    glm::mat4x3 local_from_object;
    float brightness;
    bool two_sided, mirrored;
    bool operator==(const Shining&) const = default;
  };
  static std::vector<Shining> shining_in(const model::Snapshot& snapshot);

  void add(const Shining& shining);
  void build(Building& building, uint32_t node, uint32_t first, uint32_t count);
  static void bound(Node& node, std::span<const Triangle> triangles, std::span<const uint32_t> order);
  void make_leaf(uint32_t node, std::span<const Triangle> triangles, std::span<const uint32_t> order);
  static uint32_t split_of(std::span<const Triangle> triangles, std::span<uint32_t> order);
  static uint32_t best_border(std::span<const Bin> binned);
  float importance(const Node& node, const LitPoint& point) const;
  float importance(const Triangle& triangle, const LitPoint& point) const;
  float chance(uint32_t triangle, const LitPoint& point) const;
  float density(uint32_t triangle, float chance, glm::vec3 direction, float distance) const;

  std::vector<Shining> shining_;
  std::vector<Triangle> triangles_;  // contiguous for each leaf
  std::vector<Node> nodes_;          // the first is the root
  std::vector<uint32_t> first_;      // by instance: its first entry in of_primitive_, or none
  std::vector<uint32_t> of_primitive_;  // index in triangles_, or none
};

// Makes a snapshot's sampler when it is first used, because few ways of drawing sample emitters, and those of a moving
// scene change in each frame. Any thread may use it.
class EmittersWhenUsed {
 public:
  explicit EmittersWhenUsed(std::shared_ptr<const model::Snapshot> snapshot) : snapshot_(std::move(snapshot)) {}

  const EmitterSampler& get() const {
    std::call_once(once_, [this] {
      sampler_ = EmitterSampler(*std::exchange(snapshot_, nullptr));
      made_ = true;
    });
    return sampler_;
  }
  // Returns whether the sampler was made and is right for the snapshot, too.
  bool serves(const model::Snapshot& snapshot) const { return made_ && sampler_.is_alike(snapshot); }

 private:
  mutable std::once_flag once_;
  mutable std::atomic<bool> made_{false};
  mutable std::shared_ptr<const model::Snapshot> snapshot_;  // null once the sampler is made
  mutable EmitterSampler sampler_;
};

}  // namespace sideray::rt
