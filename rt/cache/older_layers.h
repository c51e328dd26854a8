// Holds the history of the layer cache, for pixels that a deadline skips. Layers stay in place if view and surfaces are
// at rest; others are reprojected, each with its own instance. The least recently traced come first in the next frame.
// One object a sequence and cache. One thread calls it, and it uses the executor's; functions of a chunk may be called
// for several chunks at a time.
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
  // History expires after this many frames in which something changed; frames without change do not count.
  static constexpr uint32_t oldest = 120;
  static constexpr uint8_t no_answer = 255;  // instead of an age

  // Clears the cache for the request's frame, as begin_cache() does, except for reusable history. A frame that does not
  // continue the sequence resets the history, and so does a change of lights, environment, materials, textures,
  // triangles, names or options. Texels that stay in place keep their bits. Reprojected ones have an alpha of
  // moved_alpha instead of 1, and no pixel with one is whole. `posed`: the snapshot that rays hit; `committed`: the one
  // without poses.
  void begin(const CacheRequest& request, std::shared_ptr<const model::Snapshot> posed,
             std::shared_ptr<const model::Snapshot> committed, const FramePixels& pixels, Executor& executor,
             LayerCache& cache);
  // Resets the history.
  void forget() { known_ = has_moved_ = false; }
  // Returns whether the cache may hold reprojected layers.
  bool has_moved() const { return has_moved_; }

  // Returns the age of each pixel's oldest layer, encoded as by OlderMasks::answers().
  std::vector<uint8_t> answers() const;
  // Returns the frame of the least recently traced pixel; 0 if most of the pixels have no answer.
  uint32_t last_turn(std::span<const PixelRequest> pixels) const;
  // Clears pixels of the cache that are about to be traced.
  void clear(std::span<const PixelRequest> pixels, LayerCache& cache);
  // Records the surface of a traced layer. `texel`: index in the cache; `normal`: unit, on the front's side.
  void record(size_t texel, glm::vec3 normal);
  // Notes that all layers of the pixels were traced.
  void traced(std::span<const PixelRequest> pixels, LayerCache& cache);
  // Counts skipped pixels: pixels_older, answer_age. Returns how many have no answer.
  uint64_t leave(std::span<const PixelRequest> pixels, Counters& counters) const;

 private:
  // Holds the history of a layer that is not in the cache. `off` is where it was traced, relative to the middle of its
  // pixel, in 4096ths of a pixel: repeated reprojection accumulates no rounding.
  struct Surface {
    int16_t normal[2] = {0, 0};
    int16_t off[2] = {0, 0};
  };
  // Says how an instance has moved since the previous frame.
  struct Motion {
    bool lost;  // its vertices have changed, so its surfaces cannot be reprojected
    glm::dmat4 now_from_then;
    glm::dmat3 normal_now_from_then;
  };
  // Holds a layer that is reprojected to another pixel.
  struct Carried {
    uint32_t pixel, row, surface_id, traced_in;
    float distance;
    Surface surface;
    uint16_t radiance[3];
  };
  struct Row {
    std::vector<Carried> layers, sorted;
    std::vector<uint32_t> first;  // index in `sorted` of the first layer for each row of tiles
    // The surface of the last look-up, because neighbours often show the same one.
    uint32_t last_id = 0;
    const Motion* last_motion = nullptr;
  };
  // Holds the two views between which layers are reprojected.
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
  FrameCamera camera_;  // that the layers were traced from
  uint32_t number_ = 0, state_ = 0;  // number of the frame; number of changes of the scene or view so far
  uint32_t state_began_ = 0;         // last frame in which state_ grew
  std::vector<uint32_t> traced_in_;  // by pixel: state_ when its oldest layer was traced; 0 = no answer
  std::vector<uint32_t> turns_;      // by block of pixels: the last frame that traced it
  std::vector<uint32_t> tile_oldest_;  // by tile: at most the smallest traced_in_ above 0; 0 = there is none
  std::vector<Surface> surfaces_;    // one a texel of the cache
  std::unordered_map<uint32_t, Motion> motions_;  // by surface id: moved instances
  std::vector<Row> rows_;
};

}  // namespace sideray::rt
