#include "preload/gl/saved_state.h"

#include <array>

#include "preload/gl/functions.h"

namespace sideray::run {
namespace {

constexpr std::array<GLenum, 19> switches = {
    GL_ALPHA_TEST, GL_BLEND, GL_COLOR_LOGIC_OP, GL_COLOR_MATERIAL, GL_CULL_FACE, GL_DEPTH_TEST, GL_DITHER,
    GL_FOG, GL_LIGHTING, GL_LINE_SMOOTH, GL_LINE_STIPPLE, GL_NORMALIZE, GL_RESCALE_NORMAL, GL_POINT_SMOOTH,
    GL_POLYGON_OFFSET_FILL, GL_POLYGON_SMOOTH, GL_POLYGON_STIPPLE, GL_SCISSOR_TEST, GL_STENCIL_TEST};
constexpr std::array<GLenum, 4> coordinate = {GL_S, GL_T, GL_R, GL_Q};
constexpr std::array<GLenum, 8> combine = {GL_COMBINE_RGB, GL_COMBINE_ALPHA, GL_SOURCE0_RGB,   GL_SOURCE1_RGB,
                                           GL_SOURCE0_ALPHA, GL_SOURCE1_ALPHA, GL_OPERAND0_RGB, GL_OPERAND1_RGB};
constexpr std::array<GLenum, 4> blending = {GL_BLEND_SRC_RGB, GL_BLEND_DST_RGB, GL_BLEND_SRC_ALPHA, GL_BLEND_DST_ALPHA};
constexpr std::array<GLenum, 7> stencil = {GL_STENCIL_FUNC, GL_STENCIL_REF, GL_STENCIL_VALUE_MASK, GL_STENCIL_WRITEMASK,
                                           GL_STENCIL_FAIL, GL_STENCIL_PASS_DEPTH_FAIL, GL_STENCIL_PASS_DEPTH_PASS};
constexpr std::array<GLenum, 3> attenuation = {GL_CONSTANT_ATTENUATION, GL_LINEAR_ATTENUATION, GL_QUADRATIC_ATTENUATION};
constexpr std::array<GLfloat, 16> unchanged = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

void set(GLenum name, bool on) {
  if (on)
    real().Enable(name);
  else
    real().Disable(name);
}

void load_matrix(GLenum mode, const GLfloat* matrix) {
  real().MatrixMode(mode);
  real().LoadMatrixf(matrix);
}

GLenum unit_name(int unit) {
  return GL_TEXTURE0 + static_cast<GLenum>(unit);
}

GLenum as_enum(GLint value) {
  return static_cast<GLenum>(value);
}

}  // namespace

SavedState SavedState::read() {
  const Functions& gl = real();
  SavedState s;
  for (const GLenum name : switches) s.enabled_.push_back(gl.IsEnabled(name) == GL_TRUE);
  gl.GetFloatv(GL_MODELVIEW_MATRIX, s.modelview_);
  gl.GetFloatv(GL_PROJECTION_MATRIX, s.projection_);
  gl.GetFloatv(GL_CURRENT_COLOR, s.color_);
  gl.GetFloatv(GL_CURRENT_NORMAL, s.normal_);
  gl.GetIntegerv(GL_ACTIVE_TEXTURE, &s.active_unit_);
  gl.GetIntegerv(GL_ALPHA_TEST_FUNC, &s.alpha_func_);
  gl.GetFloatv(GL_ALPHA_TEST_REF, &s.alpha_reference_);
  for (size_t i = 0; i < blending.size(); ++i) gl.GetIntegerv(blending[i], &s.blend_[i]);
  gl.GetIntegerv(GL_BLEND_EQUATION, &s.blend_equation_);
  gl.GetIntegerv(GL_DEPTH_FUNC, &s.depth_func_);
  gl.GetBooleanv(GL_DEPTH_WRITEMASK, &s.depth_mask_);
  gl.GetFloatv(GL_DEPTH_RANGE, s.depth_range_);
  gl.GetIntegerv(GL_CULL_FACE_MODE, &s.cull_face_);
  gl.GetIntegerv(GL_FRONT_FACE, &s.front_face_);
  gl.GetIntegerv(GL_SHADE_MODEL, &s.shade_model_);
  gl.GetIntegerv(GL_POLYGON_MODE, s.polygon_mode_);
  gl.GetFloatv(GL_POLYGON_OFFSET_FACTOR, &s.offset_[0]);
  gl.GetFloatv(GL_POLYGON_OFFSET_UNITS, &s.offset_[1]);
  gl.GetBooleanv(GL_COLOR_WRITEMASK, s.color_mask_);
  gl.GetFloatv(GL_LINE_WIDTH, &s.line_width_);
  gl.GetFloatv(GL_POINT_SIZE, &s.point_size_);
  gl.GetIntegerv(GL_FOG_MODE, &s.fog_mode_);
  gl.GetFloatv(GL_FOG_DENSITY, &s.fog_[0]);
  gl.GetFloatv(GL_FOG_START, &s.fog_[1]);
  gl.GetFloatv(GL_FOG_END, &s.fog_[2]);
  gl.GetFloatv(GL_FOG_COLOR, s.fog_color_);
  gl.GetIntegerv(GL_VIEWPORT, s.viewport_);
  gl.GetIntegerv(GL_SCISSOR_BOX, s.scissor_);
  for (size_t i = 0; i < stencil.size(); ++i) gl.GetIntegerv(stencil[i], &s.stencil_[i]);
  gl.GetIntegerv(GL_LOGIC_OP_MODE, &s.logic_op_);
  for (GLenum i = 0; i < kept_planes; ++i) {
    s.planes_[i] = gl.IsEnabled(GL_CLIP_PLANE0 + i) == GL_TRUE;
    if (s.planes_[i]) gl.GetClipPlane(GL_CLIP_PLANE0 + i, s.plane_[i]);
  }
  s.read_units();
  s.read_lighting();
  return s;
}

void SavedState::read_units() {
  const Functions& gl = real();
  for (int i = 0; i < texture_units(); ++i) {
    Unit& unit = units_[i];
    gl.ActiveTexture(unit_name(i));
    unit.texture_2d = gl.IsEnabled(GL_TEXTURE_2D) == GL_TRUE;
    unit.texture_cube = gl.IsEnabled(GL_TEXTURE_CUBE_MAP) == GL_TRUE;
    gl.GetFloatv(GL_CURRENT_TEXTURE_COORDS, unit.coordinates);
    if (!unit.texture_2d && !unit.texture_cube) continue;
    gl.GetIntegerv(GL_TEXTURE_BINDING_2D, &unit.bound_2d);
    gl.GetIntegerv(GL_TEXTURE_BINDING_CUBE_MAP, &unit.bound_cube);
    gl.GetTexEnviv(GL_TEXTURE_ENV, GL_TEXTURE_ENV_MODE, &unit.env_mode);
    gl.GetTexEnvfv(GL_TEXTURE_ENV, GL_TEXTURE_ENV_COLOR, unit.env_color);
    for (size_t k = 0; k < combine.size(); ++k) gl.GetTexEnviv(GL_TEXTURE_ENV, combine[k], &unit.combine[k]);
    gl.GetTexEnvfv(GL_TEXTURE_ENV, GL_RGB_SCALE, &unit.scale[0]);
    gl.GetTexEnvfv(GL_TEXTURE_ENV, GL_ALPHA_SCALE, &unit.scale[1]);
    gl.GetFloatv(GL_TEXTURE_MATRIX, unit.matrix);
    for (GLenum c = 0; c < 4; ++c) {
      unit.generated[c] = gl.IsEnabled(GL_TEXTURE_GEN_S + c) == GL_TRUE;
      if (!unit.generated[c]) continue;
      gl.GetTexGeniv(coordinate[c], GL_TEXTURE_GEN_MODE, &unit.generation_mode[c]);
      gl.GetTexGenfv(coordinate[c], GL_OBJECT_PLANE, unit.object_plane[c]);
      gl.GetTexGenfv(coordinate[c], GL_EYE_PLANE, unit.eye_plane[c]);
    }
  }
  gl.ActiveTexture(as_enum(active_unit_));
}

void SavedState::read_lighting() {
  const Functions& gl = real();
  gl.GetFloatv(GL_LIGHT_MODEL_AMBIENT, model_ambient_);
  gl.GetIntegerv(GL_LIGHT_MODEL_TWO_SIDE, &two_sided_);
  gl.GetIntegerv(GL_LIGHT_MODEL_LOCAL_VIEWER, &local_viewer_);
  gl.GetIntegerv(GL_LIGHT_MODEL_COLOR_CONTROL, &color_control_);
  gl.GetIntegerv(GL_COLOR_MATERIAL_FACE, &color_material_[0]);
  gl.GetIntegerv(GL_COLOR_MATERIAL_PARAMETER, &color_material_[1]);
  for (GLenum i = 0; i < kept_lights; ++i) {
    Light& light = lights_[i];
    const GLenum name = GL_LIGHT0 + i;
    light.on = gl.IsEnabled(name) == GL_TRUE;
    if (!light.on) continue;
    gl.GetLightfv(name, GL_AMBIENT, light.ambient);
    gl.GetLightfv(name, GL_DIFFUSE, light.diffuse);
    gl.GetLightfv(name, GL_SPECULAR, light.specular);
    gl.GetLightfv(name, GL_POSITION, light.position);
    gl.GetLightfv(name, GL_SPOT_DIRECTION, light.direction);
    gl.GetLightfv(name, GL_SPOT_EXPONENT, &light.exponent);
    gl.GetLightfv(name, GL_SPOT_CUTOFF, &light.cutoff);
    for (size_t k = 0; k < attenuation.size(); ++k) gl.GetLightfv(name, attenuation[k], &light.attenuation[k]);
  }
  for (GLenum side = 0; side < 2; ++side) {
    Material& material = materials_[side];
    const GLenum face = side == 0 ? GL_FRONT : GL_BACK;
    gl.GetMaterialfv(face, GL_AMBIENT, material.ambient);
    gl.GetMaterialfv(face, GL_DIFFUSE, material.diffuse);
    gl.GetMaterialfv(face, GL_SPECULAR, material.specular);
    gl.GetMaterialfv(face, GL_EMISSION, material.emission);
    gl.GetMaterialfv(face, GL_SHININESS, &material.shininess);
  }
}

void SavedState::apply() const {
  const Functions& gl = real();
  // Light positions and planes of clipping and texture coordinates are stored in eye space.
  load_matrix(GL_MODELVIEW, unchanged.data());
  apply_lighting();
  for (GLenum i = 0; i < kept_planes; ++i) {
    set(GL_CLIP_PLANE0 + i, planes_[i]);
    if (planes_[i]) gl.ClipPlane(GL_CLIP_PLANE0 + i, plane_[i]);
  }
  apply_units();
  apply_view();
  for (size_t i = 0; i < switches.size(); ++i) set(switches[i], enabled_[i]);
  gl.AlphaFunc(as_enum(alpha_func_), alpha_reference_);
  gl.BlendFuncSeparate(as_enum(blend_[0]), as_enum(blend_[1]), as_enum(blend_[2]), as_enum(blend_[3]));
  gl.BlendEquation(as_enum(blend_equation_));
  gl.DepthFunc(as_enum(depth_func_));
  gl.DepthMask(depth_mask_);
  gl.DepthRange(static_cast<GLdouble>(depth_range_[0]), static_cast<GLdouble>(depth_range_[1]));
  gl.CullFace(as_enum(cull_face_));
  gl.FrontFace(as_enum(front_face_));
  gl.ShadeModel(as_enum(shade_model_));
  gl.PolygonMode(GL_FRONT, as_enum(polygon_mode_[0]));
  gl.PolygonMode(GL_BACK, as_enum(polygon_mode_[1]));
  gl.PolygonOffset(offset_[0], offset_[1]);
  gl.ColorMask(color_mask_[0], color_mask_[1], color_mask_[2], color_mask_[3]);
  gl.LineWidth(line_width_);
  gl.PointSize(point_size_);
  gl.Fogi(GL_FOG_MODE, fog_mode_);
  gl.Fogf(GL_FOG_DENSITY, fog_[0]);
  gl.Fogf(GL_FOG_START, fog_[1]);
  gl.Fogf(GL_FOG_END, fog_[2]);
  gl.Fogfv(GL_FOG_COLOR, fog_color_);
  gl.Viewport(viewport_[0], viewport_[1], viewport_[2], viewport_[3]);
  gl.Scissor(scissor_[0], scissor_[1], scissor_[2], scissor_[3]);
  gl.StencilFunc(as_enum(stencil_[0]), stencil_[1], static_cast<GLuint>(stencil_[2]));
  gl.StencilMask(static_cast<GLuint>(stencil_[3]));
  gl.StencilOp(as_enum(stencil_[4]), as_enum(stencil_[5]), as_enum(stencil_[6]));
  gl.LogicOp(as_enum(logic_op_));
  gl.Normal3fv(normal_);
  gl.Color4fv(color_);
}

void SavedState::apply_units() const {
  const Functions& gl = real();
  for (int i = 0; i < texture_units(); ++i) {
    const Unit& unit = units_[i];
    gl.ActiveTexture(unit_name(i));
    set(GL_TEXTURE_2D, unit.texture_2d);
    set(GL_TEXTURE_CUBE_MAP, unit.texture_cube);
    gl.MultiTexCoord4fv(unit_name(i), unit.coordinates);
    if (!unit.texture_2d && !unit.texture_cube) continue;
    gl.BindTexture(GL_TEXTURE_2D, static_cast<GLuint>(unit.bound_2d));
    gl.BindTexture(GL_TEXTURE_CUBE_MAP, static_cast<GLuint>(unit.bound_cube));
    gl.TexEnvi(GL_TEXTURE_ENV, GL_TEXTURE_ENV_MODE, unit.env_mode);
    gl.TexEnvfv(GL_TEXTURE_ENV, GL_TEXTURE_ENV_COLOR, unit.env_color);
    for (size_t k = 0; k < combine.size(); ++k) gl.TexEnvi(GL_TEXTURE_ENV, combine[k], unit.combine[k]);
    gl.TexEnvf(GL_TEXTURE_ENV, GL_RGB_SCALE, unit.scale[0]);
    gl.TexEnvf(GL_TEXTURE_ENV, GL_ALPHA_SCALE, unit.scale[1]);
    load_matrix(GL_TEXTURE, unit.matrix);
    for (GLenum c = 0; c < 4; ++c) {
      set(GL_TEXTURE_GEN_S + c, unit.generated[c]);
      if (!unit.generated[c]) continue;
      gl.TexGeni(coordinate[c], GL_TEXTURE_GEN_MODE, unit.generation_mode[c]);
      if (unit.generation_mode[c] == GL_OBJECT_LINEAR) gl.TexGenfv(coordinate[c], GL_OBJECT_PLANE, unit.object_plane[c]);
      if (unit.generation_mode[c] == GL_EYE_LINEAR) gl.TexGenfv(coordinate[c], GL_EYE_PLANE, unit.eye_plane[c]);
    }
  }
}

void SavedState::apply_view() const {
  load_matrix(GL_PROJECTION, projection_);
  load_matrix(GL_MODELVIEW, modelview_);
  real().ActiveTexture(as_enum(active_unit_));
}

int SavedState::free_unit() const {
  int behind = texture_units();
  while (behind > 0 && !units_[behind - 1].texture_2d && !units_[behind - 1].texture_cube) --behind;
  return behind < texture_units() ? behind : -1;
}

void SavedState::apply_lighting() const {
  const Functions& gl = real();
  gl.LightModelfv(GL_LIGHT_MODEL_AMBIENT, model_ambient_);
  gl.LightModeli(GL_LIGHT_MODEL_TWO_SIDE, two_sided_);
  gl.LightModeli(GL_LIGHT_MODEL_LOCAL_VIEWER, local_viewer_);
  gl.LightModeli(GL_LIGHT_MODEL_COLOR_CONTROL, color_control_);
  for (GLenum i = 0; i < kept_lights; ++i) {
    const Light& light = lights_[i];
    const GLenum name = GL_LIGHT0 + i;
    set(name, light.on);
    if (!light.on) continue;
    gl.Lightfv(name, GL_AMBIENT, light.ambient);
    gl.Lightfv(name, GL_DIFFUSE, light.diffuse);
    gl.Lightfv(name, GL_SPECULAR, light.specular);
    gl.Lightfv(name, GL_POSITION, light.position);
    gl.Lightfv(name, GL_SPOT_DIRECTION, light.direction);
    gl.Lightf(name, GL_SPOT_EXPONENT, light.exponent);
    gl.Lightf(name, GL_SPOT_CUTOFF, light.cutoff);
    for (size_t k = 0; k < attenuation.size(); ++k) gl.Lightf(name, attenuation[k], light.attenuation[k]);
  }
  // Turns colour materials off before: glColor would change the values set here.
  gl.Disable(GL_COLOR_MATERIAL);
  gl.ColorMaterial(as_enum(color_material_[0]), as_enum(color_material_[1]));
  for (GLenum side = 0; side < 2; ++side) {
    const Material& material = materials_[side];
    const GLenum face = side == 0 ? GL_FRONT : GL_BACK;
    gl.Materialfv(face, GL_AMBIENT, material.ambient);
    gl.Materialfv(face, GL_DIFFUSE, material.diffuse);
    gl.Materialfv(face, GL_SPECULAR, material.specular);
    gl.Materialfv(face, GL_EMISSION, material.emission);
    gl.Materialf(face, GL_SHININESS, material.shininess);
  }
}

AllState::AllState() {
  const Functions& gl = real();
  GLint depth = 0, client_depth = 0, most = 0, client_most = 0;
  gl.GetIntegerv(GL_ATTRIB_STACK_DEPTH, &depth);
  gl.GetIntegerv(GL_MAX_ATTRIB_STACK_DEPTH, &most);
  gl.GetIntegerv(GL_CLIENT_ATTRIB_STACK_DEPTH, &client_depth);
  gl.GetIntegerv(GL_MAX_CLIENT_ATTRIB_STACK_DEPTH, &client_most);
  if (depth >= most || client_depth >= client_most) return;
  saved_ = true;
  gl.GetFloatv(GL_MODELVIEW_MATRIX, modelview_);
  gl.GetFloatv(GL_PROJECTION_MATRIX, projection_);
  gl.PushAttrib(GL_ALL_ATTRIB_BITS);
  gl.PushClientAttrib(GL_CLIENT_ALL_ATTRIB_BITS);
  for (int unit = 0; unit < texture_units(); ++unit) {
    gl.ActiveTexture(unit_name(unit));
    gl.GetFloatv(GL_TEXTURE_MATRIX, texture_[unit]);
  }
}

AllState::~AllState() {
  if (!saved_) return;
  const Functions& gl = real();
  for (int unit = 0; unit < texture_units(); ++unit) {
    gl.ActiveTexture(unit_name(unit));
    load_matrix(GL_TEXTURE, texture_[unit]);
  }
  load_matrix(GL_PROJECTION, projection_);
  load_matrix(GL_MODELVIEW, modelview_);
  gl.PopClientAttrib();
  gl.PopAttrib();
}

}  // namespace sideray::run
