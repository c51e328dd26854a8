#include "bridge/jobs/masks/mask_binding.h"

#include <glm/gtc/type_ptr.hpp>

#include "bridge/base/local_view.h"
#include "rt/history/frame_camera.h"

namespace sideray::bridge {
namespace {

// Binds the sampler even without a mask, since samplers of different types must not share a unit.
void bind_sampler(const gl::Functions& gl, GLint location, uint32_t unit, GLenum target, uint32_t texture) {
  if (location < 0) return;
  gl.ActiveTexture(GL_TEXTURE0 + unit);
  gl.BindTexture(target, texture);
  if (gl.samplers) gl.BindSampler(unit, 0);
  gl.Uniform1i(location, static_cast<GLint>(unit));
}

// Sets the camera of the masks (FrameCamera) in the space of the program's positions.
void set_camera(const gl::Functions& gl, uint32_t program, const MaskJob& job, glm::dvec3 space_origin) {
  const sideray_mask_outputs& outputs = job.outputs();
  const rt::TraceView view = local_view(outputs.view, space_origin);
  const rt::FrameCamera camera(view, static_cast<uint32_t>(outputs.width), static_cast<uint32_t>(outputs.height));
  const glm::mat3 start(camera.origin_x, camera.origin_y, camera.origin), ray(camera.ray_x, camera.ray_y, camera.ray);
  const glm::mat4 clip(view.clip_from_local);
  const glm::vec2 error = job.depth_error(camera);
  const auto location = [&](const char* name) { return gl.GetUniformLocation(program, name); };
  gl.UniformMatrix3fv(location("sideray_mask_start"), 1, GL_FALSE, glm::value_ptr(start));
  gl.UniformMatrix3fv(location("sideray_mask_ray"), 1, GL_FALSE, glm::value_ptr(ray));
  gl.UniformMatrix4fv(location("sideray_mask_clip_from_world"), 1, GL_FALSE, glm::value_ptr(clip));
  gl.Uniform2f(location("sideray_mask_error"), error.x, error.y);
}

}  // namespace

bool reads_tints(const gl::Functions& gl, uint32_t program) {
  return gl.GetUniformLocation(program, "sideray_shadow_tints") >= 0;
}

bool reads_mask_depth(const gl::Functions& gl, uint32_t program) {
  return gl.GetUniformLocation(program, "sideray_has_mask_depth") >= 0;
}

bool reads_mask_answers(const gl::Functions& gl, uint32_t program) {
  return gl.GetUniformLocation(program, "sideray_mask_answers") >= 0;
}

void bind_masks(const gl::Functions& gl, uint32_t program, uint32_t first_unit, const MaskJob& job,
                glm::dvec3 space_origin) {
  const sideray_mask_outputs& outputs = job.outputs();
  const auto location = [&](const char* name) { return gl.GetUniformLocation(program, name); };
  const bool shadow = outputs.shadow_texture != 0, ambient = outputs.ao_texture != 0;
  bind_sampler(gl, location("sideray_shadow_masks"), first_unit + shadow_unit, GL_TEXTURE_2D_ARRAY, outputs.shadow_texture);
  bind_sampler(gl, location("sideray_ao_mask"), first_unit + ao_unit, GL_TEXTURE_2D, outputs.ao_texture);
  bind_sampler(gl, location("sideray_shadow_tints"), first_unit + tint_unit, GL_TEXTURE_2D_ARRAY, outputs.tint_texture);
  gl.Uniform1iv(location("sideray_tint_layer"), 33, outputs.tint_layers);
  GLint layers[32] = {}, next = 0;
  for (uint32_t light = 0; light < 32; ++light)
    if (shadow && ((outputs.shadow_lights >> light) & 1u)) layers[light] = ++next;
  gl.Uniform1iv(location("sideray_shadow_layer"), 32, layers);
  gl.Uniform1i(location("sideray_combined_layer"), shadow && outputs.combined_lights ? next + 1 : 0);
  gl.Uniform1i(location("sideray_has_ao"), ambient);
  bind_sampler(gl, location("sideray_mask_depth"), first_unit + mask_depth_unit, GL_TEXTURE_2D, outputs.depth_texture);
  const bool finds_moving = outputs.depth_texture != 0 && reads_mask_depth(gl, program);
  gl.Uniform1i(location("sideray_has_mask_depth"), finds_moving);
  bind_sampler(gl, location("sideray_mask_answers"), first_unit + mask_answer_unit, GL_TEXTURE_2D, outputs.answer_texture);
  gl.Uniform1i(location("sideray_has_mask_answers"), outputs.answer_texture != 0);
  if (!shadow && !ambient) return;
  gl.Uniform2f(location("sideray_mask_size"), static_cast<float>(outputs.width), static_cast<float>(outputs.height));
  gl.Uniform4f(location("sideray_mask_viewport"), static_cast<float>(outputs.x), static_cast<float>(outputs.y), 1.0f,
               1.0f);
  if (finds_moving) set_camera(gl, program, job, space_origin);
}

}  // namespace sideray::bridge
