// Finds where in a picture translucent surfaces may be, so that no rays are traced elsewhere. Plain memory; any thread.
#pragma once

#include <cstdint>
#include <vector>

#include "model/snapshot.h"
#include "rt/base/view.h"

namespace sideray::rt {

// Returns one value a pixel: 255 within the projected bounds of something translucent, else 0. Empty: it may be
// anywhere, because of sprites, wind, or bounds that reach behind the eye.
std::vector<uint8_t> translucent_places(const model::Snapshot& snapshot, const TraceView& view, uint32_t width,
                                        uint32_t height);

}  // namespace sideray::rt
