// Resolves the G-buffer: lights opaque surfaces, and shows the sky elsewhere.
layout(location = 0) out vec4 o_color;

uniform sampler2D gbuffer_albedo_metallic;
uniform sampler2D gbuffer_normal_roughness;
uniform sampler2D gbuffer_emissive_occlusion;
uniform sampler2D gbuffer_specular;
#if (SR_LOBES & 1) != 0
uniform sampler2D gbuffer_coat;
#endif
#if (SR_LOBES & 2) != 0
uniform sampler2D gbuffer_sheen;
#endif
#if (SR_LOBES & 4) != 0
uniform sampler2D gbuffer_behind;
#endif
#if (SR_LOBES & 16) != 0
uniform usampler2D gbuffer_ids;
#endif
uniform sampler2D gbuffer_depth;

// A view ray at normalized device coordinates (x, y) is origin + t * ray, t the distance along the view axis. With
// along_from_depth = (a, b), a * window depth + b is t (orthographic) or 1 / t (perspective).
uniform vec3 ray_origin, ray_origin_x, ray_origin_y;
uniform vec3 ray, ray_x, ray_y;
uniform vec2 along_from_depth;
uniform float depth_of_nothing;
uniform vec2 pixel_size;  // in normalized device coordinates

#if (SR_LOBES & 16) != 0
// Reads direction and strength as brush_bits() wrote them; the direction is not yet perpendicular to the normal.
SrSurface brushed_of(SrSurface s, uvec2 bits) {
  vec2 code = vec2(bits.x & 0xffffu, bits.x >> 16) * (2.0 / 65535.0) - 1.0;
  vec3 d = vec3(code, 1.0 - abs(code.x) - abs(code.y));
  if (d.z < 0.0) d.xy = (1.0 - abs(code.yx)) * vec2(code.x < 0.0 ? -1.0 : 1.0, code.y < 0.0 ? -1.0 : 1.0);
  s.along = normalize(d);
  s.anisotropy = uintBitsToFloat(bits.y);
  return s;
}
#endif

SrSurface surface_at(ivec2 pixel) {
  vec4 albedo_metallic = texelFetch(gbuffer_albedo_metallic, pixel, 0);
  vec4 normal_roughness = texelFetch(gbuffer_normal_roughness, pixel, 0);
  vec4 emissive_occlusion = texelFetch(gbuffer_emissive_occlusion, pixel, 0);
  vec4 specular = texelFetch(gbuffer_specular, pixel, 0);
  bool unlit = specular.w < 0.0;
  SrSurface s;
  s.normal = normalize(normal_roughness.xyz);
  s.albedo = albedo_metallic.xyz;
  s.metallic = albedo_metallic.w;
  s.diffuse = unlit ? vec3(0.0) : s.albedo * (1.0 - s.metallic);
#if (SR_LOBES & 8) != 0
  float of_metal = 0.0;  // the G-buffer holds f0 and f90 of the whole base
#else
  float of_metal = s.metallic;
#endif
  s.f0 = unlit ? vec3(0.0) : mix(specular.xyz, s.albedo, of_metal);
  s.f90 = unlit ? vec3(0.0) : vec3(mix(specular.w, 1.0, of_metal));
  s.emissive = emissive_occlusion.xyz;
  s.tint = vec3(0.0);
  s.alpha = 1.0;
  s.roughness = normal_roughness.w;
  s.occlusion = emissive_occlusion.w;
  s.behind = vec3(0.0);
  s.coat = 0.0;
  s.coat_roughness = 1.0;
  s.coat_normal = s.normal;
  s.sheen = vec3(0.0);
  s.sheen_roughness = 1.0;
  s.along = vec3(0.0);
  s.anisotropy = 0.0;
  s.coat_share = 0.0;
  s.below_sheen = 1.0;
  s.sheen_albedo = 0.0;
  s.albedo_terms = vec2(0.0);
#if (SR_LOBES & 1) != 0
  vec4 coat = texelFetch(gbuffer_coat, pixel, 0);
  s.coat = min(length(coat.xyz), 1.0);
  s.coat_normal = s.coat > 0.0 ? normalize(coat.xyz) : s.normal;
  s.coat_roughness = coat.w;
#endif
#if (SR_LOBES & 2) != 0
  vec4 sheen = texelFetch(gbuffer_sheen, pixel, 0);
  s.sheen = sheen.xyz;
  s.sheen_roughness = sheen.w;
#endif
#if (SR_LOBES & 4) != 0
  vec4 behind = texelFetch(gbuffer_behind, pixel, 0);
  s.behind = behind.xyz;
  s.diffuse *= 1.0 - behind.w;
#endif
#if (SR_LOBES & 16) != 0
  s = brushed_of(s, texelFetch(gbuffer_ids, pixel, 0).zw);
#endif
  return s;
}

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec2 ndc = gl_FragCoord.xy * pixel_size - 1.0;
  vec3 direction = ray + ray_x * ndc.x + ray_y * ndc.y;
  float depth = texelFetch(gbuffer_depth, pixel, 0).x;
  if (depth == depth_of_nothing) {
    o_color = vec4(textureLod(environment_specular, sr_latlong(normalize(direction)), 0.0).xyz, 0.0);
    return;
  }
  float along = depth * along_from_depth.x + along_from_depth.y;
  if (!orthographic) along = 1.0 / along;
  vec3 position = ray_origin + ray_origin_x * ndc.x + ray_origin_y * ndc.y + direction * along;
  vec3 to_eye = direction_to_eye(position);
  // As in the reference, opaque surfaces reflect the sky in every direction.
  o_color = vec4(radiance_from(seen(surface_at(pixel), to_eye), position, to_eye), 1.0);
}
