// A request for what glossy opaque pixels mirror, and the image that answers it. Plain values; any thread. Pixels: row
// 0 is the bottom row.
#pragma once

#include <atomic>
#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "rt/base/deadline.h"
#include "rt/base/opaque_point.h"
#include "rt/base/sequence.h"
#include "rt/base/view.h"

namespace sideray::rt {

class ShadingQueue;
class StillFrames;

// Requests what glossy opaque surfaces mirror.
struct ReflectionRequest {
  TraceView view;
  uint32_t width = 0, height = 0;
  DepthImage depth;
  float subpixel = 0x1p-9f;              // as in MaskRequest
  std::span<const glm::vec4> normals;    // a pixel: shading normal, perceptual roughness; 0 where there is no surface
  std::span<const OpaquePoint> points;   // as in MaskRequest
  float max_roughness = 0.0f;            // rougher pixels are not traced
  float error = 0.0f;                    // as LayerRequest::ray_reuse, for lights that are drawn by chance
  bool shadows = true, denoise = false;  // denoise: filter what rough surfaces mirror
  uint32_t seed = 1;
  SequenceStep sequence = SequenceStep::first;   // of `still`
  StillFrames* still = nullptr;                  // a frame that is the last one keeps the image; null: it is traced
  const std::atomic<bool>* cancelled = nullptr;  // polled between tiles
  Deadline deadline = Deadline::max();           // tiles that have not begun by then are not traced
  ShadingQueue* shading_queue = nullptr;         // as in LayerRequest
};

struct ReflectionImage {
  uint32_t width = 0, height = 0;
  std::vector<uint16_t> radiance;  // four halfs a texel; alpha: its share beside the prefiltered environment's
  bool changed = true;             // by the last trace
};

}  // namespace sideray::rt
