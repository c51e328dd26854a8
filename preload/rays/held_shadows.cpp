#include "preload/rays/held_shadows.h"

#include "preload/base/settings.h"
#include "preload/gl/functions.h"
#include "preload/gl/objects.h"

namespace sideray::run {
namespace {

constexpr Matrix identity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
constexpr float least_alpha = 0.02f;  // of what hides something: less is a hole

}  // namespace

void HeldDraw::make() const {
  if (list != 0) {
    real().CallList(list);
    return;
  }
  for (const Geometry* piece : geometry) run::draw(*piece);
}

HeldShadows::HeldShadows(const TracedScene& scene) : service_(make_service(scene.tracer())) {}

void HeldShadows::abandon() {
  service_.abandon_context();
  shadows_.abandon();
  target_.abandon();
  answers_.clear();
}

// Where draws have their holes, what lies behind is the nearest.
void HeldShadows::draw_depth(const std::vector<HeldDraw>& draws, const std::array<GLint, 4>& viewport) {
  const Functions& gl = real();
  target_.make(viewport);
  target_.begin();
  gl.DepthMask(GL_TRUE);
  gl.Clear(GL_DEPTH_BUFFER_BIT);
  for (const HeldDraw& draw : draws) {
    draw.state->apply();
    for (const GLenum off : {GL_FOG, GL_BLEND, GL_STENCIL_TEST, GL_POLYGON_STIPPLE, GL_COLOR_LOGIC_OP, GL_POLYGON_OFFSET_FILL}) gl.Disable(off);
    gl.Enable(GL_DEPTH_TEST);
    gl.DepthFunc(GL_LEQUAL);
    gl.DepthMask(GL_TRUE);
    gl.Enable(GL_ALPHA_TEST);
    gl.AlphaFunc(GL_GREATER, least_alpha);
    draw.make();
  }
  gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
}

void HeldShadows::trace(const std::vector<HeldDraw>& draws, const Receivers& receivers, uint32_t batch, const Matrix& projection,
                        const std::array<GLint, 4>& viewport) {
  Answers& answers = answers_[batch];
  answers.take(service_, 0);
  draw_depth(draws, viewport);
  if (!answers.ticket) {
    FrameInputs inputs;
    inputs.frame.view_id = batch;
    inputs.frame.view = view_of(projection);
    inputs.frame.source.framebuffer = target_.framebuffer();
    inputs.frame.source.x = viewport[0];
    inputs.frame.source.y = viewport[1];
    inputs.frame.source.width = viewport[2];
    inputs.frame.source.height = viewport[3];
    inputs.frame.source.mask = SIDERAY_MASK_NONE;
    inputs.layers.reset();
    inputs.masks = sun_masks(receivers.rounding());
    answers.submit(service_, inputs);
    for (const Receiver& draw : receivers.held()) answers.receivers[draw.name] = draw.modelview;
  }
  if (!settings().late) answers.take(service_, -1);
}

void HeldShadows::light(const Receivers& receivers, int sun, uint32_t batch, const Matrix& projection,
                        const std::array<GLint, 4>& viewport, GLuint picture_depth) {
  shadows_.light({&receivers.held(), sun, &answers_[batch].shadowed, target_.depth(), picture_depth, projection, viewport}, service_, batch);
  shadows_.count(viewport);
  // Places in the framebuffer, as shares of the texture, times w.
  const float size[2] = {static_cast<float>(viewport[0] + viewport[2]), static_cast<float>(viewport[1] + viewport[3])};
  for (size_t column = 0; column < 4; ++column) {
    const float* clip = &projection[4 * column];
    float* place = &clip_to_texture_[4 * column];
    for (size_t axis = 0; axis < 2; ++axis) {
      const float start = static_cast<float>(viewport[axis]), half = 0.5f * static_cast<float>(viewport[axis + 2]);
      place[axis] = ((start + half) * clip[3] + half * clip[axis]) / size[axis];
    }
    place[2] = 0;
    place[3] = clip[3];
  }
}

void HeldShadows::begin(const SavedState& state) {
  const int unit = state.free_unit();
  if (unit < 0) return;
  const Functions& gl = real();
  gl.MatrixMode(GL_MODELVIEW);
  gl.LoadMatrixf(identity.data());
  generate_coordinates(unit, GL_EYE_LINEAR, clip_to_texture_, 4);
  gl.ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  gl.BindTexture(GL_TEXTURE_2D, shadows_.left());
  gl.Enable(GL_TEXTURE_2D);
  // Alpha stays.
  gl.TexEnvi(GL_TEXTURE_ENV, GL_TEXTURE_ENV_MODE, GL_COMBINE);
  for (const auto& [name, value] : {std::pair{GL_COMBINE_RGB, GL_MODULATE}, {GL_SOURCE0_RGB, GL_PREVIOUS}, {GL_SOURCE1_RGB, GL_TEXTURE},
                                    {GL_OPERAND0_RGB, GL_SRC_COLOR}, {GL_OPERAND1_RGB, GL_SRC_COLOR}, {GL_COMBINE_ALPHA, GL_REPLACE},
                                    {GL_SOURCE0_ALPHA, GL_PREVIOUS}, {GL_OPERAND0_ALPHA, GL_SRC_ALPHA}})
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
