#include "preload/rays/answers.h"

#include "preload/base/settings.h"
#include "preload/gl/functions.h"

namespace sideray::run {
namespace {

void* get_proc_address(void*, const char* name) {
  return real_symbol(name);
}

sideray_view view_of(const Matrix& projection) {
  double clip_from_eye[16], identity[16] = {};
  for (size_t i = 0; i < 16; ++i)
    clip_from_eye[i] = static_cast<double>(projection[i]), identity[i] = i % 5 == 0 ? 1 : 0;
  sideray_view view{};
  sideray_error error{};
  if (const sideray_status status = sideray_view_from_matrices(clip_from_eye, identity, &view, &error);
      status != SIDERAY_OK)
    throw Error(status, error.message);
  return view;
}

}  // namespace

void Answers::submit(Service& service, const FrameInputs& inputs) {
  ticket = service.submit(inputs);
  surfaces.clear();
  receivers.clear();
}

void Answers::take(Service& service, int32_t timeout_ms) {
  if (!ticket || !service.wait(*ticket, timeout_ms)) return;
  stats = service.stats(*ticket);
  ticket.reset();
  answered = std::move(surfaces);
  shadowed = std::move(receivers);
}

FrameInputs frame_inputs(uint32_t view, const Matrix& projection, const std::array<GLint, 4>& viewport) {
  FrameInputs inputs;
  inputs.frame.view_id = view;
  inputs.frame.view = view_of(projection);
  inputs.frame.source.x = viewport[0];
  inputs.frame.source.y = viewport[1];
  inputs.frame.source.width = viewport[2];
  inputs.frame.source.height = viewport[3];
  inputs.frame.source.mask = SIDERAY_MASK_NONE;
  return inputs;
}

sideray_mask_inputs sun_masks(float rounding) {
  sideray_mask_inputs masks = sideray_mask_inputs_defaults();
  masks.shadow_lights = 1;
  masks.denoise = 0;
  masks.moving = settings().late;
  masks.shadow_bias = rounding;
  masks.shadow_bias_steps = 4;  // because OpenGL interpolates depth on large polygons more coarsely than a step
  return masks;
}

Service make_service(const Tracer& tracer) {
  const sideray_host_gl host = {sizeof(host), get_proc_address, nullptr};
  return Service::create(tracer, host).value();
}

}  // namespace sideray::run
