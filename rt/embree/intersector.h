// Intersects batches of rays with a snapshot by Embree. Only its .cpp and the headers that only it includes name RTC
// types. One thread calls set_scene; once that has returned, several threads may trace at the same time. Rays are in
// the snapshot's local space.
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

// Says which translucent instances a multihit traversal hits. with_sprites: all of them, and the quads of sprites;
// tints_light: those of model::tints_light().
enum class LayerSet { visible_in_layers, all_translucent, with_sprites, tints_light };

// Says which opaque instances a ray hits. walls: of visible_in_reflection, those without holes.
enum class OpaqueSet { visible_in_reflection, casts_shadow, occludes_sky, walls, all };

class Intersector {
 public:
  // `isa` "" = the best. Throws Failure.
  explicit Intersector(const std::string& isa);
  ~Intersector();
  Intersector(const Intersector&) = delete;
  Intersector& operator=(const Intersector&) = delete;

  // Builds on the threads of the TBB arena that it is called in; reuses the acceleration structures that both snapshots
  // share. If it throws, the scene is empty.
  void set_scene(std::shared_ptr<const model::Snapshot> snapshot, const SceneUpdate& update = {});

  // Finds the first `layers` translucent surfaces of each ray in the total order (distance, surface id, primitive):
  // hits[i * layers + k], counts[i] of them. Obeys the rasterizer's cull rule (materials that are not double sided show
  // only their front) and alpha discard (< 1/255, textured at the level that the rays' common `cone` requires). Never
  // returns one surface twice where a ray hits the edge shared by two of its triangles; returns all coplanar surfaces.
  // coherent: rays of neighbouring pixels, in 4x4 order. layers <= 64. cull = false: backs too, whatever the material.
  void nearest_layers(LayerSet set, std::span<const Ray> rays, uint32_t layers, bool coherent, Hit* hits,
                      uint32_t* counts, Cone cone = {}, bool cull = true) const;
  // Finds the nearest translucent surface of each ray and those that are at its place, as nearest_layers() finds the
  // first four: hits[i * most_at_place + k], counts[i] of them. Up to known[i] along the ray there are no others; right
  // behind them rounding does not decide. Infinite: there are none at all.
  static constexpr uint32_t most_at_place = 4;
  void nearest_places(LayerSet set, std::span<const Ray> rays, bool coherent, Hit* hits, uint32_t* counts,
                      double* known, Cone cone = {}, bool cull = true) const;
  // Finds all translucent surfaces of each ray, backs too, in the same total order and as nearest_layers() counts them at the
  // finest level of textures. Of a ray with more than 64, the nearest 64.
  void all_layers(LayerSet set, std::span<const Ray> rays, RaySurfaces& surfaces) const;
  // Finds the nearest OPAQUE or MASK surface of the set (both sides, cut-outs regarded, at the cone's level) in the
  // same total order; the instance is no_instance where there is none. cull = true: by the rasterizer's cull rule, as rays
  // of the eye see (docs/adr/0043-back-faces.md).
  void nearest_opaque(std::span<const Ray> rays, bool coherent, Hit* hits,
                      OpaqueSet set = OpaqueSet::visible_in_reflection, Cone cone = {}, bool cull = false) const;
  // Finds the first `layers` OPAQUE or MASK surfaces of each ray, whatever their visibility, as nearest_layers() does:
  // all that are coplanar, and backs as `cull` says. layers <= 64.
  void nearest_opaque_layers(std::span<const Ray> rays, uint32_t layers, bool coherent, Hit* hits, uint32_t* counts,
                             Cone cone = {}, bool cull = true) const;
  // Finds out whether an OPAQUE or MASK surface of the set lies between t_near and t_far: occluded[i] = 0 or 1.
  void occluded(std::span<const Ray> rays, bool coherent, uint8_t* occluded,
                OpaqueSet set = OpaqueSet::casts_shadow) const;
  void occluded(const RayColumns& rays, bool coherent, uint8_t* occluded,
                OpaqueSet set = OpaqueSet::casts_shadow) const;

  bool has_translucent(LayerSet set) const;
  // Grows with each set_scene() after which rays toward opaque surfaces may hit others than before: where something
  // opaque has come, gone, moved or got other holes. Lights, colours and translucent surfaces leave it.
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
