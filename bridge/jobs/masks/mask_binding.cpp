#include "bridge/jobs/masks/mask_binding.h"

namespace sideray::bridge {
namespace {

// Even without a mask: samplers of different kinds must not share a unit.
void bind_sampler(const gl::Functions& gl, GLint location, uint32_t unit, GLenum target, uint32_t texture) {
  if (location < 0) return;
  gl.ActiveTexture(GL_TEXTURE0 + unit);
  gl.BindTexture(target, texture);
  if (gl.samplers) gl.BindSampler(unit, 0);
  gl.Uniform1i(location, static_cast<GLint>(unit));
}

}  // namespace

bool reads_tints(const gl::Functions& gl, uint32_t program) {
  return gl.GetUniformLocation(program, "sideray_shadow_tints") >= 0;
}

void bind_masks(const gl::Functions& gl, uint32_t program, uint32_t first_unit, uint32_t tint_unit,
                const sideray_mask_outputs& outputs) {
  const auto location = [&](const char* name) { return gl.GetUniformLocation(program, name); };
  const bool shadow = outputs.shadow_texture != 0, ambient = outputs.ao_texture != 0;
  bind_sampler(gl, location("sideray_shadow_masks"), first_unit, GL_TEXTURE_2D_ARRAY, outputs.shadow_texture);
  bind_sampler(gl, location("sideray_ao_mask"), first_unit + 1, GL_TEXTURE_2D, outputs.ao_texture);
  bind_sampler(gl, location("sideray_shadow_tints"), tint_unit, GL_TEXTURE_2D_ARRAY, outputs.tint_texture);
  gl.Uniform1iv(location("sideray_tint_layer"), 33, outputs.tint_layers);
  GLint layers[32] = {}, next = 0;
  for (uint32_t light = 0; light < 32; ++light)
    if (shadow && ((outputs.shadow_lights >> light) & 1u)) layers[light] = ++next;
  gl.Uniform1iv(location("sideray_shadow_layer"), 32, layers);
  gl.Uniform1i(location("sideray_combined_layer"), shadow && outputs.combined_lights ? next + 1 : 0);
  gl.Uniform1i(location("sideray_has_ao"), ambient);
  if (!shadow && !ambient) return;
  gl.Uniform2f(location("sideray_mask_size"), static_cast<float>(outputs.width), static_cast<float>(outputs.height));
  gl.Uniform4f(location("sideray_mask_viewport"), static_cast<float>(outputs.x), static_cast<float>(outputs.y), 1.0f,
               1.0f);
}

}  // namespace sideray::bridge
