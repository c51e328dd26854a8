// Sideray's snippet: what a host's shaders include. See docs/embedding.md.
// It needs GLSL 1.30 or ES 3.00, or 1.20 with EXT_texture_array; in 1.20 surface ids are floats below 2^24
// (sideray_layer_inputs::float_ids). Define before it, where needed:
//   SIDERAY_MAX_LAYERS    1..8, if fewer than 8 layers are ever used
//   SIDERAY_DEBUG         fragments without an answer show a colour that says why
//   SIDERAY_MULTISAMPLED  glass is drawn multisampled, but the frame's source is resolved. (If the source is
//                         multisampled too, the service tells the snippet.)
#ifndef SIDERAY_GLSL
#define SIDERAY_GLSL 1
#include "snippet/base.glsl"
#include "snippet/fragment.glsl"
#include "snippet/layers.glsl"
#include "snippet/explain.glsl"
#include "snippet/glass.glsl"
#include "snippet/moving_glass.glsl"
#include "snippet/whole.glsl"
#include "snippet/masks.glsl"
#include "snippet/irradiance.glsl"
#include "snippet/moving_masks.glsl"
#endif
