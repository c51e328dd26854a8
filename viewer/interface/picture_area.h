// Draws the pictures in the window, A, B, both with a slider, or their difference, and handles the mouse there. Main
// thread.
#pragma once

#include <array>

#include "viewer/interface/state.h"
#include "viewer/interface/window.h"

namespace sideray::viewer {

class PictureArea {
 public:
  void draw(State& state, const Drawer::Shown& shown, ImVec2 size);

 private:
  // Holds a texture and its source.
  struct Uploaded {
    Texture texture;
    std::shared_ptr<const void> from;
  };
  void upload(const Drawer::Shown& shown);
  void draw_side(const State& state, const Drawer::Shown& shown, size_t side, float begin, float end, ImVec2 size) const;
  void draw_both(const State& state, const Drawer::Shown& shown, ImVec2 size) const;
  void draw_map(const State& state, const Drawer::Shown& shown, ImVec2 size) const;
  void control(State& state, const Drawer::Shown& shown, ImVec2 size);
  bool drag_slider(State& state, ImVec2 size);
  bool move_camera(Navigation& navigation, const glm::dvec3& under, float height);
  struct Under {
    Pixel pixel;
    glm::dvec3 point;
  };
  std::optional<Under> under_mouse(const State& state, const Drawer::Shown& shown, ImVec2 size) const;

  std::array<Uploaded, sides> sides_;
  Uploaded map_;
  glm::dvec3 pivot_{0};  // of the current drag
  bool drags_slider_ = false;
};

// Returns the distance of the opaque surface there, along the view axis; `otherwise` where there is none.
double depth_at(const Frame* frame, double x, double y, double otherwise);

}  // namespace sideray::viewer
