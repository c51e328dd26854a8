#include "preload/rays/shadows.h"

#include <algorithm>

#include "preload/base/settings.h"
#include "preload/gl/functions.h"
#include "preload/gl/objects.h"

namespace sideray::run {
namespace {

constexpr int positions_unit = 7;  // its generated coordinates are positions in the frame of the masks

// The first pass draws what OpenGL has lit, the second the share of it that is left: masks darken the sun's part alone.
constexpr const char* receivers_text = R"(
uniform sampler2D depth, picture_depth, lit;
uniform vec2 size;
uniform float shade;  // below 0: gl_Color is what is left where the sun is hidden
uniform float is_first, late;
uniform float fog_mode, fog_density, fog_start, fog_end;  // mode 0: none, 1 linear, 2 exp, 3 exp2

float share_of_fog(float d) {
  if (fog_mode < 0.5) return 0.0;
  float clear = fog_mode < 1.5 ? (fog_end - d) / (fog_end - fog_start)
                               : exp(-(fog_mode < 2.5 ? fog_density * d : fog_density * d * fog_density * d));
  return 1.0 - clamp(clear, 0.0, 1.0);
}

void main() {
  vec3 sun = sideray_shadow_color(0);
  vec3 sun_before = sideray_shadow_color_moving(0, gl_TexCoord[7].xyz);
  if (late > 0.5) sun = sun_before;
  float z = gl_FragCoord.z;
  float slope = fwidth(z);
  vec2 place = gl_FragCoord.xy / size;
  if (abs(texture2D(depth, place).x - z) > slope + 2.4e-7) discard;  // 2^-22
  if (z - texture2D(picture_depth, place).x > slope + 2.4e-7) discard;
  vec3 color = shade < 0.0 ? gl_Color.rgb : vec3(is_first > 0.5 ? 1.0 : shade);
  vec3 all = texture2D(lit, place).rgb;
  vec3 left = mix(color, all, sun) / max(all, vec3(0.00392));
  gl_FragColor = is_first > 0.5 ? vec4(color, 1.0) : vec4(clamp(left, 0.0, 1.0), share_of_fog(1.0 / gl_FragCoord.w));
}
)";

constexpr const char* cover_text = R"(#version 120
uniform sampler2D left;
uniform vec2 size;
uniform float what;
uniform vec3 fog_color;
void main() {
  vec4 share = texture2D(left, gl_FragCoord.xy / size);
  if (all(greaterThan(share.rgb, vec3(0.995)))) discard;
  gl_FragColor = vec4(what < 0.5 ? share.rgb : what < 1.5 ? share.a * (1.0 - share.rgb) * fog_color : vec3(1.0), 1.0);
}
)";

constexpr std::array<GLfloat, 16> identity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

// MODELVIEW must be the identity, because the light's position is in eye space.
void set_light(GLenum name, const FixedLight& light, bool shines) {
  constexpr GLfloat black[4] = {0, 0, 0, 1};
  const Functions& gl = real();
  gl.Enable(name);
  gl.Lightfv(name, GL_AMBIENT, light.ambient);
  gl.Lightfv(name, GL_DIFFUSE, shines ? light.diffuse : black);
  gl.Lightfv(name, GL_SPECULAR, shines ? light.specular : black);
  gl.Lightfv(name, GL_POSITION, light.position);
  gl.Lightfv(name, GL_SPOT_DIRECTION, light.spot_direction);
  gl.Lightf(name, GL_SPOT_EXPONENT, light.spot_exponent);
  gl.Lightf(name, GL_SPOT_CUTOFF, light.spot_cutoff);
  gl.Lightf(name, GL_CONSTANT_ATTENUATION, light.attenuation[0]);
  gl.Lightf(name, GL_LINEAR_ATTENUATION, light.attenuation[1]);
  gl.Lightf(name, GL_QUADRATIC_ATTENUATION, light.attenuation[2]);
}

void set_lighting(const Lighting& lighting, int dark) {
  const Functions& gl = real();
  gl.MatrixMode(GL_MODELVIEW);
  gl.LoadMatrixf(identity.data());
  for (GLenum i = 0; i < 8; ++i) gl.Disable(GL_LIGHT0 + i);
  for (int i = 0; i < lighting.lights; ++i)
    set_light(GL_LIGHT0 + static_cast<GLenum>(lighting.number[i]), lighting.light[i], lighting.number[i] != dark);
  gl.LightModelfv(GL_LIGHT_MODEL_AMBIENT, lighting.scene_ambient);
  gl.LightModeli(GL_LIGHT_MODEL_LOCAL_VIEWER, lighting.local_viewer);
}

void set_material(const DrawMaterial& material, bool colored) {
  const Functions& gl = real();
  gl.Disable(GL_COLOR_MATERIAL);
  gl.Materialfv(GL_FRONT_AND_BACK, GL_AMBIENT, material.ambient);
  gl.Materialfv(GL_FRONT_AND_BACK, GL_DIFFUSE, material.diffuse);
  gl.Materialfv(GL_FRONT_AND_BACK, GL_SPECULAR, material.specular);
  gl.Materialfv(GL_FRONT_AND_BACK, GL_EMISSION, material.emission);
  gl.Materialf(GL_FRONT_AND_BACK, GL_SHININESS, material.shininess);
  if (!colored) return;
  gl.ColorMaterial(GL_FRONT_AND_BACK, GL_AMBIENT_AND_DIFFUSE);
  gl.Enable(GL_COLOR_MATERIAL);
}

void switch_off_tests() {
  const Functions& gl = real();
  for (const GLenum off : {GL_FOG, GL_BLEND, GL_ALPHA_TEST, GL_STENCIL_TEST, GL_DEPTH_TEST, GL_SCISSOR_TEST, GL_POLYGON_STIPPLE, GL_COLOR_LOGIC_OP,
                           GL_CULL_FACE, GL_POLYGON_OFFSET_FILL, GL_DITHER})
    gl.Disable(off);
  for (GLenum plane = 0; plane < 6; ++plane) gl.Disable(GL_CLIP_PLANE0 + plane);
  gl.PolygonMode(GL_FRONT_AND_BACK, GL_FILL);
  gl.ColorMask(1, 1, 1, 1);
  gl.DepthMask(GL_FALSE);
  gl.DepthRange(0, 1);
}

float mode_of(const Fog& fog) {
  return !fog.on ? 0.0f : fog.mode == GL_LINEAR ? 1.0f : fog.mode == GL_EXP ? 2.0f : 3.0f;
}

void set(GLuint program, const char* name, float value) {
  real().Uniform1f(real().GetUniformLocation(program, name), value);
}

}  // namespace

Shadows::Shadows()
    : receivers_(make_program("", std::string("#version 120\n") + sideray_glsl(120) + receivers_text, "shadows")),
      cover_(make_program("", cover_text, "shadows")) {
  const Functions& gl = real();
  gl.GenFramebuffers(1, &framebuffer_);
  gl.ActiveTexture(GL_TEXTURE0);
  lit_ = make_texture(), left_ = make_texture(), nearest_ = make_texture();
  gl.GenQueries(1, &query_);
}

Shadows::~Shadows() {
  if (framebuffer_ == 0) return;
  const Functions& gl = real();
  gl.DeleteProgram(receivers_), gl.DeleteProgram(cover_);
  gl.DeleteFramebuffers(1, &framebuffer_);
  for (const GLuint texture : {lit_, left_, nearest_}) gl.DeleteTextures(1, &texture);
  gl.DeleteQueries(1, &query_);
}

void Shadows::abandon() {
  framebuffer_ = 0;
}

void Shadows::make_textures(GLint width, GLint height) {
  if (width == width_ && height == height_) return;
  width_ = width, height_ = height;
  const Functions& gl = real();
  gl.ActiveTexture(GL_TEXTURE0);
  for (const GLuint texture : {lit_, left_}) {
    gl.BindTexture(GL_TEXTURE_2D, texture);
    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_RGBA8, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
  }
  gl.BindTexture(GL_TEXTURE_2D, nearest_);
  gl.TexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT24, width, height, 0, GL_DEPTH_COMPONENT, GL_UNSIGNED_INT, nullptr);
}

void Shadows::set_receiver(const Receiver& draw, const ShadowInputs& inputs, Pass pass) {
  const Functions& gl = real();
  if (draw.lights) set_material(draw.material, draw.colored), gl.Enable(GL_LIGHTING);
  const auto before = inputs.before->find(draw.name);
  generate_coordinates(positions_unit, GL_OBJECT_LINEAR,
                       before != inputs.before->end() ? before->second : draw.modelview, 3);
  gl.MatrixMode(GL_MODELVIEW);
  gl.LoadMatrixf(draw.modelview.data());
  set(receivers_, "shade", draw.lights ? -1.0f : draw.shade);
  set(receivers_, "is_first", pass == Pass::lit ? 1.0f : 0.0f);
  set(receivers_, "fog_mode", mode_of(draw.fog));
  set(receivers_, "fog_density", draw.fog.density);
  set(receivers_, "fog_start", draw.fog.start);
  set(receivers_, "fog_end", draw.fog.end);
  if (draw.fog.on) std::copy_n(draw.fog.color, 3, fog_color_);
}

void Shadows::draw_receivers(const ShadowInputs& inputs, Pass pass) {
  const Functions& gl = real();
  gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, pass == Pass::lit ? lit_ : left_, 0);
  gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, nearest_, 0);
  gl.Enable(GL_DEPTH_TEST);
  gl.DepthFunc(GL_LEQUAL);
  gl.DepthMask(GL_TRUE);
  gl.ClearColor(1, 1, 1, 0);
  gl.ClearDepth(1);
  gl.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  gl.ActiveTexture(GL_TEXTURE2);
  gl.BindTexture(GL_TEXTURE_2D, inputs.picture_depth);
  gl.ActiveTexture(GL_TEXTURE1);
  gl.BindTexture(GL_TEXTURE_2D, pass == Pass::lit ? 0 : lit_);
  gl.ActiveTexture(GL_TEXTURE0);
  gl.BindTexture(GL_TEXTURE_2D, inputs.depth);
  const Lighting* set_now = nullptr;
  for (const Receiver& draw : *inputs.draws) {
    if (draw.lights && draw.lights.get() != set_now) set_lighting(*draw.lights, pass == Pass::lit ? -1 : inputs.sun);
    if (draw.lights) set_now = draw.lights.get();
    set_receiver(draw, inputs, pass);
    run::draw(*draw.geometry);
  }
}

void Shadows::light(const ShadowInputs& inputs, Service& service, uint32_t view) {
  const Functions& gl = real();
  if (gl.BindBuffer) gl.BindBuffer(GL_PIXEL_UNPACK_BUFFER, 0);
  const std::array<GLint, 4>& viewport = inputs.viewport;
  make_textures(viewport[0] + viewport[2], viewport[1] + viewport[3]);
  service.bind(receivers_, service_unit, view);
  gl.UseProgram(receivers_);
  switch_off_tests();
  gl.Viewport(viewport[0], viewport[1], viewport[2], viewport[3]);
  gl.Enable(GL_NORMALIZE);
  gl.ShadeModel(GL_SMOOTH);
  gl.LightModeli(GL_LIGHT_MODEL_TWO_SIDE, 0);
  gl.LightModeli(GL_LIGHT_MODEL_COLOR_CONTROL, GL_SINGLE_COLOR);
  gl.MatrixMode(GL_PROJECTION);
  gl.LoadMatrixf(inputs.projection.data());
  gl.Uniform1i(gl.GetUniformLocation(receivers_, "depth"), 0);
  gl.Uniform1i(gl.GetUniformLocation(receivers_, "lit"), 1);
  gl.Uniform1i(gl.GetUniformLocation(receivers_, "picture_depth"), 2);
  gl.Uniform2f(gl.GetUniformLocation(receivers_, "size"), static_cast<float>(width_), static_cast<float>(height_));
  set(receivers_, "late", settings().late ? 1.0f : 0.0f);
  gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
  draw_receivers(inputs, Pass::lit);
  draw_receivers(inputs, Pass::left);
  gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
}

// Multiplying the picture also removes fog that lies in front of the shadows, so the second pass adds it again.
void Shadows::darken(const ShadowInputs& inputs) {
  ask(inputs.viewport, Cover::multiplies);
  const bool fog =
      std::any_of(inputs.draws->begin(), inputs.draws->end(), [](const Receiver& draw) { return draw.fog.on; });
  if (fog) cover(inputs.viewport, Cover::adds_fog);
}

void Shadows::count(const std::array<GLint, 4>& viewport) {
  ask(viewport, Cover::counts);
}

void Shadows::ask(const std::array<GLint, 4>& viewport, Cover what) {
  real().BeginQuery(GL_SAMPLES_PASSED, query_);
  cover(viewport, what);
  real().EndQuery(GL_SAMPLES_PASSED);
  asked_ = true;
}

void Shadows::cover(const std::array<GLint, 4>& viewport, Cover what) {
  const Functions& gl = real();
  switch_off_tests();
  gl.Viewport(viewport[0], viewport[1], viewport[2], viewport[3]);
  if (what == Cover::counts) gl.ColorMask(0, 0, 0, 0);
  if (what == Cover::multiplies || what == Cover::adds_fog) gl.Enable(GL_BLEND);
  gl.BlendEquation(GL_FUNC_ADD);
  if (what == Cover::multiplies)
    gl.BlendFunc(GL_ZERO, GL_SRC_COLOR);
  else
    gl.BlendFunc(GL_ONE, GL_ONE);
  for (const GLenum mode : {GLenum{GL_PROJECTION}, GLenum{GL_MODELVIEW}}) gl.MatrixMode(mode), gl.LoadMatrixf(identity.data());
  gl.ActiveTexture(GL_TEXTURE0);
  gl.BindTexture(GL_TEXTURE_2D, left_);
  gl.UseProgram(cover_);
  gl.Uniform1i(gl.GetUniformLocation(cover_, "left"), 0);
  gl.Uniform2f(gl.GetUniformLocation(cover_, "size"), static_cast<float>(width_), static_cast<float>(height_));
  gl.Uniform3f(gl.GetUniformLocation(cover_, "fog_color"), fog_color_[0], fog_color_[1], fog_color_[2]);
  set(cover_, "what", static_cast<float>(what));
  Geometry all;
  all.mode = GL_QUADS;
  for (const auto& [x, y] : {std::pair{-1.0f, -1.0f}, {1.0f, -1.0f}, {1.0f, 1.0f}, {-1.0f, 1.0f}}) {
    Vertex& corner = all.vertices.emplace_back();
    corner.position[0] = x, corner.position[1] = y;
  }
  run::draw(all);
  gl.UseProgram(0);
}

void Shadows::mark(const std::array<GLint, 4>& viewport) {
  if (asked_) cover(viewport, Cover::marks);
}

uint64_t Shadows::pixels() {
  if (!asked_) return 0;
  GLuint passed = 0;
  real().GetQueryObjectuiv(query_, GL_QUERY_RESULT, &passed);
  asked_ = false;
  return passed;
}

}  // namespace sideray::run
