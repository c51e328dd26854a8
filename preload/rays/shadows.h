// Computes how much the sun's shadows darken draws. OpenGL lights the receivers again, with the sun and without it; the
// masks say how much of the difference is left.
#pragma once

#include <sideray/sideray.hpp>

#include <map>

#include "preload/rays/receivers.h"

namespace sideray::run {

// The inputs of Shadows::light() and darken().
struct ShadowInputs {
  const std::vector<Receiver>* draws = nullptr;
  int sun = 0;                                        // GL_LIGHT0 + sun
  const std::map<uint32_t, Matrix>* before = nullptr;  // where draws were in the frame of the masks, by their names
  GLuint depth = 0;                                   // depth texture of the draws' nearest surfaces
  GLuint picture_depth = 0;                           // depth texture of surfaces that may hide the draws
  Matrix projection{};
  std::array<GLint, 4> viewport{};
};

class Shadows {
 public:
  // Needs the program's context. Throws sideray::Error if the driver refuses the shaders.
  Shadows();
  ~Shadows();
  Shadows(const Shadows&) = delete;
  Shadows& operator=(const Shadows&) = delete;
  // Forgets the OpenGL objects, if their context is gone.
  void abandon();

  // Computes the share of the draws' light that is left, by the masks of a view of the service. Changes all state.
  void light(const ShadowInputs& inputs, Service& service, uint32_t view);
  // Returns a texture that begins at the framebuffer's first pixel: red, green and blue are that share, alpha the fog.
  GLuint left() const { return left_; }
  // Multiplies the picture by the share.
  void darken(const ShadowInputs& inputs);
  // Counts the pixels that darken() would darken, and leaves the picture unchanged.
  void count(const std::array<GLint, 4>& viewport);
  // Draws white where light is missing.
  void mark(const std::array<GLint, 4>& viewport);
  // Returns the pixels that the last darken() or count() found. Waits for the GPU.
  uint64_t pixels();

 private:
  enum class Pass { lit, left };
  void make_textures(GLint width, GLint height);
  void draw_receivers(const ShadowInputs& inputs, Pass pass);
  void set_receiver(const Receiver& draw, const ShadowInputs& inputs, Pass pass);
  enum class Cover { multiplies, adds_fog, marks, counts };
  void cover(const std::array<GLint, 4>& viewport, Cover what);
  void ask(const std::array<GLint, 4>& viewport, Cover what);

  GLuint receivers_ = 0, cover_ = 0;  // programs
  GLuint framebuffer_ = 0, lit_ = 0, left_ = 0, query_ = 0;
  GLuint nearest_ = 0;  // depth of the nearest surfaces, because masks cannot tell the far side of thin draws from them
  GLint width_ = 0, height_ = 0;
  float fog_color_[3] = {};
  bool asked_ = false;
};

}  // namespace sideray::run
