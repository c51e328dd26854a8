// Writes opaque and masked surfaces into the G-buffer, so that raster_light.frag.glsl can restore the SrSurface.
// SR_HOLES: fragments may be absent. With a thin film anywhere, f0 and f90 are those of the whole base.
layout(location = 0) out vec4 o_albedo_metallic;
layout(location = 1) out vec4 o_normal_roughness;
layout(location = 2) out vec4 o_emissive_occlusion;
layout(location = 3) out vec4 o_specular;  // dielectric f0, and f90; f90 -1 = unlit
#if (SR_LOBES & 16) != 0
layout(location = 4) out uvec4 o_ids;  // also direction (octahedral) and strength of anisotropy
#else
layout(location = 4) out uvec2 o_ids;      // surface id, triangle + 1
#endif
#if (SR_LOBES & 1) != 0
layout(location = 5) out vec4 o_coat;  // normal times coat, roughness
#endif
#if (SR_LOBES & 2) != 0
layout(location = 6) out vec4 o_sheen;  // colour, roughness
#endif
#if (SR_LOBES & 4) != 0
layout(location = 7) out vec4 o_behind;  // colour, and the share of the diffuse part
#endif

flat in uint v_surface_id;
#if (SR_LOBES & 24) != 0
in vec3 v_position;
uniform vec3 eye;
uniform vec3 toward_eye;  // orthographic
uniform bool orthographic;
#endif

const float largest_half = 65504.0;

#if (SR_LOBES & 16) != 0
// Encodes direction and strength of sr_brushed(), as brushed_of() reads them.
uvec2 brush_bits(SrSurface s) {
  if (s.anisotropy <= 0.0) return uvec2(0u);
  vec3 d = s.along / (abs(s.along.x) + abs(s.along.y) + abs(s.along.z));
  vec2 turned = (1.0 - abs(d.yx)) * vec2(d.x < 0.0 ? -1.0 : 1.0, d.y < 0.0 ? -1.0 : 1.0);
  uvec2 codes = uvec2(((d.z < 0.0 ? turned : d.xy) * 0.5 + 0.5) * 65535.0 + 0.5);
  return uvec2(codes.x | codes.y << 16, floatBitsToUint(s.anisotropy));
}
#endif

void main() {
  vec4 base_color = base_color_texel();
  SrMaterial m = surface_material();
  SrTexels texels = surface_texels(base_color);
  vec3 normal = surface_normal(), coat_normal = surface_coat_normal();
#ifdef SR_HOLES
  if (is_absent(base_color)) discard;
#endif
  SrSurface s = sr_surface(m, texels, normal, coat_normal);
#if (SR_LOBES & 24) != 0
  vec3 to_eye = orthographic ? toward_eye : normalize(eye - v_position);
#endif
#if (SR_LOBES & 8) != 0
  SrSurface base = sr_filmed(sr_facing(s, to_eye), m, texels, to_eye);
#else
  // With metallic 0, f0 and f90 are those of the dielectric part only.
  SrTexels dielectric_texels = texels;
  dielectric_texels.metallic = 0.0;
  SrSurface base = sr_surface(m, dielectric_texels, normal, normal);
#endif
  o_albedo_metallic = vec4(min(s.albedo, vec3(largest_half)), s.metallic);
  o_normal_roughness = vec4(normal, s.roughness);
  o_emissive_occlusion = vec4(min(s.emissive, vec3(largest_half)), s.occlusion);
  o_specular = vec4(base.f0, m.unlit ? -1.0 : base.f90.x);
#if (SR_LOBES & 16) != 0
  o_ids = uvec4(v_surface_id, uint(gl_PrimitiveID) + 1u, brush_bits(brushed_surface(sr_facing(s, to_eye), m, texels)));
#else
  o_ids = uvec2(v_surface_id, uint(gl_PrimitiveID) + 1u);
#endif
#if (SR_LOBES & 1) != 0
  o_coat = vec4(s.coat_normal * s.coat, s.coat_roughness);
#endif
#if (SR_LOBES & 2) != 0
  o_sheen = vec4(s.sheen, s.sheen_roughness);
#endif
#if (SR_LOBES & 4) != 0
  o_behind = vec4(s.behind, sr_saturate(m.diffuse_transmission * texels.diffuse_transmission));
#endif
}
