// Keeps what temporal cache rates need of the frame before: the light of its layers and where they lay. Whoever traces
// a sequence of frames keeps one for it; one thread calls begin and end, and lookups and records of different pixels
// may run at the same time.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "model/snapshot.h"
#include "rt/base/view_rays.h"
#include "rt/embree/intersector.h"
#include "rt/layers/frame_pixels.h"
#include "rt/layers/layer_request.h"

namespace sideray::rt {

// Returns after how many frames every pixel of a still picture has been shaded once: 4 or 8; 0 = not a temporal rate.
uint32_t temporal_period(sideray_cache_rate rate);

// Returns whether a pixel is shaded anew in the sequence's frame of this number. Each frame's pixels are a lattice as
// even as there is one, and frames that follow each other take lattices that lie far apart.
bool is_shaded_anew(uint32_t period, uint32_t frame, uint32_t x, uint32_t y);

class LayerHistory {
 public:
  // Holds a surface as a frame's layer does.
  struct Layer {
    uint16_t radiance[3];  // halfs
    float distance;        // along the ray of its pixel; 0 = none
    uint32_t surface_id;
  };

  // Prepares for a frame that follows the last one, or stands for it once more (SequenceStep). Whatever changed but the
  // view and where instances and vertices are drops all that is known. `committed`: the snapshot without poses of what
  // the wind moves, which rays meet in `snapshot`.
  void begin(const CacheRequest& request, std::shared_ptr<const model::Snapshot> snapshot,
             std::shared_ptr<const model::Snapshot> committed, const FramePixels& pixels);
  // A frame that was not finished leaves nothing to follow.
  void end(bool finished);

  bool is_shaded_anew(uint32_t x, uint32_t y) const;
  // Returns the light that the frame before knows of the surface that `ray` of this frame hits; none where it was
  // hidden. distance and surface_id are those of the hit.
  std::optional<Layer> find(const Hit& hit, const Ray& ray) const;

  // Empties a pixel's slots in this frame; they are empty until recorded.
  void clear(const PixelRequest& pixel);
  void record(const PixelRequest& pixel, uint32_t slot, const Layer& layer);
  // Replaces the radiance of what was recorded. `texel`: y * width + x.
  void replace(uint32_t texel, uint32_t slot, const uint16_t radiance[3]);

 private:
  struct Frame {
    bool complete = false;
    CacheRequest request;  // pointers in it are not followed
    std::shared_ptr<const model::Snapshot> snapshot, committed;
    std::vector<uint32_t> first;  // where each pixel's layers begin
    std::vector<uint8_t> slots;   // number of slots of each pixel
    std::vector<Layer> layers;
  };

  // Describes a surface in the local space of the frame before.
  struct Place {
    glm::dvec3 point, normal;
  };

  void allot(const FramePixels& pixels);
  Place place_before(const Hit& hit, const Ray& ray) const;
  const Layer* layer_at(glm::ivec2 at, uint32_t surface_id, const Place& place) const;

  Frame frames_[2];
  uint32_t current_ = 0;
  uint32_t number_ = 0;  // index of the frame in its sequence
  uint32_t period_ = 0;
  std::optional<ViewRays> previous_rays_;  // none: nothing is known of the frame before
};

}  // namespace sideray::rt
