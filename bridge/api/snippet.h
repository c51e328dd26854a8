// Provides the text of sideray.glsl for hosts, and whole programs with it. Any thread, no context.
#pragma once

#include <sideray/sideray.h>

namespace sideray::bridge {

// Returns zero-terminated text that stays valid; null where the version is not supported.
const char* snippet_text(int glsl_version);

// Return GLSL 1.20 with its #version line; null where there is no such program.
const char* ready_vertex(sideray_ready_program program);
const char* ready_fragment(sideray_ready_program program);

}  // namespace sideray::bridge
