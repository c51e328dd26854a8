// The part of the service that sets a host's program up for a view's newest frame.
#include <algorithm>
#include <glm/gtc/type_ptr.hpp>

#include "bridge/base/check_inputs.h"
#include "bridge/base/local_view.h"
#include "bridge/results/mask_binding.h"
#include "bridge/service/service.h"
#include "gl/resources/state_guard.h"
#include "model/failure.h"

namespace sideray::bridge {
namespace {

constexpr uint32_t bound_units = 5;

// sideray_rate of the snippet: the rates at which some pixels hold no layers.
GLint snippet_rate(sideray_cache_rate rate) {
  const bool sparse =
      rate == SIDERAY_RATE_CHECKERBOARD || rate == SIDERAY_RATE_INTERLEAVED || rate == SIDERAY_RATE_QUARTER;
  return sparse ? static_cast<GLint>(rate) : 0;
}

}  // namespace

bool Service::latest(uint32_t view_id, sideray_frame_outputs& outputs) const {
  check_view_id(view_id);
  const auto& view = views_[view_id];
  if (!view || view->latest.ticket == 0) return false;
  outputs = view->latest;
  return true;
}

void Service::bind(uint32_t view_id, uint32_t program, uint32_t first_unit, glm::dvec3 space_origin) {
  check_view_id(view_id);
  if (context_lost_) fail(SIDERAY_GL_FAILED, "service: its context was abandoned; destroy it and create another");
  const gl::ErrorGuard errors(gl_);
  if (gl_.IsProgram(program) != GL_TRUE)
    fail(SIDERAY_INVALID_ARGUMENT, "bind program {}: there is no such program in this context; link it first", program);
  if (first_unit >= units_ || units_ - first_unit < bound_units)
    fail(SIDERAY_INVALID_ARGUMENT, "bind first_unit {}: the driver has {} units; give at most {}", first_unit, units_,
         units_ - std::min(units_, bound_units));
  const ServiceView& view = view_of(view_id);
  const sideray_frame_outputs& latest = view.latest;
  const gl::ProgramGuard program_in_use(gl_, view.policy);
  const gl::TextureGuard active_unit(gl_, first_unit, 0, view.policy);
  gl_.UseProgram(program);
  errors.check("bind");  // before anything of another program is changed
  const bool answers = latest.ticket != 0 && latest.mode == SIDERAY_CACHE && latest.layers > 0;
  const uint32_t textures[] = {answers ? latest.radiance_texture : 0, answers ? latest.distance_texture : 0,
                               answers ? latest.surface_id_texture : 0};
  const char* const names[] = {"sideray_radiance", "sideray_distance", "sideray_surface_id"};
  for (uint32_t i = 0; i < 3; ++i) {
    gl_.ActiveTexture(GL_TEXTURE0 + first_unit + i);
    gl_.BindTexture(GL_TEXTURE_2D_ARRAY, textures[i]);
    if (gl_.samplers) gl_.BindSampler(first_unit + i, 0);
    gl_.Uniform1i(gl_.GetUniformLocation(program, names[i]), static_cast<GLint>(first_unit + i));
  }
  bind_masks(gl_, program, first_unit + 3, latest);
  gl_.Uniform1i(gl_.GetUniformLocation(program, "sideray_layers"), answers ? static_cast<GLint>(latest.layers) : 0);
  if (answers) set_layer_uniforms(program, view, space_origin);
}

void Service::set_layer_uniforms(uint32_t program, const ServiceView& view, glm::dvec3 space_origin) const {
  const sideray_frame_outputs& latest = view.latest;
  const auto width = static_cast<uint32_t>(latest.width), height = static_cast<uint32_t>(latest.height);
  const SnippetView snippet = snippet_view(latest.view, width, height, space_origin);
  const auto location = [&](const char* name) { return gl_.GetUniformLocation(program, name); };
  gl_.Uniform4f(location("sideray_viewport"), static_cast<float>(latest.x), static_cast<float>(latest.y), 1.0f, 1.0f);
  gl_.Uniform4fv(location("sideray_eye"), 1, glm::value_ptr(snippet.eye));
  gl_.Uniform4fv(location("sideray_near_plane"), 1, glm::value_ptr(snippet.near_plane));
  gl_.Uniform1i(location("sideray_match"), static_cast<GLint>(view.latest_inputs.match));
  gl_.Uniform1f(location("sideray_match_threshold"), view.latest_inputs.threshold);
  gl_.Uniform1f(location("sideray_subpixel"), subpixel_);
  gl_.Uniform1i(location("sideray_rate"), snippet_rate(view.latest_inputs.rate));
  gl_.UniformMatrix3fv(location("sideray_ray_from_pixel"), 1, GL_FALSE, glm::value_ptr(snippet.ray_from_pixel));
  gl_.UniformMatrix4fv(location("sideray_clip_from_world"), 1, GL_FALSE, glm::value_ptr(snippet.clip_from_position));
  gl_.Uniform2f(location("sideray_cache_size"), static_cast<float>(width), static_cast<float>(height));
}

}  // namespace sideray::bridge
