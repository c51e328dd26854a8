// Draws the sun's shadows onto the opaque picture. OpenGL lights the draws that receive them once more, with the sun and without;
// what the masks let through says how much of the difference is left.
#pragma once

#include <sideray/sideray.hpp>

#include <map>

#include "preload/rays/receivers.h"

namespace sideray::run {

// What a frame's shadows are drawn from.
struct ShadowInputs {
  const std::vector<Receiver>* draws = nullptr;
  int sun = 0;                                        // GL_LIGHT0 + sun
  const std::map<uint32_t, Matrix>* before = nullptr;  // where draws were in the frame of the masks, by their names
  GLuint depth = 0;                                   // a texture: the picture's depth
  Matrix projection{};
  std::array<GLint, 4> viewport{};
};

class Shadows {
 public:
  // In the program's context. Throws sideray::Error where the driver cannot.
  Shadows();
  ~Shadows();
  Shadows(const Shadows&) = delete;
  Shadows& operator=(const Shadows&) = delete;
  // For a context that is gone.
  void abandon();

  // The masks are those of a view of the service. All state is changed.
  void draw(const ShadowInputs& inputs, Service& service, uint32_t view);
  // Draws white where it has darkened the picture.
  void mark(const std::array<GLint, 4>& viewport);
  // Pixels that the last draw() has darkened. Waits for it.
  uint64_t pixels();

 private:
  enum class Pass { lit, left };
  void make_textures(GLint width, GLint height);
  void draw_receivers(const ShadowInputs& inputs, Pass pass);
  void set_receiver(const Receiver& draw, const ShadowInputs& inputs, Pass pass);
  void cover(const std::array<GLint, 4>& viewport, int what);

  GLuint receivers_ = 0, cover_ = 0;  // programs
  GLuint framebuffer_ = 0, lit_ = 0, left_ = 0, query_ = 0;
  GLint width_ = 0, height_ = 0;
  float fog_color_[3] = {};
  bool asked_ = false;
};

}  // namespace sideray::run
