#version 120
// Glass of a host without shaders: what its fixed function lights, and where in the world that is.
uniform mat4 sideray_world_from_eye;
uniform int sideray_lights;  // GL_LIGHT0 to this many are enabled; 0 = no lighting, glColor counts. Spots shine all around
varying vec3 sideray_position;

vec4 sideray_lit(vec3 eye, vec3 normal) {
  vec3 sum = gl_FrontLightModelProduct.sceneColor.rgb;
  for (int i = 0; i < 8; ++i) {
    if (i >= sideray_lights) break;
    vec4 place = gl_LightSource[i].position;
    vec3 to_light = place.w == 0.0 ? place.xyz : place.xyz / place.w - eye;
    float d = length(to_light), fade = 1.0;
    to_light /= d;
    if (place.w != 0.0)
      fade = 1.0 / (gl_LightSource[i].constantAttenuation + gl_LightSource[i].linearAttenuation * d +
                    gl_LightSource[i].quadraticAttenuation * d * d);
    float toward = dot(normal, to_light);
    vec3 light = gl_FrontLightProduct[i].ambient.rgb + gl_FrontLightProduct[i].diffuse.rgb * max(toward, 0.0);
    float shine = max(dot(normal, normalize(to_light + vec3(0.0, 0.0, 1.0))), 0.0);  // an infinite viewer, the default
    if (toward > 0.0) light += gl_FrontLightProduct[i].specular.rgb * pow(shine, gl_FrontMaterial.shininess);
    sum += light * fade;
  }
  return vec4(clamp(sum, 0.0, 1.0), gl_FrontMaterial.diffuse.a);
}

void main() {
  vec4 eye = gl_ModelViewMatrix * gl_Vertex;
  gl_Position = ftransform();
  gl_TexCoord[0] = gl_TextureMatrix[0] * gl_MultiTexCoord0;
  gl_FrontColor = gl_Color;
  if (sideray_lights > 0) gl_FrontColor = sideray_lit(eye.xyz / eye.w, normalize(gl_NormalMatrix * gl_Normal));
  sideray_position = (sideray_world_from_eye * eye).xyz;
}
