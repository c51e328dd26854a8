// Denoises the shadow of one light on the device as rt/masks/shadow_filter.h does on the CPU. One object a light and
// sequence. The thread whose context is current calls it; framebuffer, program, vertex array, viewport and the 2D
// textures of units 0 to 7 are left changed; blending, tests, scissor and masks must let a full screen be drawn.
#pragma once

#include <cstdint>

#include "gl/context/functions.h"
#include "gl/resources/objects.h"
#include "gl/resources/program.h"
#include "shaders/light/shadow_filter_cpp.h"

namespace sideray::gl {

// Refers to textures of width * height, read by texel: as rt::ShadowFilterInput has them, in the first channel; motion
// in two.
struct ShadowFilterTextures {
  uint32_t width = 0, height = 0;
  uint32_t visibility = 0, hit_distance = 0, depth = 0;
  uint32_t motion = 0;  // 0: nothing moved
  shading::SfView view{};
  shading::SfLight light{};
};

class ShadowFilterPass {
 public:
  // Throws Failure (GL_FAILED).
  explicit ShadowFilterPass(const Functions& gl);

  // Allocates for frames of this size, which spatial() does otherwise. Throws as that does.
  void fit(uint32_t width, uint32_t height);
  // Filters within the frame, into filtered(). Throws Failure (OUT_OF_MEMORY, GL_FAILED, UNSUPPORTED).
  void spatial(const ShadowFilterTextures& input);
  // Averages with the frames before, into accumulated(), after spatial() of the same input. `again`: in place of the
  // last call's frame.
  void temporal(const ShadowFilterTextures& input, bool again = false);
  // Makes the next frame follow none.
  void reset() { follows_ = false; }
  // Makes the next frame follow the last one, even where that was filtered by spatial() alone. `light` is the same as
  // there.
  void follow(const shading::SfLight& light);

  // Forgets all names without calling OpenGL, for a context that is gone.
  void abandon();

  uint32_t filtered() const { return visibility_[0].id(); }         // R32F
  uint32_t accumulated() const { return history_[current_].id(); }  // RGBA32F; the value in its first channel

 private:
  enum Stage { tile_stage, around_stage, guide_stage, blur_stage, accumulate_stage, stage_count };

  Texture make_texture(GLint format, GLenum channels, uint32_t width, uint32_t height) const;
  void release();
  const Program& begin(Stage stage, const Texture& target, const ShadowFilterTextures& input) const;
  void bind(int unit, uint32_t texture) const;
  void draw() const;
  void draw_guide(const ShadowFilterTextures& input);

  const Functions& gl_;
  Program programs_[stage_count];
  VertexArray screen_;
  Framebuffer framebuffer_;
  Texture tiles_, around_, guide_, visibility_[2], history_[2];
  uint32_t width_ = 0, height_ = 0, current_ = 0;
  bool follows_ = false, filtered_ = false;  // filtered_: a frame of this size was filtered
};

}  // namespace sideray::gl
