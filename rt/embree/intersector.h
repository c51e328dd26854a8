// Intersects batches of rays with a snapshot, by Embree. RTC types appear only in its .cpp and in headers that only the
// .cpp includes. One thread calls set_scene; after it has returned, several threads may trace at the same time. Rays
// are in the snapshot's local space.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <span>
#include <string>

#include "model/snapshot.h"
#include "rt/base/ray.h"
#include "rt/embree/ray_batch.h"
#include "rt/embree/scene_update.h"

namespace sideray::rt {

// Says which translucent instances a multihit traversal hits. with_sprites: all of them and the quads of sprites;
// tints_light: those with model::tints_light().
enum class LayerSet { visible_in_layers, all_translucent, with_sprites, tints_light };

// Says which opaque instances a ray hits. walls: the ones visible in reflections that have no holes.
enum class OpaqueSet { visible_in_reflection, casts_shadow, occludes_sky, walls, all };

// Says which opaque surface of a ray is searched, and how.
struct OpaqueSearch {
  OpaqueSet set = OpaqueSet::visible_in_reflection;
  bool coherent = false;  // the rays belong to neighbouring pixels, in 4x4 order
  AlphaCone cone = {};    // of all rays, chooses the mip level of alpha
  bool cull = false;      // the rasterizer's rule, as for primary rays (docs/adr/0043-back-faces.md)
};

// Says how layers of surfaces are searched.
struct LayerSearch {
  uint32_t layers = 1;    // the most of a ray, up to 64
  bool coherent = false;  // the rays belong to neighbouring pixels, in 4x4 order
  AlphaCone cone = {};    // of all rays, chooses the mip level of alpha
  bool cull = true;       // the rasterizer's rule: materials that are not double sided have no backs
};

class Intersector {
 public:
  // Opens a device for the instruction set `isa`; "" = the best. Throws Failure.
  explicit Intersector(const std::string& isa);
  ~Intersector();
  Intersector(const Intersector&) = delete;
  Intersector& operator=(const Intersector&) = delete;

  // Builds on the threads of the TBB arena that it is called in; reuses the acceleration structures that both snapshots
  // share. If it throws, the scene is empty.
  void set_scene(std::shared_ptr<const model::Snapshot> snapshot, const SceneUpdate& update = {});

  // Finds the first translucent surfaces of each ray in the total order (distance, surface id, primitive):
  // hits[i * search.layers + k], counts[i] of them. Obeys the rasterizer's alpha discard (< 1/255). Returns all coplanar
  // surfaces, but a surface only once if a ray hits the edge between two of its triangles.
  void nearest_layers(LayerSet set, std::span<const Ray> rays, const LayerSearch& search, Hit* hits,
                      uint32_t* counts) const;
  // Finds the nearest translucent surface of each ray and the others at the same distance, as nearest_layers() finds
  // its first four: hits[i * most_at_place + k], counts[i] of them. known[i] is a distance up to which the ray hits no
  // other surface; rounding hides whether one lies just behind it. It is infinite if the ray hits no surface.
  // search.layers has no effect.
  static constexpr uint32_t most_at_place = 4;
  void nearest_places(LayerSet set, std::span<const Ray> rays, const LayerSearch& search, Hit* hits, uint32_t* counts,
                      double* known) const;
  // Finds all translucent surfaces of each ray, back faces included, in the total order. They count as in
  // nearest_layers(), with alpha at the finest mip level. At most the nearest 64 of a ray are returned.
  void all_layers(LayerSet set, std::span<const Ray> rays, RaySurfaces& surfaces) const;
  // Finds the nearest OPAQUE or MASK surface of the set in the total order: both sides, cut-outs tested at the cone's
  // level. The instance is no_instance if there is none.
  void nearest_opaque(std::span<const Ray> rays, const OpaqueSearch& search, Hit* hits) const;
  // Finds the first OPAQUE or MASK surfaces of each ray, whatever their visibility flags, as nearest_layers() does.
  void nearest_opaque_layers(std::span<const Ray> rays, const LayerSearch& search, Hit* hits, uint32_t* counts) const;
  // Tests whether an OPAQUE or MASK surface of the set lies between t_near and t_far: occluded[i] = 0 or 1.
  void occluded(std::span<const Ray> rays, bool coherent, uint8_t* occluded,
                OpaqueSet set = OpaqueSet::casts_shadow) const;
  void occluded(const RayColumns& rays, bool coherent, uint8_t* occluded,
                OpaqueSet set = OpaqueSet::casts_shadow) const;

  bool has_translucent(LayerSet set) const;
  // Grows with each set_scene() that may change the opaque hits of a ray, because an opaque instance was added, removed
  // or moved or its holes changed. Lights, colours and translucent surfaces do not change it.
  uint64_t opaque_revision() const;
  uint32_t packet_width() const;  // 16, 8, 4 or 1: the native one
  std::string isa() const;
  std::string version() const;  // Embree's

  // Traces raw packets through the same scene, without filter or recomputation; the benchmark compares against it.
  void raw_intersect(LayerSet set, std::span<const Ray> rays, bool coherent, float* t_far) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace sideray::rt
