// Uploads the true layers of each pixel as textures that a fragment shader searches. The thread whose context is
// current calls it.
#pragma once

#include "gl/context/functions.h"
#include "gl/passes/pass_inputs.h"
#include "gl/resources/objects.h"

namespace sideray::gl {

// Lists longer than a row are wrapped: element i is at (i % width, i / width). Throws Failure (UNSUPPORTED) where there
// are more than the driver's textures hold.
struct LayerTruthTextures {
  LayerTruthTextures(const Functions& gl, const LayerTruth& truth);

  static constexpr int width = 4096;
  Texture first, surfaces;
};

}  // namespace sideray::gl
