// Says where in a picture translucent surfaces may be seen, so that no ray looks for them elsewhere. Plain memory; any thread.
#pragma once

#include <cstdint>
#include <vector>

#include "model/snapshot.h"
#include "rt/base/view.h"

namespace sideray::rt {

// Returns a value a pixel: 255 where the bounds of something translucent are, and 0 elsewhere. Empty: it may be anywhere, which
// is so with sprites, with what the wind moves, and where bounds reach behind the eye.
std::vector<uint8_t> translucent_places(const model::Snapshot& snapshot, const TraceView& view, uint32_t width,
                                        uint32_t height);

}  // namespace sideray::rt
