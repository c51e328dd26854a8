#include "bridge/jobs/layers/layer_binding.h"

#include <algorithm>
#include <cstring>
#include <glm/gtc/type_ptr.hpp>

#include "bridge/base/local_view.h"
#include "model/failure.h"

namespace sideray::bridge {
namespace {

void set_uniforms(const gl::Functions& gl, uint32_t program, const LayerJob& job, const LayerSpace& space) {
  const sideray_layer_outputs& layers = job.outputs();
  const auto width = static_cast<uint32_t>(layers.width), height = static_cast<uint32_t>(layers.height);
  const SnippetView snippet = snippet_view(layers.view, width, height, space.origin);
  const auto location = [&](const char* name) { return gl.GetUniformLocation(program, name); };
  gl.Uniform4f(location("sideray_viewport"), static_cast<float>(layers.x), static_cast<float>(layers.y), 1.0f, 1.0f);
  gl.Uniform4fv(location("sideray_eye"), 1, glm::value_ptr(snippet.eye));
  gl.Uniform4fv(location("sideray_near_plane"), 1, glm::value_ptr(snippet.near_plane));
  gl.Uniform1i(location("sideray_match"), static_cast<GLint>(job.lookup().match));
  gl.Uniform1f(location("sideray_match_threshold"), job.lookup().threshold);
  gl.Uniform1f(location("sideray_subpixel"), space.subpixel);
  gl.Uniform1i(location("sideray_refracts"), job.lookup().refracts);
  gl.Uniform1i(location("sideray_older"), job.lookup().older);
  gl.Uniform1i(location("sideray_multisampled"), job.lookup().multisampled);
  gl.Uniform1i(location("sideray_rate"), static_cast<GLint>(job.lookup().rate));
  gl.UniformMatrix3fv(location("sideray_ray_from_pixel"), 1, GL_FALSE, glm::value_ptr(snippet.ray_from_pixel));
  gl.UniformMatrix4fv(location("sideray_clip_from_world"), 1, GL_FALSE, glm::value_ptr(snippet.clip_from_position));
  gl.Uniform2f(location("sideray_cache_size"), static_cast<float>(width), static_cast<float>(height));
}

// Binds the samplers even without whole pixels, since samplers of different types must not share a unit.
void bind_whole(const gl::Functions& gl, uint32_t program, uint32_t first_unit, const sideray_layer_outputs& layers) {
  const uint32_t textures[] = {layers.whole_radiance_texture, layers.whole_transmittance_texture};
  const char* const names[] = {"sideray_whole_radiance", "sideray_whole_transmittance"};
  for (uint32_t i = 0; i < 2; ++i) {
    const GLint location = gl.GetUniformLocation(program, names[i]);
    if (location < 0) continue;
    gl.ActiveTexture(GL_TEXTURE0 + first_unit + i);
    gl.BindTexture(GL_TEXTURE_2D, textures[i]);
    if (gl.samplers) gl.BindSampler(first_unit + i, 0);
    gl.Uniform1i(location, static_cast<GLint>(first_unit + i));
  }
  gl.Uniform1i(gl.GetUniformLocation(program, "sideray_has_whole"), layers.whole_transmittance_texture != 0);
}

// Returns the type of a program's uniform; 0 where there is none of this name.
GLenum type_of_uniform(const gl::Functions& gl, uint32_t program, const char* name) {
  if (gl.GetUniformLocation(program, name) < 0) return 0;
  GLint count = 0;
  gl.GetProgramiv(program, GL_ACTIVE_UNIFORMS, &count);
  for (GLuint i = 0; i < static_cast<GLuint>(count); ++i) {
    char found[64];
    GLint size = 0;
    GLenum type = 0;
    gl.GetActiveUniform(program, i, sizeof(found), nullptr, &size, &type, found);
    if (std::strcmp(found, name) == 0) return type;
  }
  return 0;
}

}  // namespace

void check_id_sampler(const gl::Functions& gl, uint32_t program, const LayerJob& job,
                      std::vector<CheckedProgram>& checked) {
  const sideray_layer_outputs& layers = job.outputs();
  if (layers.ticket == 0 || layers.mode != SIDERAY_CACHE || layers.surface_id_texture == 0) return;
  constexpr size_t most_checked = 64;
  const CheckedProgram known{program, job.lookup().float_ids};
  if (std::ranges::find(checked, known) != checked.end()) return;
  const GLenum type = type_of_uniform(gl, program, "sideray_surface_id");
  if (type == 0) return;
  const bool reads_floats = type == GL_SAMPLER_2D_ARRAY, holds_floats = job.lookup().float_ids;
  if (reads_floats == holds_floats) {
    if (checked.size() == most_checked) checked.clear();
    return checked.push_back(known);
  }
  fail(SIDERAY_INVALID_ARGUMENT,
       "bind program {}: its sideray_surface_id reads {}, and the newest layers hold {}: {}", program,
       reads_floats ? "floats (GLSL 1.20)" : "integers", holds_floats ? "floats" : "integers",
       holds_floats ? "leave float_ids of the layer inputs 0, or paste sideray_glsl(120)"
                    : "set float_ids of the layer inputs, or paste sideray_glsl(130)");
}

bool reads_whole_pixels(const gl::Functions& gl, uint32_t program) {
  return gl.GetUniformLocation(program, "sideray_has_whole") >= 0;
}

void bind_layers(const gl::Functions& gl, uint32_t program, uint32_t first_unit, const LayerJob& job,
                 const LayerSpace& space) {
  const sideray_layer_outputs& layers = job.outputs();
  const bool answers = layers.ticket != 0 && layers.mode == SIDERAY_CACHE && layers.layers > 0;
  const uint32_t textures[] = {answers ? layers.radiance_texture : 0, answers ? layers.distance_texture : 0,
                               answers ? layers.surface_id_texture : 0};
  const char* const names[] = {"sideray_radiance", "sideray_distance", "sideray_surface_id"};
  for (uint32_t i = 0; i < 3; ++i) {
    gl.ActiveTexture(GL_TEXTURE0 + first_unit + i);
    gl.BindTexture(GL_TEXTURE_2D_ARRAY, textures[i]);
    if (gl.samplers) gl.BindSampler(first_unit + i, 0);
    gl.Uniform1i(gl.GetUniformLocation(program, names[i]), static_cast<GLint>(first_unit + i));
  }
  gl.Uniform1i(gl.GetUniformLocation(program, "sideray_layers"), answers ? static_cast<GLint>(layers.layers) : 0);
  bind_whole(gl, program, first_unit + whole_units, layers);
  if (answers) set_uniforms(gl, program, job, space);
}

}  // namespace sideray::bridge
