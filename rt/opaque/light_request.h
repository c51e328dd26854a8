// Holds what all requests for light of a frame's opaque pixels share, for reflections and for light from other
// surfaces. Plain values; any thread.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <vector>

#include "rt/base/deadline.h"
#include "rt/base/opaque_point.h"
#include "rt/base/sequence.h"
#include "rt/base/view.h"
#include "rt/history/pixel_trail.h"
#include "rt/history/still_frames.h"
#include "rt/masks/mask_request.h"

namespace sideray::rt {

class ShadingQueue;

struct LightRequest {
  TraceView view;
  uint32_t width = 0, height = 0;
  DepthImage depth;
  float subpixel = 0x1p-9f;             // as in MaskRequest
  std::span<const OpaquePoint> points;  // as in MaskRequest
  bool shadows = true, denoise = false;
  uint32_t seed = 1;
  uint32_t position = 0;                         // as in LayerRequest
  SequenceStep sequence = SequenceStep::first;   // of `still` and the history
  ViewFrame frame{};                             // of the history
  StillFrames* still = nullptr;                  // a frame equal to the last keeps its image; null: all are traced
  const std::atomic<bool>* cancelled = nullptr;  // polled between tiles
  WorkTime work;                                 // tiles that it does not let begin are skipped
  ShadingQueue* shading_queue = nullptr;         // as in LayerRequest
  const WantedTiles* wanted = nullptr;           // tiles to trace; null: all
};

// Throws a Failure that begins with `name` if the request has no size or no depth.
void check_light(const LightRequest& request, std::string_view name);
// Returns a mask request for the pixels' points.
MaskRequest depth_request(const LightRequest& request);
// `inputs`: the bytes of the request's other inputs.
FrameKey frame_key(const LightRequest& request, std::vector<std::byte> inputs);

}  // namespace sideray::rt
