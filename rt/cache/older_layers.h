// The history of the layer cache, for pixels that have no turn under a deadline. Layers stay where view and surfaces
// stand still; others are reprojected, each with its own instance. The least recently traced come first in the next
// frame. One object a sequence and cache; one thread calls it and it works on the executor's, but what is said of a
// chunk may be said of several chunks at a time.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "model/snapshot.h"
#include "rt/base/counters.h"
#include "rt/base/executor.h"
#include "rt/history/frame_camera.h"
#include "rt/layers/frame_pixels.h"
#include "rt/layers/layer_request.h"

namespace sideray::rt {

// Returns whether a request uses history: it has a deadline and traces every masked pixel.
bool takes_older(const CacheRequest& request);

class OlderLayers {
 public:
  // History expires after this many frames in which something has changed; frames without change do not count.
  static constexpr uint32_t oldest = 120;
  static constexpr uint8_t no_answer = 255;  // in place of an age

  // Clears the cache for the request's frame, as begin_cache() does, except for history that can be reused. A frame
  // that does not continue, and a change of lights, environment, materials, textures, triangles, names or options,
  // reset the history. Texels that stay in place keep their bits. Reprojected ones have an alpha of moved_alpha instead
  // of 1, and no pixel with one is whole. `posed`: the snapshot that rays hit; `committed`: without poses.
  void begin(const CacheRequest& request, std::shared_ptr<const model::Snapshot> posed,
             std::shared_ptr<const model::Snapshot> committed, const FramePixels& pixels, Executor& executor,
             LayerCache& cache);
  // Resets the history.
  void forget() { known_ = has_moved_ = false; }
  // Returns whether the cache may hold reprojected layers.
  bool has_moved() const { return has_moved_; }

  // Returns of each pixel's oldest layer what OlderMasks::answers() does.
  std::vector<uint8_t> answers() const;
  // Returns the frame of the least recently traced pixel; 0 if most of them show nothing.
  uint32_t last_turn(std::span<const PixelRequest> pixels) const;
  // Clears pixels of the cache that are about to be traced.
  void clear(std::span<const PixelRequest> pixels, LayerCache& cache);
  // Records the surface of a layer that is traced. `texel`: of the cache; `normal`: unit, on the front's side.
  void record(size_t texel, glm::vec3 normal);
  // Call when pixels were traced to the end.
  void traced(std::span<const PixelRequest> pixels, LayerCache& cache);
  // Counts pixels that were skipped: pixels_older, answer_age; returns how many show nothing.
  uint64_t leave(std::span<const PixelRequest> pixels, Counters& counters) const;

 private:
  // The history of a layer besides the cache: the place where it was traced, from the middle of its pixel, in 4096ths
  // of a pixel, so that repeated reprojection does not accumulate rounding.
  struct Surface {
    int16_t normal[2] = {0, 0};
    int16_t off[2] = {0, 0};
  };
  // How an instance has moved since the previous frame.
  struct Motion {
    bool lost;  // its vertices have changed, so its surfaces cannot be reprojected
    glm::dmat4 now_from_then;
    glm::dmat3 normal_now_from_then;
  };
  // A layer that is reprojected to another pixel.
  struct Carried {
    uint32_t pixel, row, surface_id, traced_in;
    float distance;
    Surface surface;
    uint16_t radiance[3];
  };
  struct Row {
    std::vector<Carried> layers, sorted;
    std::vector<uint32_t> first;  // index in `sorted` of the first layer for each row of tiles
    // The surface that was looked up last: neighbours show the same.
    uint32_t last_id = 0;
    const Motion* last_motion = nullptr;
  };
  // A frame on its way from one view to the next.
  struct Passage;

  bool follows(const CacheRequest& request, const model::Snapshot& committed, const LayerCache& cache) const;
  void start(const CacheRequest& request, const FramePixels& pixels, Executor& executor, LayerCache& cache);
  bool find_motions(const model::Snapshot& posed);
  void carry(const Passage& passage);
  void pull_row(const Passage& passage, uint32_t row);
  void pull_pixel(const Passage& passage, glm::uvec2 at, Row& row);
  void pull_layer(const Passage& passage, glm::uvec2 at, size_t texel, const Motion* motion, Row& row) const;
  const Motion* motion_of(uint32_t surface_id, Row& row) const;
  static void sort(Row& row, uint32_t rows);
  void place(const Passage& passage, const Carried& layer);
  void fill_holes(const Passage& passage);
  void fill_hole(const Passage& passage, glm::uvec2 at, glm::uvec2 from);
  void drop_old(const Passage& passage);
  static void refuse_whole(const Passage& passage);
  void mark(const Passage& passage, glm::uvec2 at) const;
  void empty(LayerCache& cache, size_t pixel, uint32_t from) const;
  size_t block_of(glm::uvec2 pixel) const;
  bool is_moved(uint32_t surface_id) const { return motions_.find(surface_id) != motions_.end(); }

  bool known_ = false, has_moved_ = false;
  CacheRequest request_;  // of the last frame; pointers in it are not followed
  std::shared_ptr<const model::Snapshot> posed_, committed_;
  FrameCamera camera_;  // from which the layers were traced
  uint32_t number_ = 0, state_ = 0;  // numbers of the frame, and of the last change of what is seen
  uint32_t state_began_ = 0;         // number of the last frame in which it grew
  std::vector<uint32_t> traced_in_;  // of each pixel: state_ of its oldest layer; 0 = it shows nothing
  std::vector<uint32_t> turns_;      // of each block of pixels: the number of the frame that traced it last
  std::vector<uint32_t> tile_oldest_;  // of each tile: not above the least of traced_in_; 0 = none is above 0
  std::vector<Surface> surfaces_;    // a texel of the cache each
  std::unordered_map<uint32_t, Motion> motions_;  // by surface id: of those that have moved
  std::vector<Row> rows_;
};

}  // namespace sideray::rt
