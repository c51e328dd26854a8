// Computes the sun's shadows on draws that are held back. These lie in front of the opaque depth, so their nearest
// surfaces have a depth texture and masks of their own. While OpenGL makes such a draw, one more texture multiplies the
// lit and textured colour by the share of light that the masks leave, before fog and blending.
#pragma once

#include <map>

#include "preload/gl/depth_target.h"
#include "preload/rays/answers.h"
#include "preload/rays/batch.h"
#include "preload/rays/shadows.h"

namespace sideray::run {

class HeldShadows {
 public:
  // Needs the program's context. Throws sideray::Error if the context lacks what the service needs.
  explicit HeldShadows(const TracedScene& scene);
  // Forgets the OpenGL objects, if their context is gone.
  void abandon();

  // Traces the shadows on the batch's held draws, and waits for them unless settings().late. The scene must be
  // committed. Changes OpenGL's state.
  void trace(const Batch& batch);
  // Computes the share of light that is left. `picture_depth`: depth texture of opaque draws. Changes OpenGL's state.
  void light(const Batch& batch, GLuint picture_depth);
  // Between these two a held draw, whose state is set, is made in shadow; without shadow if it uses all texture units.
  void begin(const SavedState& state);
  void end(const SavedState& state);
  // Draws white where the last draws were darkened.
  void mark(const std::array<GLint, 4>& viewport) { shadows_.mark(viewport); }
  uint64_t pixels() { return shadows_.pixels(); }
  // Returns the statistics of the frame whose answers are drawn.
  const sideray_frame_stats& stats(uint32_t batch) const { return answers_.at(batch).stats; }
  void advance() { service_.advance(); }

 private:
  void draw_depth(const Batch& batch);

  Service service_;
  Shadows shadows_;
  DepthTarget target_;
  std::map<uint32_t, Answers> answers_;  // by the batch's number
  Matrix texture_from_eye_{};
};

}  // namespace sideray::run
