// Binds a view's newest outputs to a host's program, as a part of the service.
#include <algorithm>

#include "bridge/base/check_inputs.h"
#include "bridge/jobs/irradiance/irradiance_binding.h"
#include "bridge/jobs/layers/layer_binding.h"
#include "bridge/jobs/masks/mask_binding.h"
#include "bridge/service/service.h"
#include "bridge/transport/source_checks.h"
#include "gl/resources/state_guard.h"
#include "model/failure.h"

namespace sideray::bridge {
namespace {

constexpr uint32_t bound_units = 5;

}  // namespace

void Service::bind(uint32_t view_id, uint32_t program, uint32_t first_unit, glm::dvec3 space_origin) {
  check_view_id(view_id);
  if (context_lost_) fail(SIDERAY_GL_FAILED, "service: its context was abandoned; destroy it and create another");
  require_context(gl_);
  const gl::ErrorGuard errors(gl_);
  if (gl_.IsProgram(program) != GL_TRUE)
    fail(SIDERAY_INVALID_ARGUMENT, "bind program {}: there is no such program in this context; link it first", program);
  if (first_unit >= units_ || units_ - first_unit < bound_units)
    fail(SIDERAY_INVALID_ARGUMENT, "bind first_unit {}: the driver has {} units; give at most {}", first_unit, units_,
         units_ - std::min(units_, bound_units));
  const auto require_unit = [&](bool reads, uint32_t unit, const char* what) {
    if (reads && units_ - first_unit <= unit)
      fail(SIDERAY_INVALID_ARGUMENT, "bind first_unit {}: unit {} holds {}, and the driver has {}; give less", first_unit,
           first_unit + unit, what, units_);
  };
  require_unit(reads_whole_pixels(gl_, program), whole_units + 1, "whole pixels");
  require_unit(reads_tints(gl_, program), tint_unit, "the masks' tints");
  require_unit(reads_mask_depth(gl_, program), mask_depth_unit, "the masks' depth");
  require_unit(reads_mask_answers(gl_, program), mask_answer_unit, "which masks are answered");
  require_unit(reads_irradiance(gl_, program), irradiance_unit, "the irradiance");
  const ServiceView& view = view_of(view_id);
  check_id_sampler(gl_, program, view.layers, checked_programs_);
  const gl::ProgramGuard program_in_use(gl_, view.policy);
  const gl::TextureGuard active_unit(gl_, first_unit, 0, view.policy);
  gl_.UseProgram(program);
  errors.check("bind");  // before anything changes in another program
  bind_layers(gl_, program, first_unit, view.layers, {space_origin, subpixel_});
  bind_masks(gl_, program, first_unit, view.masks, space_origin);
  bind_irradiance(gl_, program, first_unit, view.irradiance);
}

}  // namespace sideray::bridge
