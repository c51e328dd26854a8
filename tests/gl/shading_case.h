// One evaluation of every step of shading.h from 31 given vectors, in the same dialect: the parity test compiles this
// text as GLSL and as C++.
struct ShadingResult {
  real4 reflected_faces;
  real4 environment_cover;
  real4 through_alpha;
  real4 irradiance_below_sheen;
  real4 to_light_distance;
  real4 emitted_coat_share;
  real4 perturbed;
  real4 latlong_dominant;
};

SR_FN real3 sr_xyz(real4 v) {
  return real3(v.x, v.y, v.z);
}

SR_FN SrMaterial sr_case_material(real4 t[31]) {
  SrMaterial m;
  m.base_color = t[0];
  m.emissive = sr_xyz(t[1]);
  m.metallic = t[1].w;
  m.specular_color = sr_xyz(t[2]);
  m.roughness = t[2].w;
  m.absorption = sr_xyz(t[3]);
  m.transmission = t[3].w;
  m.ior = t[4].x;
  m.thickness = t[4].y;
  m.specular = t[4].z;
  m.clearcoat = t[4].w;
  m.clearcoat_roughness = t[5].x;
  m.sheen_roughness = t[5].y;
  m.diffuse_transmission = t[5].z;
  m.alpha_mode = int(t[5].w);
  m.sheen_color = sr_xyz(t[6]);
  m.unlit = t[6].w > 0.5f;
  m.diffuse_transmission_color = sr_xyz(t[7]);
  m.iridescence = t[15].w;
  m.iridescence_ior = t[16].w;
  m.iridescence_thickness_min = t[17].w;
  m.iridescence_thickness_max = t[18].w;
  m.anisotropy = t[8].w;
  m.anisotropy_cosine = t[28].x;
  m.anisotropy_sine = t[28].y;
  return m;
}

SR_FN SrTexels sr_case_texels(real4 t[31]) {
  SrTexels x;
  x.base_color = t[8];
  x.emissive = sr_xyz(t[9]);
  x.metallic = t[9].w;
  x.roughness = t[10].x;
  x.occlusion = t[10].y;
  x.transmission = t[10].z;
  x.thickness = t[10].w;
  x.specular_color = sr_xyz(t[11]);
  x.specular = t[11].w;
  x.clearcoat = t[12].x;
  x.clearcoat_roughness = t[12].y;
  x.sheen_roughness = t[12].z;
  x.diffuse_transmission = t[12].w;
  x.sheen_color = sr_xyz(t[13]);
  x.diffuse_transmission_color = sr_xyz(t[14]);
  x.iridescence = t[27].w;
  x.iridescence_thickness = t[30].w;
  x.anisotropy_along = t[29].x;
  x.anisotropy_across = t[29].y;
  x.anisotropy = t[13].w;
  return x;
}

SR_FN SrLight sr_case_light(real4 t[31]) {
  SrLight light;
  light.position = sr_xyz(t[19]);
  light.range = t[19].w;
  light.direction = sr_xyz(t[20]);
  light.cos_inner = t[20].w;
  light.intensity = sr_xyz(t[21]);
  light.cos_outer = t[21].w;
  light.type = int(t[22].w);
  return light;
}

SR_FN ShadingResult sr_evaluate(real4 t[31]) {
  real3 to_eye = sr_xyz(t[17]);
  real3 to_light = sr_xyz(t[18]);
  SrMaterial m = sr_case_material(t);
  SrTexels texels = sr_case_texels(t);
  SrSurface s = sr_surface(m, texels, sr_xyz(t[15]), sr_xyz(t[16]));
  s = sr_filmed(sr_brushed(s, m, texels, sr_xyz(t[15]), t[28]), m, texels, to_eye);
  real2 terms = sr_brushed_terms(s, real2(t[23].w, t[24].w), real2(t[24].w, sr_round_cosine(s, to_eye)));
  s = sr_seen(s, to_eye, terms, t[25].w);
  SrSurroundings around;
  around.irradiance = sr_xyz(t[23]);
  around.behind = sr_xyz(t[24]);
  around.specular = sr_xyz(t[25]);
  around.coat = sr_xyz(t[26]);
  SrBlend blend = sr_blend(s, to_eye, int(t[7].w));
  SrIncidence incidence = sr_incidence(sr_case_light(t), sr_xyz(t[22]));
  real2 uv = sr_latlong(sr_xyz(t[30]));
  ShadingResult r;
  r.reflected_faces = real4(sr_reflect_light(s, to_eye, to_light), sr_select(sr_faces(s, to_light), 1.0f, 0.0f));
  r.environment_cover = real4(sr_environment(s, t[26].w, around), blend.cover);
  r.through_alpha = real4(blend.through, s.alpha);
  r.irradiance_below_sheen = real4(incidence.irradiance, s.below_sheen);
  r.to_light_distance = real4(incidence.to_light, incidence.distance);
  r.emitted_coat_share = real4(sr_emitted(s), s.coat_share);
  r.perturbed = real4(sr_perturb(sr_xyz(t[27]), t[28], sr_xyz(t[29]), t[29].w), 1.0f);
  real3 bent = sr_bent(s, to_eye);
  real3 dominant = sr_dominant(bent, reflect(-to_eye, bent), sr_round_roughness(s));
  r.latlong_dominant = real4(uv, dominant.x, dominant.y);
  return r;
}
