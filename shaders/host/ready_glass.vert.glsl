#version 120
// Glass of a host without shaders: computes the fixed function's lighting and the world position.
uniform mat4 sideray_world_from_eye;
uniform int sideray_lights;         // GL_LIGHT0 to this many are enabled; 0 = no lighting, glColor is the colour
uniform int sideray_follows_color;  // GL_COLOR_MATERIAL: bits of SIDERAY_FOLLOW_*; 0 = off
uniform int sideray_local_viewer;   // GL_LIGHT_MODEL_LOCAL_VIEWER
varying vec3 sideray_position;

bool sideray_follows(int bit) { return mod(floor(float(sideray_follows_color) / float(bit)), 2.0) > 0.5; }

// Returns the attenuation of a light by distance and cone.
float sideray_fade(int i, vec3 to_light, float d) {
  if (gl_LightSource[i].position.w == 0.0) return 1.0;
  float fade = 1.0 / (gl_LightSource[i].constantAttenuation + gl_LightSource[i].linearAttenuation * d +
                      gl_LightSource[i].quadraticAttenuation * d * d);
  if (gl_LightSource[i].spotCutoff >= 180.0) return fade;
  float along = -dot(to_light, normalize(gl_LightSource[i].spotDirection));
  if (along < gl_LightSource[i].spotCosCutoff) return 0.0;
  return gl_LightSource[i].spotExponent > 0.0 ? fade * pow(max(along, 0.0), gl_LightSource[i].spotExponent) : fade;
}

vec4 sideray_lit(vec3 eye, vec3 normal) {
  vec4 diffuse = sideray_follows(2) ? gl_Color : gl_FrontMaterial.diffuse;
  vec3 ambient = sideray_follows(1) ? gl_Color.rgb : gl_FrontMaterial.ambient.rgb;
  vec3 specular = sideray_follows(4) ? gl_Color.rgb : gl_FrontMaterial.specular.rgb;
  vec3 sum = (sideray_follows(8) ? gl_Color.rgb : gl_FrontMaterial.emission.rgb) + ambient * gl_LightModel.ambient.rgb;
  vec3 to_viewer = sideray_local_viewer != 0 ? -normalize(eye) : vec3(0.0, 0.0, 1.0);
  for (int i = 0; i < 8; ++i) {
    if (i >= sideray_lights) break;
    vec4 place = gl_LightSource[i].position;
    vec3 to_light = place.w == 0.0 ? place.xyz : place.xyz / place.w - eye;
    float d = length(to_light);
    to_light /= d;
    float toward = dot(normal, to_light);
    vec3 light = gl_LightSource[i].ambient.rgb * ambient + gl_LightSource[i].diffuse.rgb * diffuse.rgb * max(toward, 0.0);
    float shine = max(dot(normal, normalize(to_light + to_viewer)), 0.0);
    if (toward > 0.0) light += gl_LightSource[i].specular.rgb * specular * pow(shine, gl_FrontMaterial.shininess);
    sum += light * sideray_fade(i, to_light, d);
  }
  return vec4(clamp(sum, 0.0, 1.0), diffuse.a);
}

void main() {
  vec4 eye = gl_ModelViewMatrix * gl_Vertex;
  gl_Position = ftransform();
  gl_TexCoord[0] = gl_TextureMatrix[0] * gl_MultiTexCoord0;
  gl_FrontColor = gl_Color;
  if (sideray_lights > 0) gl_FrontColor = sideray_lit(eye.xyz / eye.w, normalize(gl_NormalMatrix * gl_Normal));
  sideray_position = (sideray_world_from_eye * eye).xyz;
}
