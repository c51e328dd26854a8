// Keeps what temporal cache rates and reuse of shading need of the frame before: the light of its layers, where they lay,
// and what has changed. Whoever traces a sequence of frames keeps one for it; one thread calls begin and end, and lookups
// and records of different pixels may run at the same time.
#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "model/snapshot.h"
#include "rt/base/counters.h"
#include "rt/base/view_rays.h"
#include "rt/cache/still_view.h"
#include "rt/embree/intersector.h"
#include "rt/layers/frame_pixels.h"
#include "rt/layers/layer_request.h"
#include "rt/surfaces/surface.h"

namespace sideray::rt {

// Returns after how many frames every pixel of a still picture has been shaded once: 4 or 8; 0 = not a temporal rate.
uint32_t temporal_period(sideray_cache_rate rate);
// The same of a request, which may reuse shading; 0 = every layer is shaded in every frame.
uint32_t temporal_period(const CacheRequest& request);

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
    // Of a request that reuses shading:
    uint16_t age = 0;        // frames since it was shaded; of a mixture, of its oldest part
    bool front = false;      // the front of its surface was hit
    bool noisy = false;      // one random direction made its light: no other layer reuses it
    glm::vec3 position{0.0f};
    shading::SrBlend blend{0.0f, glm::vec3(0.0f)};
  };

  // Holds what the frame before knows of a surface.
  struct Past {
    Layer layer;
    bool stands;  // it stands for the surface's light, if that has not changed: shading the surface finds out
    bool keeps;   // it does, and nothing is known to have changed around
  };
  // No light is older than so many frames.
  static constexpr uint16_t oldest = 15;

  // Prepares for a frame that follows the last one, or stands for it once more (SequenceStep). Whatever changed but the
  // view and where instances and vertices are drops all that is known. `committed`: the snapshot without poses of what
  // the wind moves, which rays hit in `snapshot`.
  void begin(const CacheRequest& request, std::shared_ptr<const model::Snapshot> snapshot,
             std::shared_ptr<const model::Snapshot> committed, const FramePixels& pixels);
  // A frame that was not finished leaves nothing to follow.
  void end(bool finished);
  // Returns whether a frame needs no begin() since its layers are the last one's, given how many frames before it had
  // the same inputs: by then each pixel has been shaded since anything changed.
  bool stays(const CacheRequest& request, uint32_t still_frames) const {
    return request.shading_reuse > 0.0f && frames_[current_].complete && still_frames > period_;
  }

  bool is_shaded_anew(uint32_t x, uint32_t y) const;
  // Returns the light that the frame before knows of the surface that `ray` of this frame hits; none where it was
  // hidden. distance and surface_id are those of the hit.
  std::optional<Layer> find(const Hit& hit, const Ray& ray) const;
  // The same for a request that reuses shading. `footprint` is the pixel's width at the hit.
  std::optional<Past> past(const Hit& hit, const Ray& ray, float footprint) const;

  // Empties a pixel's slots in this frame; they are empty until recorded.
  void clear(const PixelRequest& pixel);
  void record(const PixelRequest& pixel, uint32_t slot, const Layer& layer);
  // Returns what was recorded, for changes.
  Layer& recorded(const PixelRequest& pixel, uint32_t slot);
  // Says what the layer was before that is shaded anew now; compare() and replace() find out by how much it changed.
  void expect(const PixelRequest& pixel, uint32_t slot, const Layer& before);
  // The layer is filtered: replace() compares.
  void leave_to_filter(const PixelRequest& pixel, uint32_t slot);
  void compare(const PixelRequest& pixel);
  // Replaces the radiance of what was recorded. `texel`: y * width + x.
  void replace(uint32_t texel, uint32_t slot, const uint16_t radiance[3]);

  // What whoever traces the sequence knows of it: whether the view stands still, and what the last frame did.
  StillView still;
  Counters counters;

 private:
  struct Frame {
    bool complete = false;
    CacheRequest request;  // pointers in it are not followed
    std::shared_ptr<const model::Snapshot> snapshot, committed;
    std::vector<uint32_t> first;  // where each pixel's layers begin
    std::vector<uint8_t> slots;   // number of slots of each pixel
    std::vector<Layer> layers;
    // Of each cell of the picture, how many layers were compared with what was expected, and how many had changed.
    std::vector<uint8_t> compared, changed;
  };
  // Holds what was expected of a layer of this frame.
  struct Expected {
    uint16_t radiance[3];
    bool known = false, filtered = false;
  };

  // Describes a surface in the local space of the frame before.
  struct Place {
    glm::dvec3 point, normal;
  };

  void allot(const FramePixels& pixels);
  static std::vector<uint8_t> changed_cells(const Frame& frame);
  size_t slot_of(const PixelRequest& pixel, uint32_t slot) const;
  void compare(uint32_t texel, size_t slot);
  bool has_changed_around(glm::dvec2 pixel) const;
  bool sees_alike(const Hit& hit, const Ray& ray, const glm::dvec3& point, bool moved) const;
  struct Seeker;
  Place place_before(const Hit& hit, const Ray& ray) const;
  const Layer* layer_at(glm::ivec2 at, uint32_t surface_id, const Place& place) const;

  Frame frames_[2];
  uint32_t current_ = 0;
  uint32_t number_ = 0;  // index of the frame in its sequence
  uint32_t period_ = 0;
  std::optional<ViewRays> previous_rays_;  // none: nothing is known of the frame before
  std::vector<uint8_t> changed_around_;    // of the frame before: its changed cells and those around
  std::vector<Expected> expected_;         // of this frame's layers, where shading is reused
};

}  // namespace sideray::rt
