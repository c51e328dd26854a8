// The retrofit's shaders in GLSL 1.30; sideray_glsl(130) goes between the #version line and these.
#pragma once

// Draws glass as the fixed function did (its lit colour plus the sphere map), or by rays where they have an answer.
// Vertices stay with the fixed function: unit 1 generates world positions.
inline constexpr char glass_fragment[] = R"(
uniform sampler2D sheen;
uniform uint surface;
void main() {
  vec3 raster = min(gl_Color.rgb + texture2D(sheen, gl_TexCoord[0].st).rgb, 1.0);
  gl_FragColor = vec4(sideray_translucent(raster, gl_TexCoord[1].xyz, surface), gl_Color.a);
}
)";

// Multiplies the opaque picture by the share of light that is left where the sun is occluded. The fixed function has no
// normals to read: they come from a copy of the depth buffer.
inline constexpr char shadow_vertex[] = "#version 130\nvoid main() { gl_Position = gl_Vertex; }\n";
inline constexpr char shadow_fragment[] = R"(
uniform sampler2D depth;
uniform mat4 world_from_clip;
uniform vec3 toward_sun, sun, ambient;
uniform bool late;  // the masks are of an older frame: found where that saw the surface, as long as it stands still
vec3 position(ivec2 pixel) {
  vec3 window = vec3(vec2(pixel) + 0.5, texelFetch(depth, pixel, 0).x) / vec3(textureSize(depth, 0), 1.0);
  vec4 p = world_from_clip * vec4(2.0 * window - 1.0, 1.0);
  return p.xyz / p.w;
}
// Along one axis of the picture, on the side where the surface goes on.
vec3 along(ivec2 pixel, ivec2 step, vec3 here) {
  vec3 ahead = position(pixel + step) - here, behind = here - position(pixel - step);
  return dot(ahead, ahead) < dot(behind, behind) ? ahead : behind;
}
void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec3 here = position(pixel);
  vec3 normal = cross(along(pixel, ivec2(1, 0), here), along(pixel, ivec2(0, 1), here));
  normal *= inversesqrt(max(dot(normal, normal), 1e-30));
  float hidden = 1.0 - (late ? sideray_shadow_at(sideray_find_masks_on(here, normal), 0) : sideray_shadow(0));
  if (hidden == 0.0) discard;
  vec3 sunlight = sun * max(dot(normal, toward_sun), 0.0);
  gl_FragColor = vec4(1.0 - sunlight * hidden / (ambient + sunlight), 1.0);
}
)";
