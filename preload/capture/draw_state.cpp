#include "preload/capture/draw_state.h"

#include "preload/gl/functions.h"

namespace sideray::run {
namespace {

void read_texture_units(DrawState& state) {
  const Functions& gl = real();
  const GLint active = get_integer(GL_ACTIVE_TEXTURE);
  for (int unit = 0; unit < 2; ++unit) {
    const GLenum name = GL_TEXTURE0 + static_cast<GLenum>(unit);
    if (active != static_cast<GLint>(name)) gl.ActiveTexture(name);
    state.textured[unit] = is_enabled(GL_TEXTURE_2D);
    if (state.textured[unit]) state.texture[unit] = static_cast<GLuint>(get_integer(GL_TEXTURE_BINDING_2D));
    if (unit == 0) state.generated_uv = state.textured[0] && is_enabled(GL_TEXTURE_GEN_S);
    if (active != static_cast<GLint>(name)) gl.ActiveTexture(static_cast<GLenum>(active));
  }
}

void read_material(DrawMaterial& material) {
  const Functions& gl = real();
  gl.GetMaterialfv(GL_FRONT, GL_AMBIENT, material.ambient);
  gl.GetMaterialfv(GL_FRONT, GL_DIFFUSE, material.diffuse);
  gl.GetMaterialfv(GL_FRONT, GL_SPECULAR, material.specular);
  gl.GetMaterialfv(GL_FRONT, GL_EMISSION, material.emission);
  gl.GetMaterialfv(GL_FRONT, GL_SHININESS, &material.shininess);
}

void read_light(GLenum name, FixedLight& light) {
  const Functions& gl = real();
  gl.GetLightfv(name, GL_AMBIENT, light.ambient);
  gl.GetLightfv(name, GL_DIFFUSE, light.diffuse);
  gl.GetLightfv(name, GL_SPECULAR, light.specular);
  gl.GetLightfv(name, GL_POSITION, light.position);
  gl.GetLightfv(name, GL_SPOT_DIRECTION, light.spot_direction);
  gl.GetLightfv(name, GL_SPOT_EXPONENT, &light.spot_exponent);
  gl.GetLightfv(name, GL_SPOT_CUTOFF, &light.spot_cutoff);
  gl.GetLightfv(name, GL_CONSTANT_ATTENUATION, &light.attenuation[0]);
  gl.GetLightfv(name, GL_LINEAR_ATTENUATION, &light.attenuation[1]);
  gl.GetLightfv(name, GL_QUADRATIC_ATTENUATION, &light.attenuation[2]);
}

}  // namespace

DrawState read_draw_state() {
  const Functions& gl = real();
  DrawState state;
  gl.GetFloatv(GL_PROJECTION_MATRIX, state.projection.data());
  gl.GetFloatv(GL_MODELVIEW_MATRIX, state.modelview.data());
  gl.GetIntegerv(GL_VIEWPORT, state.viewport.data());
  if (gl.BindFramebuffer) state.framebuffer = get_integer(GL_FRAMEBUFFER_BINDING);
  state.blend = is_enabled(GL_BLEND);
  state.blend_source = static_cast<GLenum>(get_integer(GL_BLEND_SRC));
  state.blend_target = static_cast<GLenum>(get_integer(GL_BLEND_DST));
  state.depth_test = is_enabled(GL_DEPTH_TEST);
  state.depth_write = get_integer(GL_DEPTH_WRITEMASK) != 0;
  state.depth_func = static_cast<GLenum>(get_integer(GL_DEPTH_FUNC));
  state.alpha_test = is_enabled(GL_ALPHA_TEST);
  if (state.alpha_test) gl.GetFloatv(GL_ALPHA_TEST_REF, &state.alpha_reference);
  GLboolean mask[4] = {};
  gl.GetBooleanv(GL_COLOR_WRITEMASK, mask);
  state.writes_color = mask[0] || mask[1] || mask[2];
  read_texture_units(state);
  state.lighting = is_enabled(GL_LIGHTING);
  state.color_material = state.lighting && is_enabled(GL_COLOR_MATERIAL);
  if (state.lighting) read_material(state.material);
  float color[4] = {1, 1, 1, 1};
  gl.GetFloatv(GL_CURRENT_COLOR, color);
  state.alpha = state.shows_colors() ? color[3] : state.material.diffuse[3];
  return state;
}

Lighting read_lighting() {
  const Functions& gl = real();
  Lighting lighting;
  for (GLenum i = 0; i < 8; ++i)
    if (is_enabled(GL_LIGHT0 + i)) read_light(GL_LIGHT0 + i, lighting.light[lighting.lights++]);
  gl.GetFloatv(GL_LIGHT_MODEL_AMBIENT, lighting.scene_ambient);
  lighting.two_sided = get_integer(GL_LIGHT_MODEL_TWO_SIDE);
  lighting.local_viewer = get_integer(GL_LIGHT_MODEL_LOCAL_VIEWER);
  return lighting;
}

}  // namespace sideray::run
