// The OpenGL state that decides how a draw is treated, and how it looks in a mirror.
#pragma once

#include <array>
#include <memory>

#include "preload/capture/geometry.h"

namespace sideray::run {

using Matrix = std::array<float, 16>;

struct FixedLight {
  float ambient[4], diffuse[4], specular[4], position[4], spot_direction[3], spot_exponent, spot_cutoff, attenuation[3];
};

// Holds the fixed function's lighting, in eye space. Has no padding, because it is compared as bytes.
struct Lighting {
  int lights = 0;
  GLint number[8] = {};  // light i is GL_LIGHT0 + number[i]
  FixedLight light[8] = {};
  float scene_ambient[4] = {};
  GLint local_viewer = 0;
};

struct DrawMaterial {
  float ambient[4] = {0.2f, 0.2f, 0.2f, 1}, diffuse[4] = {0.8f, 0.8f, 0.8f, 1}, specular[4] = {0, 0, 0, 1};
  float emission[4] = {0, 0, 0, 1}, shininess = 0;
};

// Says how OpenGL makes a unit's coordinates: generated or not, and multiplied by a matrix.
struct TextureCoordinates {
  Matrix matrix{};
  bool generated[4] = {};
  GLenum mode[4] = {};
  float object_plane[4][4] = {}, eye_plane[4][4] = {};
};

struct TextureUnit {
  bool textured = false;  // 2D
  GLuint texture = 0;     // 0 where it is not textured
  bool replaces = false;  // the texture environment replaces the lit colour by the texture
  std::shared_ptr<const TextureCoordinates> coordinates;  // null: the vertices' own
};

struct Fog {
  bool on = false;
  GLint mode = GL_EXP;
  float density = 1, start = 0, end = 1, color[4] = {};
};

struct DrawState {
  Matrix modelview{}, projection{};
  std::array<GLint, 4> viewport{};
  bool blend = false, depth_test = false, depth_write = false, alpha_test = false, stencil_test = false, lighting = false, color_material = false;
  bool writes_color = true;
  std::array<TextureUnit, kept_units> units;
  GLenum blend_source = GL_ONE, blend_target = GL_ZERO, depth_func = GL_LESS;
  float alpha = 1;  // of the current colour, or of the material that replaces it
  float alpha_reference = 0;
  GLint framebuffer = 0;
  bool whole_depth_range = true;  // 0 to 1
  DrawMaterial material;
  Fog fog;
  std::shared_ptr<const Lighting> lights;  // of a lit draw that rays see

  // Returns the unit of a layer's texture; layer 0 is the first that rays see, layer 1 the second. Units that use the
  // vertices' own coordinates come before the others, which are shadows, shine and the like. -1 = none.
  int unit_of_layer(int layer) const;
  GLuint texture(int layer = 0) const {
    const int unit = unit_of_layer(layer);
    return unit < 0 ? 0 : units[static_cast<size_t>(unit)].texture;
  }
  // Returns whether the texture replaces the lit colour.
  bool shows_texture_alone() const {
    const int unit = unit_of_layer(0);
    return unit >= 0 && units[static_cast<size_t>(unit)].replaces;
  }
  bool is_perspective() const { return projection[11] != 0; }
  // Returns whether the vertices' colours show: directly, or as the material's colours.
  bool shows_colors() const { return !lighting || color_material; }
  Counted counted() const;
};

DrawState read_draw_state();
// Returns the current lighting; the same object as last time if nothing has changed.
std::shared_ptr<const Lighting> read_lighting();

}  // namespace sideray::run
