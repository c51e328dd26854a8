// What of OpenGL's state says how a draw is taken, and how what it draws looks in a mirror.
#pragma once

#include <array>

#include "preload/gl/entry_points.h"

namespace sideray::run {

using Matrix = std::array<float, 16>;

struct FixedLight {
  float ambient[4], diffuse[4], specular[4], position[4], spot_direction[3], spot_exponent, spot_cutoff, attenuation[3];
};

// The lighting of the fixed function, all of it in eye space.
struct Lighting {
  int lights = 0;
  FixedLight light[8] = {};
  float scene_ambient[4] = {};
  GLint two_sided = 0, local_viewer = 0;
};

struct DrawMaterial {
  float ambient[4] = {0.2f, 0.2f, 0.2f, 1}, diffuse[4] = {0.8f, 0.8f, 0.8f, 1}, specular[4] = {0, 0, 0, 1};
  float emission[4] = {0, 0, 0, 1}, shininess = 0;
};

struct DrawState {
  Matrix modelview{}, projection{};
  std::array<GLint, 4> viewport{};
  bool blend = false, depth_test = false, depth_write = false, alpha_test = false, lighting = false, color_material = false;
  bool textured[2] = {}, generated_uv = false, writes_color = true;
  GLenum blend_source = GL_ONE, blend_target = GL_ZERO, depth_func = GL_LESS;
  GLuint texture[2] = {};  // 2D, of the first two units; 0 where it is not textured
  float alpha = 1;  // of the colour that is current, or of the material that takes its place
  float alpha_reference = 0;
  GLint framebuffer = 0;
  DrawMaterial material;

  bool is_perspective() const { return projection[11] != 0; }
  // Colours of vertices count, or are replaced by the material's.
  bool shows_colors() const { return !lighting || color_material; }
};

DrawState read_draw_state();
Lighting read_lighting();

}  // namespace sideray::run
