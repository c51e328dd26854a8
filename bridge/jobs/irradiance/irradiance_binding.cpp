#include "bridge/jobs/irradiance/irradiance_binding.h"

namespace sideray::bridge {

bool reads_irradiance(const gl::Functions& gl, uint32_t program) {
  return gl.GetUniformLocation(program, "sideray_irradiance_texels") >= 0;
}

void bind_irradiance(const gl::Functions& gl, uint32_t program, uint32_t first_unit, const IrradianceJob& job) {
  const sideray_irradiance_outputs& outputs = job.outputs();
  const auto location = [&](const char* name) { return gl.GetUniformLocation(program, name); };
  const GLint sampler = location("sideray_irradiance_texels");
  if (sampler < 0) return;
  const uint32_t unit = first_unit + irradiance_unit;
  gl.ActiveTexture(GL_TEXTURE0 + unit);
  gl.BindTexture(GL_TEXTURE_2D, outputs.irradiance_texture);
  if (gl.samplers) gl.BindSampler(unit, 0);
  gl.Uniform1i(sampler, static_cast<GLint>(unit));
  gl.Uniform1i(location("sideray_has_irradiance"), outputs.irradiance_texture != 0);
  gl.Uniform2f(location("sideray_irradiance_size"), static_cast<float>(outputs.width), static_cast<float>(outputs.height));
  gl.Uniform2f(location("sideray_irradiance_corner"), static_cast<float>(outputs.x), static_cast<float>(outputs.y));
}

}  // namespace sideray::bridge
