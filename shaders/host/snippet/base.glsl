// Names that differ between versions of GLSL, the view that was traced, and distances in it.

#ifndef SIDERAY_MAX_LAYERS
#define SIDERAY_MAX_LAYERS 8
#endif

#ifdef GL_ES
precision highp float;
precision highp int;
precision highp sampler2DArray;
precision highp usampler2DArray;
#endif
#if __VERSION__ >= 130
#define SIDERAY_UINT uint
#define SIDERAY_NO_SURFACE 0u
#define SIDERAY_ID_SAMPLER usampler2DArray
#define SIDERAY_FETCH(texture, pixel, layer, size) texelFetch(texture, ivec3(pixel, layer), 0)
#define SIDERAY_FETCH_2D(texture, pixel, size) texelFetch(texture, pixel, 0)
#else
#define SIDERAY_UINT float
#define SIDERAY_NO_SURFACE 0.0
#define SIDERAY_ID_SAMPLER sampler2DArray
#define SIDERAY_FETCH(texture, pixel, layer, size) texture2DArray(texture, vec3((vec2(pixel) + 0.5) / (size), float(layer)))
#define SIDERAY_FETCH_2D(texture, pixel, size) texture2D(texture, (vec2(pixel) + 0.5) / (size))
#endif

uniform sampler2DArray sideray_radiance;
uniform sampler2DArray sideray_distance;
uniform SIDERAY_ID_SAMPLER sideray_surface_id;
uniform vec2 sideray_cache_size;   // pixels of the three above
uniform int sideray_layers;        // 0 = no answer anywhere
uniform vec4 sideray_viewport;     // pixel of gl_FragCoord.xy = xy * zw: origin and scale of the cache
uniform vec4 sideray_eye;          // xyz = eye (w = 1, perspective) or unit view direction (w = 0, orthographic)
uniform vec4 sideray_near_plane;   // xyz = unit view direction; orthographic: distance = dot(xyz, world_position) + w
uniform int sideray_rate;          // pixels that hold layers: 0 all, 1 a checkerboard, 2 every other row, 3 one of 2x2
// Maps (x, y, 1), a pixel of the cache, to a direction along its view ray (perspective) or a point of the near plane.
uniform mat3 sideray_ray_from_pixel;
uniform mat4 sideray_clip_from_world;  // of the view that the cache was traced for
uniform int sideray_match;         // SIDERAY_MATCH_*
uniform float sideray_match_threshold;  // SIDERAY_MATCH_DISTANCE: a share of the distance
uniform float sideray_subpixel;         // the most that rasterization moves a vertex along x or along y, in pixels
uniform int sideray_multisampled;       // the target has several samples a pixel

#define SIDERAY_MATCH_ID 0
#define SIDERAY_MATCH_NEAREST 1
#define SIDERAY_MATCH_DISTANCE 2

// Returns the distance of a world position along its view ray, as layers store it.
float sideray_distance_to(vec3 world_position) {
  return sideray_eye.w > 0.5 ? distance(world_position, sideray_eye.xyz)
                             : dot(sideray_near_plane.xyz, world_position) + sideray_near_plane.w;
}

float sideray_largest(vec3 v) { return max(max(abs(v.x), abs(v.y)), abs(v.z)); }

// Returns a bound on the rounding of a distance d.
float sideray_rounding(vec3 world_position, float d) {
  float coordinates = max(sideray_largest(world_position), sideray_largest(sideray_eye.xyz));
  return max(d, 0.25 * coordinates) * 2.384e-7;  // 2^-22
}

bool sideray_has_samples() {
#ifdef SIDERAY_MULTISAMPLED
  return true;
#else
  return sideray_multisampled != 0;
#endif
}

ivec2 sideray_pixel() {
  return ivec2(floor((gl_FragCoord.xy - sideray_viewport.xy) * sideray_viewport.zw));
}

bool sideray_is_even(int i) { return mod(float(i), 2.0) < 0.5; }

bool sideray_is_within(ivec2 pixel, vec2 size) {
  return all(greaterThanEqual(pixel, ivec2(0))) && all(lessThan(vec2(pixel), size));
}
