// Requests the light that other surfaces reflect onto opaque pixels, and holds its image. Plain values; any thread. Row
// 0 of pixels is the bottom row.
#pragma once

#include <cstdint>
#include <vector>

#include "rt/opaque/light_request.h"

namespace sideray::rt {

class IrradianceHistory;

// `still` and `history` belong to one sequence. If not all tiles are wanted, the history is neither read nor written.
struct IrradianceRequest : LightRequest {
  // Of the sequence: accumulates samples over frames; null: uses only this frame's.
  IrradianceHistory* history = nullptr;
  // Number of frames, this one included, that have traced this position of a view at rest. New samples replace older
  // ones, so that the position is complete when all tiles have been traced. 0 = no such position.
  uint32_t position_frames = 0;
};

struct IrradianceImage {
  uint32_t width = 0, height = 0;
  // Four halfs a texel: irradiance over pi, which is the radiance of a white diffuse surface; alpha: 1 if it is known.
  std::vector<uint16_t> light;
  bool changed = true;  // by the last trace
};

}  // namespace sideray::rt
