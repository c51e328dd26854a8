// Samples the opaque picture as seen through a surface that bends or blurs light: where the refracted ray leaves a body
// of the material's thickness, in a mip level that matches the roughness.
uniform mat4 clip_from_local;
uniform sampler2D opaque_levels;

// Returns the mip level that is about as blurred as the surface makes the picture: the last one at a roughness of 1. A
// body with an index of 1 blurs nothing.
float level_of(SrSurface s, SrMaterial m, bool is_body) {
  float levels = log2(float(textureSize(opaque_levels, 0).y));
  return levels * s.roughness * (is_body ? clamp(2.0 * m.ior - 2.0, 0.0, 1.0) : 1.0);
}

// Returns where the refracted ray is seen to leave the body, 0..1 in the picture.
vec2 aside(SrSurface s, vec3 position, vec3 to_eye, float thickness, float ior) {
  vec3 way = thickness > 0.0 ? refract(-to_eye, s.normal, 1.0 / ior) * thickness : vec3(0.0);
  vec4 clip = clip_from_local * vec4(position + way, 1.0);
  return clip.w > 0.0 ? clip.xy / clip.w * 0.5 + 0.5 : gl_FragCoord.xy / vec2(textureSize(opaque_levels, 0));
}

// Returns the colour there minus the colour straight behind the surface: the difference keeps what is blended between
// the surface and the opaque picture, which that picture does not contain. The index for red is lower than the
// material's by `spread`, that for blue higher.
vec3 seen_aside(SrMaterial m, SrTexels t, SrSurface s, vec3 position, vec3 to_eye, float spread) {
  float thickness = m.thickness > 0.0 ? m.thickness * t.thickness : 0.0;
  vec3 straight = texelFetch(opaque_levels, ivec2(gl_FragCoord.xy), 0).rgb;
  // Smooth surfaces have the roughness 0.04.
  float level = s.roughness > 0.04 ? level_of(s, m, m.thickness > 0.0) : 0.0;
  vec3 seen = textureLod(opaque_levels, aside(s, position, to_eye, thickness, m.ior), level).rgb;
  if (spread > 0.0 && thickness > 0.0) {
    seen.r = textureLod(opaque_levels, aside(s, position, to_eye, thickness, max(m.ior - spread, 1.0)), level).r;
    seen.b = textureLod(opaque_levels, aside(s, position, to_eye, thickness, m.ior + spread), level).b;
  }
  return seen - straight;
}
