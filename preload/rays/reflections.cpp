#include "preload/rays/reflections.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "preload/base/settings.h"
#include "preload/gl/functions.h"
#include "preload/gl/objects.h"

namespace sideray::run {
namespace {

constexpr const char* vertex_text = R"(#version 120
uniform mat4 before;
varying vec3 eye_position, position_before;
void main() {
  gl_Position = ftransform();
  position_before = (before * gl_Vertex).xyz;
  eye_position = (gl_ModelViewMatrix * gl_Vertex).xyz;
}
)";

// Weights the reflected light by the surface's reflectance at this angle. Blending keeps the rest of the picture.
constexpr const char* fragment_text = R"(
varying vec3 eye_position, position_before;
uniform float surface, reflectance, fresnel, late;
uniform float shown;  // 0 = what it reflects, 1 = what is seen through it, 2 = white

// An answer where the surface was. The distance counts less than it does to sideray_find() and sideray_find_moving(): the surface
// id is that of one draw, water heaves, and what OpenGL interpolates over large polygons is coarser than a rounding.
bool find_before(vec3 position, float surface, out vec3 reflected) {
  reflected = vec3(0.0);
  bool in_picture;
  SiderayFragment f = sideray_moving_fragment(position, surface, in_picture);
  vec2 met = sideray_meet_plane(f, f.pixel);
  if (sideray_layers == 0 || !in_picture || !(met.x > 0.0)) return false;
  int layer = sideray_find_layer_at(f.pixel, met.x, met.y + 0.02 * met.x, surface);
  if (layer >= 0) reflected = SIDERAY_FETCH(sideray_radiance, f.pixel, layer, sideray_cache_size).rgb;
  return layer >= 0;
}

void main() {
  vec3 reflected;
  bool found = late < 0.5 && sideray_find(eye_position, surface, reflected);
  vec3 reflected_before;
  bool found_before = find_before(position_before, surface, reflected_before);
  if (!found && found_before) found = true, reflected = reflected_before;
  vec3 normal = normalize(cross(dFdx(eye_position), dFdy(eye_position)));
  float cosine = clamp(abs(dot(normal, normalize(eye_position))), 0.0, 1.0);
  float weight = reflectance + fresnel * (1.0 - reflectance) * pow(1.0 - cosine, 5.0);
  if (!found) discard;
  if (shown > 0.5) weight = 1.0;
  gl_FragColor = shown > 1.5 ? vec4(1.0) : vec4(weight * reflected, weight);
}
)";

void load_matrices(const Matrix& projection, const Matrix& modelview) {
  const Functions& gl = real();
  gl.MatrixMode(GL_PROJECTION);
  gl.LoadMatrixf(projection.data());
  gl.MatrixMode(GL_MODELVIEW);
  gl.LoadMatrixf(modelview.data());
}

// Passes fragments at the surface's drawn depth or a little nearer, because the copied depth may be rounded.
void test_depth() {
  const Functions& gl = real();
  gl.Enable(GL_DEPTH_TEST);
  gl.DepthFunc(GL_LEQUAL);
  gl.DepthMask(GL_FALSE);
  gl.Enable(GL_POLYGON_OFFSET_FILL);
  gl.PolygonOffset(-1, -2);
}

}  // namespace

Reflections::Reflections(const TracedScene& scene)
    : scene_(scene),
      service_(make_service(scene.tracer())),
      program_(make_program(vertex_text, std::string("#version 120\n") + sideray_glsl(120) + fragment_text, "reflections")) {
  const Functions& gl = real();
  surface_location_ = gl.GetUniformLocation(program_, "surface");
  reflectance_location_ = gl.GetUniformLocation(program_, "reflectance");
  fresnel_location_ = gl.GetUniformLocation(program_, "fresnel");
  late_location_ = gl.GetUniformLocation(program_, "late");
  shown_location_ = gl.GetUniformLocation(program_, "shown");
  before_location_ = gl.GetUniformLocation(program_, "before");
}

Reflections::~Reflections() {
  const Functions& gl = real();
  if (program_ != 0) gl.DeleteProgram(program_);
  if (!queries_.empty()) gl.DeleteQueries(static_cast<GLsizei>(queries_.size()), queries_.data());
}

void Reflections::abandon() {
  service_.abandon_context();
  target_.abandon();
  if (shadows_) shadows_->abandon();
  if (held_shadows_) held_shadows_->abandon();
  program_ = 0;
  queries_.clear();
  views_.clear();
}

void Reflections::draw_mask(const Batch& batch) {
  const Functions& gl = real();
  target_.begin();
  for (size_t i = 0; i < batch.reflectors.size(); ++i) {
    batch.states[i]->apply();
    for (const GLenum off : {GL_LIGHTING, GL_FOG, GL_BLEND, GL_ALPHA_TEST, GL_STENCIL_TEST, GL_POLYGON_STIPPLE, GL_COLOR_LOGIC_OP}) gl.Disable(off);
    for (GLenum unit = 0; unit < 4; ++unit) {
      gl.ActiveTexture(GL_TEXTURE0 + unit);
      gl.Disable(GL_TEXTURE_2D);
      gl.Disable(GL_TEXTURE_CUBE_MAP);
    }
    gl.ColorMask(1, 1, 1, 1);
    test_depth();
    const Reflector& reflector = batch.reflectors[i];
    load_matrices(batch.projection, reflector.modelview);
    // Uses a white copy, because arrays would bring the program's colours.
    gl.UseProgram(0);
    Geometry white;
    white.mode = reflector.geometry->mode;
    white.indices = reflector.geometry->indices;
    white.vertices = reflector.geometry->vertices;
    for (Vertex& vertex : white.vertices)
      for (float& c : vertex.color) c = 1;
    run::draw(white);
  }
  gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
}

void Reflections::submit(const Batch& batch) {
  FrameInputs inputs = frame_inputs(batch_, batch.projection, batch.viewport);
  inputs.frame.source.framebuffer = 0;
  inputs.frame.source.mask = SIDERAY_MASK_TEXTURE;
  inputs.frame.source.mask_texture = target_.marks();
  inputs.layers->float_ids = 1;
  const bool bends = std::any_of(batch.reflectors.begin(), batch.reflectors.end(), [](const Reflector& reflector) { return reflector.ids.bent != 0; });
  inputs.layers->refraction = bends;
  inputs.layers->max_layers = bends ? 6 : 4;  // a refracting surface has two
  if (batch.reflectors.empty()) inputs.layers.reset();
  inputs.frame.shadows = batch.has_shadows();
  if (batch.has_shadows()) inputs.masks = sun_masks(batch.receivers->rounding());
  Answers& view = views_[batch_];
  view.submit(service_, inputs);
  for (const Reflector& reflector : batch.reflectors)
    for (const uint32_t id : {reflector.ids.mirror, reflector.ids.bent}) view.surfaces[id] = reflector.modelview;
  for (const Receiver& draw : batch.receivers->draws()) view.receivers[draw.name] = draw.modelview;
}

void Reflections::trace(const Batch& batch) {
  batch_ = batch.number;
  Answers& view = views_[batch_];
  view.take(service_, 0);
  const bool is_free = !view.ticket && (!batch.reflectors.empty() || batch.has_shadows());
  if (is_free || batch.has_shadows() || !batch.shadowed.empty()) target_.make(batch.viewport), target_.copy_depth();
  // If rays take longer than a frame, the frames in between are not traced.
  if (is_free) {
    draw_mask(batch);
    submit(batch);
  }
  if (!settings().late) view.take(service_, -1);
  if (batch.shadowed.empty()) return;
  if (!held_shadows_) held_shadows_ = std::make_unique<HeldShadows>(scene_);
  held_shadows_->trace(batch);
}

void Reflections::advance() {
  service_.advance();
  if (held_shadows_) held_shadows_->advance();
}

void Reflections::draw_shadows(const Batch& batch) {
  if (batch.has_shadows()) {
    if (!shadows_) shadows_ = std::make_unique<Shadows>();
    const ShadowInputs inputs = {&batch.receivers->draws(), batch.sun,        &view().shadowed, target_.depth(),
                                 target_.depth(),           batch.projection, batch.viewport};
    shadows_->light(inputs, service_, batch_);
    shadows_->darken(inputs);
  }
  if (!batch.shadowed.empty()) held_shadows_->light(batch, target_.depth());
}

void Reflections::mark_shadows(const std::array<GLint, 4>& viewport) {
  if (shadows_) shadows_->mark(viewport);
  if (held_shadows_) held_shadows_->mark(viewport);
}

void Reflections::draw(const Reflector& reflector, Shown shown) {
  const bool behind = shown == Shown::behind || shown == Shown::marks_behind, marks = shown == Shown::marks || shown == Shown::marks_behind;
  const uint32_t id = behind ? reflector.ids.bent : reflector.ids.mirror;
  const auto before = view().answered.find(id);
  if (id == 0 || before == view().answered.end()) return;
  const Functions& gl = real();
  test_depth();
  gl.Enable(GL_BLEND);
  gl.BlendEquation(GL_FUNC_ADD);
  gl.BlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
  gl.Disable(GL_ALPHA_TEST);
  gl.MatrixMode(GL_MODELVIEW);
  gl.LoadMatrixf(reflector.modelview.data());
  service_.bind(program_, service_unit, batch_);
  gl.UseProgram(program_);
  gl.Uniform1f(surface_location_, static_cast<float>(id));
  gl.Uniform1f(reflectance_location_, reflector.reflectance);
  gl.Uniform1f(fresnel_location_, reflector.fresnel ? 1.0f : 0.0f);
  gl.Uniform1f(late_location_, settings().late ? 1.0f : 0.0f);
  gl.Uniform1f(shown_location_, marks ? 2.0f : behind ? 1.0f : 0.0f);
  gl.UniformMatrix4fv(before_location_, 1, GL_FALSE, before->second.data());
  if (marks || behind) {  // only what it reflects is counted, which lies over both
    run::draw(*reflector.geometry);
  } else {
    GLuint query = 0;
    gl.GenQueries(1, &query);
    queries_.push_back(query);
    gl.BeginQuery(GL_SAMPLES_PASSED, query);
    run::draw(*reflector.geometry);
    gl.EndQuery(GL_SAMPLES_PASSED);
  }
  gl.UseProgram(0);
}

uint64_t Reflections::fragments_answered() {
  const Functions& gl = real();
  uint64_t sum = 0;
  const auto unfinished = std::partition(queries_.begin(), queries_.end(), [&](GLuint query) {
    GLuint done = GL_TRUE;
    if (settings().late) gl.GetQueryObjectuiv(query, GL_QUERY_RESULT_AVAILABLE, &done);
    return done == GL_TRUE;
  });
  for (auto at = queries_.begin(); at != unfinished; ++at) {
    GLuint passed = 0;
    gl.GetQueryObjectuiv(*at, GL_QUERY_RESULT, &passed);
    sum += passed;
  }
  if (unfinished != queries_.begin()) gl.DeleteQueries(static_cast<GLsizei>(unfinished - queries_.begin()), queries_.data());
  queries_.erase(queries_.begin(), unfinished);
  return sum;
}

}  // namespace sideray::run
