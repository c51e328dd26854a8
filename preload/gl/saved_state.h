// Saves the fixed-function state that a draw depends on when the draw is held back, and sets it for the later draw.
#pragma once

#include <vector>

#include "preload/gl/functions.h"

namespace sideray::run {

class SavedState {
 public:
  static SavedState read();
  // Changes the matrices without restoring them; call it while AllState is alive.
  void apply() const;
  // Returns the first texture unit behind the draw's own, whose result is the draw's colour; -1 = all are used.
  int free_unit() const;
  // Sets only the view's matrices and the active unit.
  void apply_view() const;

 private:
  enum { kept_lights = 8, kept_planes = 6 };
  struct Unit {
    bool texture_2d, texture_cube, generated[4];
    GLint bound_2d, bound_cube, env_mode, combine[8], generation_mode[4];
    GLfloat env_color[4], scale[2], object_plane[4][4], eye_plane[4][4], matrix[16], coordinates[4];
  };
  struct Light {
    bool on;
    GLfloat ambient[4], diffuse[4], specular[4], position[4], direction[4], exponent, cutoff, attenuation[3];
  };
  struct Material {
    GLfloat ambient[4], diffuse[4], specular[4], emission[4], shininess;
  };

  void read_units();
  void read_lighting();
  void apply_units() const;
  void apply_lighting() const;

  std::vector<bool> enabled_;
  Unit units_[kept_units];
  Light lights_[kept_lights];
  Material materials_[2];
  bool planes_[kept_planes];
  GLdouble plane_[kept_planes][4];
  GLfloat modelview_[16], projection_[16], color_[4], normal_[3];
  GLfloat alpha_reference_, depth_range_[2], offset_[2], line_width_, point_size_, fog_[3], fog_color_[4], model_ambient_[4];
  GLint active_unit_, alpha_func_, blend_[4], blend_equation_, depth_func_, cull_face_, front_face_, shade_model_;
  GLint polygon_mode_[2], fog_mode_, two_sided_, local_viewer_, color_control_, color_material_[2], viewport_[4], scissor_[4];
  GLint stencil_[7], logic_op_;
  GLboolean depth_mask_, color_mask_[4];
};

// Pushes attributes, client state and the matrices of the fixed function; the destructor restores all.
class AllState {
 public:
  AllState();
  ~AllState();
  AllState(const AllState&) = delete;
  AllState& operator=(const AllState&) = delete;
  // Returns whether the attribute stacks had room. If not, nothing may be drawn.
  bool saved() const { return saved_; }

 private:
  bool saved_ = false;
  GLfloat modelview_[16], projection_[16], texture_[kept_units][16];
};

}  // namespace sideray::run
