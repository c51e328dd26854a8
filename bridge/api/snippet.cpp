#include "bridge/api/snippet.h"

#include <string>

#include "shaders/sources.h"

namespace sideray::bridge {
namespace {

std::string old_snippet() {
  return "#extension GL_EXT_texture_array : require\n" + std::string(shaders::source("sideray.glsl"));
}

std::string behind_snippet(const char* file) {
  return "#version 120\n" + old_snippet() + std::string(shaders::source(file));
}

}  // namespace

const char* snippet_text(int glsl_version) {
  if (glsl_version < 120) return nullptr;
  if (glsl_version >= 130) return shaders::source("sideray.glsl").data();
  static const std::string text = old_snippet();
  return text.c_str();
}

const char* ready_vertex(sideray_ready_program program) {
  if (program == SIDERAY_READY_GLASS) return shaders::source("ready_glass.vert.glsl").data();
  return program == SIDERAY_READY_SHADOWS ? shaders::source("ready_shadows.vert.glsl").data() : nullptr;
}

const char* ready_fragment(sideray_ready_program program) {
  static const std::string glass = behind_snippet("ready_glass.frag.glsl");
  static const std::string shadows = behind_snippet("ready_shadows.frag.glsl");
  static const std::string fragment = behind_snippet("ready_glass_alone.frag.glsl");
  if (program == SIDERAY_READY_GLASS) return glass.c_str();
  if (program == SIDERAY_READY_GLASS_FRAGMENT) return fragment.c_str();
  return program == SIDERAY_READY_SHADOWS ? shadows.c_str() : nullptr;
}

}  // namespace sideray::bridge
