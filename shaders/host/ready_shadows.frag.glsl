// Follows the snippet. For glBlendFunc(GL_DST_COLOR, GL_ZERO) without a depth test: multiplies the opaque picture.
uniform int sideray_light;      // index of the light in sideray_scene_set_lights
uniform vec3 sideray_in_shade;  // the ambient share of a surface's light, which shadows leave

void main() {
  gl_FragColor = vec4(mix(sideray_in_shade, vec3(1.0), sideray_shadow_color(sideray_light)) * sideray_ao(), 1.0);
}
