// Opaque and masked surfaces into the G-buffer: what raster_light.frag.glsl needs to make the same SrSurface again.
layout(location = 0) out vec4 o_albedo_metallic;
layout(location = 1) out vec4 o_normal_roughness;
layout(location = 2) out vec4 o_emissive_occlusion;
layout(location = 3) out vec4 o_specular;  // dielectric f0, and f90; f90 -1 = unlit
layout(location = 4) out uvec2 o_ids;      // surface id, triangle + 1

flat in uint v_surface_id;

const float largest_half = 65504.0;

void main() {
  vec4 base_color = base_color_texel();
  SrMaterial m = surface_material();
  SrTexels texels = surface_texels(base_color);
  vec3 normal = surface_normal();
  if (is_absent(base_color)) discard;
  SrSurface s = sr_surface(m, texels, normal, normal);
  // With metallic 0, f0 and f90 are those of the dielectric part alone.
  SrTexels dielectric_texels = texels;
  dielectric_texels.metallic = 0.0;
  SrSurface dielectric = sr_surface(m, dielectric_texels, normal, normal);
  o_albedo_metallic = vec4(min(s.albedo, vec3(largest_half)), s.metallic);
  o_normal_roughness = vec4(normal, s.roughness);
  o_emissive_occlusion = vec4(min(s.emissive, vec3(largest_half)), s.occlusion);
  o_specular = vec4(dielectric.f0, m.unlit ? -1.0 : dielectric.f90.x);
  o_ids = uvec2(v_surface_id, uint(gl_PrimitiveID) + 1u);
}
