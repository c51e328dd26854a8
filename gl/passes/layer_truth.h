// Uploads the true layers of each pixel as textures that a fragment shader searches. The context must be current.
#pragma once

#include "gl/context/functions.h"
#include "gl/passes/pass_inputs.h"
#include "gl/resources/objects.h"

namespace sideray::gl {

// Wraps lists that are longer than a row: element i is at (i % width, i / width). Throws Failure (UNSUPPORTED) where
// the driver's textures cannot hold all elements.
struct LayerTruthTextures {
  LayerTruthTextures(const Functions& gl, const LayerTruth& truth);

  static constexpr int width = 4096;
  Texture first, surfaces;
};

}  // namespace sideray::gl
