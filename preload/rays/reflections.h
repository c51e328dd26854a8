// Rays for the surfaces of a frame that reflect: depth and mask go to the service, and its answers are drawn onto them.
#pragma once

#include <sideray/sideray.hpp>

#include <map>
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

  // Traces what the reflectors show and waits for it, or with settings().late for nothing. The scene is committed; the
  // program's depth is drawn. `batch`: which of the frame's.
  void trace(uint32_t batch, const std::vector<Reflector>& reflectors, const std::vector<const SavedState*>& states, const Matrix& projection,
             const std::array<GLint, 4>& viewport);
  // Draws what one of them reflects over it. Its state is set; state is changed.
  void draw(const Reflector& reflector) { draw(reflector, false); }
  // Draws white where it would draw an answer.
  void mark(const Reflector& reflector) { draw(reflector, true); }
  // At the end of the frame: what is traced moves on.
  void advance() { service_.advance(); }
  // Fragments that took an answer, of draws that the GPU has finished and that no earlier call counted. Waits for all of them,
  // unless settings().late.
  uint64_t fragments_answered();

  // Of the frame whose answers are drawn.
  const sideray_frame_stats& stats() const { return view().stats; }

 private:
  // Where surfaces were in a frame that was submitted, by their ids.
  using Places = std::map<uint32_t, Matrix>;
  // The batches of a frame have a view each, so that each finds its answers of the frame before.
  struct View {
    std::optional<sideray_ticket> ticket;  // it is traced
    Places places, answered;               // of the ticket, and of the answers that are there
    sideray_frame_stats stats{};
  };
  const View& view() const { return views_.at(batch_); }
  void submit(const std::vector<Reflector>& reflectors, const Matrix& projection, const std::array<GLint, 4>& viewport);
  void take_answers(int32_t timeout_ms);
  void draw(const Reflector& reflector, bool marks);
  void make_target(GLint width, GLint height);
  void draw_mask(const std::vector<Reflector>& reflectors, const std::vector<const SavedState*>& states, const Matrix& projection,
                 const std::array<GLint, 4>& viewport);

  Service service_;
  GLuint program_ = 0, framebuffer_ = 0, depth_ = 0, mask_ = 0;
  GLint width_ = 0, height_ = 0;
  GLint surface_location_, reflectance_location_, fresnel_location_, late_location_, marks_location_, before_location_;
  std::vector<GLuint> queries_;
  std::map<uint32_t, View> views_;
  uint32_t batch_ = 0;
};

}  // namespace sideray::run
