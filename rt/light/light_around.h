// Finds the indirect light that arrives at a batch of points: the light of other surfaces, and the open share of the
// sky. Points that the picture shows take the light of its pixels. Few of the others send a path each
// (rt/light/diffuse_paths.h); all of these take the mean of what the paths of points near them found. A path counts
// within a reach that is proportional to the harmonic mean of the distances to the surfaces that reflect the light (Ward
// et al. 1988, "A Ray Tracing Solution for Diffuse Interreflection"). Points that weigh little in their pixels send
// fewer. Holds scratch memory: one object per thread.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "rt/light/diffuse_paths.h"
#include "rt/light/seen_light.h"
#include "rt/light/veils.h"
#include "rt/surfaces/environment_lanes.h"
#include "rt/surfaces/surface_batch.h"

namespace sideray::rt {

class LightAround {
 public:
  // The caller keeps the objects alive. `position`: LayerRequest::position. `seen`: the light where the picture shows
  // the surface, so that no path is needed; null: unknown.
  void begin(const ShadingScene& scene, const Intersector& intersector, bool shadows, uint32_t position,
             const SeenLight* seen);
  // Finds the light at the batch's points; `matt`: only at those with a diffuse part. The same batch gets the same
  // bits.
  std::span<const ArrivingLight> find(const SurfaceBatch& batch, bool matt);

  // Traversals since begin().
  uint64_t rays() const { return paths_.rays + rays_to_veils_; }
  uint64_t rays_shadow() const { return paths_.rays_shadow; }

 private:
  struct Point {
    PointAround around;
    uint32_t number;            // in the batch
    uint32_t key = 0;           // of random numbers
    glm::vec2 direction{0.0f};  // random numbers of a path's direction
    uint32_t record = 0;        // of the point that sends a path for its cell
  };
  // A cell is a cube of space and part of the directions that surfaces face.
  struct InCell {
    uint64_t cell;
    uint32_t key;    // of the point
    uint32_t point;  // index in points_
    auto operator<=>(const InCell&) const = default;
  };
  // What a path found.
  struct Record {
    glm::vec3 position, normal;
    float width = 0.0f;     // of a pixel there
    float nearness = 0.0f;  // 1 / distance of where its light comes from
    float reach = 0.0f;     // distance within which its light counts as equal
    // Light that the path brought; the sky's light in its direction, and the part of it that arrives.
    glm::vec3 thrown{0.0f}, sky{0.0f}, seen_sky{0.0f};
  };
  void gather(const SurfaceBatch& batch, bool matt);
  void draw_numbers();
  void sort_into_cells(size_t most_cells);
  void choose_senders();
  void choose_senders(std::span<const InCell> points);
  void send_path(const Point& point);
  void follow_paths();
  void see_sky();
  void find_reaches();
  ArrivingLight mean_about(const Record& record) const;

  const ShadingScene* scene_ = nullptr;
  const SeenLight* seen_ = nullptr;
  const Intersector* intersector_ = nullptr;
  const model::Environment* environment_ = nullptr;  // null: black
  EnvironmentLanes lanes_;
  uint32_t position_ = 0;
  bool veiled_ = false;  // something translucent is in front of the sky
  DiffusePaths paths_;
  Veils veils_;
  std::vector<Point> points_;
  std::vector<InCell> own_cells_;  // points_, in the smallest cells about them
  std::vector<InCell> in_cells_;   // points_, sorted by cells of one size
  std::vector<uint64_t> cells_;   // the distinct cells of in_cells_
  std::vector<Record> records_;
  std::vector<Ray> rays_, clear_;      // clear_: those without an opaque hit
  std::vector<uint32_t> of_clear_;
  uint64_t rays_to_veils_ = 0;
  std::vector<glm::vec3> normals_;
  std::vector<float> widths_;
  std::vector<uint32_t> keys_;
  std::vector<PathLight> light_;
  std::vector<glm::vec3> directions_, sky_;  // directions of rays_, and the sky's light there
  std::vector<ArrivingLight> means_;     // around each of records_
  std::vector<ArrivingLight> arriving_;  // at each point of the batch
};

}  // namespace sideray::rt
