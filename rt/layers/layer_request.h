// Requests the translucent surfaces of a frame's pixels: the host's sideray_layer_inputs, whose comments explain each
// value, with the frame's images, clock and history. Also declares the layer cache that holds the result. Plain values;
// any thread. Row 0 of pixels is the bottom row.
#pragma once

#include <sideray/sideray.h>

#include <atomic>
#include <cstdint>
#include <glm/glm.hpp>
#include <optional>
#include <span>
#include <vector>

#include "rt/base/deadline.h"
#include "rt/base/pixels.h"
#include "rt/base/sequence.h"
#include "rt/base/view.h"
#include "rt/light/seen_light.h"

namespace sideray::rt {

class OlderLayers;
class ShadingQueue;
class StillFrames;
struct WantedTiles;

inline constexpr uint32_t most_cached_layers = 8, most_composited_layers = 64;

// Returns what sideray_layer_inputs_init() fills in.
sideray_layer_inputs default_layer_inputs();

// Requests layers for a composite or a cache. `max_layers` 0 is unlimited in a composite; a cache rejects it.
struct LayerRequest : sideray_layer_inputs {
  explicit LayerRequest(const sideray_layer_inputs& inputs = default_layer_inputs()) : sideray_layer_inputs(inputs) {}

  TraceView view;
  uint32_t width = 0, height = 0;
  DepthImage depth;
  sideray_mask_source mask = SIDERAY_MASK_COUNT;
  uint32_t stencil_bits = 0x3f;
  std::span<const uint8_t> mask_bytes;  // one a pixel, for TEXTURE and MEMORY
  bool shadows = true;
  bool light_bounces = false;  // surfaces that are hit light each other, and occlude the sky for each other
  PixelLight lit{};            // with light_bounces: at the pixels of `depth`; empty: unknown
  uint32_t seed = 1;
  uint32_t position = 0;  // of the sample positions that are averaged: it alone changes the paths of bounced light
  const std::atomic<bool>* cancelled = nullptr;  // polled between chunks
  WorkTime work;                                 // limits which chunks begin; the others are skipped
  ShadingQueue* shading_queue = nullptr;         // SIDERAY_SHADE_IN_CALLS: passes points to the host's thread; null:
                                                 // shades at once
  // For a composite: resolves surfaces that bend light and filters rough reflections, as a cache does.
  bool resolves = false;
};

// Returns the light that the request knows.
inline std::optional<SeenLight> seen_light_of(const LayerRequest& r) {
  if (!r.light_bounces || !r.depth.texels || r.lit.thrown.empty()) return std::nullopt;
  return SeenLight(r.view, r.width, r.height, r.depth, r.lit);
}

// Requests a layer cache.
struct CacheRequest : LayerRequest {
  using LayerRequest::LayerRequest;

  SequenceStep sequence = SequenceStep::first;  // relates the frame to `still` and `older`
  StillFrames* still = nullptr;  // of the sequence: keeps the cache if the frame equals the last one; null: always
                                 // traces
  OlderLayers* older = nullptr;  // of the sequence: the history that untraced pixels show; null: none
  uint32_t position_frames = 0;         // as in MaskRequest
  const WantedTiles* wanted = nullptr;  // tiles to trace; null: all
  float subpixel = 0.0f;         // the most, in pixels along x and y, by which rasterization moves a vertex
};

// Holds N layers a pixel, layer-major: texel (x, y) of layer k is at (k * height + y) * width + x. Its owner reuses it
// every frame: tiles that were traced last frame but not in this one are cleared to "no answer" and also marked dirty.
struct LayerCache {
  static constexpr uint32_t tile_size = frame_tile_size;
  uint32_t width = 0, height = 0, layers = 0;
  // Four halfs a texel; alpha is 1, or moved_alpha for reprojected history.
  static constexpr float moved_alpha = 0.5f;
  std::vector<uint16_t> radiance;
  // Along the view ray; 0 = empty. A negative one belongs to a resolved layer, the pixel's last, which hides everything
  // behind it.
  std::vector<float> distance;
  std::vector<uint32_t> surface_id;
  // One plane each, four halfs a texel, empty unless requested: whole pixels, composited along the ray. A transmittance
  // with alpha 1 marks a whole pixel; in other pixels the radiance is undefined.
  std::vector<uint16_t> whole_radiance, whole_transmittance;
  std::vector<uint8_t> traced_tiles;  // row-major, 1 = holds answers
  std::vector<uint8_t> dirty_tiles;   // 1 = changed by the last trace, to be uploaded
};

// Holds every surface along the ray of every masked pixel, however many a cache would hold. Those of texel i are
// surfaces[first[i]] to surfaces[first[i + 1] - 1], nearest first; x = bits of the float distance, y = surface id.
struct LayerTruth {
  uint32_t width = 0, height = 0;
  std::vector<uint32_t> first;
  std::vector<glm::uvec2> surfaces;
};

}  // namespace sideray::rt
