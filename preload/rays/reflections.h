// Rays for the surfaces of a frame that reflect: depth and mask go to the service, and its answers are drawn onto them.
#pragma once

#include <sideray/sideray.hpp>

#include <optional>
#include <vector>

#include "preload/capture/draw_state.h"
#include "preload/capture/geometry.h"
#include "preload/gl/saved_state.h"
#include "preload/rays/traced_scene.h"

namespace sideray::run {

// A surface that reflects.
struct Reflector {
  const Geometry* geometry = nullptr;
  Matrix modelview{};
  uint32_t surface_id = 0;
  float reflectance = 0;
  bool fresnel = true;  // it grows to 1 at grazing angles
};

class Reflections {
 public:
  // In the program's context. Throws sideray::Error where it lacks what the service needs.
  explicit Reflections(const TracedScene& scene);
  ~Reflections();
  Reflections(const Reflections&) = delete;
  Reflections& operator=(const Reflections&) = delete;
  // For a context that is gone.
  void abandon();

  // Traces what the reflectors show and waits for it. The scene is committed; the program's depth is drawn.
  void trace(const std::vector<Reflector>& reflectors, const std::vector<const SavedState*>& states, const Matrix& projection,
             const std::array<GLint, 4>& viewport);
  // Draws what one of them reflects over it. Its state is set; state is changed.
  void draw(const Reflector& reflector);
  // Fragments that took an answer since the last call, of draws that the GPU has finished. May wait for it.
  uint64_t fragments_answered();

  const sideray_frame_stats& stats() const { return stats_; }

 private:
  void make_target(GLint width, GLint height);
  void draw_mask(const std::vector<Reflector>& reflectors, const std::vector<const SavedState*>& states, const Matrix& projection,
                 const std::array<GLint, 4>& viewport);

  Service service_;
  GLuint program_ = 0, framebuffer_ = 0, depth_ = 0, mask_ = 0;
  GLint width_ = 0, height_ = 0;
  GLint surface_location_, reflectance_location_, fresnel_location_;
  std::vector<GLuint> queries_;
  sideray_frame_stats stats_{};
};

}  // namespace sideray::run
