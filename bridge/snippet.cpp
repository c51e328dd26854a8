#include "bridge/snippet.h"

#include "shaders/sources.h"

namespace sideray::bridge {

const char* snippet_text(int glsl_version) {
  // Below 1.30 there are neither integer samplers nor texelFetch.
  return glsl_version >= 130 ? shaders::source("sideray.glsl").data() : nullptr;
}

}  // namespace sideray::bridge
