#include "preload/rays/held_shadows.h"

#include "preload/base/settings.h"
#include "preload/gl/functions.h"
#include "preload/gl/objects.h"

namespace sideray::run {
namespace {

constexpr Matrix identity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
constexpr float least_alpha = 0.02f;  // a smaller alpha is a hole in the draw

// Returns the matrix from eye space to coordinates of a texture that reaches from the framebuffer's first pixel to the
// viewport's far corner.
Matrix texture_from_eye(const Matrix& projection, const std::array<GLint, 4>& viewport) {
  Matrix result{};
  for (size_t column = 0; column < 4; ++column) {
    const float* clip = &projection[4 * column];
    for (size_t axis = 0; axis < 2; ++axis) {
      const auto start = static_cast<float>(viewport[axis]), length = static_cast<float>(viewport[axis + 2]);
      result[4 * column + axis] = (start * clip[3] + 0.5f * length * (clip[axis] + clip[3])) / (start + length);
    }
    result[4 * column + 3] = clip[3];
  }
  return result;
}

}  // namespace

HeldShadows::HeldShadows(const TracedScene& scene) : service_(make_service(scene.tracer())) {}

void HeldShadows::abandon() {
  service_.abandon_context();
  shadows_.abandon();
  target_.abandon();
  answers_.clear();
}

// Draws the depth of the nearest surface of the held draws. Holes show what lies behind them.
void HeldShadows::draw_depth(const Batch& batch) {
  const Functions& gl = real();
  target_.make(batch.viewport);
  target_.begin();
  gl.DepthMask(GL_TRUE);
  gl.ClearDepth(1);
  gl.Clear(GL_DEPTH_BUFFER_BIT);
  for (const HeldDraw& draw : batch.shadowed) {
    draw.state->apply();
    for (const GLenum off :
         {GL_FOG, GL_BLEND, GL_STENCIL_TEST, GL_POLYGON_STIPPLE, GL_COLOR_LOGIC_OP, GL_POLYGON_OFFSET_FILL})
      gl.Disable(off);
    gl.Enable(GL_DEPTH_TEST);
    gl.DepthFunc(GL_LEQUAL);
    gl.DepthMask(GL_TRUE);
    gl.Enable(GL_ALPHA_TEST);
    gl.AlphaFunc(GL_GREATER, least_alpha);
    draw.make();
  }
  gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
}

void HeldShadows::trace(const Batch& batch) {
  Answers& answers = answers_[batch.number];
  answers.take(service_, 0);
  draw_depth(batch);
  if (!answers.ticket) {
    FrameInputs inputs = frame_inputs(batch.number, batch.projection, batch.viewport);
    inputs.frame.source.framebuffer = target_.framebuffer();
    inputs.layers.reset();
    inputs.masks = sun_masks(batch.receivers->rounding());
    answers.submit(service_, inputs);
    for (const Receiver& draw : batch.receivers->held()) answers.receivers[draw.name] = draw.modelview;
  }
  if (!settings().late) answers.take(service_, -1);
}

void HeldShadows::light(const Batch& batch, GLuint picture_depth) {
  shadows_.light({&batch.receivers->held(), batch.sun, &answers_[batch.number].shadowed, target_.depth(), picture_depth,
                  batch.projection, batch.viewport},
                 service_, batch.number);
  shadows_.count(batch.viewport);
  texture_from_eye_ = texture_from_eye(batch.projection, batch.viewport);
}

void HeldShadows::begin(const SavedState& state) {
  const int unit = state.free_unit();
  if (unit < 0) return;
  const Functions& gl = real();
  gl.MatrixMode(GL_MODELVIEW);
  gl.LoadMatrixf(identity.data());
  generate_coordinates(unit, GL_EYE_LINEAR, texture_from_eye_, 4);
  gl.ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  gl.BindTexture(GL_TEXTURE_2D, shadows_.left());
  gl.Enable(GL_TEXTURE_2D);
  // Keeps alpha.
  gl.TexEnvi(GL_TEXTURE_ENV, GL_TEXTURE_ENV_MODE, GL_COMBINE);
  for (const auto& [name, value] : {std::pair{GL_COMBINE_RGB, GL_MODULATE},
                                    {GL_SOURCE0_RGB, GL_PREVIOUS},
                                    {GL_SOURCE1_RGB, GL_TEXTURE},
                                    {GL_OPERAND0_RGB, GL_SRC_COLOR},
                                    {GL_OPERAND1_RGB, GL_SRC_COLOR},
                                    {GL_COMBINE_ALPHA, GL_REPLACE},
                                    {GL_SOURCE0_ALPHA, GL_PREVIOUS},
                                    {GL_OPERAND0_ALPHA, GL_SRC_ALPHA}})
    gl.TexEnvi(GL_TEXTURE_ENV, static_cast<GLenum>(name), value);
  for (const GLenum scale : {GL_RGB_SCALE, GL_ALPHA_SCALE}) gl.TexEnvf(GL_TEXTURE_ENV, scale, 1);
  state.apply_view();
}

void HeldShadows::end(const SavedState& state) {
  const int unit = state.free_unit();
  if (unit < 0) return;
  const Functions& gl = real();
  gl.ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  gl.Disable(GL_TEXTURE_2D);
  for (GLenum row = 0; row < 4; ++row) gl.Disable(GL_TEXTURE_GEN_S + row);
  gl.ActiveTexture(GL_TEXTURE0);
}

}  // namespace sideray::run
