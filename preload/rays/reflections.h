// Rays for the surfaces of a frame that reflect: depth and mask go to the service, and its answers are drawn onto them.
#pragma once

#include <sideray/sideray.hpp>

#include <map>
#include <optional>
#include <vector>

#include "preload/capture/draw_state.h"
#include "preload/capture/geometry.h"
#include "preload/gl/saved_state.h"
#include "preload/rays/receivers.h"
#include "preload/rays/shadows.h"
#include "preload/rays/traced_scene.h"

namespace sideray::run {

// A surface that reflects.
struct Reflector {
  const Geometry* geometry = nullptr;
  Matrix modelview{};
  MirrorIds ids;
  float reflectance = 0;
  bool fresnel = true;  // it grows to 1 at grazing angles
};

// What waits for rays together.
struct Batch {
  uint32_t number = 0;  // of the frame's
  std::vector<Reflector> reflectors;
  std::vector<const SavedState*> states;  // of each reflector
  const Receivers* receivers = nullptr;
  int sun = 0;  // GL_LIGHT0 + sun casts shadows
  Matrix projection{};
  std::array<GLint, 4> viewport{};

  bool has_shadows() const { return !receivers->empty() && receivers->sun(); }
  bool is_empty() const { return reflectors.empty() && !has_shadows(); }
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

  static constexpr uint32_t most_batches = SIDERAY_MAX_VIEWS;

  // Traces what the batch shows and waits for it, or with settings().late for nothing. The scene is committed; the program's
  // depth is drawn.
  void trace(const Batch& batch);
  // Draws the shadows of the batch onto the picture. State is changed.
  void draw_shadows(const Batch& batch);
  void mark_shadows(const std::array<GLint, 4>& viewport);
  // Draws what is seen through a reflector that bends light, or over it what it reflects. Its state is set; state is changed.
  void draw_behind(const Reflector& reflector) { draw(reflector, Shown::behind); }
  void draw(const Reflector& reflector) { draw(reflector, Shown::reflected); }
  // Draws white where it would draw an answer.
  void mark(const Reflector& reflector) { draw(reflector, Shown::marks), draw(reflector, Shown::marks_behind); }
  // At the end of the frame: what is traced moves on.
  void advance() { service_.advance(); }
  // Fragments that took an answer, of draws that the GPU has finished and that no earlier call counted. Waits for all of them,
  // unless settings().late.
  uint64_t fragments_answered();
  // Pixels that the last shadows have darkened.
  uint64_t pixels_in_shadow() { return shadows_ ? shadows_->pixels() : 0; }

  // Of the frame whose answers are drawn.
  const sideray_frame_stats& stats() const { return view().stats; }

 private:
  // Where surfaces were in a frame that was submitted, by their ids.
  using Places = std::map<uint32_t, Matrix>;
  // The batches of a frame have a view each, so that each finds its answers of the frame before.
  struct View {
    std::optional<sideray_ticket> ticket;  // it is traced
    Places places, answered;               // of the ticket, and of the answers that are there
    Places receivers, shadowed;            // likewise, of what shadows fall on
    sideray_frame_stats stats{};
  };
  const View& view() const { return views_.at(batch_); }
  enum class Shown { behind, reflected, marks, marks_behind };
  void submit(const Batch& batch);
  void take_answers(int32_t timeout_ms);
  void draw(const Reflector& reflector, Shown shown);
  void make_target(GLint width, GLint height);
  void copy_depth(const std::array<GLint, 4>& viewport);
  void draw_mask(const Batch& batch);

  Service service_;
  GLuint program_ = 0, framebuffer_ = 0, depth_ = 0, mask_ = 0;
  GLint width_ = 0, height_ = 0;
  GLint surface_location_, reflectance_location_, fresnel_location_, late_location_, shown_location_, before_location_;
  std::unique_ptr<Shadows> shadows_;
  std::vector<GLuint> queries_;
  std::map<uint32_t, View> views_;
  uint32_t batch_ = 0;
};

}  // namespace sideray::run
