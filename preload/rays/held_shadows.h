// The sun's shadows on draws that are held back. They lie before the depth from which the masks of what is opaque are traced,
// so that their nearest surfaces have a depth and masks of their own. While such a draw is made, one more texture multiplies
// what OpenGL has lit and textured by what the masks leave of it, before fog and blending.
#pragma once

#include <map>

#include "preload/gl/depth_target.h"
#include "preload/rays/answers.h"
#include "preload/rays/batch.h"
#include "preload/rays/shadows.h"

namespace sideray::run {

class HeldShadows {
 public:
  // In the program's context. Throws sideray::Error where it lacks what the service needs.
  explicit HeldShadows(const TracedScene& scene);
  // For a context that is gone.
  void abandon();

  // Traces the shadows on what of the batch is held back, and waits for them, or with settings().late for nothing. The scene is
  // committed. Changes state.
  void trace(const Batch& batch);
  // Finds what is left of the light. `picture_depth`: of what is opaque, a texture. Changes state.
  void light(const Batch& batch, GLuint picture_depth);
  // Between these two a held draw, whose state is set, is made in shadow. Nothing happens where it uses all texture units.
  void begin(const SavedState& state);
  void end(const SavedState& state);
  // Draws white where the last draws were darkened.
  void mark(const std::array<GLint, 4>& viewport) { shadows_.mark(viewport); }
  uint64_t pixels() { return shadows_.pixels(); }
  // Of the frame whose answers are drawn.
  const sideray_frame_stats& stats(uint32_t batch) const { return answers_.at(batch).stats; }
  void advance() { service_.advance(); }

 private:
  void draw_depth(const Batch& batch);

  Service service_;
  Shadows shadows_;
  DepthTarget target_;
  std::map<uint32_t, Answers> answers_;  // of each batch of a frame
  Matrix texture_from_eye_{};
};

}  // namespace sideray::run
