// How dark the sun's shadows make draws. OpenGL lights the draws that receive them once more, with the sun and without; what the
// masks let through says how much of the difference is left.
#pragma once

#include <sideray/sideray.hpp>

#include <map>

#include "preload/rays/receivers.h"

namespace sideray::run {

// What shadows are drawn from.
struct ShadowInputs {
  const std::vector<Receiver>* draws = nullptr;
  int sun = 0;                                        // GL_LIGHT0 + sun
  const std::map<uint32_t, Matrix>* before = nullptr;  // where draws were in the frame of the masks, by their names
  GLuint depth = 0;                                   // a texture: of the nearest of the draws
  GLuint picture_depth = 0;                           // likewise, of what may hide them
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

  // Finds which share of the draws' light is left. The masks are those of a view of the service. All state is changed.
  void light(const ShadowInputs& inputs, Service& service, uint32_t view);
  // A texture, from the framebuffer's first pixel on: red, green and blue are that share; alpha is how much fog lies over it.
  GLuint left() const { return left_; }
  // Multiplies the picture by it.
  void darken(const ShadowInputs& inputs);
  // Counts the pixels that are darkened without doing so.
  void count(const std::array<GLint, 4>& viewport);
  // Draws white where the picture is darkened.
  void mark(const std::array<GLint, 4>& viewport);
  // Pixels that the last darken() or count() has found. Waits for it.
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
  GLuint nearest_ = 0;  // depth: behind what is thin, its far side is near enough to be taken for it
  GLint width_ = 0, height_ = 0;
  float fog_color_[3] = {};
  bool asked_ = false;
};

}  // namespace sideray::run
