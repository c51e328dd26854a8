// What is seen through a surface that bends or blurs light, as far as the picture of what is opaque shows it: where the
// refracted ray leaves a body of the material's thickness, and in the level that is as coarse as the surface is rough.
uniform mat4 clip_from_local;
uniform sampler2D opaque_levels;

// The level of a picture that is about as blurred as the surface makes it: the whole picture at a roughness of 1. With an
// index of 1 a body blurs nothing.
float level_of(SrSurface s, SrMaterial m, bool is_body) {
  float levels = log2(float(textureSize(opaque_levels, 0).y));
  return levels * s.roughness * (is_body ? clamp(2.0 * m.ior - 2.0, 0.0, 1.0) : 1.0);
}

// What is seen there less what is seen straight through, where the surface stands: the difference leaves in place what is
// blended between the surface and the opaque picture, which the picture does not hold.
vec3 seen_aside(SrMaterial m, SrTexels t, SrSurface s, vec3 position, vec3 to_eye) {
  float thickness = m.thickness * t.thickness;
  vec3 way = m.thickness > 0.0 ? refract(-to_eye, s.normal, 1.0 / m.ior) * thickness : vec3(0.0);
  vec4 clip = clip_from_local * vec4(position + way, 1.0);
  vec2 size = vec2(textureSize(opaque_levels, 0));
  vec2 at = clip.w > 0.0 ? clip.xy / clip.w * 0.5 + 0.5 : gl_FragCoord.xy / size;
  vec3 straight = texelFetch(opaque_levels, ivec2(gl_FragCoord.xy), 0).rgb;
  // The roughness of what is taken for smooth is 0.04.
  float level = s.roughness > 0.04 ? level_of(s, m, m.thickness > 0.0) : 0.0;
  return textureLod(opaque_levels, at, level).rgb - straight;
}
