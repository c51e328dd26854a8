#include "preload/capture/draw_state.h"

#include <cstring>

#include "preload/gl/functions.h"

namespace sideray::run {
namespace {

bool is_identity(const Matrix& m) {
  for (size_t i = 0; i < 16; ++i)
    if (m[i] != (i % 5 == 0 ? 1.0f : 0.0f)) return false;
  return true;
}

std::shared_ptr<const TextureCoordinates> read_coordinates() {
  const Functions& gl = real();
  TextureCoordinates read;
  gl.GetFloatv(GL_TEXTURE_MATRIX, read.matrix.data());
  bool changes = !is_identity(read.matrix);
  for (GLenum c = 0; c < 4; ++c) {
    read.generated[c] = is_enabled(GL_TEXTURE_GEN_S + c);
    if (!read.generated[c]) continue;
    changes = true;
    GLint mode = 0;
    gl.GetTexGeniv(GL_S + c, GL_TEXTURE_GEN_MODE, &mode);
    read.mode[c] = static_cast<GLenum>(mode);
    gl.GetTexGenfv(GL_S + c, GL_OBJECT_PLANE, read.object_plane[c]);
    gl.GetTexGenfv(GL_S + c, GL_EYE_PLANE, read.eye_plane[c]);
  }
  return changes ? std::make_shared<const TextureCoordinates>(read) : nullptr;
}

void read_texture(TextureUnit& unit) {
  unit.texture = static_cast<GLuint>(get_integer(GL_TEXTURE_BINDING_2D));
  GLint environment = GL_MODULATE;
  real().GetTexEnviv(GL_TEXTURE_ENV, GL_TEXTURE_ENV_MODE, &environment);
  unit.replaces = environment == GL_REPLACE || environment == GL_DECAL;
  unit.coordinates = read_coordinates();
}

void read_fog(Fog& fog) {
  const Functions& gl = real();
  fog.on = is_enabled(GL_FOG);
  if (!fog.on) return;
  fog.mode = get_integer(GL_FOG_MODE);
  gl.GetFloatv(GL_FOG_DENSITY, &fog.density);
  gl.GetFloatv(GL_FOG_START, &fog.start);
  gl.GetFloatv(GL_FOG_END, &fog.end);
  gl.GetFloatv(GL_FOG_COLOR, fog.color);
}

void read_texture_units(DrawState& state) {
  const Functions& gl = real();
  const GLint active = get_integer(GL_ACTIVE_TEXTURE);
  for (int i = 0; i < texture_units(); ++i) {
    const GLenum name = GL_TEXTURE0 + static_cast<GLenum>(i);
    if (active != static_cast<GLint>(name)) gl.ActiveTexture(name);
    TextureUnit& unit = state.units[static_cast<size_t>(i)];
    unit.textured = is_enabled(GL_TEXTURE_2D);
    if (unit.textured) read_texture(unit);
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

int DrawState::unit_of_layer(int layer) const {
  for (const bool plain : {true, false})
    for (int i = 0; i < kept_units; ++i) {
      const TextureUnit& unit = units[static_cast<size_t>(i)];
      if (unit.texture != 0 && plain == !unit.coordinates && layer-- == 0) return i;
    }
  return -1;
}

Counted DrawState::counted() const {
  Counted counted = {shows_colors(), lighting, 0};
  for (unsigned i = 0; i < kept_units; ++i)
    if (units[i].textured) counted.units |= 1u << i, counted.normals = counted.normals || units[i].coordinates;
  return counted;
}

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
  GLfloat range[2] = {0, 1};
  gl.GetFloatv(GL_DEPTH_RANGE, range);
  state.whole_depth_range = range[0] == 0 && range[1] == 1;
  state.stencil_test = is_enabled(GL_STENCIL_TEST);
  state.alpha_test = is_enabled(GL_ALPHA_TEST);
  if (state.alpha_test) gl.GetFloatv(GL_ALPHA_TEST_REF, &state.alpha_reference);
  GLboolean mask[4] = {};
  gl.GetBooleanv(GL_COLOR_WRITEMASK, mask);
  state.writes_color = mask[0] || mask[1] || mask[2];
  read_texture_units(state);
  state.lighting = is_enabled(GL_LIGHTING);
  state.color_material = state.lighting && is_enabled(GL_COLOR_MATERIAL);
  if (state.lighting) read_material(state.material);
  read_fog(state.fog);
  float color[4] = {1, 1, 1, 1};
  gl.GetFloatv(GL_CURRENT_COLOR, color);
  state.alpha = state.shows_colors() ? color[3] : state.material.diffuse[3];
  return state;
}

std::shared_ptr<const Lighting> read_lighting() {
  static std::shared_ptr<const Lighting>& last = *new std::shared_ptr<const Lighting>;  // programs draw until they exit
  const Functions& gl = real();
  Lighting lighting;
  for (GLenum i = 0; i < 8; ++i) {
    if (!is_enabled(GL_LIGHT0 + i)) continue;
    lighting.number[lighting.lights] = static_cast<GLint>(i);
    read_light(GL_LIGHT0 + i, lighting.light[lighting.lights++]);
  }
  gl.GetFloatv(GL_LIGHT_MODEL_AMBIENT, lighting.scene_ambient);
  lighting.local_viewer = get_integer(GL_LIGHT_MODEL_LOCAL_VIEWER);
  if (!last || std::memcmp(last.get(), &lighting, sizeof(lighting)) != 0) last = std::make_shared<const Lighting>(lighting);
  return last;
}

}  // namespace sideray::run
