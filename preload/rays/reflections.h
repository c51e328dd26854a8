// Traces rays for a frame's reflecting surfaces: the service reads depth and mask, and its answers are drawn onto them.
#pragma once

#include <sideray/sideray.hpp>

#include <map>
#include <optional>
#include <vector>

#include "preload/capture/draw_state.h"
#include "preload/capture/geometry.h"
#include "preload/gl/depth_target.h"
#include "preload/gl/saved_state.h"
#include "preload/rays/answers.h"
#include "preload/rays/held_shadows.h"
#include "preload/rays/receivers.h"
#include "preload/rays/shadows.h"
#include "preload/rays/traced_scene.h"

namespace sideray::run {

class Reflections {
 public:
  // Needs the program's context. Throws sideray::Error if the context lacks what the service needs.
  explicit Reflections(const TracedScene& scene);
  ~Reflections();
  Reflections(const Reflections&) = delete;
  Reflections& operator=(const Reflections&) = delete;
  // Forgets the OpenGL objects, if their context is gone.
  void abandon();

  static constexpr uint32_t most_batches = SIDERAY_MAX_VIEWS;

  // Traces what the batch shows, and waits for it unless settings().late. The scene must be committed, and the
  // program's depth drawn.
  void trace(const Batch& batch);
  // Draws the batch's shadows onto the picture, and computes the shadows on held draws. Changes OpenGL's state.
  void draw_shadows(const Batch& batch);
  void mark_shadows(const std::array<GLint, 4>& viewport);
  // Returns the shadows on held draws; null until there are some.
  HeldShadows* held_shadows() { return held_shadows_.get(); }
  // Draw what is seen through a refracting reflector, or on top what it reflects. The reflector's state must be set;
  // changes OpenGL's state.
  void draw_behind(const Reflector& reflector) { draw(reflector, Shown::behind); }
  void draw(const Reflector& reflector) { draw(reflector, Shown::reflected); }
  // Draws white where draw() or draw_behind() would draw an answer.
  void mark(const Reflector& reflector) { draw(reflector, Shown::marks), draw(reflector, Shown::marks_behind); }
  // Ends the frame, and lets the services advance.
  void advance();
  // Returns how many fragments took an answer, in draws that the GPU has finished and no earlier call counted. Waits
  // for all draws unless settings().late.
  uint64_t fragments_answered();
  // Returns how many pixels the last shadows darkened.
  uint64_t pixels_in_shadow() { return shadows_ ? shadows_->pixels() : 0; }
  // Returns in how many pixels held draws are in shadow, as counted last.
  uint64_t held_in_shadow() { return held_shadows_ ? held_shadows_->pixels() : 0; }

  // Returns the statistics of the frame whose answers are drawn.
  const sideray_frame_stats& stats() const { return view().stats; }

 private:
  const Answers& view() const { return views_.at(batch_); }
  enum class Shown { behind, reflected, marks, marks_behind };
  void submit(const Batch& batch);
  void draw(const Reflector& reflector, Shown shown);
  void draw_mask(const Batch& batch);

  const TracedScene& scene_;
  Service service_;
  GLuint program_ = 0;
  DepthTarget target_;
  GLint surface_location_, reflectance_location_, fresnel_location_, late_location_, shown_location_, before_location_;
  std::unique_ptr<Shadows> shadows_;
  std::unique_ptr<HeldShadows> held_shadows_;
  std::vector<GLuint> queries_;
  // Each batch of a frame has a view of its own, so that it finds its answers of the previous frame.
  std::map<uint32_t, Answers> views_;
  uint32_t batch_ = 0;
};

}  // namespace sideray::run
