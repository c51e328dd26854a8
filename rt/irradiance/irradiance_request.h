// A request for the light that other surfaces throw on opaque pixels, and the image that answers it. Plain values; any thread.
// Pixels: row 0 is the bottom row.
#pragma once

#include <atomic>
#include <cstdint>
#include <span>
#include <vector>

#include "rt/base/deadline.h"
#include "rt/base/opaque_point.h"
#include "rt/base/sequence.h"
#include "rt/base/view.h"

namespace sideray::rt {

class IrradianceHistory;
class ShadingQueue;
class StillFrames;
struct WantedTiles;

struct IrradianceRequest {
  TraceView view;
  uint32_t width = 0, height = 0;
  DepthImage depth;
  float subpixel = 0x1p-9f;             // as in MaskRequest
  std::span<const OpaquePoint> points;  // as in MaskRequest
  bool shadows = true, denoise = true;
  uint32_t seed = 1;
  SequenceStep sequence = SequenceStep::first;   // of `still` and `history`
  StillFrames* still = nullptr;                  // a frame that is the last one keeps the image; null: it is traced
  // Of the sequence: adds up samples of frames; null: this frame's alone.
  IrradianceHistory* history = nullptr;
  // Frames that a position of a still view has taken, this one included: what is traced takes the place of older samples, so
  // that the position is whole when all tiles have had a turn. 0 = it is none.
  uint32_t position_frames = 0;
  const std::atomic<bool>* cancelled = nullptr;  // polled between tiles
  WorkTime work;                                 // tiles that it does not let begin are given up
  ShadingQueue* shading_queue = nullptr;         // as in LayerRequest
  const WantedTiles* wanted = nullptr;           // null: all tiles are; otherwise the history is neither read nor written
};

struct IrradianceImage {
  uint32_t width = 0, height = 0;
  // Four halfs a texel: irradiance over pi, which is the radiance of a white matt surface; alpha: 1 where it is known.
  std::vector<uint16_t> light;
  bool changed = true;  // by the last trace
};

}  // namespace sideray::rt
