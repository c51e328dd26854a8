// A request for the translucent surfaces of a frame's pixels: what a host asked for (sideray_layer_inputs, whose comments say
// what each value means), and beside it the frame's images, clock and history. And the layer cache that answers it. Plain
// values; any thread. Pixels: row 0 is the bottom row.
#pragma once

#include <sideray/sideray.h>

#include <atomic>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "rt/base/deadline.h"
#include "rt/base/pixels.h"
#include "rt/base/sequence.h"
#include "rt/base/view.h"

namespace sideray::rt {

class OlderLayers;
class ShadingQueue;
class StillFrames;
struct WantedTiles;

inline constexpr uint32_t most_cached_layers = 8, most_composited_layers = 64;

// What sideray_layer_inputs_init() fills in.
sideray_layer_inputs default_layer_inputs();

// A composite of 0 `max_layers` is unlimited; a cache refuses it.
struct LayerRequest : sideray_layer_inputs {
  explicit LayerRequest(const sideray_layer_inputs& inputs = default_layer_inputs()) : sideray_layer_inputs(inputs) {}

  TraceView view;
  uint32_t width = 0, height = 0;
  DepthImage depth;
  sideray_mask_source mask = SIDERAY_MASK_COUNT;
  uint32_t stencil_bits = 0x3f;
  std::span<const uint8_t> mask_bytes;  // a pixel: TEXTURE, MEMORY
  bool shadows = true;
  bool light_bounces = false;  // surfaces that are hit light each other, and hide the sky from each other
  uint32_t seed = 1;
  const std::atomic<bool>* cancelled = nullptr;  // polled between chunks
  WorkTime work;                                 // chunks that it does not let begin are skipped
  ShadingQueue* shading_queue = nullptr;         // SIDERAY_SHADE_IN_CALLS: to the host's thread; null: shaded at once
  // Of a composite: surfaces that bend light are resolved and what rough ones reflect is filtered, as layers of a cache are.
  bool resolves = false;
};

// A request that a layer cache answers.
struct CacheRequest : LayerRequest {
  using LayerRequest::LayerRequest;

  SequenceStep sequence = SequenceStep::first;  // of `still` and `older`
  StillFrames* still = nullptr;  // of its sequence: a frame that is the last one keeps the cache; null: it is traced
  OlderLayers* older = nullptr;  // of its sequence: what has no turn shows its history; null: there is none
  uint32_t position_frames = 0;         // as MaskRequest has it
  const WantedTiles* wanted = nullptr;  // null: all tiles are
  float subpixel = 0.0f;         // by how much of a pixel rasterization moves a vertex along x and along y, at most
};

// N layers a pixel, layer-major: texel (x, y) of layer k is at (k * height + y) * width + x. Kept from frame to frame
// by its owner: tiles traced last frame and not in this one are cleared to "no answer" and reported as dirty too.
struct LayerCache {
  static constexpr uint32_t tile_size = frame_tile_size;
  uint32_t width = 0, height = 0, layers = 0;
  // Four halfs a texel; alpha 1, or moved_alpha for reprojected history.
  static constexpr float moved_alpha = 0.5f;
  std::vector<uint16_t> radiance;
  // Along the view ray; 0 = empty. Negative: the layer there is resolved, the last of its pixel, and hides all behind it.
  std::vector<float> distance;
  std::vector<uint32_t> surface_id;
  // One plane each, four halfs a texel, empty unless requested: whole pixels, composited along the ray. Those have a
  // transmittance with an alpha of 1; the others' radiance has no meaning.
  std::vector<uint16_t> whole_radiance, whole_transmittance;
  std::vector<uint8_t> traced_tiles;  // row-major, 1 = holds answers
  std::vector<uint8_t> dirty_tiles;   // 1 = changed by the last trace: upload these
};

// Every surface of the layers' set along the ray of every masked pixel, however many a cache would hold: those of texel
// i are surfaces[first[i]] to surfaces[first[i + 1] - 1], nearest first; x = bits of the float distance, y = surface
// id.
struct LayerTruth {
  uint32_t width = 0, height = 0;
  std::vector<uint32_t> first;
  std::vector<glm::uvec2> surfaces;
};

}  // namespace sideray::rt
