// The text of sideray.glsl for hosts. Any thread, no context.
#pragma once

namespace sideray::bridge {

// Zero-terminated, valid for ever; null below GLSL 1.30.
const char* snippet_text(int glsl_version);

}  // namespace sideray::bridge
