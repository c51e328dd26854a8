// Finds indirect light at a batch of points: light of other surfaces, and the visible share of the sky. Few points send
// a path (rt/light/diffuse_paths.h); each point averages the results of paths nearby. Results are shared within a
// distance proportional to the harmonic mean of the distances to the light's origins (Ward et al. 1988, "A Ray Tracing
// Solution for Diffuse Interreflection"). It has scratch memory: one object per thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "rt/light/diffuse_paths.h"
#include "rt/light/veils.h"
#include "rt/surfaces/environment_lanes.h"
#include "rt/surfaces/surface_batch.h"

namespace sideray::rt {

class LightAround {
 public:
  // The caller keeps both objects alive.
  void begin(const ShadingScene& scene, const Intersector& intersector, bool shadows);
  // Finds the light at the batch's points; `matt`: only at those with a diffuse part. The same batch gets the same
  // bits.
  std::span<const ArrivingLight> find(const SurfaceBatch& batch, bool matt);

  // Traversals since begin().
  uint64_t rays() const { return paths_.rays + rays_to_veils_; }
  uint64_t rays_shadow() const { return paths_.rays_shadow; }

 private:
  // Is a cell of space and of surface normals.
  struct Cell {
    glm::i64vec3 place;
    glm::i8vec3 facing;
    bool operator==(const Cell&) const = default;
  };
  struct Point {
    PointAround around;
    uint32_t number;  // in the batch
    Cell cell;
    uint32_t record;  // of the path that its cell sends
  };
  // Holds the result of a path.
  struct Record {
    glm::vec3 position, normal;
    float width;     // of a pixel there
    float nearness;  // 1 / distance of what the path hit
    float reach;     // radius within which the result is shared
    glm::vec3 thrown, sky, seen_sky;  // radiance of surfaces; the sky's light in the path's direction, and its visible
                                      // part
  };
  void gather(const SurfaceBatch& batch, bool matt);
  size_t sort_into_cells(int coarser);
  void choose_senders();
  void send_paths();
  void see_sky();
  void find_reaches();
  ArrivingLight mean_about(const Record& record) const;

  const ShadingScene* scene_ = nullptr;
  const Intersector* intersector_ = nullptr;
  const model::Environment* environment_ = nullptr;  // null: black
  EnvironmentLanes lanes_;
  bool veiled_ = false;  // something translucent is in front of the sky
  DiffusePaths paths_;
  Veils veils_;
  std::vector<Point> points_;  // sorted by cell
  std::vector<Record> records_;
  std::vector<Ray> rays_, clear_;      // clear_: those without an opaque hit
  std::vector<uint32_t> of_clear_;
  uint64_t rays_to_veils_ = 0;
  std::vector<Cone> cones_;
  std::vector<uint32_t> keys_;
  std::vector<glm::vec3> radiance_;
  std::vector<float> nearness_;
  std::vector<glm::vec3> directions_, sky_;  // directions of rays_, and the sky's light there
  std::vector<ArrivingLight> means_;     // around each of records_
  std::vector<ArrivingLight> arriving_;  // at each point of the batch
};

}  // namespace sideray::rt
