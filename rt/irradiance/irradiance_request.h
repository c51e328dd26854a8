// A request for the light that other surfaces throw on opaque pixels, and the image that answers it. Plain values; any thread.
// Pixels: row 0 is the bottom row.
#pragma once

#include <cstdint>
#include <vector>

#include "rt/opaque/light_request.h"

namespace sideray::rt {

class IrradianceHistory;

// `still` and `history` are of one sequence; where not all tiles are wanted the history is neither read nor written.
struct IrradianceRequest : LightRequest {
  // Of the sequence: adds up samples of frames; null: this frame's alone.
  IrradianceHistory* history = nullptr;
  // Frames that a position of a still view has taken, this one included: what is traced takes the place of older samples, so
  // that the position is whole when all tiles have had a turn. 0 = it is none.
  uint32_t position_frames = 0;
};

struct IrradianceImage {
  uint32_t width = 0, height = 0;
  // Four halfs a texel: irradiance over pi, which is the radiance of a white matt surface; alpha: 1 where it is known.
  std::vector<uint16_t> light;
  bool changed = true;  // by the last trace
};

}  // namespace sideray::rt
