// Behind the snippet. For glBlendFunc(GL_DST_COLOR, GL_ZERO) and no depth test: the opaque picture is multiplied.
uniform int sideray_light;      // the light's place in sideray_scene_set_lights
uniform vec3 sideray_in_shade;  // what is left of a surface there: its ambient share

void main() {
  gl_FragColor = vec4(mix(sideray_in_shade, vec3(1.0), sideray_shadow_color(sideray_light)) * sideray_ao(), 1.0);
}
